"""contourctl cure: the distances of the cured part from the model, and messages about bad input."""

import json
import math
import os
import re
import statistics

from harness import BAD_DATA, BAD_USAGE, CANNOT_CREATE, FLOATING, OK, FolderTest, binary_stl, box, contents, contourctl, source_json

BAD_CONFIG = 78

# A slab of 3 mm, 3 mm above the plate, on two pillars.
BRIDGE = binary_stl(box((-3, -2, 0), (-2, 2, 3)) + box((2, -2, 0), (3, 2, 3)) + box((-3, -2, 3), (3, 2, 6)))


class CureTest(FolderTest):
    def resin(self, name="resin.json", **curve):
        """Writes a profile with Dp 150 um and 50 um of overcure; returns its path."""
        profile = source_json("resins/standard.json")
        del profile["exposure_ms"], profile["bottom_exposure_ms"]
        profile |= {"bottom_layers": 0, "fade_layers": 0, "growth_um": 0, "elephant_foot_um": 0}
        profile["working_curve"] = {
            "penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 50,
        } | curve  # fmt: skip
        return self.write(name, json.dumps(profile).encode())

    def cure(self, model, *arguments):
        result = contourctl("cure", "--json", *arguments, self.write("model.stl", model), expect=OK)
        self.assertEqual(result.stderr, b"")
        return json.loads(result.stdout)


class Figures(CureTest):
    def test_the_underside_of_a_bridge_is_too_low_by_the_print_through(self):
        found = self.cure(BRIDGE, "--resin", self.resin(peel_memory=1))
        self.assertAlmostEqual(found["undersides"]["median_um"], 239, delta=0.6)  # rounded in the source to 1 um
        self.assertAlmostEqual(found["undersides"]["worst_mm"][2], 3, delta=1e-6)
        self.assertEqual((found["tops"]["missing"], found["closed_gaps_mm2"]), (0, 0))
        # The pillars' inner walls have vanished in the print-through: 80 rows of two walls, in 3 of every second layer there.
        self.assertEqual(found["walls"]["missing"], 2 * 80 * 3)
        self.assertLess(found["tops"]["p95_um"], 0.1)  # the layers end at the slab's top
        self.assertAlmostEqual(found["too_much_mm3"], 4 * 4 * 0.239, delta=0.02)
        self.assertAlmostEqual(found["missing_mm3"], 0, delta=0.001)
        self.assertEqual(found["warnings"], [])

    def test_the_memory_of_the_resin_decides_and_its_lack_is_told(self):
        found = self.cure(BRIDGE, "--resin", self.resin(peel_memory=0.9))
        self.assertAlmostEqual(found["undersides"]["median_um"], 168, delta=0.6)
        found = self.cure(BRIDGE, "--resin", self.resin())
        self.assertAlmostEqual(found["undersides"]["median_um"], 239, delta=0.6)
        self.assertIn("peel_memory was not measured", found["warnings"][0])

    def test_layers_that_do_not_bond_are_told(self):
        found = self.cure(BRIDGE, "--resin", self.resin(peel_memory=1, dead_zone_um=60))
        self.assertLess(found["weakest_bond"], 1)
        self.assertIn("does not cure down to the layer beneath", found["warnings"][0])

    def test_a_print_of_contourd_has_the_same_figures(self):
        alone = self.cure(BRIDGE, "--resin", self.resin(peel_memory=1))
        printer = source_json("contourd.json")
        os.mkdir(self.path("resins"))
        printer |= {"resin": "curve", "resins_folder": self.path("resins"), "supports": "off"}
        self.resin("resins/curve.json", peel_memory=1)
        config = self.write("printer.json", json.dumps(printer).encode())
        printed = self.cure(BRIDGE, "--printer", config)
        self.assertEqual(printed["undersides"]["median_um"], alone["undersides"]["median_um"])
        self.assertEqual(printed["resin"]["name"], "curve")

    def test_light_that_spreads_moves_walls_and_leaves_wide_undersides(self):
        os.mkdir(self.path("resins"))
        self.resin("resins/curve.json", peel_memory=1)
        printer = source_json("contourd.json")
        printer |= {"resin": "curve", "resins_folder": self.path("resins"), "supports": "off"}
        pitch = printer["display"]["pixel_pitch_um"]

        def cured(*gaussians):
            display = {**printer["display"], **({"pixel_light": gaussians} if gaussians else {})}
            return self.cure(BRIDGE, "--printer", self.write("printer.json", json.dumps({**printer, "display": display}).encode()))

        narrow, wide = cured(), cured({"sigma_um": pitch})
        self.assertEqual((narrow["pixel_light"], wide["pixel_light"]), ([], [{"sigma_pixels": 1, "share": 1}]))
        # In the middle of a layer, all layers together give 5.8 Ec, of which the Gaussian leaves Ec at 0.95 sigma beside the
        # mask's edge. Between the pixels' middles the place is interpolated.
        total = math.exp((100 - 25) / 150) / (1 - math.exp(-50 / 150))
        sigmas = statistics.NormalDist().inv_cdf(1 - 1 / total)
        self.assertAlmostEqual(wide["walls"]["median_um"] - narrow["walls"]["median_um"], sigmas * pitch, delta=0.25 * pitch)
        self.assertAlmostEqual(wide["undersides"]["median_um"], narrow["undersides"]["median_um"], delta=0.6)
        tail = cured({"sigma_um": pitch / 2, "share": 0.9}, {"sigma_um": 2 * pitch, "share": 0.1})
        self.assertGreater(tail["walls"]["median_um"], cured({"sigma_um": pitch / 2})["walls"]["median_um"])
        text = contourctl("cure", "--printer", self.path("printer.json"), self.path("model.stl"), expect=OK).stdout.decode()
        self.assertIn("pixel light   sigma 0.5 pixels\n", text)

    def test_a_weak_lamp_cures_resin_of_a_low_exponent_as_its_own_does(self):
        os.mkdir(self.path("resins"))
        printer = source_json("contourd.json")
        printer |= {"resin": "curve", "resins_folder": self.path("resins"), "supports": "off"}
        config = self.write("printer.json", json.dumps(printer).encode())
        own = printer["projector"]["irradiance_mw_cm2"]
        for irradiance, exponent in ((own, 1), (own * 4, 1), (own * 4, 0.5), (own / 4, 0.8)):
            with self.subTest(irradiance=irradiance, exponent=exponent):
                self.resin("resins/curve.json", peel_memory=1, irradiance_mw_cm2=irradiance, reciprocity_exponent=exponent)
                found = self.cure(BRIDGE, "--printer", config)
                self.assertAlmostEqual(found["resin"]["critical_energy_mj_cm2"], 8 * (own / irradiance) ** (1 - exponent), places=9)
                self.assertAlmostEqual(found["undersides"]["median_um"], 239, delta=0.6)

    def test_the_text_names_each_kind_of_surface(self):
        result = contourctl("cure", "--resin", self.resin(peel_memory=1), self.write("bridge.stl", BRIDGE), expect=OK)
        for line in (b"undersides    median +239 um", b"tops          median +0 um", b"walls         median", b"weakest bond  1.40"):
            self.assertIn(line, result.stdout)


