"""A display's description of itself: EDID according to VESA's E-EDID 1.4."""

import struct
from dataclasses import dataclass


@dataclass(frozen=True)
class Timing:
    """The timing of one mode. For pixels across and lines down: the number shown, before the sync, in the sync, and in
    total."""

    clock_khz: int
    across: tuple
    down: tuple


# CEA-861's formats 16 and 4.
FULL_HD = Timing(148_500, (1920, 88, 44, 2200), (1080, 4, 5, 1125))
HD = Timing(74_250, (1280, 110, 40, 1650), (720, 5, 5, 750))


def _detailed_timing(timing):
    (width, h_front, h_sync, h_total), (height, v_front, v_sync, v_total) = timing.across, timing.down
    h_blank, v_blank = h_total - width, v_total - height
    return struct.pack(
        "<H10B5x",
        timing.clock_khz // 10,
        width & 255, h_blank & 255, width >> 8 << 4 | h_blank >> 8,
        height & 255, v_blank & 255, height >> 8 << 4 | v_blank >> 8,
        h_front & 255, h_sync & 255, (v_front & 15) << 4 | v_sync & 15,
        h_front >> 8 << 6 | h_sync >> 8 << 4 | v_front >> 4 << 2 | v_sync >> 4,
    ) + bytes([0x1E])  # no size, as projectors have none; separate syncs, both positive  # fmt: skip


def edid(timing):
    """Returns the EDID of a digital display of unknown size that has only this mode."""
    block = bytes.fromhex("00ffffffffffff00") + struct.pack(">H", 0x6A0A) + bytes(6) + bytes([1, 30])  # maker "ZPJ"; 2020
    block += bytes([1, 4, 0x80, 0, 0, 120, 0x02]) + bytes(10)  # digital; gamma 2.2; the first timing is preferred
    block += bytes(3) + b"\x01\x01" * 8  # no established and no standard timings
    dummy = bytes([0, 0, 0, 0x10, 0]) + bytes(13)
    block += _detailed_timing(timing) + 3 * dummy + bytes(1)
    return block + bytes([-sum(block) % 256])
