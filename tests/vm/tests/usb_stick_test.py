"""A USB stick that is plugged in: its models are queued once, and it can be pulled out at any moment."""

import contextlib
import hashlib
import os
import subprocess
import tempfile
from pathlib import Path

from bed import guests, models
from bed.architecture import BED, root_image
from bed.qemu import disk_over
from bed.registry import vm_test
from bed.service import SPOOL, booted, install

_INCOMING = f"{SPOOL}/incoming"
_SAID = "journalctl -t contourd-usb -o cat --no-pager"
_PART = models.binary_stl(models.twisted_star(0.1))
# A file that the slow stick delivers in half a minute.
_SLOW_BYTES_PER_S = 100_000
_LARGE = models.binary_stl(models.twisted_star(0.1) * 65)
_MODULES = ("xhci_pci", "usb_storage", "sd_mod", "vfat", "nls_cp437", "nls_ascii")


def _guest():
    guest = guests.systemd_guest(guests.simulated_config(wait_for_plate_cleared=True), resin=guests.QUICK_RESIN)
    guest.add_kernel_modules(*_MODULES)
    return guest


class Sticks:
    """Images of sticks, with QEMU's options for them."""

    def __init__(self, folder):
        self._folder, self.options = Path(folder), ["-device", "qemu-xhci,id=usb"]

    def image(self, name):
        return self._folder / name

    def fat(self, name, files):
        image = self.image(name)
        subprocess.run(["mkfs.vfat", "-C", "-n", "STICK", image, "16384"], check=True, capture_output=True)
        for path, data in files.items():
            source = self.image("file")
            source.write_bytes(data)
            subprocess.run(["mcopy", "-i", image, source, f"::{path}"], check=True)
        self._add(name)

    def ext4(self, name, make_files):
        """Makes an ext4 image. `make_files` creates its content in the folder that it is given."""
        with tempfile.TemporaryDirectory(dir=self._folder) as root:
            Path(root).chmod(0o755)
            make_files(Path(root))
            subprocess.run(["mke2fs", "-q", "-t", "ext4", "-e", "panic", "-d", root, self.image(name), "16M"],
                           check=True, capture_output=True)  # fmt: skip
        self._add(name)

    def bytes(self, name, data):
        self.image(name).write_bytes(data)
        self._add(name)

    def _add(self, name):
        self.options += ["-blockdev", f"driver=file,node-name={name},filename={self.image(name)}"]

    def slow(self, name):
        self.options += ["-object", f"throttle-group,id=limits,x-bps-read={_SLOW_BYTES_PER_S}",
                         "-blockdev", f"driver=throttle,node-name={name}-slow,throttle-group=limits,file={name}"]  # fmt: skip


@contextlib.contextmanager
def _machine(make_sticks):
    with tempfile.TemporaryDirectory(prefix="sticks.", dir=BED) as folder:
        sticks = Sticks(folder)
        make_sticks(sticks)
        with guests.written(_guest()) as initramfs, disk_over(root_image()) as disk:
            with booted(initramfs, disk, sticks.options) as machine:
                install(machine)
                machine.run("udevadm control --reload")
                yield machine, sticks
                machine.power_off()


def _enable(machine):
    machine.run("systemctl enable contourd-usb@.service")


def _plug(machine, name):
    machine.qmp("device_add", driver="usb-storage", id="plugged", bus="usb.0", drive=name)


def _unplug(machine):
    """Unplugs the stick and checks that no unit remains, neither active nor failed."""
    machine.qmp("device_del", id="plugged")
    machine.wait_for("test ! -e /dev/sda")
    machine.wait_for("test -z \"$(systemctl list-units --all --no-legend 'contourd-usb@*')\"", limit_s=120)


def _is_over(machine):
    """Waits until no unit of the stick is running, and checks that no mount namespace contains the stick. The unit of an
    unreadable stick stays listed as failed while the stick is plugged in, because its device wants the unit, whatever
    CollectMode= says."""
    states = "activating,active,reloading,deactivating"
    machine.wait_for(f"test -z \"$(systemctl list-units --all --state={states} --no-legend 'contourd-usb@*')\"", limit_s=120)
    machine.run("! grep -qs /dev/sda /proc/[0-9]*/mountinfo")


def _plug_and_wait(machine, name, word):
    before = machine.run(f"{_SAID} | wc -l")
    _plug(machine, name)
    machine.wait_for(f"{_SAID} | tail -n +{int(before) + 1} | grep -q '{word}'", limit_s=120)
    _is_over(machine)
    said = machine.run(f"{_SAID} | tail -n +{int(before) + 1}")
    _unplug(machine)
    return said


