"""The printer under test: a contourd that is started, disturbed and killed repeatedly. If run as root, contourd has its own user
and its folders have the permissions of a real printer; hostile programs run as a member of its group."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unicodedata

from harness import BIN, NIMBLE_AXIS, NIMBLE_RESIN, SANITIZED, SOURCE, Daemon, merge
from process_figures import Waits, memory_mb

GROUP, SERVICE, MEMBER = 64000, 64001, 64002  # ids that no one else uses
AS_ROOT = os.geteuid() == 0
HERE = os.path.dirname(os.path.abspath(__file__))
DISK_MB = 200

# A machine whose jobs take seconds in real time, with a display that is small, so that masks are written fast.
MACHINE = {
    "z_axis": {**NIMBLE_AXIS, "travel_mm": 12}, "projector": {"warm_up_s": 0}, "display": {"width_px": 480, "height_px": 270},
    "simulation": {"start_height_mm": 0}, "memory_limit_mb": 300,
}  # fmt: skip
RESIN = {**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 50}


class Folder:
    """The part of a test that the harness's daemon needs: a folder, and clean-up calls."""

    def __init__(self, path, on_exit):
        self.folder, self.addCleanup = path, on_exit.callback
        os.mkdir(path)


def new_daemon(folder):
    daemon = Daemon(folder, MACHINE, RESIN, masks=True)
    daemon.write_resin("growing", {**RESIN, "growth_um": 60, "elephant_foot_um": 40, "elephant_foot_height_um": 200})
    return daemon


def small_disk(path, on_exit):
    """Mounts a separate disk for the spool, which can become full. Returns the reason if that is not possible."""
    os.mkdir(path)
    if not AS_ROOT:
        return "only root can mount a disk that becomes full"
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_MB}m", "soak", path], capture_output=True, check=False)
    if mounted.returncode != 0:
        return f"cannot mount a disk that becomes full: {mounted.stderr.decode().strip()}"
    on_exit.callback(subprocess.run, ["umount", "-l", path], check=False)
    return None


