"""Runs guests: in deterministic time to the end of their scenario, or in real time with a command line. Always with
QEMU's emulator (TCG); every run has a time limit."""

import io
import json
import os
import signal
import socket
import subprocess
import tarfile
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from bed.architecture import BED

# The space for a scenario's files in /out.
_RESULTS_BYTES = 128 << 20


class GuestFailure(AssertionError):
    """The guest failed at something that every guest must do: start, answer, end."""


def _common(arch, initramfs, memory_mb, options=""):
    return [
        arch.qemu, "-M", arch.machine, "-cpu", arch.cpu, "-m", str(memory_mb), "-nodefaults", "-no-user-config",
        "-display", "none", "-no-reboot", "-kernel", str(arch.kernel), "-initrd", str(initramfs),
        # no_timer_check: on a busy host the timer's interrupts are so late that the kernel would reject the timer.
        "-append", f"console={arch.console} quiet panic=-1 mitigations=off no_timer_check {options}",
    ]  # fmt: skip


def _drive(path, kind="raw"):
    return ["-drive", f"file={path},format={kind},if=none,id=disk,cache=writeback", "-device", "virtio-blk-pci,drive=disk"]


@contextmanager
def disk_over(image):
    """Makes a disk with the image's content that is written separately from the image, as long as the context. The disk
    survives the end of its machine, as in a power cut."""
    with tempfile.TemporaryDirectory(prefix="disk.", dir=BED) as folder:
        disk = Path(folder, "disk.qcow2")
        command = ["qemu-img", "create", "-q", "-f", "qcow2", "-b", str(image), "-F", "raw", str(disk)]
        subprocess.run(command, check=True)
        yield disk


class Results:
    """The files that a scenario left in /out, by name."""

    def __init__(self, tar):
        self._files = {}
        with tarfile.open(fileobj=io.BytesIO(tar)) as archive:
            for member in archive:
                if member.isfile():
                    self._files[member.name.removeprefix("./")] = archive.extractfile(member).read()

    def __contains__(self, name):
        return name in self._files

    def names(self):
        return sorted(self._files)

    def bytes(self, name):
        return self._files[name]

    def text(self, name):
        return self._files[name].decode(errors="replace")

    def save(self, folder):
        for name, data in self._files.items():
            path = Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)


def run_scenario(arch, initramfs, limit_s=300, memory_mb=512, shift=1):
    """Boots and runs /scenario in deterministic time: the guest's clock counts instructions (2^shift ns each) and idle
    time is skipped. The guest has no connection to the outside, so runs of the same initramfs are identical. Returns its
    Results."""
    with tempfile.TemporaryDirectory(prefix="run.", dir=BED) as folder:
        disk, console = Path(folder, "results"), Path(folder, "console")
        with open(disk, "wb") as file:
            file.truncate(_RESULTS_BYTES)
        command = _common(arch, initramfs, memory_mb) + _drive(disk) + [
            "-accel", "tcg,thread=single", "-icount", f"shift={shift},sleep=off", "-seed", "1",
            "-rtc", "base=2026-01-01,clock=vm", "-serial", f"file:{console}",
        ]  # fmt: skip
        try:
            subprocess.run(command, timeout=limit_s, check=True, stdin=subprocess.DEVNULL, capture_output=True)
        except subprocess.TimeoutExpired:
            raise GuestFailure(f"the guest did not end within {limit_s} s:\n{_tail(console)}") from None
        except subprocess.CalledProcessError as error:
            raise GuestFailure(f"QEMU failed: {error.stderr.decode()}") from None
        try:
            return Results(disk.read_bytes())
        except tarfile.ReadError:
            raise GuestFailure(f"the guest left no results:\n{_tail(console)}") from None


def _tail(path):
    return path.read_text(errors="replace")[-3000:] if path.exists() else ""


