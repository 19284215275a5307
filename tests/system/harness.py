"""Shared parts of the system tests: small models, a PNG reader, calls of the programs, and a daemon in a private folder.

Environment: CONTOURD_BIN (folder of the programs), CONTOURD_SOURCE (the repository).
"""

import contextlib
import ctypes
import json
import os
import queue
import resource
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
import unittest
import zlib

BIN = os.environ["CONTOURD_BIN"]
SOURCE = os.environ["CONTOURD_SOURCE"]
SHARED = os.path.join(SOURCE, "..", "shared")
CONTOURCTL = os.path.join(BIN, "contourctl")
CONTOURD = os.path.join(BIN, "contourd")
CONTOURD_WEB = os.path.join(BIN, "contourd-web")
MAKE_MODEL = os.path.join(BIN, "make-model")

OK, FAILED, BAD_USAGE, BAD_DATA, NO_INPUT, UNAVAILABLE, CANNOT_CREATE = 0, 1, 64, 65, 66, 69, 73
BAD_CONFIG = 78


def contents(path):
    with open(path, "rb") as file:
        return file.read()


def text_of(path):
    return contents(path).decode()


def _is_sanitized():
    if not os.path.exists(CONTOURD):
        return False  # the virtual machine's tests read this before they build it
    return b"__asan_init" in contents(CONTOURD)


# AddressSanitizer reserves terabytes of address space and keeps freed memory, so memory limits are not tested with it.
SANITIZED = _is_sanitized()

# With sanitizers, contourctl inspect takes four times as much processor time, a fast print eight times.
SLOWNESS = 8 if SANITIZED else 1

# A test fails if it waits longer than this for something. Generous, since the machine may be busy.
DEADLINE_S = 60.0 * SLOWNESS


def limit_memory(bytes_):
    """Limits the address space of the process; for Popen's preexec_fn."""
    if not SANITIZED:
        resource.setrlimit(resource.RLIMIT_AS, (bytes_, bytes_))


# <sys/ptrace.h> and <sys/wait.h>, see ptrace(2).
PTRACE_DETACH, PTRACE_SEIZE, PTRACE_INTERRUPT, WALL = 17, 0x4206, 0x4207, 0x40000000


def _ptrace(request, thread):
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    libc.ptrace.restype = ctypes.c_long
    if libc.ptrace(request, thread, None, None) != 0:
        raise OSError(ctypes.get_errno(), f"ptrace({request:#x}) of thread {thread}")


def skip_file(reason):
    """Ends the whole test file as skipped."""
    print(f"SKIPPED: {reason}")
    sys.exit(0)


def check_generated(test, path, begin, end, parts):
    """Compares the generated parts of a page with `parts`, by name; the lines `begin`, with the name, and `end` surround a part.
    With CONTOURD_RENEW=1 in the environment, writes the parts into the page instead."""
    page = os.path.join(SOURCE, path)
    text = renewed = text_of(page)
    for name, part in parts.items():
        before, line, rest = renewed.partition(begin.format(name))
        test.assertTrue(line, f"{path} has no line {begin.format(name)!r}")
        renewed = before + line + part + rest[rest.index(end):]
    if os.environ.get("CONTOURD_RENEW"):
        with open(page, "w", encoding="utf-8") as file:
            file.write(renewed)
    else:
        test.assertEqual(text, renewed, f"{path} is out of date: run this test with CONTOURD_RENEW=1 to renew it")


# --- models


def box(low, high):
    """Returns the twelve facets of a box, counter-clockwise seen from outside."""
    x, y, z = zip(low, high)
    corner = [(x[i & 1], y[i >> 1 & 1], z[i >> 2 & 1]) for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (3, 2, 6, 7), (2, 0, 4, 6), (1, 3, 7, 5)]
    facets = []
    for a, b, c, d in quads:
        facets.append((corner[a], corner[b], corner[c]))
        facets.append((corner[a], corner[c], corner[d]))
    return facets


def cube(side):
    return box((0, 0, 0), (side, side, side))


