"""The exact print: contourd with its real hardware prints a model of twenty layers on arm64, in deterministic time, and
the records of the axis and the display are compared with the core's masks."""

import hashlib
import json
import tempfile
from pathlib import Path

import numpy

from bed import core_masks, exposure_checks, guests, models, motion_checks
from bed.architecture import ARM64
from bed.edge_log import EdgeLog
from bed.exposure_checks import ExpectedLayer
from bed.frame_log import FrameLog
from bed.motion_checks import MotionLimits
from bed.qemu import run_scenario
from bed.registry import check, vm_test

_LAYER_NM = 50_000
STEP_NM = 1_250  # 800 microsteps per mm
RESIN = {"exposure_ms": 1000, "bottom_exposure_ms": 2000, "bottom_layers": 2, "fade_layers": 3, "lift_mm": 0.6,
         "second_lift_mm": 0.4, "settle_ms": 300, "rest_ms": 100}  # fmt: skip

# The plate is 2.5 mm above a switch that bounces for 1.2 ms.
_SCENARIO = f"""\
. /lib.sh
{{devices}} bounce_us=300
fake-projector /dev/ttyZ1 9600 /out/projector {guests.ACER} &
start_daemon
print_model
wait_for_print
keep_logs
stop_daemon || fail "the daemon ended with $?"
"""


def print_layers(arch, layers, config=None, devices="load_devices", layer_nm=_LAYER_NM, model=models.twisted_star, resin=None, **options):
    resin = {**RESIN, "layer_height_um": layer_nm / 1000, **(resin or {})}
    guest = guests.printer_guest(arch, config or guests.real_config(), layers * layer_nm / 1e6, resin, model)
    guest.add_text("/scenario", _SCENARIO.format(devices=devices))
    with guests.written(guest) as initramfs:
        results = run_scenario(arch, initramfs, **options)
    assert results.text("exit_code") == "0\n", results.text("output") + results.text("daemon.log")
    assert "spool/done/part.report.json" in results, results.text("daemon.log")
    return results


