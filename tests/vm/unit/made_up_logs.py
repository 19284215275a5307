"""Logs as a faultless printer would leave them, for tests to damage."""

import math

from bed.edge_log import MOVED, EdgeLog, Lines
from bed.exposure_checks import REFRESH_NS, ExpectedLayer
from bed.frame_log import FrameLog

SECOND = 1_000_000_000
LINES = Lines()


def trapezoid_times(steps, speed_mm_s, acceleration_mm_s2, steps_per_mm=800.0):
    """Returns the times in ns from the start at which the steps of a move are due."""
    distance = steps / steps_per_mm
    top = min(speed_mm_s, math.sqrt(distance * acceleration_mm_s2))
    ramp_s, ramp_mm = top / acceleration_mm_s2, top * top / (2 * acceleration_mm_s2)
    cruise_s = (distance - 2 * ramp_mm) / top
    times = []
    for i in range(1, steps + 1):
        x = i / steps_per_mm
        if x <= ramp_mm:
            t = math.sqrt(2 * x / acceleration_mm_s2)
        elif x <= distance - ramp_mm:
            t = ramp_s + (x - ramp_mm) / top
        else:
            t = 2 * ramp_s + cruise_s - math.sqrt(max(0.0, 2 * (distance - x) / acceleration_mm_s2))
        times.append(round(t * 1e9))
    return times


class Recorder:
    """Builds both logs as the devices would."""

    def __init__(self, position=0):
        self.edges, self.frames = [], []
        self.now, self.position, self.up = SECOND, position, False

    def edge(self, line, value, flags=0, at=None):
        self.edges.append((self.now if at is None else at, self.position, flags, line, value))

    def turn(self, up):
        if up != self.up:
            self.up = up
            self.edge(LINES.direction, int(up))
        self.now += 10_000

    def move(self, steps, speed=5.0, acceleration=25.0, width=3_000):
        self.turn(steps > 0)
        for due in trapezoid_times(abs(steps), speed, acceleration):
            self.position += 1 if steps > 0 else -1
            self.edge(LINES.step, 1, MOVED, self.now + due)
            self.edge(LINES.step, 0, 0, self.now + due + width)
        self.now += due + SECOND // 2

    def flip(self, crc, lit):
        self.now = -(-self.now // REFRESH_NS) * REFRESH_NS
        self.frames.append(f"{self.now} {self.now // REFRESH_NS} FLIP 1920x1080 {crc:08x} {lit}")

    def expose(self, crc, exposure_ns):
        self.flip(crc, 1000)
        self.now += 100_000
        self.edge(LINES.light, 1)
        self.now += exposure_ns + 20_000
        self.edge(LINES.light, 0)
        self.flip(0, 0)

    def edge_log(self):
        return EdgeLog(EdgeLog.pack(self.edges))

    def frame_log(self):
        return FrameLog("\n".join(self.frames))


def print_of(layers=3, exposure_ns=2 * SECOND):
    """Returns a recorder with a print, and its expected layers."""
    recorder, expected = Recorder(position=4000), []
    recorder.move(-4000)
    recorder.flip(0, 0)
    for i in range(1, layers + 1):
        recorder.move(40 * i - recorder.position)
        recorder.expose(0xABC0 + i, exposure_ns)
        expected.append(ExpectedLayer(i, 40 * i, 0xABC0 + i, exposure_ns))
        recorder.move(1600)
    return recorder, expected
