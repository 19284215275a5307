"""The cured part: contourd with its real hardware prints models with undersides by dose on arm64, in deterministic time. The resin
that the light of the records cures at the heights of the records, by a model of the light that shares no code with contourd,
begins where the models are drawn."""

import json
import math
import tempfile
from pathlib import Path

import numpy

from bed import core_masks, exposure_checks, guests, models
from bed.architecture import ARM64
from bed.edge_log import EdgeLog
from bed.exposure_checks import ExpectedLayer
from bed.frame_log import FrameLog
from bed.registry import Skipped, check, vm_test
from tests.exact_print_test import RESIN, STEP_NM, print_layers

import cured_reference as reference

_LAYER_NM = round(reference.LAYER * 1e6)


def _resin(memory):
    return {**RESIN, "exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 0, "fade_layers": 0, "undersides": "dose",
            "lift_mm": 0.2, "second_lift_mm": 0.1, "working_curve": reference.working_curve(memory)}  # fmt: skip


def _masks(facets, resin):
    """Returns the masks that contourctl slice computes."""
    with tempfile.TemporaryDirectory() as folder:
        model, profile = Path(folder, "model.stl"), Path(folder, "resin.json")
        model.write_bytes(models.binary_stl(facets))
        profile.write_text(guests.resin_profile(resin))
        return core_masks.layers_of(model, _LAYER_NM, Path(folder, "masks"), "--resin", profile)


def _middle(mask):
    """Returns the part of a mask around its middle that the reference looks at."""
    top, left = (mask.shape[0] - reference.HEIGHT) // 2, (mask.shape[1] - reference.WIDTH) // 2
    middle = mask[top : top + reference.HEIGHT, left : left + reference.WIDTH]
    assert numpy.count_nonzero(middle) == numpy.count_nonzero(mask), "the model is larger than what the reference looks at"
    return middle


def _distances(facets, memory):
    """Prints the facets and returns how much lower their undersides cure than they are drawn, and across walls, in um."""
    resin = _resin(memory)
    layers = math.ceil(max(corner[2] for facet in facets for corner in facet) / reference.LAYER - 1e-6)
    # The record of the axis has room for the edges of 150 layers.
    results = print_layers(ARM64, layers, resin=resin, model=lambda _: facets, devices="load_devices log_entries=1000000", limit_s=1200)
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
    masks = _masks(facets, resin)
    records = json.loads(results.text("spool/done/part.report.json"))["layer_records"]
    check(exposure_checks.all_checks(frames, edges, [
        ExpectedLayer(number, number * _LAYER_NM // STEP_NM, core_masks.xrgb_crc(mask), round(layer["exposure_asked_ms"] * 1e6))
        for number, (layer, mask) in enumerate(zip(records, masks, strict=True), 1)
    ]))  # fmt: skip
    irradiance = guests.real_config()["projector"]["irradiance_mw_cm2"]
    doses = [irradiance * (off - on) / 1e9 for on, off in edges.active(edges.lines.light)]
    tops = [edges.position_at(picture.start_ns) * STEP_NM / 1e6 for picture in frames.lit_pictures()]
    return reference.distances(facets, memory, reference.Print([_middle(mask) for mask in masks], doses, tops))


def _scanned():
    class Missing:
        @staticmethod
        def skipTest(reason):
            raise Skipped(reason)

    return reference.scanned(Missing)


def _register(what, model, memory, least):
    def test():
        undersides, walls = _distances(model(), memory)
        assert len(undersides) >= least, f"only {len(undersides)} undersides"
        most = reference.percentile(map(abs, undersides), 0.95)
        assert most <= 15, f"5 % of the undersides are off by more than {most:.1f} um"
        across = max(map(abs, walls), default=0)
        assert across <= 1000 * (reference.PITCH + reference.LAYER / 2), f"a wall is off by {across:.1f} um"
        return f"{len(undersides)} undersides, 95 % of them within {most:.1f} um"

    test.__doc__ = f"""The undersides of {what} by dose, with a memory of {memory:g}: every picture is the mask of contourctl slice, and
        the resin that the logged light cures begins within 15 um (95 %) of the drawn underside."""
    vm_test("full", f"undersides-of-{what.replace(' ', '-')}")(test)


_register("a bridge", lambda: reference.BRIDGE, 0.75, 100)
_register("a sphere", lambda: reference.placed(reference.made("sphere", "40"), 0.15), 1, 100)
_register("horizontal holes", lambda: reference.HOLES, 0.9, 20)
_register("a gyroid", lambda: reference.placed(reference.made("gyroid-sphere", "40"), 0.18), 0.75, 30)
_register("a scanned model", _scanned, 0.9, 10)
