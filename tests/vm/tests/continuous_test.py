"""The continuous print: contourd with its real hardware raises the plate in the light on arm64, in deterministic time. The records
of the axis and the display are compared with contourd's record of the masks, and with the core's masks."""

import json
import struct
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bed import core_masks, exposure_checks, guests, models
from bed.architecture import ARM64
from bed.edge_log import EdgeLog
from bed.frame_log import FrameLog
from bed.qemu import run_scenario
from bed.registry import check, vm_test

_HEIGHT_MM, _LAYERED_MM = 1.6, 0.2
_STEP_NM = 1_250  # 800 microsteps per mm
_GAP_NM = 73_150  # 30 um of dead zone, and Dp ln(M / (M - 1)) of _RESIN
_MASK_STEP_NM = 2_000  # a mask for every step of the default mask_step_um
_CUT_NS = 5_000_000  # from a safety input's edge until the input thread has switched the light's line off
_SAMPLE = 60  # pictures that are compared with the core's masks, of the hundreds of a rise

# A window above which the plate rises at 1.6 um a refresh, in resin as thin as water.
_RESIN = {
    "working_curve": {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "dead_zone_um": 30, "overcure_um": 50,
                      "bottom_overcure_um": 150},
    "continuous": {"margin": 4, "window_s": 3600, "recovery_s": 1800, "layered_mm": _LAYERED_MM},
    "viscosity_mpa_s": 1, "exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 2, "fade_layers": 0,
    "lift_mm": 0.6, "second_lift_mm": 0.4, "mode": "continuous",
}  # fmt: skip
_CONFIG = {"projector": {"irradiance_mw_cm2": 25}}

_SCENARIO = f"""\
. /lib.sh
load_devices
fake-projector /dev/ttyZ1 9600 /out/projector {guests.ACER} &
start_daemon
print_model
{{during}}
wait_for_print
sleep 1
keep_logs
stop_daemon || fail "the daemon ended with $?"
"""


@dataclass(frozen=True)
class Mask:
    """A record of docs/printing.md, "Frames of a continuous print". Heights are in nm."""

    shown_ns: int
    cut: int
    first: int
    last: int
    refreshes: int
    missed: int


def read_frames(data):
    """Returns the masks of a file of frames."""
    assert data[:16] == b"contourd-frames\n" and struct.unpack_from("<II", data, 16) == (1, 32), data[:32]
    masks, at = [], 32
    while number := struct.unpack_from("<I", data, at)[0]:
        for record in struct.iter_unpack("<qiiiIIHH", data[at + 16 : at + 16 + 32 * number]):
            shown, cut, first, last, _, _, refreshes, missed = record
            masks.append(Mask(shown, cut, first, last, refreshes, missed))
        at += 16 + 32 * number
    recorded, lost = struct.unpack_from("<QQ", data, at + 16)
    assert (recorded, lost) == (len(masks), 0) and at + 32 == len(data)
    return masks


def _small_star(height_mm):
    """Returns a twisted star of 7 mm, whose points lie near to open resin."""
    return [tuple((x / 5, y / 5, z) for x, y, z in facet) for facet in models.twisted_star(height_mm)]


def _print(during="", config=None):
    guest = guests.printer_guest(ARM64, guests.real_config(**{**_CONFIG, **(config or {})}), _HEIGHT_MM, _RESIN, _small_star)
    guest.add_text("/scenario", _SCENARIO.format(during=during))
    with guests.written(guest) as initramfs:
        results = run_scenario(ARM64, initramfs, shift=0)
    assert results.text("exit_code") == "0\n", results.text("output") + results.text("daemon.log")
    return results


def _heights(masks, edges, pictures):
    """Checks each mask's recorded heights against the axis' log at the middle of its first and of its last refresh: to one
    microstep, and nearly always to none, since half a refresh is less than a microstep. And checks the height of each cut: it is
    the gel gap below the plate, but for the first masks, which are those of the first section above the layers."""
    broken, different = [], 0
    half = exposure_checks.REFRESH_NS // 2
    for mask, picture in zip(masks, pictures, strict=True):
        first, last = (edges.position_at(time_ns) * _STEP_NM for time_ns in (picture.start_ns + half, picture.end_ns - half))
        off = max(abs(mask.first - first), abs(mask.last - last))
        different += off > 0
        if off > _STEP_NM:
            broken.append(f"{mask}: the plate was at {first} and {last} nm at the middles of its first and its last refresh")
        if abs(mask.cut - max(mask.first - _GAP_NM, 1e6 * _LAYERED_MM)) > _MASK_STEP_NM + _STEP_NM:
            broken.append(f"{mask}: resin gels {_GAP_NM} nm below the plate")
        if mask.last - mask.first > _MASK_STEP_NM + _STEP_NM:
            broken.append(f"{mask}: the plate had risen by more than a step of masks")
    if different > 1 + len(masks) // 20:  # one more, for a rise of a few masks
        broken.append(f"{different} of {len(masks)} masks are a microstep from the plate's height")
    return broken


