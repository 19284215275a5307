"""Checks of an axis' edge log. Every check returns a sentence for each violation."""

from dataclasses import dataclass

import numpy

from bed import edge_log

# A pause of this length between steps ends a move. The slowest start of a move (25 mm/s2, 800 steps/mm) takes 10 ms per step.
_MOVE_GAP_NS = 100_000_000


@dataclass(frozen=True)
class MotionLimits:
    steps_per_mm: float = 800.0
    top_speed_mm_s: float = 10.0
    acceleration_mm_s2: float = 25.0
    pulse_width_ns: int = 2_000
    direction_setup_ns: int = 5_000
    # A late step leaves less time to the next if that is on time.
    lateness_ns: int = 50_000


def lost_steps(log):
    """Finds steps that did not move the plate."""
    lost = log.steps()[(log.steps()["flags"] & edge_log.LOST) != 0]
    return [f"the step at {step['time_ns']} ns was lost (flags {step['flags']:#x})" for step in lost]


def pulse_widths(log, limits):
    edges = log.edges(log.lines.step)
    widths = numpy.diff(edges["time_ns"].astype(numpy.int64))
    return [
        f"the step line was {'high' if edges['value'][i] else 'low'} for {widths[i]} ns at {edges['time_ns'][i]} ns"
        for i in numpy.flatnonzero(widths < limits.pulse_width_ns)
    ]


def direction_setups(log, limits):
    """Finds steps too soon after a change of direction, and changes of direction during a pulse."""
    steps = log.edges(log.lines.step)
    broken = []
    for edge in log.edges(log.lines.direction):
        index = int(numpy.searchsorted(steps["time_ns"], edge["time_ns"], side="right"))
        if index > 0 and steps["value"][index - 1]:
            broken.append(f"the direction changed within a step's pulse at {edge['time_ns']} ns")
        if index < len(steps) and steps["time_ns"][index] - edge["time_ns"] < limits.direction_setup_ns:
            ahead = steps["time_ns"][index] - edge["time_ns"]
            broken.append(f"the direction changed only {ahead} ns before the step at {steps['time_ns'][index]} ns")
    return broken


def moves(log):
    """Returns the steps by moves, which are runs in one direction without a pause: [(times_ns, positions)]."""
    steps = log.steps()
    if not len(steps):
        return []
    times = steps["time_ns"].astype(numpy.int64)
    turns = log.edges(log.lines.direction)["time_ns"].astype(numpy.int64)
    cuts = set(numpy.flatnonzero(numpy.diff(times) > _MOVE_GAP_NS) + 1)
    cuts.update(int(i) for i in numpy.searchsorted(times, turns))
    bounds = sorted({0, len(times), *cuts})
    return [(times[a:b], steps["position"][a:b]) for a, b in zip(bounds, bounds[1:]) if b > a]


def speeds(log, limits):
    """Finds steps that follow each other faster than at the top speed."""
    shortest = 1e9 / (limits.top_speed_mm_s * limits.steps_per_mm) - limits.lateness_ns
    broken = []
    for times, _ in moves(log):
        periods = numpy.diff(times)
        broken += [f"two steps within {periods[i]} ns at {times[i]} ns" for i in numpy.flatnonzero(periods < shortest)]
    return broken


def _ended_at_the_switch(log, times):
    """True if the limit switch closed with the move's last step."""
    closed = log.edges(log.lines.limit)
    closed = closed[closed["value"] == 0]["time_ns"].astype(numpy.int64)
    return bool((numpy.abs(closed - times[-1]) < 1_000_000).any())


def accelerations(log, limits):
    """Changes of speed beyond the acceleration, from the second difference of the position over a window.

    With x known to a step (it lies between two of them), x(t+h) - 2 x(t) + x(t-h) is known to within two steps, and with
    times off by at most the lateness l, to within 2 v l more. The window is as long as it takes for both to make a
    fifth of what the acceleration does in it."""
    step_mm = 1 / limits.steps_per_mm
    slack_mm = 2 * step_mm + 2 * limits.top_speed_mm_s * limits.lateness_ns * 1e-9
    window_s = (slack_mm / (0.2 * limits.acceleration_mm_s2)) ** 0.5
    most_mm = limits.acceleration_mm_s2 * window_s**2 + slack_mm
    broken = []
    for times, _ in moves(log):
        start, end = times[0] * 1e-9, times[-1] * 1e-9
        # In homing the switch stops the plate at once, so the missing ramp is not an error.
        last = end - window_s if _ended_at_the_switch(log, times) else end + window_s
        at = numpy.arange(start - window_s, last, window_s / 8)
        seconds = times * 1e-9

        def position(t, seconds=seconds):
            return numpy.searchsorted(seconds, t, side="right") * step_mm

        changes = numpy.abs(position(at + window_s) - 2 * position(at) + position(at - window_s))
        for i in numpy.flatnonzero(changes > most_mm):
            broken.append(
                f"the speed changed by {changes[i] / window_s:.2f} mm/s within {window_s * 1e3:.0f} ms around {at[i]:.4f} s, "
                f"more than {limits.acceleration_mm_s2} mm/s2 allow"
            )
    return broken


def all_checks(log, limits):
    return [
        *lost_steps(log),
        *pulse_widths(log, limits),
        *direction_setups(log, limits),
        *speeds(log, limits),
        *accelerations(log, limits),
    ]
