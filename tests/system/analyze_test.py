"""contourctl analyze: its figures, its HTML page, and its messages about bad input."""

import base64
import html.parser
import json
import os
import re

from harness import (
    BAD_DATA, BAD_USAGE, CANNOT_CREATE, FLOATING, NO_INPUT, OK, SOURCE, Daemon, FolderTest, binary_stl, box, contourctl, cube, inside_out, read_png,
    source_json, text_of, wedge,
)  # fmt: skip

BAD_CONFIG = 78


class AnalyzeTest(FolderTest):
    def analyze(self, data, *arguments):
        result = contourctl("analyze", "--json", *arguments, self.write("model.stl", data), expect=OK)
        self.assertEqual(result.stderr, b"")
        return json.loads(result.stdout)


class Figures(AnalyzeTest):
    def test_a_box_has_its_exact_figures(self):
        found = self.analyze(binary_stl(box((-3, 5, 1), (7, 25, 11))))
        self.assertEqual((found["facets"], found["size_mm"], found["layer_height_um"]), (12, [10, 20, 10], 50))
        self.assertEqual((found["layers"], found["islands"], found["empty_layers"]), (200, 0, 0))
        self.assertEqual((found["cracked_layers"], found["open_chains"], found["gaps_closed"]), (0, 0, 0))
        self.assertEqual((found["warnings"], found["model_warnings"], found["island_list"]), ([], [], []))
        self.assertEqual((found["layer_time_s"], found["assumed_layer_time_s"]), (200 * 10, 10))
        # The sides lie on borders of pixels, so only the rounding of doubles remains.
        self.assertAlmostEqual(found["resin_ml"], 2, delta=1e-9)
        self.assertAlmostEqual(found["largest_area_mm2"], 200, delta=1e-9)
        self.assertEqual(found["largest_area_layer"], 1)
        self.assertEqual(len(found["area_mm2"]), 200)
        for area in found["area_mm2"]:
            self.assertAlmostEqual(area, 200, delta=1e-9)
        statistics = found["statistics"]
        self.assertEqual(statistics["intersecting_facets"], {"mean": 8, "sd": 0})
        self.assertEqual(statistics["loop_count"], {"mean": 1, "sd": 0})
        # The correlation with a constant (equation 4.1) is the mean over the root mean square: the same for both constants.
        self.assertAlmostEqual(statistics["correlation_contour_time_loop_count"],
                               statistics["correlation_contour_time_intersecting_facets"], delta=1e-12)  # fmt: skip
        self.assertGreater(statistics["total_ms"]["mean"], 0)

    def test_a_wedge_is_largest_at_its_foot(self):
        found = self.analyze(binary_stl(wedge(20, 10, 10)), "--layer-height-um", "100", "--layer-time-s", "7.5")
        self.assertEqual(found["layer_time_s"], 750)
        self.assertEqual((found["layers"], found["largest_area_layer"]), (100, 1))
        # The midpoint rule is exact for a plane; grey pixels of one slanted edge are rounded to 1/255.
        self.assertAlmostEqual(found["resin_ml"], 1, delta=1e-3)

    def test_an_island_and_the_empty_layers_under_it_are_found(self):
        found = self.analyze(FLOATING)
        self.assertEqual((found["layers"], found["islands"], found["empty_layer_list"]), (60, 1, list(range(21, 41))))
        island = found["island_list"][0]
        self.assertEqual(island["layer"], 41)
        # The model is in the middle of 1920 x 1080 pixels of 50 um; the island is 2 mm left of the middle and 1 mm down.
        for value, expected in zip(island["plate_mm"] + island["pixel"], (-2, -1, 920, 560), strict=True):
            self.assertAlmostEqual(value, expected, delta=1e-9)
        self.assertAlmostEqual(island["area_mm2"], 4, delta=1e-9)
        self.assertEqual(len(found["warnings"]), 2)

    def test_a_model_whose_masks_are_all_dark_gives_a_warning(self):
        found = self.analyze(binary_stl(box((0, 0, 0), (0.00001, 5, 0.04))))
        self.assertEqual((found["layers"], found["empty_layers"], found["empty_layer_list"]), (1, 1, [1]))
        self.assertEqual(found["warnings"], ["all masks are dark (1 layer): nothing would be printed"])

    def test_a_model_that_reaches_no_layers_middle_gives_a_warning(self):
        found = self.analyze(binary_stl(box((0, 0, 0), (5, 5, 0.01))))
        self.assertEqual((found["layers"], found["empty_layers"]), (0, 0))
        self.assertEqual(
            found["model_warnings"], ["the model is 0.01 mm high, too thin for a layer: nothing would be printed"]
        )

    def test_a_plate_between_two_cuts_gives_a_warning(self):
        stem, plate = box((0, 0, 0), (4, 4, 6)), box((-3, -3, 2), (7, 7, 2.02))
        warnings = self.analyze(binary_stl(stem + plate))["model_warnings"]
        self.assertEqual(len(warnings), 1)
        self.assertIn("at 1 height: the first is 0.02 mm thick, at ", warnings[0])

    def test_cracks_are_listed_by_layer(self):
        facets = [f for f in cube(2) if not all(vertex[0] == 2 for vertex in f)]
        found = self.analyze(binary_stl(facets))
        self.assertEqual((found["cracked_layers"], found["open_chains"], found["widest_gap_mm"]), (40, 40, 2))
        self.assertEqual([each["layer"] for each in found["cracked_layer_list"]], list(range(1, 41)))
        self.assertTrue(any("did not close" in warning for warning in found["warnings"]), found["warnings"])

    def test_without_json_it_prints_plain_text(self):
        result = contourctl("analyze", self.write("model.stl", FLOATING))
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        for words in (b"60 of 50 um", b"10 min 00 s, at 10 s each", b"0.104 ml", "100.00 mm², layer 1".encode(), b"islands       1", b"empty layers  20",
                      b"1 island begins with nothing under it: layer 41", b"normalized correlation"):  # fmt: skip
            self.assertIn(words, result.stdout)
        self.assertNotIn(b"{", result.stdout)

    def test_a_model_without_facets_has_no_layers(self):
        found = self.analyze(binary_stl([]), "--html", self.path("page.html"))
        self.assertEqual((found["layers"], found["resin_ml"], found["largest_area_layer"]), (0, 0, None))

    def test_a_model_larger_than_the_display_gives_a_warning(self):
        found = self.analyze(binary_stl(cube(20)), "--display", "100x100")
        self.assertEqual(len(found["model_warnings"]), 1)
        self.assertIn("larger than the display", found["model_warnings"][0])