class Undersides(CureTest):
    def test_undersides_by_dose_cure_at_their_drawn_height(self):
        for memory in (1, 0.9, 0.75):
            resin = self.resin(peel_memory=memory)
            plain = self.cure(BRIDGE, "--resin", resin)
            dose = self.cure(BRIDGE, "--resin", resin, "--undersides", "dose")
            self.assertGreater(plain["undersides"]["median_um"], 100)
            self.assertLess(dose["undersides"]["p95_um"], 2.5)  # a grey step
            self.assertLess(dose["missing_mm3"], 0.01)

    def test_a_profile_that_lacks_the_memory_is_cured_as_it_is_printed(self):
        path = self.resin()
        with open(path, encoding="utf-8") as file:
            profile = json.load(file)
        self.write("resin.json", json.dumps(profile | {"undersides": "dose"}).encode())
        self.assertAlmostEqual(self.cure(BRIDGE, "--resin", path)["undersides"]["median_um"], 239, delta=0.6)

    def test_a_model_that_is_too_thin_for_a_layer_is_cured_to_nothing(self):
        found = self.cure(binary_stl(box((0, 0, 0), (2, 2, 0.01))), "--resin", self.resin(peel_memory=1), "--undersides", "dose")
        self.assertEqual(found["layers"], 0)
        self.assertIn("too thin for a layer", found["warnings"][0])

    def test_they_need_a_measured_memory(self):
        result = contourctl("cure", "--resin", self.resin(), "--undersides", "dose", self.write("m.stl", BRIDGE), expect=BAD_DATA)
        self.assertIn(b"undersides cannot be exposed by dose: the working_curve of the resin resin has no peel_memory", result.stderr)


    def test_slice_and_analyze_need_a_print_for_them(self):
        model, resin = self.write("m.stl", BRIDGE), self.resin()
        for arguments in (
            ["slice", "--layer-height-um", "50", "--undersides", "dose"], ["analyze", "--undersides", "plain"],
            ["slice", "--resin", resin, "--z", "1"], ["slice", "--resin", resin, "--grow-um", "10", "--masks", "x"], ["slice"],
            ["slice", "--resin", resin, "--cusp-um", "10"], ["slice", "--resin", resin, "--printer", "x.json"],
        ):  # fmt: skip
            with self.subTest(arguments):
                contourctl(*arguments, model, expect=BAD_USAGE)
        for command in ("slice", "analyze"):
            result = contourctl(command, "--resin", resin, "--undersides", "dose", model, expect=BAD_DATA)
            self.assertIn(b"undersides cannot be exposed by dose", result.stderr)

    def test_slice_takes_layers_and_corrections_of_the_resin_and_those_of_the_projector_from_options(self):
        path = self.resin(peel_memory=1)
        with open(path, encoding="utf-8") as file:
            profile = json.load(file)
        self.write("resin.json", json.dumps(profile | {"layer_height_um": 100, "growth_um": 50}).encode())
        model = self.write("m.stl", binary_stl(box((0, 0, 0), (2, 2, 1))))
        contourctl("slice", model, "--resin", path, "--gamma", "2", "--masks", self.path("masks"), expect=OK)
        self.assertEqual(len(os.listdir(self.path("masks"))), 10)
        contourctl("slice", model, "--layer-height-um", "100", "--grow-um", "50", "--gamma", "2", "--masks", self.path("same"), expect=OK)
        for name in os.listdir(self.path("same")):
            self.assertEqual(contents(self.path("masks", name)), contents(self.path("same", name)))


