"""The part that masks and doses cure, by a model of the light that shares no code with contourd: brute force on a fine grid of
heights; and the distance of its undersides from those of the model that was drawn."""

import math
import os
import struct
import tempfile

import numpy

from harness import MAKE_MODEL, OK, SHARED, box, run

# In mm. The masks show 12 x 8 mm; layers have 50 um.
PITCH, WIDTH, HEIGHT, LAYER = 0.05, 240, 160, 0.05
DEPTH, CRITICAL, OVERCURE = 0.15, 8, 0.05  # Dp, Ec in mJ/cm², cure depth beyond a layer
GRID = 0.005  # distance of the heights at which a dose is computed
REACH = 8 * DEPTH  # farther light is below 0.04 percent
SURE = 12 * LAYER  # a roof of this height spares the light of its lowest layers
SAMPLE = 5  # every fifth pixel in each direction


def facets_of(path):
    """Yields the facets of a binary STL file."""
    with open(path, "rb") as file:
        data = file.read()
    (count,) = struct.unpack_from("<I", data, 80)
    for i in range(count):
        numbers = struct.unpack_from("<9f", data, 84 + 50 * i + 12)
        yield numbers[0:3], numbers[3:6], numbers[6:9]


def placed(facets, scale=1):
    """Returns the facets scaled, on the plate, in the middle of the display."""
    facets = [tuple(tuple(scale * x for x in corner) for corner in facet) for facet in facets]
    low, high = ([fold(corner[axis] for facet in facets for corner in facet) for axis in range(3)] for fold in (min, max))
    middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    return [tuple(tuple(x - m for x, m in zip(corner, middle)) for corner in facet) for facet in facets]