class WithPrinter(AnalyzeTest):
    CONFIG = os.path.join(SOURCE, "config", "simulated.json")

    def test_the_figures_are_the_same_as_the_daemon_s(self):
        daemon = Daemon(self).start()
        ticket = {"layer_height_um": 100, "copies": 2, "position_mm": {"x": 3, "y": -2}}
        expected = daemon.printed("part.stl", FLOATING, ticket)["analysis"]
        daemon.stop()
        ticket_path = self.write("ticket.json", json.dumps(ticket).encode())
        found = self.analyze(FLOATING, "--printer", daemon.config_path, "--ticket", ticket_path)
        self.assertEqual(found["islands"], 2)
        self.assertGreater(found["layer_time_s"], 30 * 6)
        self.assertIsNone(found["assumed_layer_time_s"])
        self.assertEqual({key: found[key] for key in expected}, expected)

    def test_the_layer_time_depends_on_the_resin(self):
        found = self.analyze(binary_stl(box((0, 0, 0), (5, 5, 1))), "--printer", self.CONFIG)
        resin = source_json("resins", "standard.json")
        least = resin["exposure_ms"] + resin["settle_ms"] + resin["rest_ms"]
        self.assertGreater(found["layer_time_s"], found["layers"] * least / 1000)

    def test_the_layer_time_on_a_real_printer_depends_on_its_axis(self):
        real = source_json("raspberry-pi-4.json")
        real["resins_folder"], real["projectors_folder"] = (os.path.join(SOURCE, "config", name) for name in ("resins", "projectors"))
        resin = source_json("resins", "standard.json")

        def layer_time(**of_axis):
            config = self.write("printer.json", json.dumps({**real, "z_axis": {**real["z_axis"], **of_axis}}).encode())
            return self.analyze(binary_stl(box((0, 0, 0), (5, 5, 1))), "--printer", config)["layer_time_s"]

        layers, plain, jerk = 20, layer_time(), 500.0
        # A trapezoid that reaches its full speed takes d/v + v/a, an S-curve that reaches its full acceleration a/jerk more.
        acceleration = real["z_axis"]["acceleration_mm_s2"]
        # The plate makes four moves for each layer; the last stage of the way down is too short for full acceleration.
        self.assertGreater(layer_time(jerk_mm_s3=jerk) - plain, layers * 3 * acceleration / jerk)
        self.assertLess(layer_time(jerk_mm_s3=jerk) - plain, layers * 4 * acceleration / jerk)
        # With backlash the plate goes down 1 mm further and comes back up at the same speed, in both stages.
        further = sum(2 / resin[key] + resin[key] / acceleration for key in ("retract_speed_mm_s", "slow_retract_speed_mm_s"))
        self.assertAlmostEqual(layer_time(backlash_um=1000) - plain, layers * further, delta=0.001)

    def continuous_printer(self, **changes):
        resin = {**source_json("resins", "standard.json"), "continuous": {"window_s": 3600, "recovery_s": 60, "layered_mm": 0.5}}
        curve = {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 150, "dead_zone_um": 30}
        resin = {key: resin[key] for key in resin if key not in ("exposure_ms", "bottom_exposure_ms", "ticket_limits")}
        resin = {**resin, "working_curve": curve, **changes}
        self.write("standard.json", json.dumps({key: resin[key] for key in resin if resin[key] is not None}).encode())
        return self.write("printer.json", json.dumps({**source_json("simulated.json"), "resins_folder": "."}).encode())

    def test_a_continuous_print_has_a_plan(self):
        # A flange of 54 mm around a stem of 6 mm, from 4 to 6 mm above the plate.
        model = binary_stl(box((-3, -3, 0), (3, 3, 10)) + box((-27, -26, 4), (27, 26, 6)))
        found = self.analyze(model, "--printer", self.continuous_printer(), "--mode", "continuous", "--supports", "off")["continuous"]
        limits = [each["limit"] for each in found["ranges"]]
        self.assertEqual((limits[0], limits[1], limits[-1]), (None, "cure", "cure"))
        # At 5 mW/cm2: 55 mm/h x 5/4. The flange lets resin in at 11 mm/h through the gap of the dead zone.
        self.assertAlmostEqual(found["speed_mm_h"][1], 69.08, delta=0.01)
        self.assertLess(found["speed_mm_h"][0], 15)
        slow = min((each for each in found["ranges"] if each["limit"] == "refill"), key=lambda each: each["speed_mm_h"][0])
        self.assertTrue(3.5 <= slow["bottom_mm"] <= 4.2, slow)
        self.assertAlmostEqual(sum(each["time_s"] + each["rest_s"] for each in found["ranges"]), found["time_s"], delta=1e-6)
        text = contourctl("analyze", self.path("model.stl"), "--printer", self.path("printer.json"), "--mode", "continuous", expect=OK).stdout.decode()
        for part in ("continuous    ", "gel gap       ", "refill  ", "mm/h"):
            self.assertIn(part, text)

    def test_a_print_that_cannot_be_continuous_is_refused(self):
        path = self.write("cube.stl", binary_stl(cube(3)))
        for changes, said in (({"viscosity_mpa_s": None}, "viscosity_mpa_s"), ({"continuous": None}, "continuous"),
                              ({"continuous": {"window_s": 60, "recovery_s": 60, "margin": 100}}, "least_speed_mm_h")):  # fmt: skip
            result = contourctl("analyze", path, "--printer", self.continuous_printer(**changes), "--mode", "continuous")
            self.assert_refusal(result, BAD_DATA, "standard", said)
        # The settings that a job refuses, too.
        for changes, said in (({"undersides": "dose"}, "undersides"), ({"mode": "continuous", "undersides": "dose"}, "undersides")):
            result = contourctl("analyze", path, "--printer", self.continuous_printer(**changes), "--mode", "continuous")
            self.assert_refusal(result, BAD_DATA, said)
        printer = json.loads(open(self.continuous_printer(), "rb").read())
        printer["display"] = {**printer["display"], "grey_bits": 3}
        coarse = self.write("coarse.json", json.dumps(printer).encode())
        self.assert_refusal(contourctl("analyze", path, "--printer", coarse, "--mode", "continuous"), BAD_DATA, "grey_bits")
        self.assertEqual(contourctl("analyze", path, "--mode", "continuous").returncode, BAD_USAGE)
        self.assertIsNone(self.analyze(binary_stl(cube(3)), "--printer", self.continuous_printer())["continuous"])

    def test_a_model_that_the_printer_cannot_print_is_bad_data(self):
        path = self.write("large.stl", binary_stl(cube(100)))
        result = contourctl("analyze", path, "--printer", self.CONFIG)
        self.assert_refusal(result, BAD_DATA, path, "over the left edge", "of the build area")

    def test_a_wrong_configuration_or_ticket_is_an_error(self):
        model = self.write("cube.stl", binary_stl(cube(10)))
        config = self.write("printer.json", b'{"name": 3}')
        result = contourctl("analyze", model, "--printer", config)
        self.assert_refusal(result, BAD_CONFIG, config)
        ticket = self.write("ticket.json", b'{"copies": "many"}')
        result = contourctl("analyze", model, "--printer", self.CONFIG, "--ticket", ticket)
        self.assert_refusal(result, BAD_DATA, ticket, "copies")