def _pictures_are_the_masks(masks, pictures):
    """Checks a sample of the pictures against the core's masks at the recorded heights of the cuts."""
    broken = []
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.stl")
        model.write_bytes(models.binary_stl(_small_star(_HEIGHT_MM)))
        for mask, picture in list(zip(masks, pictures, strict=True))[:: max(1, len(masks) // _SAMPLE)]:
            crc = core_masks.xrgb_crc(core_masks.mask_at(model, mask.cut))
            if picture.crc != crc:
                broken.append(f"{mask}: the picture is {picture.crc:08x}, the core's mask is {crc:08x}")
    return broken


def _light_of(edges, pictures):
    """Returns when the light of the rise went on and off."""
    (span,) = [(on, off) for on, off in edges.active(edges.lines.light) if on <= pictures[1].start_ns < off]
    return span


def _light_covers(edges, pictures):
    """Checks that one span of light begins in the first picture of the rise, and ends in the last one or in the dark ones after it, as
    soon as the plate stands."""
    on, off = _light_of(edges, pictures)
    first, last = pictures[0], pictures[-1]
    if first.start_ns <= on <= first.end_ns and last.start_ns <= off <= last.end_ns + 4 * exposure_checks.REFRESH_NS:
        return []
    return [f"the light from {on} to {off} ns is not that of the pictures from {first.start_ns} to {last.end_ns} ns"]


def _outcome(results):
    """Returns the masks of the record that have lit pixels, their pictures on the screen, and the logs of axis and screen."""
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
    (name,) = [name for name in results.names() if name.endswith("/part.frames.bin")]
    masks = [mask for mask in read_frames(results.bytes(name)) if mask.cut < 1e6 * _HEIGHT_MM]
    begin = masks[0].shown_ns - exposure_checks.REFRESH_NS // 2
    pictures = [picture for picture in frames.lit_pictures() if begin <= picture.start_ns]
    return masks, pictures[: len(masks)], edges, frames


@vm_test("full")
def continuous_print():
    """A rise of 1.4 mm at 60 Hz: no mask is missed; every mask is cut a gel gap below the plate's height in the axis' log at the
    middle of its first refresh, to one microstep, and replaced when the height has changed; a sample of the pictures is the core's
    to the bit; and the light stays on from the first picture to the last."""
    results = _print()
    assert "spool/done/part.report.json" in results, results.text("daemon.log")
    report = json.loads(results.text("spool/done/part.report.json"))
    masks, pictures, edges, frames = _outcome(results)
    # The emulated processor, of 1 instruction a nanosecond, takes up to 8.9 ms for a mask, which has a refresh: 16.7 ms.
    assert report["frames"]["missed"] == sum(mask.missed for mask in masks) == 0, report["frames"]
    assert masks[-1].cut > 1e6 * _HEIGHT_MM - 2 * _MASK_STEP_NM, masks[-1]
    check(_heights(masks, edges, pictures))
    check(_pictures_are_the_masks(masks, pictures))
    check(_light_covers(edges, pictures))
    check(exposure_checks.dark_at_the_end(frames, edges))
    return f"{len(masks)} masks in {(pictures[-1].end_ns - pictures[0].start_ns) / 1e9:.1f} s"


@vm_test("full")
def emergency_stop_in_a_rise():
    """The emergency stop is pressed in a rise: the light is off within the time of the input thread, the plate stands, the screen is
    black, and the job is filed with the reason."""
    results = _print(f'wait_for 300 "the rise" exposing 40\necho in {guests.EMERGENCY_STOP} 1 >$PLANT/ctl')
    masks, pictures, edges, frames = _outcome(results)
    assert "emergency stop" in results.text("spool/failed/part.reason.txt"), results.text("daemon.log")
    pressed_ns = int(edges.edges(guests.EMERGENCY_STOP)["time_ns"][0])
    light_off_ns = _light_of(edges, pictures)[1]
    assert 0 <= light_off_ns - pressed_ns <= _CUT_NS, f"the light went off {light_off_ns - pressed_ns} ns after the stop"
    after = int((edges.steps()["time_ns"] > pressed_ns + _CUT_NS).sum())
    assert after == 0, f"the plate made {after} steps after the stop"
    check(_heights(masks[:-1], edges, pictures[:-1]))
    check(exposure_checks.dark_at_the_end(frames, edges))
    return f"dark {(light_off_ns - pressed_ns) / 1e6:.2f} ms after the stop, {len(masks)} masks"