class Printer:
    def __init__(self, folder, on_exit):
        self.folder = os.path.join(folder, "printer")
        self.daemon = new_daemon(Folder(self.folder, on_exit))
        self.disk = os.path.join(self.folder, "disk")
        self.without_full_disk = small_disk(self.disk, on_exit)
        self.daemon.spool = os.path.join(self.disk, "spool")
        self.slow = self.daemon.put_on_slow_disk()
        self.give_back = os.path.join(self.folder, "give-back")
        self.daemon.config["spool_folder"] = self.daemon.spool
        self.plain = json.dumps(self.daemon.config)
        self.state, self.home = os.path.join(self.disk, "state"), os.path.join(self.disk, "home")
        self.lives = 0
        self.hostile = []
        self.waits = Waits()
        on_exit.callback(self.waits.close)
        on_exit.callback(self.stop_hostile)
        self._make_folders()

    def _make_folders(self):
        daemon = self.daemon
        os.mkdir(self.state)
        os.mkdir(self.home)
        for name in ("run", "secrets", "masks"):
            os.mkdir(self.path(name))
        with open(os.path.join(SOURCE, "systemd", "contourd.tmpfiles"), encoding="utf-8") as file:
            folders = [line.split() for line in file if line.startswith("d /var/spool")]
        for _, path, mode, *_ in folders:
            path = path.replace("/var/spool/contourd", daemon.spool)
            os.mkdir(path)
            if AS_ROOT:
                os.chown(path, SERVICE, GROUP)
            os.chmod(path, int(mode, 8))
        daemon.config["control_socket"] = daemon.socket_path = self.path("run", "control.sock")
        self.plain = json.dumps(daemon.config)
        if not AS_ROOT:
            return
        os.chown(self.home, MEMBER, MEMBER)
        for path in (self.state, self.path("run"), self.path("masks")):
            os.chown(path, SERVICE, GROUP)
        for path in (self.folder, self.path("slow")):
            os.chmod(path, 0o777)  # contains the harness's notify socket and the control of the slow disk
        daemon.rights = {"user": SERVICE, "group": GROUP, "extra_groups": [], "umask": 0o002}

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    # --- a life, from a start to an end

    def start(self, changes, slow_disk):
        self.lives += 1
        daemon = self.daemon
        daemon.config = merge(json.loads(self.plain), changes)
        daemon.write_config()
        daemon.environment = {"STATE_DIRECTORY": self.state}
        if not SANITIZED:  # AddressSanitizer must be loaded first
            libraries = ["give-back", *(["slow-disk"] if slow_disk else [])]
            daemon.environment["LD_PRELOAD"] = " ".join(os.path.join(BIN, f"lib{name}.so") for name in libraries)
            daemon.environment |= {"SLOW_DISK": self.slow, "GIVE_BACK": self.give_back}
        daemon.log_path = self.path(f"contourd-{self.lives}.log")
        daemon.start()
        daemon.watcher.close()
        self.client = daemon.client()
        self.waits.watch(daemon.process.pid)

    @property
    def pid(self):
        return self.daemon.process.pid

    def memory_held_mb(self):
        """Returns the daemon's memory in MB, without memory that it has freed."""
        with open(self.give_back, "wb"):
            time.sleep(0.3)  # more than twice the period of the preloaded library
        os.unlink(self.give_back)
        return memory_mb(self.pid)

    def status(self):
        """Returns the status, and how long the answer took in s."""
        asked = time.monotonic()
        self.client.seen.clear()
        result = self.call("status")["result"]
        return result, time.monotonic() - asked

    def call(self, method):
        """Sends a command. Root's connection persists; that of the flood's user may have to be opened again."""
        while True:
            try:
                return self.client.call(method)
            except (OSError, AssertionError) as error:
                if AS_ROOT or "timed out" in str(error) or not self.daemon.alive():
                    raise AssertionError(f"{method} has no answer: {error}; contourd ended with {self.daemon.process.poll()}") from None
                self.client = self.daemon.client()

    def freeze(self, seconds):
        self.daemon.process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        self.daemon.process.send_signal(signal.SIGCONT)
        self.waits.stopped_for(seconds)

    def log_trouble(self):
        """Returns a sentence if this life's log has a line that could affect a terminal or is too long, or None."""
        with open(self.daemon.log_path, "rb") as file:
            for line in file:
                try:
                    text = line.decode("utf-8").rstrip("\n")
                except UnicodeDecodeError:
                    return f"the log has a line that is not UTF-8: {line[:200]!r}"
                if any(does_something(char) for char in text):
                    return f"the log has a line that cannot be printed: {line[:200]!r}"
                if text.startswith("break"):  # the second half of a hostile name
                    return f"a file's name has broken a line of the log: {line[:200]!r}"
                if len(line) > 20000:
                    return f"the log has a line of {len(line)} bytes: {line[:200]!r}"
        return None

    def forget_old_logs(self):
        old = self.path(f"contourd-{self.lives - 5}.log")
        if os.path.exists(old):
            os.unlink(old)

    # --- others

    def start_hostile(self, seed):
        incoming = self.daemon.file("incoming")
        for script, *arguments in (("hostile_files.py", incoming, self.home, self.path("secrets")),
                                   ("hostile_clients.py", self.daemon.socket_path)):  # fmt: skip
            rights = f"{MEMBER},{GROUP}" if AS_ROOT else ""
            with open(self.path(script[:-3] + ".log"), "ab") as log:
                self.hostile.append(subprocess.Popen(
                    [sys.executable, "-B", os.path.join(HERE, script), rights, str(seed), *arguments],
                    stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.home))

    def stop_hostile(self):
        for process in self.hostile:
            process.kill()
            process.wait()
        self.hostile = []

    def hostile_that_died(self):
        return next((process for process in self.hostile if process.poll() is not None), None)

    def remove_hostile_files(self, folder):
        """Removes all hostile files, like a user who finds them."""
        for name in os.listdir(self.daemon.file(folder)):
            if name.startswith(("bad", ".contourd-")) or folder == "incoming" and name.startswith("."):
                remove(self.daemon.file(folder, name))

    def fill_disk(self, full):
        path = os.path.join(self.disk, "fill")
        if not full:
            os.unlink(path)
            return
        with open(path, "wb") as file:
            size = 0
            for block in (1 << 20, 1 << 12):  # other processes write meanwhile
                with contextlib.suppress(OSError):
                    while True:
                        os.posix_fallocate(file.fileno(), size, block)
                        size += block


def does_something(char):
    """True for a character that affects a terminal or the display of a line: controls, line ends, direction marks."""
    return unicodedata.category(char) in ("Cc", "Cs", "Zl", "Zp") or unicodedata.bidirectional(char) in (
        "LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")  # fmt: skip


def remove(path):
    if os.path.isdir(path) and not os.path.islink(path):
        os.chmod(path, 0o700)
        shutil.rmtree(path, ignore_errors=True)
    else:
        try:
            os.unlink(path)
        except FileNotFoundError:
            pass