class Parser(html.parser.HTMLParser):
    """Checks that elements are closed in order; collects references, labels and text."""

    VOID = {"meta", "img"}

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.references, self.text = [], [], [], ""
        self.labels = []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag not in self.VOID:
            self.open.append(tag)
        self.labels += [value for name, value in attributes if name == "aria-label"]
        self.references += [value for name, value in attributes if name in ("src", "href", "data", "action")]

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open}"
        self.open.pop()

    def handle_data(self, data):
        self.text += data


class Page(AnalyzeTest):
    def page(self, data, name="page.html", *arguments):
        path = self.path(name)
        self.analyze(data, "--html", path, *arguments)
        text = text_of(path)
        page = Parser()
        page.feed(text)
        page.close()
        self.assertEqual(page.open, [])
        return text, page

    def test_the_page_is_one_file_without_references(self):
        text, page = self.page(FLOATING)
        self.assertNotRegex(text, r"(?i)https?:|url\(|@import|<link|\bimport\b")
        self.assertEqual([each for each in page.references if not each.startswith("data:image/png;base64,")], ["#mark-0"])
        self.assertEqual(page.tags.count("svg"), 7)  # the plots, and the marks in the picture
        self.assertEqual((page.tags.count("img"), page.tags.count("script")), (1, 0))
        self.assertNotRegex(text, r"\b(nan|inf)\b")
        self.assertNotIn("{{", text)
        for words in ("model.stl", "Slicing time", "Contour time", "Total time", "Intersecting facets", "Contour loops",
                      "Exposed area", "Normalized correlation", "1 island begins", "0.10 ml"):  # fmt: skip
            self.assertIn(words, page.text)

    def test_a_plot_is_labelled_with_its_title_as_plain_text(self):
        _, page = self.page(FLOATING)
        # Two boxes of 20 layers each, and 20 empty layers.
        self.assertIn("Intersecting facets mean 5.333, SD 3.803", page.labels)
        self.assertNotRegex("".join(page.labels), "[<>&]")

    def test_the_picture_shows_the_part_and_marks_the_place_of_each_table_row(self):
        # A slab, and two boxes that float above it at different heights.
        text, page = self.page(binary_stl(box((0, 0, 0), (10, 10, 1)) + box((2, 3, 2), (4, 5, 3)) + box((6, 3, 5), (7, 5, 6))))
        [source] = [each for each in page.references if each.startswith("data:")]
        picture = read_png(self.write("picture.png", base64.b64decode(source.partition(",")[2], validate=True)))
        left, top, right, bottom = picture.lit_box()
        self.assertGreater(len(picture.values()), 3)
        rings = dict(re.findall(r'<circle class="ring island" id="(mark-\d)" cx="[\d.]+" cy="([\d.]+)"', text))
        self.assertEqual([each for each in page.references if each.startswith("#")], [f"#{ring}" for ring in rings])
        self.assertEqual(len(rings), 2)  # the larger island, which is the lower one, is first
        self.assertTrue(top < float(rings["mark-1"]) < float(rings["mark-0"]) < bottom, (rings, top, bottom))
        self.assertLess(abs((left + right) / 2 - picture.width / 2), 2)
        self.assertRegex(page.text, "island, layer 41")

    def test_a_file_name_cannot_become_part_of_the_page(self):
        name = "<script>alert(1)</script>{{data}}&.stl".replace("/", "\u2215")
        path = self.write(name, binary_stl(cube(2)))
        contourctl("analyze", path, "--html", self.path("page.html"), expect=OK)
        text = text_of(self.path("page.html"))
        page = Parser()
        page.feed(text)
        self.assertEqual(page.tags.count("script"), 0)
        self.assertIn(name, page.text)

    def test_a_page_that_cannot_be_written_gives_73(self):
        page = self.path("nowhere", "page.html")
        result = contourctl("analyze", self.write("cube.stl", binary_stl(cube(2))), "--html", page)
        self.assert_refusal(result, CANNOT_CREATE, page)


