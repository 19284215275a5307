"""Whole prints on the simulated printer: masks, reports, and what happens when the machine fails."""

import html
import json
import math
import os
import random
import re
import shutil
import signal
import time

from harness import (
    ENDLESS, NIMBLE_RESIN, OK, REALTIME, SLAB, SOURCE, Daemon, FolderTest, ascii_stl, binary_stl, box, contents, contourctl, cube, inside_out,
    read_png, source_json, text_of, wait_until, wedge,
)  # fmt: skip

ANALYSIS = "contourd-layers"  # the name of the analysis thread
# In a preview, faint layers have at most 0.3 of the brightest grey value, 250.
BRIGHTER_THAN_FAINT = 80
PITCH_MM, WIDTH, HEIGHT = 0.05, 1920, 1080  # simulated.json


class PrintTest(FolderTest):
    def daemon(self, config=None, resin=None, masks=True):
        return Daemon(self, config, resin, masks).start()

    def masks(self, job):
        folder = self.path("masks", job)
        return {name: read_png(os.path.join(folder, name)) for name in sorted(os.listdir(folder))}

    def printed(self, data, ticket=None, config=None, resin=None):
        daemon = self.daemon(config, resin)
        report = daemon.printed("part.stl", data, ticket)
        daemon.stop()
        return report


class MaskBudget(PrintTest):
    def test_a_soup_of_facets_is_refused_if_its_masks_take_too_long(self):
        dice = random.Random(4)
        soup = [[[dice.uniform(0, 20) for _ in range(3)] for _ in range(3)] for _ in range(6000)]
        daemon = self.daemon({"mask_budget_ms": 100}, NIMBLE_RESIN, masks=False)
        reason = daemon.refused("soup.stl", binary_stl(soup))
        self.assert_one_line(reason.encode(), "takes longer than mask_budget_ms, 100 ms", "steps", "facets cut")
        daemon.printed("sound.stl", SLAB)