class Surface(CureTest):
    def written(self, model, *arguments):
        """Writes the cured part's surface; returns the report of cure, and that of inspect on the surface."""
        surface = self.path("cured.stl")
        found = self.cure(model, "--stl", surface, *arguments)
        return found, json.loads(contourctl("inspect", "--json", surface, expect=OK).stdout)

    def test_the_surface_is_a_sound_model_of_the_reported_volume(self):
        for resin in (self.resin(peel_memory=1), self.resin(peel_memory=0.75, oxygen_dose_mj_cm2=0.5, dead_zone_um=5)):
            for arguments in ([], ["--undersides", "dose"], ["--supports", "on"], ["--display", "100x70"]):
                with self.subTest(resin=resin, arguments=arguments):
                    found, surface = self.written(BRIDGE, "--resin", resin, *arguments)
                    self.assertEqual(surface["facets"], found["surface"]["facets"])
                    self.assertEqual(found["surface"]["step_pixels"], 1)
                    self.assertTrue(surface["watertight"])
                    for defect in ("degenerate_facets", "zero_area_facets", "duplicate_facets", "non_manifold_edges"):
                        self.assertEqual(surface[defect], 0, defect)
                    self.assertEqual(set(surface["repairs"].values()), {0})
                    volume = found["model_mm3"] + found["too_much_mm3"] - found["missing_mm3"]
                    # Walls between pixels are interpolated.
                    self.assertAlmostEqual(surface["volume_mm3"], volume, delta=0.02 * volume)

    def test_a_surface_of_more_facets_than_a_file_may_have_is_coarser(self):
        model = binary_stl(box((0, 0, 0), (60, 50, 20)))
        found, surface = self.written(model, "--resin", self.resin(peel_memory=1))
        self.assertEqual(found["surface"]["step_pixels"], 2)
        self.assertLess(surface["facets"], 4_000_000)
        self.assertAlmostEqual(surface["volume_mm3"], 60 * 50 * 20, delta=20)

    def test_a_part_that_does_not_cure_has_an_empty_surface(self):
        thin = binary_stl(box((0, 0, 0), (2, 2, 0.05)))
        found = self.cure(thin, "--resin", self.resin(peel_memory=1, dead_zone_um=60), "--stl", self.path("cured.stl"))
        self.assertEqual(found["surface"]["facets"], 0)
        self.assertEqual(len(contents(self.path("cured.stl"))), 84)

    def test_a_surface_that_cannot_be_written_leaves_nothing(self):
        model, resin = self.write("bridge.stl", BRIDGE), self.resin(peel_memory=1)
        for target, why in (("/dev/full", b"not a regular file"), (self.path("none", "x.stl"), b"No such file"),
                            (self.folder, b"not a regular file")):  # fmt: skip
            result = contourctl("cure", "--resin", resin, model, "--stl", target, expect=CANNOT_CREATE)
            self.assertIn(why, result.stderr)
        result = contourctl("cure", "--resin", resin, model, "--stl", model, expect=BAD_USAGE)
        self.assertIn(b"this file is the model", result.stderr)
        self.assertEqual(contents(model), BRIDGE)
        self.assertEqual(sorted(os.listdir(self.folder)), ["bridge.stl", "resin.json"])


