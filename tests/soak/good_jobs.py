"""Good jobs: the result of each when it is printed alone, and checks that it has the same result during the soak."""

import hashlib
import itertools
import json
import os

from harness import ascii_stl, binary_stl, wedge

# A report's keys that depend on wall time, or on when and where the job was printed.
OF_ITS_TIME = ("job", "started", "ended", "print_time_s", "states_s", "time", "interruptions", "pauses", "pause_count", "late_steps", "loop_busy_ms_worst_lit", "reading_ms",
               "indexing_ms", "first_mask_ms", "arrival_to_first_mask_ms", "masks_folder", "analysis")  # fmt: skip
OF_ITS_TIME_IN_A_LAYER = ("shown_at_s", "mask_ms", "exposure_least_ms", "exposure_most_ms", "exposure_parts")

# Tolerance for milliseconds as doubles, whose rounding errors are far smaller.
ROUNDING_MS = 1e-6


class Kind:
    """A model with its ticket, or a plate. `files` maps names to contents; a single file is a model."""

    def __init__(self, name, files, ticket=None, immovable=False):
        self.name, self.files, self.ticket = name, files, ticket
        self.immovable = immovable  # a member's own folder, which the service can copy but not move
        self.masks = self.report = None  # those of the job alone

    @property
    def is_plate(self):
        return "plate.json" in self.files

    def file_of(self, job):
        return job if self.is_plate else job + ".stl"


def kinds(rng, gyroid):
    """Returns nine jobs whose masks differ from layer to layer, as far as possible."""
    def solid():
        return wedge(rng.uniform(4, 9), rng.uniform(3, 6), rng.uniform(0.8, 2))
    def plate(models, **more):
        files = {f"{number}.stl": binary_stl(solid()) for number in range(2)}
        return {**files, "plate.json": json.dumps({"models": models, **more}).encode()}
    placed = [{"file": "0.stl", "position_mm": {"x": -5, "y": 0}}, {"file": "1.stl", "position_mm": {"x": 5, "y": 1}}]
    return [
        Kind("binary", {"model.stl": binary_stl(solid())}),
        Kind("text", {"model.stl": ascii_stl(solid())}, {"layer_height_um": rng.choice((25, 40, 80))}),
        Kind("copies", {"model.stl": binary_stl(solid())}, {"copies": 2, "scale": 0.8}),
        Kind("turned", {"model.stl": binary_stl(solid())}, {"rotation_deg": {"x": rng.randint(1, 89), "z": 30}}),
        Kind("cracked", {"model.stl": binary_stl(solid()[:-1])}, {"cracks": "repair"}),
        Kind("grown", {"model.stl": binary_stl(solid())}, {"resin": "growing"}),
        Kind("gyroid", {"model.stl": gyroid}, {"scale": rng.uniform(0.1, 0.15), "layer_height_um": 100}),
        Kind("plate", plate(placed)),
        Kind("copied", plate([{"file": "0.stl"}, {"file": "1.stl"}], layer_height_um=100), immovable=True),
    ]  # fmt: skip


def digests(folder):
    """Returns the digests of the masks in a folder, in order."""
    found = []
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            found.append(hashlib.sha256(file.read()).hexdigest())
    return found


def runs(masks):
    return [(mask, len(list(group))) for mask, group in itertools.groupby(masks)]


def masks_trouble(masks, alone, interruptions):
    """Returns a sentence if a print's masks are wrong, or None. An interrupted layer may be shown again."""
    if [mask for mask, _ in runs(masks)] != [mask for mask, _ in runs(alone)]:
        first = next((i for i, (a, b) in enumerate(itertools.zip_longest(masks, alone)) if a != b), 0)
        return f"{len(masks)} masks differ from the {len(alone)} of the job alone, first at mask {first + 1}"
    more = [count - count_alone for (_, count), (_, count_alone) in zip(runs(masks), runs(alone))]
    if min(more) < 0 or sum(more) > interruptions:
        return f"{len(masks)} masks for {len(alone)} alone, with {interruptions} interruptions"
    return None


def without_its_time(report):
    kept = {key: value for key, value in report.items() if key not in OF_ITS_TIME}
    kept["layer_records"] = [
        {key: value for key, value in layer.items() if key not in OF_ITS_TIME_IN_A_LAYER} for layer in report["layer_records"]]
    return kept


def report_trouble(report, alone):
    """Returns a sentence if a figure in a report differs that must not, or None."""
    ours, theirs = without_its_time(report), without_its_time(alone)
    if report["analysis"] and alone["analysis"]:
        ours["analysis"], theirs["analysis"] = report["analysis"], alone["analysis"]
    differ = [key for key in theirs if ours.get(key) != theirs[key]] + [key for key in ours if key not in theirs]
    if not differ:
        return None
    key = differ[0]
    if key == "layer_records" and len(ours[key]) == len(theirs[key]):
        layer = next(i for i in range(len(ours[key])) if ours[key][i] != theirs[key][i])
        return f"layer {layer + 1} of its report is {ours[key][layer]}, alone {theirs[key][layer]}"
    return f"its report has {key} {str(ours.get(key))[:300]}, alone {str(theirs.get(key))[:300]}"


def light_off_asked(layer):
    """Returns the largest error of a layer's exposure in ms that its bounds allow."""
    return max(abs(layer["exposure_most_ms"] - layer["exposure_asked_ms"]), abs(layer["exposure_asked_ms"] - layer["exposure_least_ms"]))


def light_trouble(report, tolerated_ms):
    for layer in report["layer_records"]:
        if not layer["complete"]:
            return f"layer {layer['layer']} is incomplete in a print that is done"
        if light_off_asked(layer) > tolerated_ms:
            return (f"layer {layer['layer']} had light for {layer['exposure_least_ms']} to {layer['exposure_most_ms']} ms, "
                    f"{layer['exposure_asked_ms']} ms were asked for")  # fmt: skip
    return None