def wedge(width, depth, height):
    """Returns a wedge that is width * (1 - z / height) wide at height z: full width at the bottom, an edge at x = 0 at the top."""
    a, b, c = (0, 0, 0), (width, 0, 0), (0, 0, height)
    d, e, f = (0, depth, 0), (width, depth, 0), (0, depth, height)
    return [(a, b, c), (d, f, e), (a, d, e), (a, e, b), (b, e, f), (b, f, c), (a, c, f), (a, f, d)]


def inside_out(facets):
    return [(a, c, b) for a, b, c in facets]


def binary_stl(facets, header=b"", count=None):
    data = [header.ljust(80, b"\0"), struct.pack("<I", len(facets) if count is None else count)]
    for facet in facets:
        data.append(struct.pack("<12fH", 0, 0, 0, *(x for vertex in facet for x in vertex), 0))
    return b"".join(data)


def ascii_stl(facets):
    lines = ["solid test"]
    for facet in facets:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += ["      vertex %.9g %.9g %.9g" % vertex for vertex in facet]
        lines += ["    endloop", "  endfacet"]
    return ("\n".join(lines + ["endsolid test"]) + "\n").encode()


# Layers have 50 um.
SMALL = binary_stl(box((0, 0, 0), (10, 5, 0.2)))  # 4 layers
SLAB = binary_stl(box((0, 0, 0), (10, 5, 1)))  # 20 layers
# A slab, a gap of 1 mm, and a box above the gap: 60 layers.
FLOATING = binary_stl(box((0, 0, 0), (10, 10, 1)) + box((2, 3, 2), (4, 5, 3)))
# One part begins in the third layer, with nothing under it.
ISLAND = binary_stl([*box((0, 0, 0), (10, 5, 0.2)), *box((15, 0, 0.1), (20, 5, 0.2))])


# --- pictures


class Picture:
    """An 8-bit grey picture; rows[0] is the top."""

    def __init__(self, width, height, rows):
        self.width, self.height, self.rows = width, height, rows

    def lit_box(self, least=1):
        """Returns (left, top, right, bottom) around all pixels of at least this value, right and bottom exclusive; None if there is none."""
        darkened = bytes(value if value >= least else 0 for value in range(256))
        rows = [row.translate(darkened) for row in self.rows]
        lit = [y for y in range(self.height) if rows[y].strip(b"\0")]
        if not lit:
            return None
        left = min(self.width - len(rows[y].lstrip(b"\0")) for y in lit)
        right = max(len(rows[y].rstrip(b"\0")) for y in lit)
        return left, lit[0], right, lit[-1] + 1

    def values(self):
        return set(b"".join(self.rows))

    def __eq__(self, other):
        return (self.width, self.height, self.rows) == (other.width, other.height, other.rows)


def _paeth(a, b, c):
    p = a + b - c
    return min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]