class Page(CureTest):
    def page(self, model, *arguments):
        found = self.cure(model, "--html", self.path("page.html"), *arguments)
        return found, contents(self.path("page.html")).decode()

    def areas(self, page):
        """Returns the areas in mm² of the first section: cured, in the model, in both."""
        return [
            sum(float(width) * (float(bottom) - float(top)) for bottom, width, top in re.findall(r" (-?[\d.]+)h([\d.]+)V(-?[\d.]+)h", path))
            for path in re.findall(r'<path class="\w+" d="([^"]*)"', page)[:3]
        ]  # fmt: skip

    def test_the_page_has_the_figures_the_section_and_all_places_in_its_plots(self):
        for printer in ([], ["--display", "300x200"]):
            found, page = self.page(BRIDGE, "--resin", self.resin(peel_memory=1), *printer)
            self.assertIn("<td>median +239 um", page)
            self.assertIn("<h2>Undersides, places by distance, um</h2>", page)
            for ring in ("worst underside: +239 um", "worst top:", "worst wall:"):
                self.assertIn(ring, page)
            cured, model, both = self.areas(page)
            self.assertAlmostEqual(model, 6 * 6 - 4 * 3, delta=0.001)
            self.assertAlmostEqual(both, model, delta=0.001)
            self.assertAlmostEqual(cured - both, 4 * 0.239, delta=0.003)
            for name, plot in re.findall(r'aria-label="(\w+) by their distance(.*?)</svg>', page, re.DOTALL):
                places = sum(int(count) for count in re.findall(r"<title>(\d+) places", plot))
                self.assertEqual(places, found[name.lower()]["places"], name)
            self.assertNotRegex(page, r"(href|src)=\"(?!data:)|<script|url\(")

    def test_a_part_without_undersides_or_of_nothing_has_a_page(self):
        found, page = self.page(binary_stl(box((0, 0, 0), (2, 3, 1))), "--resin", self.resin(peel_memory=1))
        self.assertEqual(found["undersides"]["places"], 0)
        self.assertIn("Section through the worst place", page)
        _, page = self.page(binary_stl(box((0, 0, 0), (2, 3, 0.01))), "--resin", self.resin(peel_memory=1))
        self.assertNotIn("Section through", page)
        self.assertIn("too thin for a layer", page)

    def test_a_page_that_cannot_be_written_is_reported(self):
        model, resin = self.write("bridge.stl", BRIDGE), self.resin(peel_memory=1)
        result = contourctl("cure", "--resin", resin, model, "--html", "/dev/full", expect=CANNOT_CREATE)
        self.assertIn(b"cannot write /dev/full", result.stderr)
        contourctl("cure", "--resin", resin, model, "--html", model, expect=BAD_USAGE)
        contourctl("cure", "--resin", resin, model, "--html", self.path("x"), "--stl", self.path("x"), expect=BAD_USAGE)


class BadInput(CureTest):
    def test_a_resin_without_a_curve_is_refused(self):
        profile = self.write("plain.json", json.dumps(source_json("resins/standard.json")).encode())
        result = contourctl("cure", "--resin", profile, self.write("bridge.stl", BRIDGE), expect=BAD_DATA)
        self.assertIn(b"has no working_curve", result.stderr)

    def test_a_curve_that_cannot_be_is_refused_with_its_place(self):
        for key, value in (("penetration_depth_um", 0), ("critical_energy_mj_cm2", -1), ("peel_memory", 1.5)):
            profile = self.resin(**{key: value})
            result = contourctl("cure", "--resin", profile, self.write("bridge.stl", BRIDGE), expect=BAD_CONFIG)
            self.assertIn(f"/working_curve/{key}".encode(), result.stderr)

    def test_an_assumed_irradiance_is_called_one(self):
        bridge = self.write("bridge.stl", BRIDGE)
        for arguments in (["cure"], ["slice", "--masks", self.path("masks")]):
            result = contourctl(*arguments, bridge, "--resin", self.resin(bottom_overcure_um=1500), expect=BAD_DATA)
            self.assertIn(b"an irradiance of 10 mW/cm\xc2\xb2, assumed because no printer is given", result.stderr)
            self.assertNotIn(b"of the projector", result.stderr)

    def test_a_layer_height_of_the_command_line_must_be_the_resins(self):
        result = contourctl("cure", "--resin", self.resin(), "--layer-height-um", "900",
                            self.write("bridge.stl", BRIDGE), expect=BAD_DATA)  # fmt: skip
        self.assertIn(b"900", result.stderr)

    def test_neither_a_printer_nor_a_resin_is_a_usage_error(self):
        result = contourctl("cure", self.write("floating.stl", FLOATING), expect=BAD_USAGE)
        self.assertIn(b"cure needs --printer, or --resin", result.stderr)