def _is_left_alone_as_installed(machine):
    _plug(machine, "good")
    machine.wait_for("test -b /dev/sda && udevadm settle")
    machine.wait_for("systemctl is-active dev-sda.device")
    machine.run(f"test -z \"$({_SAID})\" && test -z \"$(ls {_INCOMING})\"")
    _unplug(machine)


def _is_printed_once(machine):
    said = _plug_and_wait(machine, "good", "second.STL: job second")
    assert "first.stl: job first" in said, said
    machine.wait_for(f"test -e {SPOOL}/done/first.stl", limit_s=200)
    machine.run(f"grep -q '\"copies\": 2' {SPOOL}/done/first.json")
    machine.run(f"test $(stat -c %U {SPOOL}/done/first.stl) = contourd-usb")
    # The plate is occupied.
    machine.wait_for("contourctl status | grep -q '^waiting.*plate'")
    machine.run(f"test -e {_INCOMING}/second.stl")
    said = _plug_and_wait(machine, "good", "nothing to take")
    assert "2 were taken before" in said, said


def _hostile(root):
    (root / "good.stl").write_bytes(_PART)
    os.symlink("/etc/shadow", root / "shadow.stl")
    os.symlink("/var/spool/contourd", root / "spool")
    os.mkfifo(root / "fifo.stl")
    (root / "new\nline\x1b[2J.stl").write_bytes(_PART)
    with open(root / "sparse.stl", "wb") as file:
        file.truncate(200 << 30)
    os.mknod(root / "device.stl", 0o666 | 0o60000, os.makedev(254, 0))
    (root / "secret.stl").write_bytes(_PART)
    (root / "secret.stl").chmod(0)


def _hostile_stick_is_taken_for_what_it_is(machine):
    said = _plug_and_wait(machine, "hostile", "sparse.stl. is not taken")
    for name in ("shadow", "fifo", "device", "secret", "sparse"):
        assert f'"{name}.stl" is not taken' in said, said
    assert "good.stl: job good" in said and ": job new_line_[2J" in said, said
    listed = machine.run(f"ls {_INCOMING}").splitlines()
    assert sorted(listed) == ["good.stl", "new_line_[2J.stl", "second.stl"], listed


def _make_sticks(sticks):
    sticks.fat("good", {"first.stl": _PART, "first.json": b'{"copies": 2}', "second.STL": _PART})
    sticks.ext4("hostile", _hostile)
    # Only the first bytes of a file system.
    sticks.bytes("broken", sticks.image("hostile").read_bytes()[:4096] + b"\xff" * (1 << 20))


@vm_test("full")
def usb_stick():
    """Once the unit is enabled, a stick's models are queued, each once, with their tickets; the stick is mounted for no
    other process and stays unchanged; links, FIFOs, devices, endless files and broken file systems are reported and do no
    harm; before the unit is enabled, sticks are ignored."""
    with _machine(_make_sticks) as (machine, sticks):
        before = {name: hashlib.sha256(sticks.image(name).read_bytes()).digest() for name in ("good", "hostile")}
        _is_left_alone_as_installed(machine)
        _enable(machine)
        _is_printed_once(machine)
        _hostile_stick_is_taken_for_what_it_is(machine)
        _plug_and_wait(machine, "broken", "cannot be read")
        machine.run("systemctl is-active contourd && contourctl status")
        assert before == {name: hashlib.sha256(sticks.image(name).read_bytes()).digest() for name in before}


def _make_slow_stick(sticks):
    sticks.fat("large", {"large.stl": _LARGE})
    sticks.slow("large")


@vm_test("full")
def usb_stick_pulled_out():
    """A stick that is pulled out during copying leaves nothing in the spool, no mount and no process, and delays no other
    job; when it is plugged in again its model is copied completely."""
    with _machine(_make_slow_stick) as (machine, _):
        _enable(machine)
        _plug(machine, "large-slow")
        machine.wait_for(f"ls -l /proc/[0-9]*/fd 2>/dev/null | grep -q '{_INCOMING}/#'", limit_s=120)
        _unplug(machine)
        _is_over(machine)
        machine.run(f"test -z \"$(ls -A {_INCOMING})\" && systemctl is-active contourd")
        said = _plug_and_wait(machine, "large-slow", ": job large")
        assert "is not taken" not in said, said
        machine.wait_for(f"test -e {SPOOL}/done/large.stl || test -e {_INCOMING}/large.stl || test -e {SPOOL}/printing/large.stl")
        assert machine.run(f"cat {SPOOL}/*/large.stl | wc -c") == str(len(_LARGE))