def _expected_layers(report, edges, frames, crc=core_masks.xrgb_crc):
    """Returns the layers with the core's masks at the heights in the axis' log, and the exposures of the job."""
    expected = []
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.stl")
        layers = report["layer_records"]
        model.write_bytes(models.binary_stl(models.twisted_star(len(layers) * _LAYER_NM / 1e6)))
        for number, (layer, picture) in enumerate(zip(layers, frames.lit_pictures()), 1):
            height_nm = edges.position_at(picture.start_ns) * STEP_NM
            mask = core_masks.mask_at(model, height_nm - _LAYER_NM // 2)
            exposure_ns = round(layer["exposure_asked_ms"] * 1e6)
            position = number * _LAYER_NM // STEP_NM
            expected.append(ExpectedLayer(number, position, crc(mask), exposure_ns))
    return expected


def _verify(results, layers, crc=core_masks.xrgb_crc):
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
    report = json.loads(results.text("spool/done/part.report.json"))
    expected = _expected_layers(report, edges, frames, crc)
    assert len(expected) == layers, f"{len(expected)} of {layers} layers were shown"
    check(exposure_checks.all_checks(frames, edges, expected))
    check(motion_checks.all_checks(edges, MotionLimits()))
    return f"{len(edges.steps())} steps, {len(frames.lit_pictures())} masks"


def _fingerprint(results):
    return {name: hashlib.sha256(results.bytes(name)).hexdigest() for name in ("edges", "frames", "projector")}


@vm_test("quick")
def exact_print():
    """Five layers: every picture is the core's mask at the plate's height, nothing is lit outside exposures, exposures
    have the requested length, steps keep the motor's rules, and homing is exact with a bouncing switch."""
    return _verify(print_layers(ARM64, 5), 5)


@vm_test("full")
def exact_print_with_supports():
    """Forty layers of a table that gets supports from the daemon: every picture is the model with the supports of
    contourctl slice at the plate's height, and the other checks of exact_print hold."""
    layers, layer_nm = 40, 100_000
    config = {**guests.real_config(), "supports": "auto"}
    results = print_layers(ARM64, layers, config, layer_nm=layer_nm, model=models.table)
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
    report = json.loads(results.text("spool/done/part.report.json"))
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.stl")
        model.write_bytes(models.binary_stl(models.table(layers * layer_nm / 1e6)))
        masks = core_masks.layers_of(model, layer_nm, Path(folder, "masks"), "--supports", "auto")
        bare = core_masks.layers_of(model, layer_nm, Path(folder, "bare"))
    held = sum(not numpy.array_equal(with_supports, without) for with_supports, without in zip(masks, bare, strict=True))
    assert held > layers / 2, f"only {held} of {layers} layers have supports"
    expected = [
        ExpectedLayer(number, number * layer_nm // STEP_NM, core_masks.xrgb_crc(mask), round(layer["exposure_asked_ms"] * 1e6))
        for number, (layer, mask) in enumerate(zip(report["layer_records"], masks, strict=True), 1)
    ]
    check(exposure_checks.all_checks(frames, edges, expected))
    check(motion_checks.all_checks(edges, MotionLimits()))
    return f"{held} of {layers} masks with supports"


@vm_test("full")
def exact_print_twice():
    """Twenty layers with the same checks as exact_print; the logs of a second run are identical."""
    first, second = print_layers(ARM64, 20), print_layers(ARM64, 20)
    note = _verify(first, 20)
    differing = [name for name, digest in _fingerprint(first).items() if _fingerprint(second)[name] != digest]
    assert not differing, f"the second run's logs differ: {differing}"
    return note


@vm_test("full")
def exact_print_without_atomic():
    """Two layers on a display whose driver has no atomic mode setting: the checks of exact_print hold."""
    results = print_layers(ARM64, 2, devices="ZPROJ=atomic=0 load_devices")
    log = results.text("daemon.log")
    assert "1920x1080 at 60.00 Hz, legacy" in log, log
    return _verify(results, 2)


@vm_test("full")
def exact_print_in_rgb565():
    """Two layers in 16-bit pixels: every picture is the core's mask rounded to these pixels."""
    results = print_layers(ARM64, 2, config=guests.real_config(display={"format": "rgb565"}))
    return _verify(results, 2, core_masks.rgb565_crc)


@vm_test("full")
def exact_print_on_a_slow_computer():
    """Two layers on a computer that is fully busy while it makes steps (64 ns per instruction), at speeds from which the
    motor may stop dead (up to half the homing speed): the switch still halts the plate at the next step, homing is exact,
    and every picture is the core's mask at the plate's height."""
    results = print_layers(ARM64, 2, guests.real_config(z_axis={"travel_speed_mm_s": 2.5}), shift=6)
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
    expected = _expected_layers(json.loads(results.text("spool/done/part.report.json")), edges, frames)
    assert len(expected) == 2, f"{len(expected)} of 2 layers were shown"
    check(exposure_checks.masks(frames, edges, expected))
    check(exposure_checks.light_only_on_masks(frames, edges))
    check(exposure_checks.dark_at_the_end(frames, edges))
    # The motion is not checked further, because late steps do not give a uniform acceleration.
    check(motion_checks.lost_steps(edges))
    check(motion_checks.pulse_widths(edges, MotionLimits()))
    check(motion_checks.direction_setups(edges, MotionLimits()))
    lowest = int(edges.steps()["position"].min())
    # One step may be in progress when the switch closes.
    assert lowest >= -1, f"the plate went to step {lowest}"
    periods = numpy.diff(edges.steps()["time_ns"].astype(numpy.int64))
    return f"shortest time between two steps {periods.min() / 1e3:.0f} us, lowest step {lowest}"
