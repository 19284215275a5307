"""The part that the exposed masks cure, by a model of the light that shares no code with contourd: brute force on a fine grid of
heights, from the masks that the simulated printer showed and from the times that its report states."""

import bisect
import json
import math
import os
import struct
import unittest

from harness import BAD_DATA, MAKE_MODEL, NO_INPUT, OK, SHARED, Daemon, FolderTest, binary_stl, box, contents, contourctl, read_png, run, source_json, wait_until

# In mm. The display shows 12 x 8 mm; layers have 50 um.
PITCH, WIDTH, HEIGHT, LAYER = 0.05, 240, 160, 0.05
DEPTH, CRITICAL, OVERCURE = 0.15, 8, 0.05  # Dp, Ec in mJ/cm², cure depth beyond a layer
IRRADIANCE = 5
GRID = 0.005  # distance of the heights at which a dose is computed
REACH = 8 * DEPTH  # farther light is below 0.04 percent
SURE = 12 * LAYER  # a roof of this height spares the light of its lowest layers
SAMPLE = 5  # every fifth pixel in each direction


def facets_of(path):
    data = contents(path)
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
    """The masks and doses of a print."""

    def __init__(self, daemon, job):
        report = daemon.report(job)
        folder = os.path.join(daemon.folder, "masks", job)
        layers = report["layer_records"]
        self.masks = [read_png(os.path.join(folder, name)) for name in sorted(os.listdir(folder))]
        assert len(self.masks) == len(layers), (len(self.masks), len(layers))
        self.doses = [IRRADIANCE * layer["exposure_asked_ms"] / 1000 for layer in layers]
        self.tops = [layer["plate_height_mm"] for layer in layers]

    def light(self, pixel):
        column, row = pixel
        return [mask.rows[row][column] / 255 for mask in self.masks]

    def cured(self, pixel, memory):
        """Returns the intervals of height in which the resin above a pixel solidifies."""
        light = self.light(pixel)
        solid = []
        for step in range(round(self.tops[-1] / GRID)):
            z = (step + 0.5) * GRID
            dose, cured = 0, False
            for layer in range(bisect.bisect_left(self.tops, z), len(self.tops)):
                depth = self.tops[layer] - z
                if depth > REACH:
                    break
                dose = memory * dose + light[layer] * self.doses[layer] * math.exp(-depth / DEPTH)
                if dose >= CRITICAL:
                    cured = True
                    break
            if not cured:
                continue
            if solid and abs(solid[-1][1] - (z - GRID / 2)) < GRID / 10:
                solid[-1][1] = z + GRID / 2
            else:
                solid.append([z - GRID / 2, z + GRID / 2])
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


