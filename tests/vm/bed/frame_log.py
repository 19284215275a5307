"""zproj's record, read from /sys/kernel/debug/zproj/log: every picture on the screen with its first vblank and the CRC-32
of its pixels."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    time_ns: int
    vblank: int
    kind: str  # ON, FLIP, REDRAW, OFF, PLUG, UNPLUG
    size: str  # "1920x1080"
    crc: int
    lit: int  # pixels


@dataclass(frozen=True)
class Picture:
    """A frame's time on the screen. end_ns is None for the last frame."""

    start_ns: int
    end_ns: int
    crc: int
    lit: int


class FrameLog:
    def __init__(self, text):
        self.entries = [self._entry(line) for line in text.splitlines()]

    @staticmethod
    def _entry(line):
        fields = line.split()
        if len(fields) != 6:
            raise ValueError(f"no line of a frame log: {line!r}")
        return Entry(int(fields[0]), int(fields[1]), fields[2], fields[3], int(fields[4], 16), int(fields[5]))

    def pictures(self):
        """Returns the pictures in order, without the times at which the output was off."""
        shown = []
        changes = [entry for entry in self.entries if entry.kind in ("FLIP", "REDRAW", "OFF")]
        for entry, following in zip(changes, [*changes[1:], None]):
            if entry.kind != "OFF":
                shown.append(Picture(entry.time_ns, following.time_ns if following else None, entry.crc, entry.lit))
        return shown

    def lit_pictures(self):
        return [picture for picture in self.pictures() if picture.lit]

    def times(self, kind):
        return [entry.time_ns for entry in self.entries if entry.kind == kind]
