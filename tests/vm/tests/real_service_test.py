"""contourd as a service with its real hardware, on both Debians: libgpiod 1.6 and 2, the unit's sandbox, the devices'
permissions, and what becomes of the light when the daemon is killed."""

from bed import exposure_checks, guests, models, motion_checks
from bed.architecture import root_image
from bed.motion_checks import MotionLimits
from bed.qemu import disk_over
from bed.registry import check, vm_test
from bed.service import SPOOL, booted, device_logs, install, journal, submit, unit_property

_RESIN = {**guests.QUICK_RESIN, "exposure_ms": 4000, "bottom_exposure_ms": 4000}
_MODULES = ("zplant start_pos=2000 bounce_us=300", "zproj", "zserial")
_PROJECTOR = f"systemd-run --unit=projector /usr/local/bin/fake-projector /dev/ttyZ1 9600 /run/projector {guests.ACER}"


def _prints(machine):
    install(machine)
    assert unit_property(machine, "ActiveState") == "active"
    submit(machine)
    machine.wait_for(f"test -e {SPOOL}/done/part.stl", limit_s=240)
    assert [entry["LAYER"] for entry in journal(machine, "layer")] == ["1", "2"]
    edges, frames = device_logs(machine)
    assert [edges.position_at(picture.start_ns) for picture in frames.lit_pictures()] == [40, 80]
    check(exposure_checks.light_only_on_masks(frames, edges))
    check(exposure_checks.dark_at_the_end(frames, edges))
    check(motion_checks.lost_steps(edges) + motion_checks.pulse_widths(edges, MotionLimits()))
    check(motion_checks.direction_setups(edges, MotionLimits()))


def _is_killed_in_an_exposure(machine):
    """How long the light stayed on, in ns."""
    submit(machine, "killed")
    machine.wait_for(". /root/lib.sh; light_is_on", limit_s=120)
    machine.run("kill -9 $(systemctl show -P MainPID contourd)")
    killed_ns = int(float(machine.run("cut -d' ' -f1 /proc/uptime")) * 1e9)
    machine.wait_for("test $(systemctl show -P NRestarts contourd) = 1 && systemctl is-active contourd", limit_s=60)
    machine.wait_for(f"test -e {SPOOL}/failed/killed.reason.txt")
    edges, frames = device_logs(machine)
    check(exposure_checks.dark_at_the_end(frames, edges))
    return edges.active(edges.lines.light)[-1][1] - killed_ns


def _run(debian=None):
    guest = guests.systemd_guest(guests.real_config(), _RESIN, _MODULES, debian)
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(0.1)))
    with guests.written(guest) as initramfs, disk_over(root_image(debian)) as disk:
        with booted(initramfs, disk) as machine:
            machine.run(_PROJECTOR)
            _prints(machine)
            lit_ns = _is_killed_in_an_exposure(machine)
            machine.power_off()
    return f"killed in an exposure: light off {lit_ns / 1e6:.0f} ms later"


@vm_test("full")
def real_service():
    """The installed service prints with real devices as its own user; killed in an exposure it leaves no light on."""
    return _run()


@vm_test("full", other_debian=True)
def real_service_on_the_other_debian():
    """The same on the other Debian: with libgpiod 2 where this is Debian 12."""
    return _run("bookworm" if root_image().name == "root-trixie.ext4" else "trixie")