def sampled_pixels():
    return [(column, row) for row in range(SAMPLE // 2, HEIGHT, SAMPLE) for column in range(SAMPLE // 2, WIDTH, SAMPLE)]


def place_of(column, row):
    """Returns the place of a pixel's middle; the display's first row is at the back."""
    return (column + 0.5 - WIDTH / 2) * PITCH, (HEIGHT / 2 - row - 0.5) * PITCH


def crossings(facets):
    """Returns for each sampled pixel the sorted heights at which the vertical line through its middle crosses the model, each with
    the cosine of the surface's slope."""
    step = SAMPLE * PITCH
    first_x, first_y = place_of(SAMPLE // 2, SAMPLE // 2)
    found = {pixel: [] for pixel in sampled_pixels()}
    for (ax, ay, az), (bx, by, bz), (cx, cy, cz) in facets:
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0:
            continue
        across = (by - ay) * (cz - az) - (bz - az) * (cy - ay), (bz - az) * (cx - ax) - (bx - ax) * (cz - az)
        cosine = abs(area) / math.hypot(area, *across)
        for i in range(math.ceil((min(ax, bx, cx) - first_x) / step), math.floor((max(ax, bx, cx) - first_x) / step) + 1):
            for j in range(math.ceil((first_y - max(ay, by, cy)) / step), math.floor((first_y - min(ay, by, cy)) / step) + 1):
                pixel = SAMPLE // 2 + i * SAMPLE, SAMPLE // 2 + j * SAMPLE
                x, y = first_x + i * step + 1e-7, first_y - j * step + 1.3e-7  # beside the model's edges
                b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
                c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
                if pixel in found and b >= 0 and c >= 0 and b + c <= 1:
                    found[pixel].append((az + b * (bz - az) + c * (cz - az), cosine))
    return {pixel: sorted(heights) for pixel, heights in found.items()}


class Print:
    """The layers of a print: masks as rows of grey values, doses of full light in mJ/cm², and heights of the plate in mm."""

    def __init__(self, masks, doses, tops):
        assert len(masks) == len(doses) == len(tops), (len(masks), len(doses), len(tops))
        rows, columns = slice(SAMPLE // 2, HEIGHT, SAMPLE), slice(SAMPLE // 2, WIDTH, SAMPLE)
        self.light = [numpy.array([list(row)[columns] for row in mask[rows]]) / 255 for mask in masks]  # of sampled pixels
        self.doses, self.tops = doses, tops
        self.solid = {}  # by memory: of each sampled pixel, whether the resin at each height of the grid solidifies

    def cured(self, pixel, memory):
        """Returns the intervals of height in which the resin above a sampled pixel solidifies."""
        if memory not in self.solid:
            self.solid[memory] = self.expose(memory)
        column, row = pixel
        changes = numpy.diff(self.solid[memory][row // SAMPLE, column // SAMPLE], prepend=False, append=False)
        ends = [int(i) * GRID for i in numpy.flatnonzero(changes)]
        return list(zip(ends[::2], ends[1::2]))

    def expose(self, memory):
        heights = (numpy.arange(round(self.tops[-1] / GRID)) + 0.5) * GRID
        dose = numpy.zeros((*self.light[0].shape, len(heights)))
        solid = numpy.zeros(dose.shape, bool)
        for light, full, top in zip(self.light, self.doses, self.tops):
            lit = slice(*numpy.searchsorted(heights, (top - REACH, top)))
            dose[..., lit] = memory * dose[..., lit] + light[..., None] * full * numpy.exp((heights[lit] - top) / DEPTH)
            solid[..., lit] |= dose[..., lit] >= CRITICAL
        return solid


def ring(inner, outer, x, y0, y1, sides=90):
    """Returns a ring around a horizontal axis along y, at height `outer`."""
    angles = [2 * math.pi * i / sides for i in range(sides + 1)]
    angles[-1] = 0

    def corner(radius, angle, y):
        return x + radius * math.cos(angle), y, outer + radius * math.sin(angle)

    facets = []
    for a, b in zip(angles, angles[1:]):
        ia0, ib0, ia1, ib1 = (corner(inner, angle, y) for y in (y0, y1) for angle in (a, b))
        oa0, ob0, oa1, ob1 = (corner(outer, angle, y) for y in (y0, y1) for angle in (a, b))
        for p, q, r, s in ((oa0, oa1, ob1, ob0), (ia0, ib0, ib1, ia1), (ia0, oa0, ob0, ib0), (ia1, ib1, ob1, oa1)):
            facets += [(p, r, q), (p, s, r)]
    return facets


def percentile(values, share):
    values = sorted(values)
    return values[min(int(share * len(values)), len(values) - 1)]


def distances(facets, memory, print_):
    """Returns how much lower undersides cure than they are drawn, below roofs that can spare light, in um: of slopes up to 60
    degrees in height, of steeper ones, which are walls, across the wall."""
    undersides, walls = [], []
    for pixel, found in crossings(facets).items():
        assert len(found) % 2 == 0, pixel
        drawn = list(zip(found[::2], found[1::2]))
        if not any(low > LAYER for (low, _), _ in drawn):
            continue
        cured = print_.cured(pixel, memory)
        below = 0
        for (low, cosine), (high, _) in drawn:
            room, below = low - below, high
            if low < LAYER or room < min(low, REACH) or high - low < SURE:
                continue
            # The lowest resin that hangs together with the solid's middle.
            middle = low + SURE / 2
            around = [interval for interval in cured if interval[0] < middle < interval[1]]
            assert len(around) == 1, (pixel, low, high, cured)
            too_low = 1000 * (low - around[0][0])
            undersides.append(too_low) if cosine >= 0.5 else walls.append(too_low * cosine)
    return undersides, walls


def working_curve(memory):
    """Returns the working curve of a resin profile whose liquid keeps that share of its dose at a peel."""
    return {"penetration_depth_um": DEPTH * 1000, "critical_energy_mj_cm2": CRITICAL, "overcure_um": OVERCURE * 1000,
            "bottom_overcure_um": OVERCURE * 1000, "peel_memory": memory}  # fmt: skip


# --- models

BRIDGE = placed(box((-3, -2, 0), (-2, 2, 3)) + box((2, -2, 0), (3, 2, 3)) + box((-3, -2, 3), (3, 2, 5.013)))

# Tubes around horizontal holes of 5, 2 and 1 mm.
HOLES = placed([facet for i, (diameter, x) in enumerate(((5, 0), (2, -2), (1, 2)))
                for facet in ring(diameter / 2, diameter / 2 + 1, x, -3 + 6 * i / 3, -3 + 6 * i / 3 + 1.5)])  # fmt: skip


def made(kind, *arguments):
    """Returns the facets of a model of make-model."""
    with tempfile.NamedTemporaryFile(suffix=".stl") as file:
        run(MAKE_MODEL, kind, file.name, *arguments, expect=OK)
        return list(facets_of(file.name))


def scanned(test):
    """Returns the facets of a scanned model, 6.5 mm large; skips the test if the model is not there."""
    path = os.path.join(SHARED, "models", "bunny-closed-70k.stl")
    if not os.path.exists(path):
        test.skipTest(f"{path} does not exist")
    facets = list(facets_of(path))
    size = max(max(c[i] for f in facets for c in f) - min(c[i] for f in facets for c in f) for i in range(3))
    return placed(facets, 6.5 / size)
