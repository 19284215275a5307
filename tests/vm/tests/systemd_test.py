"""contourd as a service of a real Debian system: installed as its README says, with simulated hardware."""

import json
from contextlib import contextmanager

from bed import guests, models
from bed.architecture import AMD64, host_root
from bed.qemu import GuestFailure, Machine, disk_over
from bed.registry import vm_test

_LAYERS = 4
_MODEL_MM = 0.2
_SPOOL = "/var/spool/contourd"

# README.md, "On a Raspberry Pi".
_INSTALL = (
    "systemd-sysusers && systemd-tmpfiles --create",
    "systemctl daemon-reload && systemctl enable --now contourd",
)


@contextmanager
def _booted(initramfs, disk):
    with Machine(AMD64, initramfs, disk=disk) as machine:
        machine.wait_until_ready()
        try:
            yield machine
        except AssertionError as error:
            raise AssertionError(f"{error}\n{_circumstances(machine)}") from None


def _circumstances(machine):
    """What one wants to see of a guest in which something went wrong."""
    try:
        return machine.run(f"journalctl -u contourd --no-pager | tail -30; ls -lR {_SPOOL}", check=False)
    except GuestFailure:
        return "(and the guest does not answer any more)"


def _guest(**resin):
    guest = guests.systemd_guest(guests.simulated_config(), resin={**guests.QUICK_RESIN, **resin})
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(_MODEL_MM)))
    return guest


def _install(machine):
    for command in _INSTALL:
        machine.run(command)


def _property(machine, name):
    return machine.run(f"systemctl show -P {name} contourd")


def _submit(machine, name="part"):
    machine.run(f"cp /root/part.stl {_SPOOL}/.{name} && mv {_SPOOL}/.{name} {_SPOOL}/incoming/{name}.stl")


def _journal(machine):
    lines = machine.run("journalctl -u contourd -o json --all --no-pager").splitlines()
    return [json.loads(line) for line in lines]


def _entries(machine, event):
    return [entry for entry in _journal(machine) if entry.get("EVENT") == event]


def _starts_and_prints(machine):
    _install(machine)
    assert _property(machine, "Type") == "notify" and _property(machine, "ActiveState") == "active"
    assert _property(machine, "User") == "contourd"
    assert len(_entries(machine, "ready")) == 1
    _submit(machine)
    machine.wait_for(f"test -e {_SPOOL}/done/part.stl", limit_s=120)
    layers = _entries(machine, "layer")
    assert [entry["LAYER"] for entry in layers] == [str(i) for i in range(1, _LAYERS + 1)], layers
    assert [entry["Z_NM"] for entry in layers] == [str(50_000 * i) for i in range(1, _LAYERS + 1)], layers
    assert all(entry["JOB_ID"] == "part" and entry["_SYSTEMD_UNIT"] == "contourd.service" for entry in layers)


def _stops_cleanly(machine):
    machine.run("systemctl stop contourd")
    assert _property(machine, "Result") == "success" and _property(machine, "ActiveState") == "inactive"
    assert len(_entries(machine, "stopped")) == 1
    machine.run("test ! -e /run/contourd")


def _is_restarted_when_it_stalls(machine):
    # The unit waits 30 s; less here, so that the test does not.
    machine.run("mkdir -p /run/systemd/system/contourd.service.d")
    machine.run(r"printf '[Service]\nWatchdogSec=4\n' >/run/systemd/system/contourd.service.d/watchdog.conf")
    machine.run("systemctl daemon-reload && systemctl start contourd")
    _submit(machine, "stalled")
    machine.wait_for("contourctl status --json | grep -q '\"layer\"'")
    machine.run("kill -STOP $(systemctl show -P MainPID contourd)")
    machine.wait_for("test $(systemctl show -P NRestarts contourd) = 1", limit_s=60)
    machine.wait_for("systemctl is-active contourd")
    machine.wait_for(f"test -e {_SPOOL}/failed/stalled.stl")
    reason = machine.run(f"cat {_SPOOL}/failed/stalled.reason.txt")
    assert reason.strip(), "no reason"
    assert "Watchdog timeout" in machine.run("journalctl -u contourd --no-pager")
    return reason


@vm_test("quick")
def systemd():
    """The unit starts and is ready, a print's journal has its fields, it stops cleanly, and when it stalls in a print the
    watchdog starts it again: the job is filed as failed with its reason, and nothing else is lost."""
    with guests.written(_guest()) as initramfs, disk_over(host_root()) as disk:
        with _booted(initramfs, disk) as machine:
            _starts_and_prints(machine)
            _stops_cleanly(machine)
            _is_restarted_when_it_stalls(machine)
            machine.run(f"cmp /root/part.stl {_SPOOL}/done/part.stl && cmp /root/part.stl {_SPOOL}/failed/stalled.stl")
            assert len(_entries(machine, "layer")) >= _LAYERS, "the journal lost entries"
            machine.power_off()


@vm_test("full")
def power_cut():
    """The power fails in a print: after the next boot the job lies in failed/ with its reason, whole, the one behind it
    is printed, and a done one is still there."""
    with guests.written(_guest(exposure_ms=3000, bottom_exposure_ms=3000)) as initramfs, disk_over(host_root()) as disk:
        with _booted(initramfs, disk) as machine:
            _install(machine)
            _submit(machine, "first")
            machine.wait_for(f"test -e {_SPOOL}/done/first.stl", limit_s=120)
            _submit(machine, "cut")
            machine.wait_for("contourctl status --json | grep -q '\"layer\"'")
            _submit(machine, "waiting")
            # Whoever copies a file owes it this; what has been claimed is the daemon's to keep.
            machine.run(f"sync {_SPOOL}/incoming/waiting.stl")
            machine.wait_for("contourctl status --json | grep -q waiting")
            machine.kill()
        with _booted(initramfs, disk) as machine:
            machine.wait_for("systemctl is-active contourd")
            machine.wait_for(f"test -e {_SPOOL}/done/waiting.stl", limit_s=120)
            reason = machine.run(f"cat {_SPOOL}/failed/cut.reason.txt")
            for file in ("done/first", "failed/cut", "done/waiting"):
                machine.run(f"cmp /root/part.stl {_SPOOL}/{file}.stl")
            assert machine.run(f"ls -A {_SPOOL}/printing {_SPOOL}/incoming").count(".stl") == 0
            machine.power_off()
    return reason.strip()
