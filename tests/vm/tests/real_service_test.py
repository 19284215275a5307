"""contourd as a service with its real hardware, on both Debian releases: libgpiod 1.6 and 2, the unit's sandbox, the
devices' permissions, and the light after the daemon is killed."""

from bed import exposure_checks, guests, models, motion_checks
from bed.architecture import other_debian, root_image
from bed.motion_checks import MotionLimits
from bed.qemu import disk_over
from bed.registry import check, vm_test
from bed.service import SPOOL, booted, device_logs, install, journal, submit, unit_property

_RESIN = {**guests.QUICK_RESIN, "exposure_ms": 4000, "bottom_exposure_ms": 4000}
_MODULES = ("zplant start_pos=2000 bounce_us=300", "zproj", "zserial")
_PROJECTOR = f"systemd-run --unit=projector /usr/local/bin/fake-projector /dev/ttyZ1 9600 /run/projector {guests.ACER}"


_DAEMON = "$(systemctl show -P MainPID contourd)"
_WATCHDOG = "$(grep -sx contourd-light /proc/[0-9]*/comm | cut -d/ -f3)"
# Stops both first, so that neither notices the other's death.
_KILL_BOTH = f'both="{_DAEMON} {_WATCHDOG}"; kill -STOP $both; kill -9 $both'


def _prints(machine):
    install(machine)
    assert unit_property(machine, "ActiveState") == "active"
    submit(machine)
    machine.wait_for(f"test -e {SPOOL}/done/part.stl", limit_s=240)
    assert [entry["LAYER"] for entry in journal(machine, "layer")] == ["1", "2"]
    edges, frames = device_logs(machine)
    shown_at = [edges.position_at(picture.start_ns) for picture in frames.lit_pictures()]
    assert shown_at == [40, 80], f"masks were shown with the plate at the steps {shown_at}"
    check(exposure_checks.light_only_on_masks(frames, edges))
    check(exposure_checks.dark_at_the_end(frames, edges))
    check(motion_checks.lost_steps(edges) + motion_checks.pulse_widths(edges, MotionLimits()))
    check(motion_checks.direction_setups(edges, MotionLimits()))


def _is_killed_in_an_exposure(machine, name, kill=f"kill -9 {_DAEMON}"):
    """Kills the daemon in an exposure. Returns when the light went off and when systemd started the daemon again, in ns
    after the kill."""
    submit(machine, name)
    machine.wait_for(". /root/lib.sh; light_is_on", limit_s=120)
    restarts = int(unit_property(machine, "NRestarts"))
    # The time is read first, so that later events cannot be earlier than it.
    killed = machine.run("cut -d' ' -f1 /proc/uptime; " + kill)
    killed_ns = int(float(killed) * 1e9)
    again = f"test $(systemctl show -P NRestarts contourd) = {restarts + 1} && systemctl is-active contourd"
    machine.wait_for(again, limit_s=60)
    machine.wait_for(f"test -e {SPOOL}/failed/{name}.reason.txt")
    started_ns = int(unit_property(machine, "ExecMainStartTimestampMonotonic")) * 1000
    edges, frames = device_logs(machine)
    check(exposure_checks.dark_at_the_end(frames, edges))
    return edges.active(edges.lines.light)[-1][1] - killed_ns, started_ns - killed_ns


# The limit for the light watchdog, which acts at once when the daemon is gone and after 250 ms when it is silent. It includes a
# margin for a machine in real time, whose clock is read in hundredths of a second and whose processor is emulated.
_WATCHDOG_NS = 300_000_000


def _light_watchdog_turns_the_light_off(machine):
    """Checks that the light watchdog turns the light off. zplant's released lines keep their level, so the kernel does
    not."""
    off_ns, started_ns = _is_killed_in_an_exposure(machine, "killed")
    assert 0 < off_ns < _WATCHDOG_NS, f"light off {off_ns} ns after the kill"
    assert off_ns < started_ns
    return f"killed in an exposure: light off {off_ns / 1e6:.0f} ms later, the next start at {started_ns / 1e6:.0f} ms"


def _clean_up_turns_the_light_off(machine):
    """Checks that the unit's clean-up turns the light off without the light watchdog."""
    machine.run("contourctl plate-cleared")  # the print that was killed holds the queue
    off_ns, started_ns = _is_killed_in_an_exposure(machine, "killed-both", _KILL_BOTH)
    assert 0 < off_ns < started_ns, f"light off {off_ns} ns after the kill, the next start after {started_ns} ns"
    return f"with the light watchdog: {off_ns / 1e6:.0f} ms, before the next start at {started_ns / 1e6:.0f} ms"


def _without_the_clean_up_the_next_start_does(machine):
    """Checks that without the clean-up the next start turns the light off, which shows that the clean-up did it above."""
    machine.run("mkdir -p /run/systemd/system/contourd.service.d")
    machine.run(r"printf '[Service]\nExecStopPost=\n' >/run/systemd/system/contourd.service.d/no-clean-up.conf")
    machine.run("systemctl daemon-reload")
    machine.run("contourctl plate-cleared")
    off_ns, started_ns = _is_killed_in_an_exposure(machine, "killed-again", _KILL_BOTH)
    assert started_ns < off_ns, f"light off {off_ns} ns after the kill, the next start only after {started_ns} ns"
    return f"without the clean-up: {off_ns / 1e6:.0f} ms, after the start at {started_ns / 1e6:.0f} ms"


def _run(debian=None):
    # In real time an emulator delays steps by 10 ms, which loses none at up to half the homing speed.
    slow = guests.real_config(z_axis={"homing_speed_mm_s": 6, "travel_speed_mm_s": 3})
    guest = guests.systemd_guest(slow, _RESIN, _MODULES, debian)
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(0.1)))
    with guests.written(guest) as initramfs, disk_over(root_image(debian)) as disk:
        with booted(initramfs, disk) as machine:
            machine.run(_PROJECTOR)
            _prints(machine)
            notes = [
                _light_watchdog_turns_the_light_off(machine),
                _clean_up_turns_the_light_off(machine),
                _without_the_clean_up_the_next_start_does(machine),
            ]
            machine.power_off()
    return "; ".join(notes)


@vm_test("full", alone=True)
def real_service():
    """The installed service prints with real devices as its own user; when it is killed in an exposure the unit's
    clean-up turns the light off, and without the clean-up the next start would."""
    return _run()


@vm_test("full", other_debian=True, alone=True)
def real_service_on_the_other_debian():
    """The installed service passes the same test on the other Debian release: with libgpiod 2 if this is Debian 12."""
    return _run(other_debian())