class BadInput(AnalyzeTest):
    def test_bad_data_gives_65_and_one_line(self):
        for data in (b"", b"no STL file", binary_stl(cube(20))[:-7], binary_stl([((float("nan"), 0, 0), (1, 0, 0), (0, 1, 0))])):
            path = self.write("bad.stl", data)
            for more in ([], ["--json"], ["--html", self.path("page.html")], ["--printer", WithPrinter.CONFIG]):
                result = contourctl("analyze", path, *more)
                self.assert_refusal(result, BAD_DATA, path)
        self.assertFalse(os.path.exists(self.path("page.html")))

    def test_a_file_that_cannot_be_read_gives_66_and_one_line(self):
        for path in (self.path("missing.stl"), self.folder, ""):
            for more in ([], ["--printer", WithPrinter.CONFIG]):
                result = contourctl("analyze", *more, "--", path)
                self.assert_refusal(result, NO_INPUT, path)

    def test_wrong_options_are_bad_usage(self):
        path = self.write("cube.stl", binary_stl(cube(2)))
        for more in (["--layer-height-um", "0"], ["--layer-height-um", "nan"], ["--layer-time-s", "-1"], ["--layer-time-s", "nan"],
                     ["--layer-time-s", "8", "--printer", WithPrinter.CONFIG], ["--display", "0x5"], ["--aa", "maybe"],
                     ["--html", ""], ["--pixel-pitch-um", "-1"], ["--ticket", "ticket.json"],
                     ["--printer", WithPrinter.CONFIG, "--display", "100x100"]):  # fmt: skip
            result = contourctl("analyze", path, *more)
            self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), (more, result))
        self.assertEqual(contourctl("analyze").returncode, BAD_USAGE)

    def test_a_model_inside_out_is_analysed_with_a_warning(self):
        for more in ([], ["--printer", WithPrinter.CONFIG]):
            found = self.analyze(binary_stl(inside_out(cube(20))), *more)
            self.assertAlmostEqual(found["resin_ml"], 8, delta=1e-9)
            self.assertEqual(found["model_warnings"], ["the model is inside out: its facets were turned outwards"])
