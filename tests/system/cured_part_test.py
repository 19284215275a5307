"""The part that the exposed masks cure, by a model of the light that shares no code with contourd: brute force on a fine grid of
heights, from the masks that the simulated printer showed and from the times that its report states."""

import bisect
import json
import math
import os
import unittest

from cured_reference import (
    BRIDGE, GRID, HEIGHT, HOLES, LAYER, PITCH, WIDTH, Print, crossings, distances, facets_of, made, percentile, placed, scanned, working_curve,
)  # fmt: skip
from harness import BAD_DATA, DEADLINE_S, NO_INPUT, OK, Daemon, FolderTest, binary_stl, box, contourctl, read_png, source_json, wait_until

IRRADIANCE = 5  # mW/cm²


class CuredPart(FolderTest):
    def printed(self, facets, memory, undersides="dose", claimed_memory=None, **curve):
        """Prints the facets, with further keys of the working curve; returns the print."""
        claimed = memory if claimed_memory is None else claimed_memory
        profile = source_json("resins/standard.json")
        del profile["exposure_ms"], profile["bottom_exposure_ms"]
        profile |= {
            "bottom_layers": 0, "fade_layers": 0, "growth_um": 0, "elephant_foot_um": 0, "undersides": undersides,
            "working_curve": working_curve(claimed) | curve,
        }  # fmt: skip
        if not hasattr(self, "daemon"):
            self.daemon = Daemon(self, {"display": {"width_px": WIDTH, "height_px": HEIGHT, "pixel_pitch_um": PITCH * 1000}}, masks=True).start()
        job = f"part-{undersides}-{claimed:g}"
        self.write(os.path.join("resins", f"{job}.json"), json.dumps(profile).encode())
        self.daemon.printed(f"{job}.stl", binary_stl(facets), {"resin": job})
        layers = self.daemon.report(job)["layer_records"]
        folder = os.path.join(self.daemon.folder, "masks", job)
        masks = [read_png(os.path.join(folder, name)).rows for name in sorted(os.listdir(folder))]
        return Print(masks, [IRRADIANCE * layer["exposure_asked_ms"] / 1000 for layer in layers], [layer["plate_height_mm"] for layer in layers])

    def check(self, facets, least, memories=(1, 0.9, 0.75)):
        for memory in memories:
            with self.subTest(memory=memory):
                undersides, walls = distances(facets, memory, self.printed(facets, memory))
                self.assertGreater(len(undersides), least)
                self.assertLessEqual(percentile(map(abs, undersides), 0.95), 15)
                # A pixel and half a layer.
                self.assertLessEqual(max(map(abs, walls), default=0), 1000 * (PITCH + LAYER / 2))

    def test_a_plain_bridge_is_too_low_by_the_print_through(self):
        undersides, _ = distances(BRIDGE, 1, self.printed(BRIDGE, 1, "plain"))
        self.assertGreater(len(undersides), 100)
        # The table of the process facts, and half a step of the grid.
        self.assertAlmostEqual(percentile(undersides, 0.5), 239, delta=1 + 1000 * GRID / 2)

    def test_undersides_of_a_bridge_cure_where_they_are_drawn(self):
        self.check(BRIDGE, 100)

    def test_a_memory_that_is_wrong_by_two_hundredths_loses_26_um(self):
        undersides, _ = distances(BRIDGE, 0.98, self.printed(BRIDGE, 0.98, claimed_memory=1))
        # By the formula, four dark layers and 19 % in the fifth lose 25.7 um. Half a step of the grid, and 1 um for
        # the rounding of that light to a grey value.
        self.assertAlmostEqual(-percentile(undersides, 0.5), 25.7, delta=1 + 1000 * GRID / 2)

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
            self.check_surface(BRIDGE, memory)

    def test_the_surface_of_a_sphere_lies_where_its_masks_cure(self):
        self.check_surface(placed(made("sphere", "40"), 0.15), 0.9)

    def recorded(self, report, facets, job, *arguments, expect=OK):
        """Cures the part of a report, given as a dictionary or as bytes; returns the figures, or the message."""
        text = report if isinstance(report, bytes) else json.dumps(report).encode()
        result = contourctl("cure", "--json", self.write("model.stl", binary_stl(facets)), "--report", self.write("job.report.json", text),
                            "--resin", self.path("resins", f"{job}.json"), "--display", f"{WIDTH}x{HEIGHT}",
                            "--pixel-pitch-um", str(PITCH * 1000), *arguments, expect=expect)  # fmt: skip
        return json.loads(result.stdout) if expect == OK else result.stderr.decode()

    def test_the_part_of_a_finished_print_follows_from_the_light_that_was_given(self):
        for undersides in ("plain", "dose"):
            self.printed(BRIDGE, 1, undersides)
            job = f"part-{undersides}-1"
            report = self.daemon.report(job)
            found = self.recorded(report, BRIDGE, job)
            self.assertEqual(found["print"], {"job": job, "outcome": "done", "layers_with_light": len(report["layer_records"])})
            self.assertEqual(found["warnings"], [])
            too_low = 239 if undersides == "plain" else 0
            self.assertAlmostEqual(found["undersides"]["median_um"], too_low, delta=2.5)
        # With twice the light, the underside is lower by Dp ln 2.
        report = self.daemon.report("part-plain-1")
        for layer in report["layer_records"]:
            layer["exposure_least_ms"] *= 2
            layer["exposure_most_ms"] *= 2
        found = self.recorded(report, BRIDGE, "part-plain-1")
        self.assertAlmostEqual(found["undersides"]["median_um"], 239 + 150 * math.log(2), delta=1)
        # A print that was cancelled has no more than its layers.
        report["layer_records"] = report["layer_records"][:30]
        found = self.recorded(report, BRIDGE, "part-plain-1", "--stl", self.path("cured.stl"))
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

        # The computation has a low priority.
        return wait_until(computed, f"the cured part of {job}", 10 * DEADLINE_S)

    def test_the_report_of_a_print_has_the_part_that_it_cured(self):
        for undersides in ("plain", "dose"):
            self.printed(BRIDGE, 1, undersides)
            job = f"part-{undersides}-1"
            part = self.reported(job)
            found = self.recorded(self.daemon.report(job), BRIDGE, job)
            for key, value in part.items():
                self.assertEqual(found[key], value, key)
            page = self.daemon.read("done", f"{job}.report.html")
            self.assertIn("The part that was cured", page)
            self.assertIn(f"median {round(part['undersides']['median_um']):+d} um", page)
            self.assertEqual(page.count("by their distance, um"), 3)
        self.daemon.printed("flat.stl", binary_stl(box((0, 0, 0), (2, 2, 0.5))))
        self.assertIsNone(self.daemon.report("flat")["cured_part"])  # its resin has no curve

    def test_a_print_of_warm_resin_with_light_that_spreads_has_the_same_part_in_its_report_and_by_cure(self):
        light = [{"sigma_um": 500 * PITCH, "share": 0.9}, {"sigma_um": 2000 * PITCH, "share": 0.1}]
        display = {"width_px": WIDTH, "height_px": HEIGHT, "pixel_pitch_um": PITCH * 1000, "pixel_light": light}
        self.daemon = Daemon(self, {"display": display, "resin_temperature": {"celsius": 33}}, masks=True).start()
        self.printed(BRIDGE, 1, "plain", temperature_c=23)
        job = "part-plain-1"
        part, report = self.reported(job), self.daemon.report(job)
        self.assertEqual(report["settings"]["pixel_light"], [{"sigma_pixels": 0.5, "share": 0.9}, {"sigma_pixels": 2, "share": 0.1}])
        factor = math.exp(30000 / 8.314462618 * (1 / 306.15 - 1 / 296.15))  # Arrhenius' law
        self.assertAlmostEqual(report["settings"]["temperature"]["light"], factor, places=4)

        def cured(report):
            result = contourctl("cure", "--json", self.write("model.stl", binary_stl(BRIDGE)), "--printer", self.daemon.config_path,
                                "--ticket", self.write("ticket.json", json.dumps({"resin": job}).encode()),
                                "--report", self.write("job.report.json", json.dumps(report).encode()), expect=OK)  # fmt: skip
            return json.loads(result.stdout)

        found = cured(report)
        self.assertEqual({key: found[key] for key in part}, part)
        self.assertEqual(found["pixel_light"], report["settings"]["pixel_light"])
        self.assertEqual(found["warnings"], [])
        # Warm resin got less light, and its part is that of the curve's temperature: in the middle, light from all sides makes up
        # for light that spreads.
        self.assertAlmostEqual(found["undersides"]["median_um"], 239, delta=2.5)
        report["settings"]["temperature"]["light"] = 1  # the same light in resin as at the curve's measurement
        self.assertAlmostEqual(cured(report)["undersides"]["median_um"] - found["undersides"]["median_um"], 150 * math.log(factor), delta=0.1)

    def test_a_report_of_another_model_or_of_no_print_is_noticed(self):
        self.printed(BRIDGE, 1, "plain")
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
            self.assertIn(why, self.recorded(bad, BRIDGE, "part-plain-1", expect=BAD_DATA))
        contourctl("cure", self.write("m.stl", binary_stl(BRIDGE)), "--resin", self.path("resins", "part-plain-1.json"),
                   "--report", self.path("none.json"), expect=NO_INPUT)  # fmt: skip

    def test_undersides_of_a_sphere_cure_where_they_are_drawn(self):
        self.check(placed(made("sphere", "40"), 0.15), 100)

    def test_undersides_of_horizontal_holes_cure_where_they_are_drawn(self):
        self.check(HOLES, 20)

    def test_undersides_of_a_gyroid_cure_where_they_are_drawn(self):
        self.check(placed(made("gyroid-sphere", "40"), 0.18), 30)

    def test_undersides_of_a_scanned_model_cure_where_they_are_drawn(self):
        self.check(scanned(self), 10, memories=(0.9,))


if __name__ == "__main__":
    unittest.main()
