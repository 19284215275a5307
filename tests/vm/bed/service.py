"""contourd as a service in a Debian with systemd: steps that its tests share."""

import base64
import gzip
import json
import traceback
from contextlib import contextmanager

from bed.architecture import AMD64
from bed.edge_log import EdgeLog
from bed.frame_log import FrameLog
from bed.qemu import GuestFailure, Machine

SPOOL = "/var/spool/contourd"

# docs/printer-setup.md, "Upgrade and uninstall".
_INSTALL = (
    "systemd-sysusers && systemd-tmpfiles --create",
    "systemctl daemon-reload && systemctl enable --now contourd",
)


@contextmanager
def booted(initramfs, disk, extra=()):
    """Boots the machine, with `extra` options for QEMU; a failure is reported with the machine's journal."""
    with Machine(AMD64, initramfs, disk=disk, extra=extra) as machine:
        machine.wait_until_ready()
        try:
            yield machine
        except AssertionError as error:
            what = str(error) or "".join(traceback.format_tb(error.__traceback__))
            raise AssertionError(f"{what}\n{_circumstances(machine)}") from None


def _circumstances(machine):
    try:
        return machine.run(f"journalctl -u contourd --no-pager | tail -30; ls -lR {SPOOL}", check=False)
    except (GuestFailure, OSError):
        return "(and the guest does not answer any more)"


def install(machine):
    for command in _INSTALL:
        machine.run(command)


def unit_property(machine, name):
    return machine.run(f"systemctl show -P {name} contourd")


def submit(machine, name="part"):
    machine.run(f"cp /root/part.stl {SPOOL}/.{name} && mv {SPOOL}/.{name} {SPOOL}/incoming/{name}.stl")


def journal(machine, event):
    """Returns the service's journal entries with that EVENT, as dictionaries of their fields."""
    lines = machine.run("journalctl -u contourd -o json --all --no-pager").splitlines()
    return [entry for entry in map(json.loads, lines) if entry.get("EVENT") == event]


def device_logs(machine):
    """Returns the records of the axis and the display so far."""
    machine.run("gzip -c /sys/kernel/debug/zplant/log >/run/edges; gzip -c /sys/kernel/debug/zproj/log >/run/frames")
    edges, frames = (gzip.decompress(base64.b64decode(machine.run(f"base64 /run/{name}"))) for name in ("edges", "frames"))
    return EdgeLog(edges), FrameLog(frames.decode())