def _unfilter(kind, line, above):
    if kind == 0:
        return line
    if kind == 2 and not any(line):
        return above
    out = bytearray(line)
    for i, value in enumerate(line):
        left = out[i - 1] if i else 0
        upper_left = above[i - 1] if i else 0
        predicted = {1: left, 2: above[i], 3: (left + above[i]) // 2, 4: _paeth(left, above[i], upper_left)}[kind]
        out[i] = (value + predicted) & 255
    return bytes(out)


def read_png(path):
    """Reads an 8-bit grey PNG; raises AssertionError for anything else."""
    data = contents(path)
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is not a PNG file"
    at, packed, size, ended = 8, b"", None, False
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        (crc,) = struct.unpack(">I", data[at + 8 + length : at + 12 + length])
        assert zlib.crc32(kind + body) == crc, f"{path}: chunk {kind} is damaged"
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert (depth, colour, interlace) == (8, 0, 0), f"{path} is not 8-bit grey"
            size = width, height
        elif kind == b"IDAT":
            packed += body
        elif kind == b"IEND":
            ended = True
        at += 12 + length
    assert ended, f"{path} is cut short"
    width, height = size
    raw = zlib.decompress(packed)
    assert len(raw) == (width + 1) * height
    rows, above = [], bytes(width)
    for y in range(height):
        start = y * (width + 1)
        above = _unfilter(raw[start], raw[start + 1 : start + 1 + width], above)
        rows.append(above)
    return Picture(width, height, rows)


# --- programs


def run(program, *arguments, expect=None, **options):
    """Runs a program until it ends, with this exit code if one is given. Its output is kept as bytes, since file names are bytes."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": DEADLINE_S, **options}
    result = subprocess.run([program, *map(os.fspath, arguments)], **options)
    assert expect in (None, result.returncode), f"expected exit code {expect}: {result}"
    return result


def check_config(path):
    """Returns the exit code, the warnings and the last line of a check of this configuration. Warnings about the user of an
    installed package are left out: the service cannot read the tests' folders."""
    result = run(CONTOURD, "--check-config", path)
    *warnings, last = (result.stdout + result.stderr).decode().splitlines()
    return result.returncode, [line for line in warnings if "the unit hides home folders" not in line], last


def contourctl(*arguments, **options):
    return run(CONTOURCTL, *arguments, **options)


def on_terminal(columns, *arguments):
    """Returns the lines that contourctl prints on a dumb terminal with this number of columns."""
    mine, its = os.openpty()
    termios.tcsetwinsize(its, (24, columns))
    process = subprocess.Popen([CONTOURCTL, *arguments], stdin=its, stdout=its, stderr=its, env={**os.environ, "TERM": "dumb"})
    os.close(its)
    shown = b""
    with contextlib.suppress(OSError):  # contourctl has closed the terminal
        while data := os.read(mine, 4096):
            shown += data
    os.close(mine)
    process.wait(DEADLINE_S)
    return shown.decode().replace("\r", "").splitlines()


def wait_until(condition, what, deadline_s=DEADLINE_S):
    """Polls until the condition is true, for events without a notification, such as a file that appears."""
    end = time.monotonic() + deadline_s
    while True:
        result = condition()
        if result:
            return result
        if time.monotonic() > end:
            raise AssertionError(f"timed out after {deadline_s:g} s waiting for {what}")
        time.sleep(0.005)


class FolderTest(unittest.TestCase):
    """A test with a private folder. The folder's path is short, since a socket's path may have at most 107 bytes."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="contourd-", dir="/tmp")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def printing(self, name="part.stl", model=None, resin=None, ticket=None, **config):
        """Starts a daemon in real time, and returns it when it exposes the first layer of a print, by default until the test ends it."""
        daemon = Daemon(self, realtime(**config), {**NIMBLE_RESIN, **(ENDLESS if resin is None else resin)}).start()
        daemon.begin(name, model or SLAB, ticket)
        return daemon

    def reachable(self, program):
        """Returns a path of the program that other users can read, since the build may lie in root's home. The program is
        copied only if it cannot be linked: with sanitizers it has 100 MB, which delay the daemon's next write to the disk."""
        path = self.path(os.path.basename(program))
        try:
            os.link(program, path)
        except OSError:
            shutil.copy(program, path)
        return path

    def killed_at_the_end(self, process):
        """Has the process killed when the test ends, if it still runs then."""
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def write(self, name, data):
        path = os.path.join(os.fsencode(self.folder), os.fsencode(name))
        with open(path, "wb") as file:
            file.write(data if isinstance(data, bytes) else data.encode())
        return path

    def assert_one_line(self, text, *words):
        """Asserts that the text is exactly one line, not empty, and contains these words."""
        self.assertTrue(text.endswith(b"\n"), text)
        self.assertEqual(text.count(b"\n"), 1, text)
        self.assertGreater(len(text.strip()), 10, text)
        self.assert_words(text, *words)

    def assert_words(self, text, *words):
        """Asserts that a text, or a list, contains each of these words."""
        for word in words:
            self.assertIn(os.fsencode(word) if isinstance(text, bytes) else word, text)

    def assert_refusal(self, result, code, *words):
        """Asserts that a program ended with this code, without output but for one line on stderr that contains these words."""
        self.assertEqual((result.returncode, result.stdout or b""), (code, b""), result)
        self.assert_one_line(result.stderr, *words)


# --- the daemon


class Client:
    """A connection to the control socket. A separate thread reads all messages as they arrive."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(path)
        self.messages = queue.Queue()
        self.ids = iter(range(1, 1 << 30))
        self.seen = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        received = b""
        while True:
            try:
                data = self.socket.recv(65536)
            except OSError:
                data = b""
            if not data:
                return self.messages.put(None)
            *lines, received = (received + data).split(b"\n")
            for line in lines:
                self.messages.put(json.loads(line))

    def send(self, data):
        self.socket.sendall(data)

    def next(self, deadline_s=DEADLINE_S):
        """Returns the next message, or None once the daemon has closed the connection."""
        try:
            return self.messages.get(timeout=deadline_s)
        except queue.Empty:
            raise AssertionError(f"no message within {deadline_s:g} s") from None

    def wait_for(self, accept, what, deadline_s=DEADLINE_S):
        """Skips messages until `accept` returns true for one, and returns that message."""
        end = time.monotonic() + deadline_s
        while True:
            try:
                message = self.messages.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"timed out after {deadline_s:g} s waiting for {what}") from None
            if message is None:
                raise AssertionError(f"the connection ended before {what}")
            self.seen.append(message)
            if accept(message):
                return message

    def call(self, method, **parameters):
        """Returns the whole answer. Skips the notifications that arrive before it: use another client to watch."""
        number = next(self.ids)
        request = {"jsonrpc": "2.0", "method": method, "params": parameters, "id": number}
        self.send(json.dumps(request).encode() + b"\n")
        return self.wait_for(lambda m: m.get("id") == number, f"the answer to {method}")

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


def merge(base, changes):
    """Merges `changes` into `base`; None removes a key."""
    for key, value in changes.items():
        if value is None:
            base.pop(key, None)
        elif isinstance(value, dict) and isinstance(base.get(key), dict):
            merge(base[key], value)
        else:
            base[key] = value
    return base


def source_json(*parts):
    return json.loads(contents(os.path.join(SOURCE, "config", *parts)))


# A fast machine and a resin without delays, for tests in real time: a layer takes a few milliseconds.
NIMBLE_AXIS = {"homing_speed_mm_s": 50, "travel_speed_mm_s": 50, "acceleration_mm_s2": 5000}
NIMBLE_RESIN = {
    "exposure_ms": 1, "bottom_exposure_ms": 1, "bottom_layers": 1, "fade_layers": 0, "lift_mm": 0.1,
    "second_lift_mm": 0, "slow_retract_mm": 0, "lift_speed_mm_s": 50, "retract_speed_mm_s": 50, "settle_ms": 0, "rest_ms": 0,
}  # fmt: skip
# In real time, every print stays in its first exposure until the test ends it.
ENDLESS = {"exposure_ms": 120000, "bottom_exposure_ms": 120000}
REALTIME = {
    "z_axis": {**NIMBLE_AXIS, "travel_mm": 12}, "projector": {"warm_up_s": 0},
    "simulation": {"pace": "realtime", "start_height_mm": 0},
}  # fmt: skip


def realtime(**changes):
    return merge(json.loads(json.dumps(REALTIME)), changes)


class Daemon:
    """A contourd that runs in the test's folder, with the simulated printer's configuration and the test's changes to it.
    A daemon that still runs at the end of its test is stopped, and must exit with 0."""

    def __init__(self, test, config=None, resin=None, masks=False):
        self.test = test
        self.folder = test.folder
        self.process = None
        self.environment = {}
        self.rights = {}  # for Popen: user, group and so on
        self.program = CONTOURD
        self.clients = []
        self.log_path = os.path.join(self.folder, "contourd.log")
        self.spool = os.path.join(self.folder, "spool")
        self.socket_path = os.path.join(self.folder, "control.sock")
        self.config_path = os.path.join(self.folder, "contourd.json")
        self.config = source_json("simulated.json")
        if not masks:
            del self.config["simulation"]["masks_folder"]
        merge(self.config, {"supports": "off", "wait_for_plate_cleared": False, "min_free_disk_mb": 0, "job_ended_socket": "job-ended.socket"})
        merge(self.config, config or {})
        os.makedirs(os.path.join(self.folder, "resins"), exist_ok=True)
        self.write_resin("standard", resin or {})
        self.write_config()
        test.addCleanup(self._clean_up)

    def write_config(self):
        with open(self.config_path, "w", encoding="utf-8") as file:
            json.dump(self.config, file)

    def write_resin(self, name, changes):
        # Without the viscosity, no first layer waits a minute until the plate has pressed out the resin.
        profile = merge(merge(source_json("resins", "standard.json"), {"viscosity_mpa_s": None}), changes)
        path = os.path.join(self.folder, "resins", name + ".json")
        with open(path + ".new", "w", encoding="utf-8") as file:
            json.dump(profile, file)
        os.replace(path + ".new", path)  # the daemon may be reading it

    def start(self, *arguments, **environment):
        """Starts the daemon, and returns when it has reported that it is ready."""
        notify_path = os.path.join(self.folder, "notify.sock")
        with contextlib.suppress(FileNotFoundError):
            os.unlink(notify_path)
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
            notify.bind(notify_path)
            os.chmod(notify_path, 0o777)  # for a daemon of another user
            self.launch(*arguments, NOTIFY_SOCKET=notify_path, **environment)
            notify.settimeout(0.02)
            end = time.monotonic() + DEADLINE_S
            while True:
                with contextlib.suppress(TimeoutError):
                    if b"READY=1" in notify.recv(4096).split(b"\n"):
                        break
                if self.process.poll() is not None:
                    raise AssertionError(f"contourd ended with {self.process.returncode}:\n{self.log()}")
                if time.monotonic() > end:
                    raise AssertionError(f"contourd is not ready:\n{self.log()}")
        self.watcher = self.client()
        self.watcher.call("watch")
        # Jobs that were in the spool before the start may have ended by now: put them in front of the notifications.
        ended = self.watcher.call("history", this_run=True)["result"]["ended"]
        with self.watcher.messages.mutex:
            self.watcher.messages.queue.extendleft({"method": "ended", "params": {"last": job}} for job in reversed(ended))
        return self

    def launch(self, *arguments, **environment):
        """Starts the daemon without waiting for anything."""
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(
                [self.program, "--config", self.config_path, *arguments], stdin=subprocess.DEVNULL, stdout=log,
                stderr=log, env={**os.environ, **self.environment, **environment}, **self.rights)  # fmt: skip

    def log(self):
        return contents(self.log_path).decode(errors="replace")

    def client(self):
        client = Client(self.socket_path)
        self.clients.append(client)
        return client

    def rpc(self, method, **parameters):
        """Makes one call on a new connection."""
        client = self.client()
        try:
            return client.call(method, **parameters)
        finally:
            client.close()

    def status(self):
        return self.rpc("status")["result"]

    def put_on_slow_disk(self):
        """Preloads slow_disk.cpp, and returns the folder slow/ in which a test makes the files that control it: while
        slow/reads or slow/writes exists, the spool's disk does not answer; while slow/full exists, it has no room; while
        slow/read-only exists, nothing on it can be changed. Call this before start()."""
        folder = os.path.join(self.folder, "slow")
        os.mkdir(folder)
        self.environment = {"LD_PRELOAD": os.path.join(BIN, "libslow-disk.so"), "SLOW_DISK": folder}
        return folder

    def ctl(self, command, *arguments, **options):
        return contourctl(command, "--socket", self.socket_path, *arguments, **options)

    def alive(self):
        return self.process.poll() is None

    def stop(self):
        """Stops the daemon as systemd does. The daemon must exit with 0."""
        self.process.send_signal(signal.SIGTERM)
        self.wait_stopped()

    def restart(self):
        self.stop()
        return self.start()

    def wait_stopped(self):
        code = self.process.wait(DEADLINE_S)
        self._close_clients()
        if code != 0:
            raise AssertionError(f"contourd ended with {code}:\n{self.log()}")

    def reload(self):
        """Reloads the daemon as `systemctl reload` does."""
        self.process.send_signal(signal.SIGUSR1)

    def wait_restart(self):
        """Waits until the daemon exits with 75, the request to be started again."""
        code = self.process.wait(DEADLINE_S)
        self._close_clients()
        if code != 75:
            raise AssertionError(f"contourd ended with {code}:\n{self.log()}")

    @property
    def state_folder(self):
        return self.environment.get("STATE_DIRECTORY", self.spool + ".state")

    def records_a_part(self):
        """True if the print's record says that its plate has come down (daemon/progress/progress_record.cpp)."""
        try:
            text = contents(os.path.join(self.state_folder, "print-progress"))
        except FileNotFoundError:
            return False
        copies = [text[at + 36:at + 4096].split(b"\0") for at in (0, 65536)]
        latest = max((copy for copy in copies if copy[0]), key=lambda copy: int(copy[0]), default=None)
        return latest is not None and latest[7] != b"0"

    def kill(self, while_reading=False):
        """Kills the daemon. Waits for the end of a reading first, unless `while_reading`: the next daemon refuses a file during
        whose reading it was killed (daemon/spool/reading_record.hpp)."""
        if not while_reading:
            wait_until(lambda: not os.path.exists(os.path.join(self.state_folder, "reading")), "the end of a reading")
        self.process.kill()
        self.process.wait(DEADLINE_S)
        self._close_clients()

    def _close_clients(self):
        while self.clients:
            self.clients.pop().close()

    def _clean_up(self):
        if self.process is None:
            return
        if self.alive():
            self.process.send_signal(signal.SIGCONT)  # a failed test may leave it stopped
            try:
                self.stop()
            finally:
                self.process.kill()
                self.process.wait()
        self._close_clients()
        if self.process.returncode < 0 and self.process.returncode != -signal.SIGKILL:
            raise AssertionError(f"contourd died of signal {-self.process.returncode}:\n{self.log()}")

    @contextlib.contextmanager
    def held_thread(self, name):
        """Waits until the daemon's thread of this name sleeps, and stops that thread until the end of the block."""
        def find():
            for thread in os.listdir(f"/proc/{self.process.pid}/task"):
                with open(f"/proc/{self.process.pid}/task/{thread}/stat", encoding="utf-8") as file:
                    if f"({name}) S " in file.read():
                        return int(thread)
            return None
        wait_until(find, f"the thread {name} to sleep")
        thread = find()
        _ptrace(PTRACE_SEIZE, thread)
        _ptrace(PTRACE_INTERRUPT, thread)
        os.waitpid(thread, WALL)
        try:
            yield
        finally:
            _ptrace(PTRACE_DETACH, thread)

    # --- the spool

    def file(self, *parts):
        return os.path.join(self.spool, *parts)

    def has(self, *parts):
        return os.path.lexists(self.file(*parts))

    def names_in(self, folder):
        return sorted(os.listdir(self.file(folder)))

    def read(self, *parts):
        return text_of(self.file(*parts))

    def state(self, name):
        """Returns the text of a file in the daemon's state folder."""
        return text_of(os.path.join(self.spool + ".state", name))

    def drop(self, name, data, ticket=None):
        """Puts a complete file into the spool, its ticket first."""
        if ticket is not None:
            text = ticket if isinstance(ticket, (str, bytes)) else json.dumps(ticket)
            self._put(os.path.splitext(name.removesuffix(".gz"))[0] + ".json", text.encode() if isinstance(text, str) else text)
        self._put(name, data)

    def drop_plate(self, name, ticket, files):
        """Puts a complete plate into the spool; `files` has the contents of its models by name."""
        staging = os.path.join(self.folder, "staged-plate")
        os.mkdir(staging)
        text = ticket if isinstance(ticket, (str, bytes)) else json.dumps(ticket)
        for file, data in {**files, "plate.json": text.encode() if isinstance(text, str) else text}.items():
            with open(os.path.join(staging, file), "wb") as out:
                out.write(data)
        os.makedirs(self.file("incoming"), exist_ok=True)
        os.rename(staging, self.file("incoming", name))

    def _put(self, name, data):
        # Written elsewhere and moved in, so that the daemon never sees half a file.
        staging = os.path.join(self.folder, "staging")
        os.makedirs(self.file("incoming"), exist_ok=True)
        with open(staging, "wb") as file:
            file.write(data)
        os.rename(staging, self.file("incoming", name))

    def wait_ended(self, job, deadline_s=DEADLINE_S):
        """Waits until the job has ended, and returns {"job", "outcome", "reason"}. Skips the ends of other jobs."""
        def is_end(message):
            return message.get("method") == "ended" and message["params"]["last"]["job"] == job
        try:
            return self.watcher.wait_for(is_end, f"the end of {job}", deadline_s)["params"]["last"]
        except AssertionError as error:
            raise AssertionError(f"{error}\n{self.log()}") from None

    def cancel(self, job):
        self.rpc("cancel")
        return self.wait_ended(job)

    def wait_next_end(self):
        """Waits until any job has ended, and returns {"job", "outcome", "reason"}."""
        return self.watcher.wait_for(lambda m: m.get("method") == "ended", "the end of a job")["params"]["last"]

    def wait_outcomes(self, expected):
        """Waits until as many jobs have ended as are expected, in any order, and asserts that they are these jobs with these
        outcomes. Returns the jobs in the order in which they ended."""
        ends = [self.wait_next_end() for _ in expected]
        self.test.assertEqual({end["job"]: end["outcome"] for end in ends}, expected, self.log())
        return [end["job"] for end in ends]

    def wait_done(self, job):
        """Waits until the job is printed, and returns its report."""
        end = self.wait_ended(job)
        if end["outcome"] != "done":
            raise AssertionError(f"{end}\n{self.log()}")
        return self.report(job)

    def wait_refused(self, job):
        """Waits until the job has failed, and returns its reason, which must be the same in the file and on the socket."""
        end = self.wait_ended(job)
        if end["outcome"] != "failed":
            raise AssertionError(f"{end}\n{self.log()}")
        reason = self.read("failed", job + ".reason.txt")
        self.test.assertTrue(reason.endswith("\n"), reason)
        self.test.assertEqual(reason.strip(), end["reason"].strip())
        self.test.assertGreater(len(reason), 10)
        return reason

    def printed(self, name, data, ticket=None):
        """Puts a file into the spool, waits until it is printed, and returns its report."""
        self.drop(name, data, ticket)
        return self.wait_done(os.path.splitext(name.removesuffix(".gz"))[0])

    def refused(self, name, data, ticket=None):
        """Puts a file into the spool, waits until it has failed, and returns the reason."""
        self.drop(name, data, ticket)
        return self.wait_refused(os.path.splitext(name)[0])

    def wait_status(self, key, value=True):
        """Waits until the status has this value, or with True any value that is true, and returns the status."""
        def reached():
            status = self.status()
            return status if (status[key] if value is True else status[key] == value) else None
        return wait_until(reached, f"{key} to be {value} in the status")

    def job(self, name):
        """Returns a job of the queue, {} if there is none of this name."""
        return next((job for job in self.rpc("queue")["result"]["jobs"] if job["job"] == name), {})

    def wait_job(self, name, state="unaccepted"):
        """Waits until a job of the queue has this state, and returns the job."""
        wait_until(lambda: self.job(name).get("state") == state, f"{name} to be {state}")
        return self.job(name)

    def begin(self, name, data, ticket=None):
        """Puts a file into the spool, and waits until its first layer is exposed."""
        self.drop(name, data, ticket)
        return self.wait_state("exposing")

    def wait_state(self, state):
        """Waits until the print enters the state. Looks only at notifications after the last one that was waited for."""
        return self.watcher.wait_for(
            lambda m: m.get("method") == "state" and m["params"]["state"] == state, f"the state {state}")["params"]

    def report(self, job, folder="done"):
        return json.loads(self.read(folder, job + ".report.json"))


# --- tests of the spool

WAITS = {"wait_for_plate_cleared": True}


class SpoolTest(FolderTest):
    """A test of the spool, with the simulated printer."""

    def daemon(self, config=None, resin=None, **options):
        return Daemon(self, config, resin, **options)

    def printing_daemon(self, **config):
        return self.printing("first.stl", SLAB, **config)

    def second_daemon(self, name, config):
        """Returns another daemon in the same folder, with its own configuration, socket and log."""
        second = Daemon(self)
        second.config_path, second.log_path = self.path(name + ".json"), self.path(name + ".log")
        second.spool, second.socket_path = self.path(config["spool_folder"]), self.path(name + ".sock")
        merge(second.config, {**config, "control_socket": name + ".sock"})
        second.write_config()
        return second

    def looks_pass(self, daemon):
        """Waits until the daemon refuses an empty file; meanwhile it looks at all incomplete files several times."""
        daemon.refused("empty.stl", b"")
        for suffix in ("stl", "reason.txt"):
            os.unlink(daemon.file("failed", "empty." + suffix))
