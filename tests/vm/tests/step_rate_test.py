"""The rate and the regularity of steps: the move to the parking height at full speed."""

import base64
import gzip

import numpy

from bed import guests, host_clock, motion_checks
from bed.architecture import AMD64, ARM64
from bed.edge_log import EdgeLog
from bed.motion_checks import MotionLimits
from bed.qemu import Machine, run_scenario
from bed.registry import Skipped, check, vm_test

_STEPS_PER_MM = 800
_ACCELERATION = 100.0


def _config(steps_per_s, travel_mm):
    speed = steps_per_s / _STEPS_PER_MM
    axis = {"travel_mm": travel_mm, "travel_speed_mm_s": speed, "top_speed_mm_s": speed, "acceleration_mm_s2": _ACCELERATION}
    return guests.real_config(z_axis=axis, projector={"port": None, "table": None})


def _cruise(log, steps_per_s):
    """Returns the times between the steps at full speed, in ns, of the longest move, from where full speed is first
    reached to where it is left. A slower move may precede it without a pause."""
    times = max((times for times, _ in motion_checks.moves(log)), key=len)
    periods = numpy.diff(times)
    full = numpy.flatnonzero(periods < 1.02 * 1e9 / steps_per_s)
    return periods[full[0] : full[-1] + 1]


def _report(periods, steps_per_s):
    due = 1e9 / steps_per_s
    late = int((periods > 2 * due).sum())
    text = (
        f"{len(periods)} steps at {1e9 / periods.mean():.1f}/s; time between two: p50 {numpy.median(periods) / 1e3:.1f}, "
        f"p99 {numpy.percentile(periods, 99) / 1e3:.1f}, max {periods.max() / 1e3:.1f} us; {late} late by a period"
    )
    return late, text


def _edges_of_print(config, shift, beside=":"):
    """Returns the edge log of a print in deterministic time; the shell command `beside` runs before it."""
    guest = guests.printer_guest(ARM64, config, 0.05, guests.QUICK_RESIN)
    guest.add_text(
        "/scenario",
        f"""\
. /lib.sh
load_devices
start_daemon
{beside}
print_model
wait_for_print
keep_logs
stop_daemon || fail "the daemon ended with $?"
""",
    )
    with guests.written(guest) as initramfs:
        results = run_scenario(ARM64, initramfs, shift=shift)
    assert results.text("exit_code") == "0\n", results.text("output") + results.text("daemon.log")
    return EdgeLog(results.bytes("edges"))


@vm_test("full")
def ten_thousand_steps_a_second():
    """10,000 steps per second in deterministic time: no step is late by a period."""
    # 1e9 instructions per second, like a small computer of today.
    log = _edges_of_print(_config(10_000, travel_mm=30), shift=0)
    check(motion_checks.all_checks(log, MotionLimits(top_speed_mm_s=12.5, acceleration_mm_s2=_ACCELERATION)))
    late, text = _report(_cruise(log, 10_000), 10_000)
    assert late == 0, text
    return text


@vm_test("full")
def four_thousand_steps_a_second_on_a_busy_processor():
    """4,000 steps per second in deterministic time while other programs keep the processor busy: no step is late by a
    period."""
    busy = "for program in 1 2 3; do sh -c 'while :; do :; done' & done"
    log = _edges_of_print(_config(4_000, travel_mm=20), shift=2, beside=busy)
    check(motion_checks.lost_steps(log) + motion_checks.pulse_widths(log, MotionLimits()))
    late, text = _report(_cruise(log, 4_000), 4_000)
    assert late == 0, text
    return text


@vm_test("full", alone=True)
def four_thousand_steps_a_second():
    """4,000 steps per second in real time with both of the guest's processors busy: no step is late by a period. Skipped
    if the host's own real-time threads are late."""
    guest = guests.printer_guest(AMD64, _config(4_000, travel_mm=60), 0.05, guests.QUICK_RESIN)
    with guests.written(guest) as initramfs, Machine(AMD64, initramfs, cpus=2) as machine:
        machine.wait_until_ready()
        machine.run(". /lib.sh; load_devices; start_daemon")
        machine.run("for processor in 1 2; do nice sh -c 'while :; do :; done' & done; print_model")
        machine.wait_for("print_is_over", limit_s=180)
        machine.run("gzip <$PLANT/log >/tmp/log")
        log = EdgeLog(_fetched(machine))
    check(motion_checks.lost_steps(log) + motion_checks.pulse_widths(log, MotionLimits()))
    late, text = _report(_cruise(log, 4_000), 4_000)
    own = host_clock.late_wakes(1 / 4_000, seconds=5)
    if late > 0 and own.late > 0:
        # An emulator cannot keep better time than its host.
        raise Skipped(f"{text}; {own}")
    assert late == 0, f"{text}; {own}"
    return text


def _fetched(machine):
    return gzip.decompress(base64.b64decode(machine.run("base64 /tmp/log", limit_s=120)))
