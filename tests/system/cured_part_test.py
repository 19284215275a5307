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
from harness import (
    BAD_DATA, DEADLINE_S, NIMBLE_RESIN, NO_INPUT, OK, Daemon, FolderTest, binary_stl, box, contourctl, merge, read_png, realtime, source_json,
    wait_until,
)  # fmt: skip

IRRADIANCE = 5  # mW/cm²
NIMBLE_MOVES = {key: value for key, value in NIMBLE_RESIN.items() if "exposure" not in key} | {"bottom_layers": 0, "viscosity_mpa_s": None}


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

    def cure(self, report, facets, ticket, expect=OK):
        """Cures the part of a report, given as a dictionary or as a path, with the printer's configuration; returns the figures, or
        the message."""
        path = report if isinstance(report, str) else self.write("job.report.json", json.dumps(report).encode())
        result = contourctl("cure", "--json", self.write("model.stl", binary_stl(facets)), "--printer", self.daemon.config_path,
                            "--ticket", self.write("ticket.json", json.dumps(ticket).encode()),
                            "--report", path, expect=expect)  # fmt: skip
        return json.loads(result.stdout) if expect == OK else result.stderr.decode()

    def printed_without(self, job, facets, ticket, excluded):
        """Prints a job; `excluded` has the numbers of copies by the layers from which on they are excluded."""
        self.daemon.drop(f"{job}.stl", binary_stl(facets), ticket)
        self.daemon.wait_state("homing")
        for layer, numbers in excluded.items():
            # The plate is far up, or paused, so that the pause is planned in time.
            self.assertNotIn("error", self.daemon.rpc("pause", at_layer=layer))
            if layer != min(excluded):
                self.daemon.rpc("resume")
            self.assertEqual(self.daemon.wait_state("paused")["job"]["layer"] + 1, layer)
            for number in numbers:
                self.assertNotIn("error", self.daemon.rpc("exclude", copy=str(number)))
        self.daemon.rpc("resume")
        self.daemon.wait_done(job)
        return self.reported(job), self.daemon.report(job)

    def resin_of_copies(self, name, **changes):
        profile = source_json("resins/standard.json")
        del profile["exposure_ms"], profile["bottom_exposure_ms"]
        merge(profile, {**NIMBLE_MOVES, "fade_layers": 0, "growth_um": 0, "elephant_foot_um": 0, "working_curve": working_curve(0.9)} | changes)
        self.write(os.path.join("resins", f"{name}.json"), json.dumps(profile).encode())

    def start_realtime(self, **changes):
        display = {"width_px": 2 * WIDTH, "height_px": 2 * HEIGHT, "pixel_pitch_um": PITCH * 1000}
        self.daemon = Daemon(self, realtime(display=display, simulation={"start_height_mm": 5}, **changes)).start()

    def test_a_print_with_excluded_copies_has_the_same_part_in_its_report_and_by_cure(self):
        # An exposure takes 80 ms, so that its dose is right on a busy machine, too.
        self.start_realtime(projector={"irradiance_mw_cm2": 200})
        # A table on one leg, which begins at layer 21 and needs a support beside the leg.
        table = box((-1.5, -1, 0), (-0.5, 1, 1)) + box((-1.5, -1, 1), (1.5, 1, 2))
        parts = {}
        for undersides, supports in (("plain", "off"), ("dose", "off"), ("dose", "on")):
            with self.subTest(undersides=undersides, supports=supports):
                job = f"{undersides}-{supports}"
                self.resin_of_copies(job, undersides=undersides)
                ticket = {"resin": job, "copies": 4, "supports": supports}
                # Layers of the leg (on supports 5 mm high: before its first one), of the roof in which its underside is dark,
                # and of the solid roof.
                lift = 100 if supports == "on" else 0
                excluded = {8: [2], lift + 22: [1], lift + 30: [4]}
                part, report = self.printed_without(job, table, ticket, excluded)
                self.assertEqual(report["settings"]["undersides"], undersides)
                if supports == "on":
                    self.assertGreater(report["supports"]["contacts"], 3)
                found = self.cure(report, table, ticket)
                self.assertEqual({key: found[key] for key in part}, part)
                self.assertEqual(found["warnings"], [])  # all masks have the area of the print's
                self.assertEqual([each["number"] for each in part["compared_up_to"]], [2, 1, 4])
                for each, layer in zip(part["compared_up_to"], excluded):
                    self.assertAlmostEqual(each["up_to_mm"], report["layer_records"][layer - 2]["plate_height_mm"])
                page = self.daemon.read("done", f"{job}.report.html")
                self.assertIn(f"copy 2 up to {part['compared_up_to'][0]['up_to_mm']:.3f} mm", page)
                parts[job] = part
        # Three copies lack the area beneath their tables or most of it, and count as far as they were printed.
        leg, roof = 1 * 2, 3 * 2
        self.assertAlmostEqual(parts["plain-off"]["model_mm3"], leg * (3 + 7 * LAYER) + roof * (1 + LAYER + 9 * LAYER), delta=0.01)
        # By dose, the only layer of a roof that was to be thicker is dark.
        one = round(2 * 2 / PITCH**2)
        for job, places in (("plain-off", 3 * one), ("dose-off", 2 * one)):
            undersides, tops = parts[job]["undersides"], parts[job]["tops"]
            self.assertEqual((undersides["places"], undersides["missing"]), (places, 3 * one - places))
            self.assertEqual((tops["places"], tops["missing"]), (round(roof / PITCH**2), 0))
        self.assertAlmostEqual(parts["plain-off"]["missing_mm3"], 0, delta=0.01)
        self.assertLess(abs(parts["dose-off"]["undersides"]["median_um"]), 15)

    def test_a_continuous_print_with_a_copy_that_was_excluded_before_the_rise_has_the_same_part_by_cure(self):
        # The plate rises so slowly, 46 um a second, that a busy machine shows the masks in time.
        self.start_realtime(z_axis={"travel_mm": 30}, projector={"irradiance_mw_cm2": 12})
        curve = {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "dead_zone_um": 30, "overcure_um": 50, "bottom_overcure_um": 150}
        self.resin_of_copies("rising", bottom_layers=2, mode="continuous", working_curve=curve, viscosity_mpa_s=1,
                             continuous={"margin": 4, "window_s": 3600, "recovery_s": 1800, "layered_mm": 0.2})  # fmt: skip
        height = 1.25
        block, ticket = box((0, 0, 0), (2, 2, height)), {"resin": "rising", "copies": 2}
        # The fourth layer is the last one before the rise, which leaves the copy dark.
        for job, layer in (("beneath", 3), ("before", 4)):
            with self.subTest(layer=layer):
                self.daemon.drop(f"{job}.stl", binary_stl(block), ticket)
                self.daemon.wait_state("homing")
                self.daemon.rpc("pause", at_layer=layer)
                self.daemon.wait_state("paused")
                self.daemon.rpc("resume")
                self.daemon.wait_state("exposing")
                self.assertNotIn("error", self.daemon.rpc("exclude", copy="1"))
                self.daemon.wait_state("rising")
                self.assertIn("error", self.daemon.rpc("exclude", copy="2"))
                self.daemon.wait_done(job)
                part, report = self.reported(job), self.daemon.report(job)
                self.assertEqual(report["excluded"][0]["from_layer"], layer + 1)
                # The masks of the rise are beside the report.
                found = self.cure(self.daemon.file("done", f"{job}.report.json"), block, ticket)
                self.assertEqual({key: found[key] for key in part}, part)
                self.assertEqual([warning for warning in found["warnings"] if "masks" in warning], [])
                self.assertGreater(part["rise"]["masks"], 100)
                (cut,) = part["compared_up_to"]
                self.assertEqual(cut["number"], 1)
                self.assertAlmostEqual(cut["up_to_mm"], layer * LAYER, delta=0.005)
                self.assertAlmostEqual(part["model_mm3"], 4 * (height + cut["up_to_mm"]), delta=0.001)
                # The dead zone is missing on tops and on the plate, but not the copy above its cut.
                self.assertLess(part["missing_mm3"], 0.1 * 4 * (height - cut["up_to_mm"]))
                self.assertEqual(part["tops"]["places"] + part["tops"]["missing"], round(4 / PITCH**2))

    def test_a_list_of_excluded_copies_that_cannot_be_is_refused_in_one_sentence(self):
        self.start_realtime(projector={"irradiance_mw_cm2": 1000})
        block = box((0, 0, 0), (1, 1, 0.5))
        ticket = {"resin": "thin", "copies": 2, "scale": 1}
        self.resin_of_copies("thin")
        _, report = self.printed_without("block", block, ticket, {4: [1]})
        first = report["excluded"][0]
        self.assertEqual(first["from_layer"], 4)
        for bad, why in (
            ([first, first], "excluded has copy 1 twice"),
            ([first | {"number": 3}], "the print excluded copy 3, and there are only 2 of the model: give the model"),
            ([first, first | {"number": 2}], "the print excluded all copies of the model"),
            ([first | {"number": 0}], "number is 0, expected 1 to"), ([first | {"number": 1.5}], "number is 1.5, expected a whole number"),
            ([first | {"number": 1e300}], "number is 1e+300, expected 1 to"), ([first | {"number": "1"}], "is not the report of a print"),
            ([first | {"from_layer": -3}], "from_layer is -3, expected 1 to"), ([first | {"from_layer": None}], "is not the report of a print"),
            ([first | {"from_layer": math.nan}], "is not the report of a print"), ([first | {"from_layer": 4.5}], "from_layer is 4.5, expected a whole number"),
            ([first | {"from_layer": 11}], "the print excluded copy 1 from layer 11 on, and the model has only 10 layers"),
            ([{"copy": "block.stl"}], "excluded has an entry without number and from_layer"), ([7], "excluded has an entry without"),
            ({"number": 1}, "excluded is not a list of copies"), (None, "excluded is not a list of copies"), ("x", "excluded is not a list of copies"),
        ):  # fmt: skip
            with self.subTest(bad=bad):
                message = self.cure(report | {"excluded": bad}, block, ticket, expect=BAD_DATA)
                self.assertIn(why, message)
                self.assertEqual(message.count("\n"), 1)
        # Another layer has other masks, and a model alone has no copies.
        self.assertIn("are not those of the print", self.cure(report | {"excluded": [first | {"from_layer": 5}]}, block, ticket)["warnings"][0])
        self.assertIn("the print excluded the only copy of the model", self.cure(report, block, {"resin": "thin"}, expect=BAD_DATA))
        # A report from before copies could be excluded has no list.
        del report["excluded"]
        self.assertEqual(self.cure(report, block, ticket)["compared_up_to"], [])

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