class CuredPart(FolderTest):
    def printed(self, facets, memory, undersides="dose", claimed_memory=None):
        """Prints the facets; returns the print."""
        claimed = memory if claimed_memory is None else claimed_memory
        profile = source_json("resins/standard.json")
        del profile["exposure_ms"], profile["bottom_exposure_ms"]
        profile |= {
            "bottom_layers": 0, "fade_layers": 0, "growth_um": 0, "elephant_foot_um": 0, "undersides": undersides,
            "working_curve": {
                "penetration_depth_um": DEPTH * 1000, "critical_energy_mj_cm2": CRITICAL, "overcure_um": OVERCURE * 1000,
                "bottom_overcure_um": OVERCURE * 1000, "peel_memory": claimed,
            },
        }  # fmt: skip
        if not hasattr(self, "daemon"):
            self.daemon = Daemon(self, {"display": {"width_px": WIDTH, "height_px": HEIGHT, "pixel_pitch_um": PITCH * 1000}}, masks=True).start()
        job = f"part-{undersides}-{claimed:g}"
        self.write(os.path.join("resins", f"{job}.json"), json.dumps(profile).encode())
        self.daemon.printed(f"{job}.stl", binary_stl(facets), {"resin": job})
        return Print(self.daemon, job)

    def distances(self, facets, memory, print_):
        """Returns how much lower undersides cure than they are drawn, below roofs that can spare light, in um: of slopes up to 60
        degrees in height, of steeper ones, which are walls, across the wall."""
        undersides, walls = [], []
        for pixel, found in crossings(facets).items():
            self.assertEqual(len(found) % 2, 0, pixel)
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
                self.assertEqual(len(around), 1, (pixel, low, high, cured))
                too_low = 1000 * (low - around[0][0])
                undersides.append(too_low) if cosine >= 0.5 else walls.append(too_low * cosine)
        return undersides, walls

    def check(self, facets, least, memories=(1, 0.9, 0.75)):
        for memory in memories:
            with self.subTest(memory=memory):
                undersides, walls = self.distances(facets, memory, self.printed(facets, memory))
                self.assertGreater(len(undersides), least)
                self.assertLessEqual(percentile(map(abs, undersides), 0.95), 15)
                # A pixel and half a layer.
                self.assertLessEqual(max(map(abs, walls), default=0), 1000 * (PITCH + LAYER / 2))

    def made(self, *arguments):
        path = self.path("made.stl")
        run(MAKE_MODEL, arguments[0], path, *arguments[1:], expect=OK)
        return list(facets_of(path))

    BRIDGE = placed(box((-3, -2, 0), (-2, 2, 3)) + box((2, -2, 0), (3, 2, 3)) + box((-3, -2, 3), (3, 2, 5.013)))

    def test_a_plain_bridge_is_too_low_by_the_print_through(self):
        undersides, _ = self.distances(self.BRIDGE, 1, self.printed(self.BRIDGE, 1, "plain"))
        self.assertGreater(len(undersides), 100)
        # The table of the process facts, and half a step of the grid.
        self.assertAlmostEqual(percentile(undersides, 0.5), 239, delta=1 + 1000 * GRID / 2)

    def test_undersides_of_a_bridge_cure_where_they_are_drawn(self):
        self.check(self.BRIDGE, 100)

    def test_a_wrong_memory_loses_ten_um_for_each_hundredth(self):
        undersides, _ = self.distances(self.BRIDGE, 0.98, self.printed(self.BRIDGE, 0.98, claimed_memory=1))
        lost = -percentile(undersides, 0.5)
        self.assertTrue(10 < lost < 35, lost)

    def check_surface(self, facets, memory):
        """Compares the surface that contourctl cure writes with the intervals that the shown masks cure."""
        print_ = self.printed(facets, memory, "plain")
        surface = self.path("surface.stl")
        contourctl("cure", self.write("model.stl", binary_stl(facets)), "--stl", surface,
                   "--resin", self.path("resins", f"part-plain-{memory:g}.json"),
                   "--display", f"{WIDTH}x{HEIGHT}", "--pixel-pitch-um", str(PITCH * 1000), expect=OK)  # fmt: skip
        solid = 0
        for pixel, found in crossings(facets_of(surface)).items():
            heights = [height for height, _ in found]
            cured = [height for interval in print_.cured(pixel, memory) for height in interval]
            for step in range(round(print_.tops[-1] / GRID)):
                z = (step + 0.5) * GRID
                if min((abs(z - height) for height in heights), default=1) > 0.001:
                    self.assertEqual(bisect.bisect(heights, z) % 2, bisect.bisect(cured, z) % 2, (pixel, z, heights, cured))
            solid += len(heights) > 0
        self.assertGreater(solid, 200)

    def test_the_surface_of_a_bridge_lies_where_its_masks_cure(self):
        for memory in (1, 0.75):
            self.check_surface(self.BRIDGE, memory)

    def test_the_surface_of_a_sphere_lies_where_its_masks_cure(self):
        self.check_surface(placed(self.made("sphere", "40"), 0.15), 0.9)

    def recorded(self, report, facets, job, *arguments, expect=OK):
        """Cures the part of a report, given as a dictionary or as bytes; returns the figures, or the message."""
        text = report if isinstance(report, bytes) else json.dumps(report).encode()
        result = contourctl("cure", "--json", self.write("model.stl", binary_stl(facets)), "--report", self.write("job.report.json", text),
                            "--resin", self.path("resins", f"{job}.json"), "--display", f"{WIDTH}x{HEIGHT}",
                            "--pixel-pitch-um", str(PITCH * 1000), *arguments, expect=expect)  # fmt: skip
        return json.loads(result.stdout) if expect == OK else result.stderr.decode()

    def test_the_part_of_a_finished_print_follows_from_the_light_that_was_given(self):
        for undersides in ("plain", "dose"):
            self.printed(self.BRIDGE, 1, undersides)
            job = f"part-{undersides}-1"
            report = self.daemon.report(job)
            found = self.recorded(report, self.BRIDGE, job)
            self.assertEqual(found["print"], {"job": job, "outcome": "done", "layers_with_light": len(report["layer_records"])})
            self.assertEqual(found["warnings"], [])
            too_low = 239 if undersides == "plain" else 0
            self.assertAlmostEqual(found["undersides"]["median_um"], too_low, delta=2.5)
        # With twice the light, the underside is lower by Dp ln 2.
        report = self.daemon.report("part-plain-1")
        for layer in report["layer_records"]:
            layer["exposure_least_ms"] *= 2
            layer["exposure_most_ms"] *= 2
        found = self.recorded(report, self.BRIDGE, "part-plain-1")
        self.assertAlmostEqual(found["undersides"]["median_um"], 239 + 150 * math.log(2), delta=1)
        # A print that was cancelled has no more than its layers.
        report["layer_records"] = report["layer_records"][:30]
        found = self.recorded(report, self.BRIDGE, "part-plain-1", "--stl", self.path("cured.stl"))
        self.assertAlmostEqual(found["missing_mm3"], found["model_mm3"] - 2 * 4 * 1.5, delta=0.1)
        self.assertAlmostEqual(max(corner[2] for facet in facets_of(self.path("cured.stl")) for corner in facet), 1.5, delta=0.01)
        one = self.write("one.json", json.dumps(report | {"layer_records": report["layer_records"][:1]}).encode())
        result = contourctl("cure", self.path("model.stl"), "--resin", self.path("resins", "part-plain-1.json"), "--report", one, expect=OK)
        self.assert_words(result.stdout.decode(), "part-plain-1, done, 1 layer with light\n")

    def reported(self, job, folder="done"):
        """Returns the cured part in a job's report, once it is computed."""
        def computed():
            part = self.daemon.report(job, folder)["cured_part"]
            return None if part is None or "has not finished" in part.get("not_computed", "") else part

        return wait_until(computed, f"the cured part of {job}")

    def test_the_report_of_a_print_has_the_part_that_it_cured(self):
        for undersides in ("plain", "dose"):
            self.printed(self.BRIDGE, 1, undersides)
            job = f"part-{undersides}-1"
            part = self.reported(job)
            found = self.recorded(self.daemon.report(job), self.BRIDGE, job)
            for key, value in part.items():
                self.assertEqual(found[key], value, key)
            page = self.daemon.read("done", f"{job}.report.html")
            self.assertIn("The part that was cured", page)
            self.assertIn(f"median {round(part['undersides']['median_um']):+d} um", page)
            self.assertEqual(page.count("by their distance, um"), 3)
        self.daemon.printed("flat.stl", binary_stl(box((0, 0, 0), (2, 2, 0.5))))
        self.assertIsNone(self.daemon.report("flat")["cured_part"])  # its resin has no curve

    def test_a_report_of_another_model_or_of_no_print_is_noticed(self):
        self.printed(self.BRIDGE, 1, "plain")
        report = self.daemon.report("part-plain-1")
        found = self.recorded(report, placed(box((0, 0, 0), (3, 3, 6))), "part-plain-1")
        self.assertIn("layers are not those of the print", found["warnings"][0])
        low = self.recorded(report, placed(box((0, 0, 0), (3, 3, 1))), "part-plain-1", expect=BAD_DATA)
        self.assertIn("layers, and the model only 20", low)
        layers = report["layer_records"]
        for bad, why in (
            (b"{", "is not the report of a print"), (b"[]", "is not the report"), ({"job": "x"}, "is not the report"), (b"\xff" * 9, "is not the report"),
            (b"[" * 100000, "is not the report"),
            (report | {"layer_records": []}, "no layer was exposed"), (report | {"layer_records": layers[1:]}, "do not lie one upon another"),
            (report | {"layer_records": layers[::-1]}, "do not lie one upon another"),
            (report | {"layer_records": [layers[0] | {"exposure_most_ms": -1}]}, "exposure_most_ms is -1"),
            (report | {"layer_records": [layers[0] | {"plate_height_mm": "x"}]}, "is not the report"),
            (report | {"settings": report["settings"] | {"irradiance_mw_cm2": 0}}, "irradiance_mw_cm2 is 0"),
        ):  # fmt: skip
            self.assertIn(why, self.recorded(bad, self.BRIDGE, "part-plain-1", expect=BAD_DATA))
        contourctl("cure", self.write("m.stl", binary_stl(self.BRIDGE)), "--resin", self.path("resins", "part-plain-1.json"),
                   "--report", self.path("none.json"), expect=NO_INPUT)  # fmt: skip

    def test_undersides_of_a_sphere_cure_where_they_are_drawn(self):
        self.check(placed(self.made("sphere", "40"), 0.15), 100)

    def test_undersides_of_horizontal_holes_cure_where_they_are_drawn(self):
        holes = [ring(diameter / 2, diameter / 2 + 1, x, -3 + 6 * i / 3, -3 + 6 * i / 3 + 1.5)
                 for i, (diameter, x) in enumerate(((5, 0), (2, -2), (1, 2)))]  # fmt: skip
        self.check(placed([facet for hole in holes for facet in hole]), 20)

    def test_undersides_of_a_gyroid_cure_where_they_are_drawn(self):
        self.check(placed(self.made("gyroid-sphere", "40"), 0.18), 30)

    def test_undersides_of_a_scanned_model_cure_where_they_are_drawn(self):
        path = os.path.join(SHARED, "models", "bunny-closed-70k.stl")
        if not os.path.exists(path):
            self.skipTest(f"{path} does not exist")
        facets = list(facets_of(path))
        size = max(max(c[i] for f in facets for c in f) - min(c[i] for f in facets for c in f) for i in range(3))
        self.check(placed(facets, 6.5 / size), 10, memories=(0.9,))


if __name__ == "__main__":
    unittest.main()