class Undersides(PrintTest):
    """Masks of a slab of 1 mm on two pillars, with "undersides": "dose"."""

    BRIDGE = binary_stl(box((-3, -2, 0), (-2, 2, 0.52)) + box((2, -2, 0), (3, 2, 0.52)) + box((-3, -2, 0.52), (3, 2, 1.5)))
    DEPTH_UM, CRITICAL, OVERCURE_UM, LAYER_UM = 150, 8, 50, 50

    def resin(self, undersides="dose", **curve):
        return {"undersides": undersides, "exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 0, "fade_layers": 0,
                "growth_um": 0, "elephant_foot_um": 0, "elephant_foot_height_um": 0,
                "working_curve": {"penetration_depth_um": self.DEPTH_UM, "critical_energy_mj_cm2": self.CRITICAL,
                                  "overcure_um": self.OVERCURE_UM, "bottom_overcure_um": self.OVERCURE_UM, **curve}}  # fmt: skip

    def columns(self, job="part"):
        """Returns the grey values of a pixel of the span and of one on a pillar, by layer."""
        pictures = [picture.rows[HEIGHT // 2] for picture in self.masks(job).values()]
        return [row[WIDTH // 2] for row in pictures], [row[WIDTH // 2 + 50] for row in pictures]

    def assert_critical_dose(self, memory):
        self.printed(self.BRIDGE, resin=self.resin(peel_memory=memory))
        span, pillar = self.columns()
        self.assertEqual(pillar, [255] * 30)
        full = math.exp((self.LAYER_UM + self.OVERCURE_UM) / self.DEPTH_UM)  # over Ec
        running = greatest = 0
        for layer, grey in enumerate(span):
            above_um = (layer + 1) * self.LAYER_UM - 520
            light = full * grey / 255 * math.exp(-above_um / self.DEPTH_UM) if above_um > 0 else 0
            running = running * memory + light
            greatest = max(greatest, running)
        # Half a grey value of 255 changes the dose by 0.4 %.
        self.assertAlmostEqual(greatest, 1, delta=0.005)
        self.assertIn(0, span[10:])
        self.assertEqual(span[-5:], [255] * 5)

    def test_the_printed_masks_give_the_underside_the_critical_dose(self):
        self.assert_critical_dose(memory=1)

    def test_so_they_do_if_the_resin_forgets_some_of_it(self):
        self.assert_critical_dose(memory=0.9)

    def test_without_a_measured_memory_the_job_is_exposed_plainly_and_told(self):
        report = self.printed(self.BRIDGE, resin=self.resin())
        self.assertEqual(set(self.columns()[0][11:]), {255})
        self.assertEqual(report["settings"]["undersides"], "plain")
        self.assertEqual(len(report["model"]["warnings"]), 1)
        self.assert_words(report["model"]["warnings"][0], "undersides are exposed plainly, not by dose", "no peel_memory")

    def test_a_ticket_decides_for_its_job(self):
        daemon = self.daemon(resin=self.resin("plain", peel_memory=1))
        for undersides in ("dose", "plain"):
            report = daemon.printed(undersides + ".stl", self.BRIDGE, {"undersides": undersides})
            self.assertEqual(report["settings"]["undersides"], undersides)
            self.assertEqual(0 in self.columns(undersides)[0][11:], undersides == "dose")
            self.assertEqual("; undersides by dose" in daemon.read("done", undersides + ".report.html"), undersides == "dose")

    def test_contourctl_slices_the_masks_and_forecasts_the_areas_of_the_print(self):
        daemon = self.daemon(resin=self.resin("plain", peel_memory=0.9))
        model, profile = self.write("model.stl", self.BRIDGE), self.path("resins", "standard.json")
        for undersides in ("dose", "plain"):
            ticket = self.write("ticket.json", json.dumps({"undersides": undersides}).encode())
            areas = [layer["area_mm2"] for layer in daemon.printed(undersides + ".stl", self.BRIDGE, {"undersides": undersides})["layer_records"]]
            printed = self.masks(undersides)
            for name, arguments in {
                "ticket": ["--printer", daemon.config_path, "--ticket", ticket],
                "option": ["--printer", daemon.config_path, "--undersides", undersides],
                "alone": ["--resin", profile, "--undersides", undersides],
            }.items():
                with self.subTest(undersides=undersides, name=name):
                    folder = self.path("sliced", undersides, name)
                    contourctl("slice", model, *arguments, "--masks", folder, expect=OK)
                    sliced = {file: read_png(os.path.join(folder, file)) for file in sorted(os.listdir(folder))}
                    self.assertEqual(sliced, printed)
                    analysis = json.loads(contourctl("analyze", model, *arguments, "--json", expect=OK).stdout)
                    self.assertEqual([round(area, 6) for area in analysis["area_mm2"]], [round(area, 6) for area in areas])
                    self.assertAlmostEqual(analysis["resin_ml"], (6 * 4 * 1 + 2 * 4 * 0.5) / 1000, delta=1e-6)  # whatever the light
                    self.assertEqual(analysis["islands"], 0)

    def test_a_ticket_cannot_have_dose_from_a_resin_without_a_curve_and_is_told(self):
        report = self.printed(self.BRIDGE, {"undersides": "dose"})
        self.assert_words(report["model"]["warnings"][0], "undersides are exposed plainly, not by dose", "has no working_curve")


class Masks(PrintTest):
    def assert_same_as_contourctl(self, data, report, *arguments):
        model = self.write("model.stl", data)
        result = contourctl("slice", model, "--layer-height-um", str(report["layer_height_um"]), "--masks",
                            self.path("expected"), "--display", f"{WIDTH}x{HEIGHT}", "--pixel-pitch-um", "50",
                            *arguments)  # fmt: skip
        self.assertEqual(result.returncode, OK, result.stderr)
        names = sorted(os.listdir(self.path("expected")))
        self.assertEqual(sorted(os.listdir(self.path("masks", "part"))), names)
        self.assertEqual(report["masks_folder"], self.path("masks", "part"))
        self.assertEqual(len(names), report["layers"])
        for name in names:
            # Compares the pixels, not the bytes of the files.
            self.assertEqual(read_png(self.path("masks", "part", name)), read_png(self.path("expected", name)), name)

    def test_a_box_of_20_mm_has_the_masks_of_contourctl_bit_for_bit(self):
        data = binary_stl(box((3, 4, 5), (23, 24, 25)))
        report = self.printed(data, {"layer_height_um": 100})
        self.assertEqual(report["layers"], 200)
        self.assertEqual(self.masks("part")["0001.png"].lit_box(), (760, 340, 1160, 740))
        self.assert_same_as_contourctl(data, report)

    def test_slanted_walls_holes_and_odd_layer_heights_have_the_masks_of_contourctl(self):
        facets = wedge(20, 10.013, 3.03) + inside_out(box((2.001, 2, 0), (6, 5.5, 1.0)))
        data = ascii_stl(facets)
        self.assert_same_as_contourctl(data, self.printed(data, {"layer_height_um": 33.75}))

    def test_without_anti_aliasing_the_masks_are_those_of_contourctl(self):
        data = binary_stl(wedge(20, 10, 3))
        report = self.printed(data, config={"display": {"anti_aliasing": False}})
        self.assert_same_as_contourctl(data, report, "--aa", "off")

    def test_compensation_and_correction_are_those_of_contourctl_and_in_the_report(self):
        data = binary_stl(wedge(10, 5, 1) + box((20, 0, 0), (22, 9, 1)))
        self.write("model.stl", data)
        contourctl("slice", self.path("model.stl"), "--z", "0.5", "--mask", self.path("even.png"))
        resin = {**source_json("resins", "standard.json"), "growth_um": 40, "elephant_foot_um": 120,
                 "elephant_foot_height_um": 600}  # fmt: skip
        report = self.printed(data, config={"display": {"uniformity_mask": "even.png", "gamma": 1.8, "threshold": 20}},
                              resin=resin)  # fmt: skip
        self.assert_same_as_contourctl(data, report, "--grow-um", "40", "--elephant-foot-um", "120",
                                       "--elephant-foot-height-um", "600", "--uniformity-mask", self.path("even.png"),
                                       "--gamma", "1.8", "--threshold", "20")  # fmt: skip
        settings = report["settings"]
        self.assertEqual((settings["growth_um"], settings["elephant_foot_um"], settings["elephant_foot_height_um"]),
                         (40, 120, 600))  # fmt: skip
        self.assertEqual((settings["uniformity_mask"], settings["gamma"], settings["threshold"]), (True, 1.8, 20))
        with open(self.path("spool", "done", "part.report.html"), encoding="utf-8") as file:
            self.assertIn("contours moved outwards by 40 um, elephant foot of 120 um compensated over 600 um of height, "
                          "uniformity mask applied, gamma 1.8, grey below 20 left dark", file.read())  # fmt: skip

    def test_the_report_s_area_is_the_masks_area(self):
        report = self.printed(binary_stl(wedge(20, 10.013, 2)))
        pictures = list(self.masks("part").values())
        self.assertEqual(len(pictures), 40)
        for layer, picture in zip(report["layer_records"], pictures):
            lit = sum(map(sum, picture.rows)) / 255 * PITCH_MM**2
            self.assertAlmostEqual(layer["area_mm2"], lit, delta=lit * 1e-9)
            width = 20 * (1 - layer["mask_height_mm"] / 2)
            # Grey values are rounded: half a value along 200 rows of both ends is far less than this.
            self.assertAlmostEqual(layer["area_mm2"], width * 10.013, delta=width * 10.013 * 1e-3 + 0.01)

    def lit(self, data, ticket=None, config=None):
        report = self.printed(data, ticket, config)
        return report, self.masks("part")["0001.png"]

    def test_a_single_part_is_centred_whatever_its_shape(self):
        for number, (x, y) in enumerate(((10, 5), (10, 50), (1, 40), (90, 2))):
            with self.subTest(x=x, y=y):
                daemon = self.daemon()
                name = f"part{number}"
                daemon.printed(name + ".stl", binary_stl(box((7, 7, 7), (7 + x, 7 + y, 7.1))))
                daemon.stop()
                self.assertEqual(self.masks(name)["0001.png"].lit_box(),
                                 (960 - x * 10, 540 - y * 10, 960 + x * 10, 540 + y * 10))  # fmt: skip

    def test_a_position_moves_the_part_by_the_same_number_of_pixels(self):
        _, picture = self.lit(SLAB, {"position_mm": {"x": 20, "y": -10}})
        self.assertEqual(picture.lit_box(), (960 - 100 + 400, 540 - 50 + 200, 960 + 100 + 400, 540 + 50 + 200))

    def test_copies_are_apart_from_each_other_and_inside_the_plate(self):
        for copies in (2, 3, 5, 6):
            with self.subTest(copies):
                daemon = self.daemon()
                report = daemon.printed(f"part{copies}.stl", binary_stl(box((0, 0, 0), (10, 5, 0.1))), {"copies": copies})
                daemon.stop()
                picture = self.masks(f"part{copies}")["0001.png"]
                self.assertEqual(sum(map(sum, picture.rows)), 255 * copies * 200 * 100)
                self.assertEqual(report["layer_records"][0]["loops"], 1)  # of one copy
                left, top, right, bottom = picture.lit_box()
                self.assertLessEqual(abs(left + right - WIDTH), 2)
                self.assertLessEqual(abs(top + bottom - HEIGHT), 2)

    def test_a_quarter_turn_turns_the_mask_anticlockwise(self):
        facets = box((0, 0, 0), (10, 2, 0.1)) + box((8, 2, 0), (10, 6, 0.1))  # an L that stands at the right
        _, picture = self.lit(binary_stl(facets), {"rotation_deg": {"z": 90}})
        left, top, right, bottom = picture.lit_box()
        self.assertEqual((right - left, bottom - top), (120, 200))
        # The model's right side becomes its top and its top becomes its left side: the long bar is at the right, the rest top left.
        self.assertEqual(picture.rows[top + 5][left:right], b"\xff" * 120)
        self.assertEqual(picture.rows[bottom - 5][left:right], bytes(80) + b"\xff" * 40)

    def test_mirrors_turn_the_picture_over(self):
        facets = binary_stl(box((0, 0, 0), (10, 2, 0.1)) + box((8, 2, 0), (10, 6, 0.1)))
        pictures = {}
        for number, (x, y) in enumerate(((False, False), (True, False), (False, True))):
            daemon = self.daemon({"display": {"mirror_x": x, "mirror_y": y}})
            daemon.printed(f"m{number}.stl", facets)
            daemon.stop()
            pictures[x, y] = self.masks(f"m{number}")["0001.png"]
        plain = pictures[False, False]
        self.assertEqual(pictures[True, False].rows, [row[::-1] for row in plain.rows])
        self.assertEqual(pictures[False, True].rows, plain.rows[::-1])

    def test_masks_of_an_earlier_job_of_the_same_name_are_deleted(self):
        daemon = self.daemon()
        daemon.printed("part.stl", SLAB)
        for name in daemon.names_in("done"):
            os.unlink(daemon.file("done", name))
        daemon.printed("part.stl", binary_stl(box((0, 0, 0), (10, 5, 0.2))))
        self.assertEqual(list(self.masks("part")), ["0001.png", "0002.png", "0003.png", "0004.png"])


class Analysis(PrintTest):
    # A slab, a gap of 1 mm, and a box above the gap: 60 layers of 50 um.
    FLOATING = binary_stl(box((0, 0, 0), (10, 10, 1)) + box((2, 3, 2), (4, 5, 3)))

    def test_a_sound_print_is_analysed_without_a_warning(self):
        report = self.printed(SLAB)
        found = report["analysis"]
        self.assertEqual((found["layers"], found["islands"], found["empty_layers"]), (20, 0, 0))
        self.assertEqual((found["warnings"], found["island_list"], found["empty_layer_list"]), ([], [], []))
        self.assertEqual((found["largest_area_layer"], found["cracked_layers"], found["open_chains"]), (1, 0, 0))
        # 20 boxes of 200 by 100 pixels, in double.
        self.assertAlmostEqual(found["resin_ml"], 0.05, delta=1e-9)
        self.assertAlmostEqual(found["largest_area_mm2"], 50, delta=1e-9)
        # Besides its layers, a print has the lamp's warm-up of 5 s, homing, the first way down, and parking.
        self.assertGreater(found["layer_time_s"], 20 * 6)
        self.assertGreater(report["print_time_s"], found["layer_time_s"] + 5)
        self.assertLess(report["print_time_s"], found["layer_time_s"] + 120)

    def test_islands_and_empty_layers_give_warnings_and_are_printed(self):
        daemon = self.daemon()
        report = daemon.printed("part.stl", self.FLOATING)
        self.assertEqual(report["layers_exposed"], 60)
        found = report["analysis"]
        self.assertEqual((found["islands"], found["empty_layers"]), (1, 20))
        self.assertEqual(found["empty_layer_list"], list(range(21, 41)))
        island = found["island_list"][0]
        self.assertEqual(island["layer"], 41)
        # The corners lie on borders of pixels, so only the rounding of doubles remains.
        for value, expected in zip(island["plate_mm"], (-2, -1), strict=True):
            self.assertAlmostEqual(value, expected, delta=1e-9)
        self.assertAlmostEqual(island["area_mm2"], 4, delta=1e-9)
        self.assertAlmostEqual(found["resin_ml"], 0.104, delta=1e-9)
        self.assertEqual(len(found["warnings"]), 2)
        page = daemon.read("done", "part.report.html")
        log = daemon.log()
        for warning in found["warnings"]:
            self.assertIn(warning, html.unescape(page))
            self.assertIn(warning, log)
        self.assertRegex(log, r"60 layers in .*, 0\.10 ml of resin, .*, 1 island, 20 empty layers; found in")
        history = daemon.rpc("history")["result"]["ended"]
        self.assertEqual(history[-1]["analysis"]["islands"], 1)

    def test_a_print_that_ends_before_its_analysis_is_filed_as_done_even_at_a_stop(self):
        daemon = self.daemon(masks=False)
        with daemon.held_thread(ANALYSIS):
            daemon.drop("part.stl", SLAB)
            daemon.wait_state("finishing")
            daemon.process.send_signal(signal.SIGTERM)
        daemon.wait_stopped()
        report = daemon.report("part")
        self.assertEqual((report["outcome"], report["layers_exposed"]), ("done", report["layers"]))
        self.assertIn("analysis", report)
        self.assertTrue(daemon.has("done", "part.stl"))
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("incoming")), ([], []))

    def test_the_status_shows_the_analysis_during_the_print(self):
        daemon = self.daemon(REALTIME)
        daemon.drop("part.stl", self.FLOATING)
        status = daemon.watcher.wait_for(lambda m: m.get("method") == "analysis", "the analysis")["params"]
        self.assertEqual(status["job"]["analysis"]["islands"], 1)
        self.assertEqual(daemon.status()["job"]["analysis"], status["job"]["analysis"])
        result = daemon.ctl("status")
        self.assertIn(b"resin     0.10 ml", result.stdout)
        self.assertIn(b"warning   1 island begins", result.stdout)
        daemon.stop()
        self.assertEqual(daemon.report("part", "failed")["analysis"]["islands"], 1)


class Report(PrintTest):
    def test_the_figures_of_the_report_are_those_of_the_print(self):
        report = self.printed(binary_stl(cube(20)))
        resin = source_json("resins", "standard.json")
        self.assertEqual((report["job"], report["outcome"], report["printer"]), ("part", "done", "Simulated printer"))
        self.assertEqual((report["layers"], report["layers_exposed"], report["layer_height_um"]), (400, 400, 50))
        self.assertEqual(report["resin"], "standard")
        self.assertNotIn("reason", report)
        model = report["model"]
        self.assertEqual((model["format"], model["facets"], model["watertight"]), ("binary", 12, True))
        self.assertEqual((model["size_mm"], model["scale"], model["copies"]), ([20, 20, 20], 1, 1))
        self.assertRegex(report["started"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertLessEqual(report["started"], report["ended"])
        # 400 squares of 400 pixels, in double.
        self.assertAlmostEqual(report["exposed_volume_mm3"], 8000, delta=1e-6)
        records = report["layer_records"]
        self.assertEqual([record["layer"] for record in records], list(range(1, 401)))
        for record in records:
            number = record["layer"]
            self.assertAlmostEqual(record["plate_height_mm"], number * 0.05, delta=1e-9)
            self.assertAlmostEqual(record["mask_height_mm"], (number - 0.5) * 0.05, delta=1e-9)
            self.assertAlmostEqual(record["area_mm2"], 400, delta=1e-9)
            self.assertEqual((record["loops"], record["intersecting_facets"], record["open_chains"]), (1, 8, 0))
            self.assertGreater(record["mask_ms"], 0)
            # Bottom exposure, then linearly down over the fade layers, then the normal one. Whole nanoseconds.
            faded = min(max(number - resin["bottom_layers"], 0), resin["fade_layers"] + 1) / (resin["fade_layers"] + 1)
            expected = resin["bottom_exposure_ms"] + (resin["exposure_ms"] - resin["bottom_exposure_ms"]) * faded
            self.assertAlmostEqual(record["exposure_asked_ms"], expected, delta=1e-5)
            # Only the print's own timers advance the simulated clock.
            self.assertAlmostEqual(record["exposure_most_ms"], record["exposure_asked_ms"], delta=1e-5)
        light = sum(record["exposure_asked_ms"] for record in records) / 1000
        waits = sum(record["settle_ms"] + resin["rest_ms"] for record in records) / 1000
        slow = resin["lift_mm"] / resin["lift_speed_mm_s"] + resin["slow_retract_mm"] / resin["slow_retract_speed_mm_s"]
        fast = resin["second_lift_mm"] / resin["second_lift_speed_mm_s"]
        fast += (resin["lift_mm"] + resin["second_lift_mm"] - resin["slow_retract_mm"]) / resin["retract_speed_mm_s"]
        self.assertGreater(report["print_time_s"], light + waits + 400 * (slow + fast))
        self.assertLess(report["print_time_s"], light + waits + 400 * (slow + fast + 1) + 120)  # acceleration, homing, parking

    def test_in_real_time_exposures_are_as_long_as_asked(self):
        resin = {**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 40, "bottom_layers": 2}
        report = self.printed(SLAB, config=REALTIME, resin=resin)
        self.assertEqual(report["layers_exposed"], 20)
        for record in report["layer_records"]:
            self.assertEqual(record["exposure_asked_ms"], 40 if record["layer"] <= 2 else 20)
            # Never too short. On a busy machine it may be late; a printer has its computer for itself.
            self.assertGreaterEqual(record["exposure_most_ms"], record["exposure_asked_ms"] - 0.01)
            self.assertLess(record["exposure_most_ms"], record["exposure_asked_ms"] + 50)
        self.assertGreater(report["print_time_s"], 20 * 0.02)

    def test_an_exposure_that_was_too_long_gives_a_warning_with_both_figures(self):
        resin = {**NIMBLE_RESIN, "exposure_ms": 1000, "bottom_exposure_ms": 1000}
        daemon = self.daemon(REALTIME, resin=resin)
        daemon.begin("part.stl", SLAB)
        lit = time.monotonic()
        wait_until(lambda: time.monotonic() - lit > 0.3, "the lamp, which takes 20 ms")
        # Simulates a computer that is busy with something else.
        daemon.process.send_signal(signal.SIGSTOP)
        stopped = time.monotonic()
        wait_until(lambda: time.monotonic() - stopped > 1.5, "longer than the exposure")
        daemon.process.send_signal(signal.SIGCONT)
        layer = daemon.wait_done("part")["layer_records"][0]
        daemon.stop()
        self.assertGreater(layer["exposure_least_ms"], 1500)
        # The log has one figure if both bounds round to the same.
        least, most = "%.1f" % layer["exposure_least_ms"], "%.1f" % layer["exposure_most_ms"]
        light = most if least == most else least + " to " + most
        self.assertIn("layer 1: the light was on for " + light + " ms, 1000.0 ms were asked for", daemon.log())

    def test_warnings_about_the_model_are_in_the_report(self):
        report = self.printed(binary_stl(cube(2)[1:]))
        self.assertFalse(report["model"]["watertight"])
        self.assertEqual(report["model"]["open_edges"], 3)
        self.assertTrue(any("watertight" in warning for warning in report["model"]["warnings"]), report["model"])

    def test_the_preview_shows_unprinted_layers_faintly(self):
        daemon = self.daemon({"simulation": {"projector_silent_after_commands": 101}})
        daemon.refused("part.stl", binary_stl(cube(20)))
        picture = read_png(daemon.file("failed", "part.preview.png"))
        all_of_it, part = picture.lit_box(), picture.lit_box(BRIGHTER_THAN_FAINT)
        daemon.stop()
        daemon.config["simulation"].pop("projector_silent_after_commands")
        daemon.write_config()
        daemon.start()
        daemon.rpc("resume")
        daemon.printed("whole.stl", binary_stl(cube(20)))
        whole = read_png(daemon.file("done", "whole.preview.png")).lit_box(BRIGHTER_THAN_FAINT)
        daemon.stop()
        # The top of the printed part is lower, since a quarter was printed.
        self.assertGreater(part[1], whole[1] + (whole[3] - whole[1]) // 4)
        self.assertLessEqual(abs(part[3] - whole[3]), 1)  # both have the same bottom
        for side, faint in zip(whole, all_of_it):
            self.assertLessEqual(abs(side - faint), 1)


class HeldQueue(PrintTest):
    """After a print that failed because of the hardware, no job starts by itself, whatever wait_for_plate_cleared is."""

    def held(self, wait_for_plate_cleared=False):
        daemon = self.daemon({"simulation": {"limit_switch": "stuck_open"}, "wait_for_plate_cleared": wait_for_plate_cleared})
        for name in ("one", "two", "three"):
            daemon.drop(name + ".stl", SLAB)
        daemon.wait_refused("one")
        return daemon, self.waiting(daemon, "homing failed")

    def waiting(self, daemon, words):
        def waits():
            status = daemon.status()
            return status if status["waiting_for"] and words in status["waiting_for"] else None
        return wait_until(waits, f"jobs to wait because of {words}")

    def test_jobs_wait_until_the_user_resumes_and_the_status_says_why(self):
        daemon, status = self.held()
        self.assertEqual((status["queued"], status["plate"]), (2, "clear"))
        sentence = status["held"]
        self.assertEqual(status["waiting_for"], sentence)
        self.assertRegex(sentence, 'the queue is held: one failed: homing failed: .*; check the printer, then run "contourctl resume"')
        self.assertIn(sentence, daemon.log())
        self.assertIn(sentence.encode(), daemon.ctl("status").stdout)
        self.assertEqual(sorted(daemon.names_in("incoming")), ["three.stl", "two.stl"])
        # After the user's resume, the next job starts and fails as well.
        self.assertEqual(daemon.ctl("resume").returncode, OK)
        daemon.wait_refused("two")
        self.waiting(daemon, "two failed")
        self.assertEqual(daemon.names_in("incoming"), ["three.stl"])
        self.assertNotIn("error", daemon.rpc("plate_cleared"))
        daemon.wait_refused("three")
        # The hold is shown even if no job waits.
        self.assertIn("three failed", daemon.wait_status("held")["held"])
        self.assertIn(b"held      the queue is held: three failed", daemon.ctl("status").stdout)
        self.assertIsNone(daemon.rpc("resume")["result"]["held"])
        self.assertIn("no print", daemon.rpc("resume")["error"]["message"])

    def test_a_restart_does_not_release_the_queue(self):
        daemon, _ = self.held()
        daemon.stop()
        daemon.config["simulation"]["limit_switch"] = "works"
        daemon.write_config()
        daemon.start()
        self.waiting(daemon, "one failed: homing failed")
        daemon.rpc("resume")
        daemon.wait_done("two")
        daemon.wait_done("three")
        daemon.stop()
        self.assertFalse(daemon.has("../spool.state/queue-held"))

    def test_with_a_part_on_the_plate_one_command_confirms_printer_and_plate(self):
        daemon = self.daemon({"simulation": {"projector_silent_after_commands": 8}, "wait_for_plate_cleared": True})
        daemon.drop("one.stl", SLAB)
        daemon.drop("two.stl", SLAB)
        daemon.wait_refused("one")
        sentence = self.waiting(daemon, "one failed: timed out after 30 s waiting for the projector")["waiting_for"]
        self.assertIn('check the printer and clear the plate, then run "contourctl plate-cleared"', sentence)
        daemon.rpc("plate_cleared")
        daemon.wait_refused("two")

    def test_a_job_that_fails_because_of_its_file_does_not_hold_the_queue(self):
        daemon = self.daemon()
        daemon.drop("bad.stl", b"no model")
        daemon.drop("good.stl", SLAB)
        daemon.wait_refused("bad")
        daemon.wait_done("good")
        self.assertIsNone(daemon.status()["held"])

    def test_a_stop_of_the_daemon_holds_the_queue_only_during_a_print(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        daemon.restart()
        self.assertIsNone(daemon.status()["held"])
        daemon.begin("part.stl", SLAB)
        daemon.restart()
        self.assertIn("part failed: contourd was stopped", daemon.status()["held"])


class Reload(PrintTest):
    def test_an_idle_daemon_is_restarted_at_once(self):
        daemon = self.daemon()
        daemon.reload()
        daemon.wait_restart()
        daemon.start()
        daemon.printed("part.stl", SLAB)

    def test_a_print_ends_undisturbed_and_the_new_daemon_prints_the_next_job(self):
        daemon = self.daemon(REALTIME, NIMBLE_RESIN)
        daemon.begin("one.stl", SLAB)
        daemon.drop("two.stl", SLAB)
        daemon.wait_status("queued", 1)
        daemon.reload()
        daemon.wait_restart()
        self.assertIn("contourd restarts when one is over", daemon.log())
        report = daemon.report("one", "done")
        self.assertEqual((report["outcome"], report["layers_exposed"]), ("done", report["layers"]))
        self.assertTrue(daemon.has("incoming", "two.stl"))
        daemon.start()
        daemon.wait_done("two")

    def test_a_print_whose_analysis_is_running_is_filed_with_the_analysis(self):
        daemon = self.daemon(masks=False)
        with daemon.held_thread(ANALYSIS):
            daemon.drop("part.stl", SLAB)
            daemon.wait_state("finishing")
            daemon.reload()
            wait_until(lambda: "contourd restarts when part is over" in daemon.log(), "the reload")
        daemon.wait_restart()
        self.assertIsNotNone(daemon.report("part")["analysis"])

    def test_a_paused_print_goes_on_before_the_restart(self):
        daemon = self.daemon(REALTIME, NIMBLE_RESIN)
        daemon.begin("part.stl", SLAB)
        daemon.rpc("pause")
        daemon.wait_state("paused")
        daemon.reload()
        wait_until(lambda: "contourd restarts when part is over" in daemon.log(), "the reload")
        self.assertEqual(daemon.status()["state"], "paused")
        daemon.rpc("resume")
        daemon.wait_restart()
        self.assertTrue(daemon.has("done", "part.stl"))

    def test_a_stop_before_the_restart_interrupts_the_print(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        daemon.begin("part.stl", SLAB)
        daemon.reload()
        daemon.stop()
        self.assertTrue(daemon.has("failed", "part.stl"))


class Fault(PrintTest):
    def fails(self, simulation, layers_exposed, data=SLAB, **config):
        daemon = self.daemon({"simulation": simulation, **config}, masks=False)
        self.assertEqual(daemon.names_in("failed"), [])
        for name in ("one", "two"):  # the next job starts after a failure
            reason = daemon.refused(name + ".stl", data)
            self.assertEqual(len(reason.splitlines()), 1, reason)
            report = daemon.report(name, "failed")
            self.assertEqual((report["outcome"], report["reason"]), ("failed", reason.strip()))
            if name == "one":
                self.assertEqual(report["layers_exposed"], layers_exposed)
                # The last layer may have had a part of its light, or its light is unknown.
                self.assertEqual(sum(layer["complete"] for layer in report["layer_records"]), layers_exposed)
                first = reason
            self.assertTrue(daemon.has("failed", name + ".report.html"))
            daemon.rpc("resume")
        self.assertEqual(daemon.status()["state"], "idle")
        self.daemon_under_test = daemon
        return first

    def test_a_limit_switch_that_never_closes_or_opens_and_a_silent_projector_end_the_print(self):
        for simulation, reason in (({"limit_switch": "stuck_open"}, "homing failed: .*switch"), ({"limit_switch": "stuck_closed"}, "homing failed: .*switch"),
                                   ({"projector_silent_after_commands": 0}, "power on: .*answer")):  # fmt: skip
            with self.subTest(simulation):
                self.assertRegex(self.fails(simulation, 0), reason)
                self.assertEqual(self.daemon_under_test.status()["plate"], "clear")
                self.daemon_under_test.stop()
                shutil.rmtree(self.daemon_under_test.spool)

    def interrupted(self, simulation):
        """Starts a print, and returns the daemon and the status once the print has paused by itself."""
        daemon = self.daemon({"simulation": simulation})
        daemon.drop("part.stl", SLAB)
        return daemon, daemon.wait_state("paused")

    def test_a_lost_display_pauses_the_print_until_it_is_back_and_the_user_resumes(self):
        daemon, status = self.interrupted({"display_lost_after_frames": 12, "display_back_after_s": 60})
        self.assertEqual((status["job"]["interruption"], status["job"]["layer"]), ("the display was unplugged", 13))
        self.assertEqual(status["job"]["layers_done"], 12)
        # The display is back after a simulated minute, which passes at once.
        status = wait_until(lambda: (lambda s: None if s["not_ready_reason"] else s)(daemon.status()), "the display to be back")
        self.assertEqual((status["state"], status["job"]["interruption"]), ("paused", "the display was unplugged"))
        self.assertIn(b"stopped   the display was unplugged", daemon.ctl("status").stdout)
        self.assertEqual(daemon.ctl("resume").returncode, OK)
        report = daemon.wait_done("part")
        daemon.stop()
        self.assertEqual((report["outcome"], report["layers_exposed"]), ("done", 20))
        self.assertEqual(report["interruptions"], ["layer 13: the display was unplugged"])
        self.assertEqual(len(self.masks("part")), 20)  # only the masks that could be seen
        self.assertIn("layer 13: the display was unplugged; the light is off", daemon.log())
        self.assertIn("the display was plugged in again", daemon.log())

    def test_a_print_is_not_resumed_while_the_display_is_gone_and_can_be_cancelled(self):
        daemon, status = self.interrupted({"display_lost_after_frames": 0})
        self.assertEqual(status["not_ready_reason"], "the display is unplugged")
        refused = daemon.ctl("resume")
        self.assertNotEqual(refused.returncode, OK)
        self.assertIn(b"the print cannot go on: the display is unplugged", refused.stderr)
        self.assertEqual(daemon.status()["state"], "paused")
        self.assertEqual(daemon.ctl("cancel").returncode, OK)
        self.assertEqual(daemon.wait_ended("part")["outcome"], "cancelled")
        # The next job waits for the machine, and the status says so.
        daemon.drop("next.stl", SLAB)
        status = daemon.wait_status("waiting_for")
        self.assertEqual((status["waiting_for"], status["queued"]), ("the display is unplugged", 1))
        self.assertIn(b"machine   the display is unplugged", daemon.ctl("status").stdout)

    def test_a_lid_opened_during_an_exposure_divides_it_and_the_parts_add_up(self):
        # Layers 1 to 5 have the bottom's 30 s each: the lid opens 18 s into the second.
        daemon, status = self.interrupted({"lid_opened_after_light_s": 48})
        self.assertEqual((status["job"]["interruption"], status["job"]["layer"]), ("the lid was opened", 2))
        wait_until(lambda: not daemon.status()["not_ready_reason"], "the lid to be closed")
        self.assertEqual(daemon.rpc("resume")["result"]["job"]["interruption"], None)
        report = daemon.wait_done("part")
        daemon.stop()
        self.assertEqual([record["exposure_parts"] for record in report["layer_records"]], [1, 2] + [1] * 18)
        for record in report["layer_records"]:
            self.assertAlmostEqual(record["exposure_most_ms"], record["exposure_asked_ms"], delta=1e-5)
        self.assertEqual(report["interruptions"], ["layer 2: the lid was opened"])
        self.assertIn("layer 2: the lid was opened", text_of(daemon.file("done", "part.report.html")))

    def test_a_projector_that_falls_silent_ends_the_print(self):
        # The projector gets power on, and then one command for each layer.
        reason = self.fails({"projector_silent_after_commands": 8}, 7)
        self.assertRegex(reason, "timed out after 30 s waiting for the projector to confirm that its light is off")
        last = self.daemon_under_test.report("one", "failed")["layer_records"][-1]
        self.assertEqual((last["layer"], last["complete"], last["dark_confirmed"]), (8, False, False))
        self.assertEqual(last["exposure_least_ms"], 0)
        self.assertGreater(last["exposure_most_ms"], last["exposure_asked_ms"])
        self.daemon_under_test.stop()

    def test_a_slow_projector_does_not_shorten_the_exposure(self):
        report = self.printed(SLAB, config={"simulation": {"projector_reply_ms": 1500}})
        for record in report["layer_records"]:
            self.assertAlmostEqual(record["exposure_most_ms"], record["exposure_asked_ms"], delta=1e-5)

    def test_masks_that_cannot_be_written_end_the_print(self):
        self.write("masks", b"a file, no folder")
        daemon = self.daemon()
        self.assertIn("masks", daemon.refused("part.stl", SLAB))
        self.assertTrue(daemon.alive())

    def test_a_job_waits_while_the_disk_is_too_full(self):
        daemon = self.daemon({"min_free_disk_mb": 1000000}, masks=False)
        if os.statvfs(self.folder).f_bavail * os.statvfs(self.folder).f_frsize >= 1e12:
            self.skipTest("the disk has more room than the limit can be")
        daemon.drop("part.stl", SLAB)
        daemon.refused("bad.stl", b"no model")
        status = daemon.status()
        self.assertEqual((status["state"], status["queued"]), ("idle", 1))
        self.assertRegex(status["waiting_for"], r"disk has \d+ MB free, 1000000 MB")


class Log(PrintTest):
    def test_a_layer_is_one_line_and_the_light_goes_off_at_the_end(self):
        daemon = self.daemon(masks=False)
        daemon.printed("part.stl", SLAB)
        daemon.stop()
        log = daemon.log()
        self.assertEqual(len(re.findall(r"layer \d+ of 20:", log)), 20)
        self.assertRegex(log, r"part: done after 20 of 20 layers and \d+ min")
        self.assertIn("light off", log.splitlines()[-1])
        self.assertNotIn("\x1b", log)  # no terminal

    def test_a_file_name_cannot_forge_a_line(self):
        daemon = self.daemon(masks=False)
        name = "x\n00:00:00.000 error   the printer burns"
        daemon.printed(name + ".stl", SLAB)
        daemon.stop()
        self.assertNotRegex(daemon.log(), r"(?m)^00:00:00.000")

    def test_the_readme_s_configurations_are_there(self):
        for name in ("contourd.json", "simulated.json"):
            self.assertIn("$schema", json.loads(contents(os.path.join(SOURCE, "config", name))))