class Machine:
    """A guest in real time. run() executes commands, one line of shell each."""

    def __init__(self, arch, initramfs, disk=None, extra=(), memory_mb=512, cpus=1, limit_s=600, options=""):
        self._folder = tempfile.TemporaryDirectory(prefix="run.", dir=BED)
        folder = Path(self._folder.name)
        self.console = folder / "console"
        command = _common(arch, initramfs, memory_mb, options) + (_drive(disk, "qcow2") if disk else []) + [
            "-accel", "tcg", "-smp", str(cpus), "-serial", f"file:{self.console}",
            "-qmp", f"unix:{folder}/qmp,server=on,wait=off", "-device", "virtio-serial-pci",
            "-chardev", f"socket,id=ctl,path={folder}/ctl,server=on,wait=off", "-device", "virtserialport,chardev=ctl,name=ctl",
            *extra,
        ]  # fmt: skip
        self._output = open(folder / "qemu", "w")
        self._process = subprocess.Popen(
            ["timeout", "-k", "5", str(limit_s), *command], stdin=subprocess.DEVNULL, stdout=self._output,
            stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            self._control = self._connect(folder / "ctl")
            self._qmp = self._connect(folder / "qmp").makefile("rw")
            self._qmp.readline()
            self.qmp("qmp_capabilities")
        except BaseException:
            self.kill()
            raise
        self._received = b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()

    def _connect(self, path):
        deadline = time.monotonic() + 20
        while True:
            peer = socket.socket(socket.AF_UNIX)
            try:
                peer.connect(str(path))
                return peer
            except OSError:
                peer.close()
                if self._process.poll() is not None or time.monotonic() > deadline:
                    raise GuestFailure(f"QEMU did not start: {_tail(Path(self._output.name))}") from None
                time.sleep(0.02)

    def _line(self, deadline):
        while b"\n" not in self._received:
            self._control.settimeout(max(0.01, deadline - time.monotonic()))
            try:
                received = self._control.recv(65536)
            except TimeoutError:
                raise GuestFailure(f"the guest did not answer in time:\n{_tail(self.console)}") from None
            if not received:
                raise GuestFailure(f"the guest is gone:\n{_tail(self.console)}")
            self._received += received
        line, self._received = self._received.split(b"\n", 1)
        return line.decode(errors="replace").rstrip("\r")

    def wait_until_ready(self, limit_s=180):
        deadline = time.monotonic() + limit_s
        while not self._line(deadline).startswith("READY"):
            pass

    def run(self, command, limit_s=120, check=True):
        """Runs one line of shell and returns its output. With check, an exit code other than 0 is a failure."""
        deadline = time.monotonic() + limit_s
        self._control.sendall(command.encode() + b"\n")
        lines = []
        while not (line := self._line(deadline)).startswith("__RC "):
            lines.append(line)
        output = "\n".join(lines).rstrip("\n")
        if check and line != "__RC 0":
            raise GuestFailure(f"{command!r} ended with {line[5:]}: {output}")
        return output

    def wait_for(self, command, limit_s=60, pause_s=0.2):
        """Repeats the command until it succeeds, and returns its output."""
        deadline = time.monotonic() + limit_s
        while True:
            output = self.run(f"{{ {command}; }} && echo __YES", check=False)
            if output.endswith("__YES"):
                return output.removesuffix("__YES").rstrip("\n")
            if time.monotonic() > deadline:
                raise GuestFailure(f"timed out after {limit_s} s waiting for {command!r}: {output}\n{_tail(self.console)}")
            time.sleep(pause_s)

    def qmp(self, command, **arguments):
        self._qmp.write(json.dumps({"execute": command, "arguments": arguments}) + "\n")
        self._qmp.flush()
        while True:
            reply = json.loads(self._qmp.readline())
            if "error" in reply:
                raise GuestFailure(f"{command}: {reply['error']['desc']}")
            if "return" in reply:
                return reply["return"]

    def power_off(self, limit_s=60):
        """Powers off by the guest's own command."""
        self._control.sendall(b"poweroff\n")
        try:
            self._process.wait(limit_s)
        except subprocess.TimeoutExpired:
            raise GuestFailure(f"the guest did not power off within {limit_s} s:\n{_tail(self.console)}") from None

    def kill(self):
        """Ends the guest like a power cut."""
        # QEMU is a child of timeout, which exits after it. So when timeout has exited, QEMU is gone and its disk is free.
        while self._process.poll() is None:
            for child in Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children").read_text().split():
                os.kill(int(child), signal.SIGKILL)
            try:
                self._process.wait(0.1)
            except subprocess.TimeoutExpired:
                pass
        self._output.close()
        self._folder.cleanup()
