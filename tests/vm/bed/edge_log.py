"""zplant's record: every change of a line's level, with its time and the plate's position, read from
/sys/kernel/debug/zplant/log. Positions are steps above the place where the limit switch closes."""

from dataclasses import dataclass

import numpy

_EVENT = numpy.dtype(
    [("time_ns", "<u8"), ("position", "<i4"), ("flags", "<u2"), ("line", "u1"), ("value", "u1")]
)  # struct ev in modules/zplant/zplant.c

LOST_DISABLED, LOST_STOP, LOST_RATE, SHORT_HIGH, SHORT_LOW, DIRECTION_SETUP, MOVED = (1 << bit for bit in range(7))
LOST = LOST_DISABLED | LOST_STOP | LOST_RATE


@dataclass(frozen=True)
class Lines:
    """The numbers of the chip's lines; the defaults are zplant's."""

    step: int = 17
    direction: int = 27
    enable: int = 22
    limit: int = 23
    light: int = 24


class EdgeLog:
    def __init__(self, data, lines=Lines()):
        if len(data) % _EVENT.itemsize:
            raise ValueError(f"an edge log of {len(data)} bytes is cut short")
        self.events = numpy.frombuffer(data, _EVENT)
        self.lines = lines
        if (numpy.diff(self.events["time_ns"].astype(numpy.int64)) < 0).any():
            raise ValueError("an edge log's times go backwards")

    @staticmethod
    def pack(events):
        """Returns the bytes of a log of (time_ns, position, flags, line, value), for tests of its readers."""
        return numpy.array(events, _EVENT).tobytes()

    def edges(self, line):
        return self.events[self.events["line"] == line]

    def steps(self):
        """Returns the rising edges of the step line."""
        edges = self.edges(self.lines.step)
        return edges[edges["value"] == 1]

    def position_at(self, time_ns):
        """Returns the plate's position, or None before the first event."""
        index = int(numpy.searchsorted(self.events["time_ns"], time_ns, side="right")) - 1
        return None if index < 0 else int(self.events["position"][index])

    def active(self, line):
        """Returns [(start_ns, end_ns)] during which the line was high; the end is None if the line stayed high."""
        intervals, start = [], None
        for edge in self.edges(line):
            if edge["value"] and start is None:
                start = int(edge["time_ns"])
            elif not edge["value"] and start is not None:
                intervals.append((start, int(edge["time_ns"])))
                start = None
        return intervals if start is None else [*intervals, (start, None)]
