"""Sliced archives (.sl1, .sl1s, .sl1_svg): finished layers that are printed as they are, pictures or outlines."""

import os
import shutil
import struct
import subprocess
import zlib

from harness import BAD_DATA, OK, SLAB, SpoolTest, binary_stl, box, contents, contourctl, read_png, wedge
from sliced import config_ini, nanodlp, pictures, png, sl1, sl1_svg, slicer_ini, svg

WIDTH, HEIGHT = 64, 40
DISPLAY = {"display": {"width_px": WIDTH, "height_px": HEIGHT}}
CURVE = {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 150}
LIMITS = {"ticket_limits": {"exposure_ms": [1000, 5000], "bottom_exposure_ms": [4000, 60000]}}


def mirrored(rows):
    return [row[::-1] for row in rows]


def turned(rows):
    """Returns the picture, turned by a quarter counter-clockwise."""
    return [bytes(row[x] for row in rows) for x in reversed(range(len(rows[0])))]


class Sliced(SpoolTest):
    LAYERS = pictures(6, WIDTH, HEIGHT)

    def printer(self, config=None, resin=None):
        # A small display stands for a large one, for a test in seconds.
        return self.daemon({**DISPLAY, **(config or {})}, resin, masks=True).start()

    def masks(self, job):
        folder = self.path("masks", job)
        return [read_png(os.path.join(folder, name)).rows for name in sorted(os.listdir(folder)) if name.endswith(".png")]

    def test_each_mask_is_the_picture_to_the_byte(self):
        daemon = self.printer(resin={"growth_um": 200})
        for name in ("part.sl1", "other.SL1S", "third.zip"):
            job = name.split(".")[0]
            data = sl1(self.LAYERS)
            daemon.drop(name, data)
            report = daemon.wait_done(job)
            self.assertEqual(self.masks(job), self.LAYERS)
            self.assertEqual(contents(daemon.file("done", name.lower())), data)
            self.assertEqual((report["layers"], report["layer_height_um"], report["model"]["format"]), (6, 50, "sl1"))
            areas = [sum(sum(row) for row in rows) / 255 * 0.05**2 for rows in self.LAYERS]
            self.assertEqual([round(layer["area_mm2"], 6) for layer in report["layer_records"]], [round(area, 6) for area in areas])
            self.assertEqual(len([w for w in report["model"]["warnings"] if "finished pictures of layers" in w]), 1)
            self.assertIn("pictures of layers", daemon.read("done", job + ".report.html"))

    def test_a_plate_of_nanodlp_is_printed_as_it_is(self):
        daemon = self.printer({"display": {**DISPLAY["display"], "mirror_x": True}}, LIMITS)
        data = nanodlp(self.LAYERS)
        daemon.drop("part.nanodlp", data)
        report = daemon.wait_done("part")
        self.assertEqual(self.masks("part"), self.LAYERS)
        self.assertEqual(contents(daemon.file("done", "part.nanodlp")), data)
        self.assertEqual((report["layers"], report["layer_height_um"], report["model"]["format"]), (6, 50, "nanodlp"))
        self.assertEqual(len([w for w in report["model"]["warnings"] if "shown as they are: check that the part is not mirrored" in w]), 1)
        report = daemon.printed("file.nanodlp", data, {"exposure_from": "file"})
        self.assertEqual([layer["exposure_asked_ms"] for layer in report["layer_records"]], [20000] * 2 + [2500] * 4)
        self.assert_words(daemon.refused("fine.nanodlp", nanodlp(self.LAYERS, pitch_mm=0.047)), "47.00 x 47.00 um", "50.00 um")
        self.assert_words(daemon.refused("gap.nanodlp", nanodlp(self.LAYERS, more={"3.png": None})), "3.png, is missing")
        self.assert_words(daemon.refused("short.nanodlp", nanodlp(self.LAYERS, more={"6.png": None})), "6 layers (LayersCount)", "pictures of 5")
        self.assert_words(daemon.refused("odd.nanodlp", nanodlp(self.LAYERS, more={"options.json": "{", "profile.json": "{}"})), "options.json is damaged")
        self.assert_words(daemon.refused("no.nanodlp", b"x" * 500), "sliced archive", "no ZIP file")

    def test_the_light_on_the_plate_is_that_of_the_sliced_model_whatever_the_mirrors_of_both_displays_are(self):
        for mirror_x, mirror_y in ((False, False), (True, False), (True, True)):
            with self.subTest(mirror_x=mirror_x, mirror_y=mirror_y):
                daemon = self.printer({"display": {**DISPLAY["display"], "mirror_x": mirror_x, "mirror_y": mirror_y}})
                expected = [mirrored(rows) if mirror_x else rows for rows in self.LAYERS]
                expected = [rows[::-1] if mirror_y else rows for rows in expected]
                for case, (sliced, changes) in {
                    "as on the plate": (self.LAYERS, {}),
                    "columns": ([mirrored(rows) for rows in self.LAYERS], {"display_mirror_x": 1}),
                    "rows": ([rows[::-1] for rows in self.LAYERS], {"display_mirror_y": 1}),
                    "on end": ([turned(rows) for rows in self.LAYERS], {"display_orientation": "portrait"}),
                    "on end, columns": ([mirrored(turned(rows)) for rows in self.LAYERS], {"display_orientation": "portrait", "display_mirror_x": 1}),
                }.items():  # fmt: skip
                    job = f"{case}, {mirror_x}, {mirror_y}"
                    daemon.printed(job + ".sl1", sl1(sliced, slicer=slicer_ini(WIDTH, HEIGHT, **changes)))
                    self.assertEqual(self.masks(job), expected)
                daemon.stop()

    def test_a_file_that_does_not_name_its_display_is_printed_as_it_is_with_a_warning(self):
        daemon = self.printer({"display": {**DISPLAY["display"], "mirror_x": True}})
        report = daemon.printed("part.sl1", sl1(self.LAYERS, more={"prusaslicer.ini": None}))
        self.assertEqual(self.masks("part"), self.LAYERS)
        self.assertTrue(any("prusaslicer.ini" in warning for warning in report["model"]["warnings"]))

    def test_exposures_are_the_resins_or_by_the_ticket_the_files(self):
        daemon = self.printer(resin={**LIMITS, "bottom_layers": 1, "fade_layers": 0})
        asked = lambda report: [layer["exposure_asked_ms"] for layer in report["layer_records"]]
        self.assertEqual(asked(daemon.printed("resin.sl1", sl1(self.LAYERS))), [30000] + [3000] * 5)
        report = daemon.printed("file.sl1", sl1(self.LAYERS), {"exposure_from": "file"})
        # Three layers have the first exposure, and the fade is that of PrusaSlicer's time: in equal steps.
        fade = [20000 - (20000 - 2500) / 3 * step for step in (1, 2)]
        self.assertEqual([round(each) for each in asked(report)], [20000] * 3 + [round(each) for each in fade] + [2500])
        self.assert_words(daemon.refused("short.sl1", sl1(self.LAYERS, config_ini(6, expTime=0.5)), {"exposure_from": "file"}), "exposure_ms is 500", "1000 to 5000", "exposure_from")
        self.assert_words(daemon.refused("none.sl1", sl1(self.LAYERS, config_ini(6, expTime=None)), {"exposure_from": "file"}), "names none", "expTime")
        self.assert_words(daemon.refused("model.stl", SLAB, {"exposure_from": "file"}), "exposure_from", "is a model")
        self.assert_words(daemon.refused("both.sl1", sl1(self.LAYERS), {"exposure_from": "file", "exposure_ms": 3000}), "exposure_from", "not both")

    def test_a_resin_with_a_working_curve_gets_no_comparison_with_a_model_that_is_not_there(self):
        daemon = self.printer(resin={"exposure_ms": None, "bottom_exposure_ms": None, "working_curve": CURVE})
        self.assertIsNotNone(daemon.printed("model.stl", binary_stl(box((0, 0, 0), (1, 1, 0.3))))["cured_part"])
        report = daemon.printed("part.sl1", sl1(self.LAYERS, config_ini(6, layerHeight=0.1)))
        self.assertEqual(self.masks("part"), self.LAYERS)
        self.assertIsNone(report["cured_part"])
        # The curve gives the exposure of the file's layer height.
        self.assertGreater(report["layer_records"][-1]["exposure_asked_ms"], daemon.printed("thin.sl1", sl1(self.LAYERS))["layer_records"][-1]["exposure_asked_ms"])

    def test_the_layer_height_is_the_files(self):
        daemon = self.printer()
        report = daemon.printed("thick.sl1", sl1(self.LAYERS, config_ini(6, layerHeight=0.1)))
        self.assertEqual((report["layer_height_um"], report["layers"]), (100, 6))
        first = daemon.printed("first.sl1", sl1(self.LAYERS, slicer=slicer_ini(WIDTH, HEIGHT, initial_layer_height=0.08)))
        self.assertTrue(any("first layer of the file is 80 um thick" in warning and "30 um too low" in warning for warning in first["model"]["warnings"]), first["model"])
        self.assertEqual(self.masks("thick"), self.LAYERS)
        self.assert_words(daemon.refused("other.sl1", sl1(self.LAYERS), {"layer_height_um": 100}), "layers of 100 um", "50 um thick")
        self.assert_words(daemon.refused("thin.sl1", sl1(self.LAYERS, config_ini(6, layerHeight=0.01))), "the layer height of 10 um", "25 um to 100 um")

    def test_what_needs_a_model_is_refused_by_name(self):
        daemon = self.printer()
        ticket = {"copies": 2, "scale": 2, "supports": "on", "up": "auto"}
        self.assert_words(daemon.refused("part.sl1", sl1(self.LAYERS), ticket), "finished layers", "supports, up, scale, copies", "leave them out")
        self.assert_words(daemon.refused("named.sl1", sl1(self.LAYERS), {"model": "x.stl"}), "no model", "x.stl")

    def test_pictures_for_another_display_are_refused_with_what_differs(self):
        daemon = self.printer()
        small = pictures(2, 40, 24)
        self.assert_words(daemon.refused("small.sl1", sl1(small)), "have 40x24 pixels, and this display 64x40", "slice the model for this printer's display")
        self.assert_words(daemon.refused("fine.sl1", sl1(self.LAYERS, slicer=slicer_ini(WIDTH, HEIGHT, pitch_um=47))), "47.00 x 47.00 um", "50.00 um", "6.4 % too large")
        # Half a percent is within what a slicer's millimetres are rounded to.
        daemon.printed("rounded.sl1", sl1(self.LAYERS, slicer=slicer_ini(WIDTH, HEIGHT, pitch_um=50.2)))
        self.assert_words(daemon.refused("odd.sl1", sl1(self.LAYERS, slicer=slicer_ini(WIDTH, HEIGHT, display_pixels_x=65, display_width=3.25))), "a display of 65x40 pixels", "64x40")
        self.assert_words(daemon.refused("high.sl1", sl1(self.LAYERS, config_ini(6, layerHeight=1))), "layer height of 1000 um")

    def test_damaged_and_hostile_files_are_refused_with_one_sentence(self):
        daemon = self.printer()
        for number, content in enumerate((b"PNG\n", b"x" * 500, sl1(self.LAYERS)[4:])):
            self.assert_words(daemon.refused(f"other-{number}.sl1", content), "name is that of a sliced archive", "no ZIP file", "slice the model again")
        rows = self.LAYERS[3]
        good = png(rows)
        noisy = bytes(WIDTH * 3)
        large = struct.pack(">IIBBBBB", 16384, 16384, 8, 0, 0, 0, 0)
        cases = {
            "missing": ({"part00003.png": None}, ("picture of layer 4, part00003.png, is missing",)),
            "last": ({"part00005.png": None}, ("names 6 layers", "pictures of 5")),
            "first": ({"part00000.png": None}, ("picture of layer 1",)),
            "twice": ({"part00003.png": None, "part00004.png": good, "other00003.png": good, "config.ini": config_ini(6, jobDir=None)}, ("may be those of a layer",)),
            "size": ({"part00003.png": png(pictures(1, 40, 24)[0])}, ("part00003.png", "40x24", "64x40")),
            "sixteen": ({"part00003.png": png([row + row for row in rows], depth=16, size=(WIDTH, HEIGHT))}, ("part00003.png", "not 8-bit grey")),
            "palette": ({"part00003.png": png(rows, colour=3, more=b"".join([struct.pack(">I", 6), b"PLTE", bytes(6), struct.pack(">I", zlib.crc32(b"PLTE" + bytes(6)))]))}, ("not 8-bit grey",)),
            "colour": ({"part00003.png": png([noisy] * HEIGHT, colour=2, size=(WIDTH, HEIGHT))}, ("not 8-bit grey",)),
            "alpha": ({"part00003.png": png([bytes(WIDTH * 2)] * HEIGHT, colour=4, size=(WIDTH, HEIGHT))}, ("not 8-bit grey",)),
            "truncated": ({"part00003.png": good[: len(good) // 2]}, ("part00003.png", "cannot be read")),
            "rows": ({"part00003.png": png(rows[:9], size=(WIDTH, HEIGHT))}, ("part00003.png", "cannot be read")),
            "text": ({"part00000.png": b"no picture at all, but long enough"}, ("no PNG picture",)),
            "huge": ({f"part{n:05}.png": good[:8] + struct.pack(">I", 13) + b"IHDR" + large + struct.pack(">I", zlib.crc32(b"IHDR" + large)) for n in range(6)}, ("16384x16384", "64x40")),
            "bomb": ({"part00003.png": good + bytes(50_000_000)}, ("part00003.png", "50000", "limit")),
            "height": ({"config.ini": config_ini(6, layerHeight=None)}, ("layerHeight",)),
            "number": ({"config.ini": config_ini(6, layerHeight="0,05")}, ("layerHeight", "0,05")),
            "nan": ({"config.ini": config_ini(6, expTime="nan")}, ("expTime", "nan")),
            "dark": ({f"part{n:05}.png": png([bytes(WIDTH)] * HEIGHT) for n in range(6)}, ("dark",)),
            "none": ({f"part{n:05}.png": None for n in range(6)}, ("without a PNG picture",)),
            "both": ({"part00006.svg": "<svg/>"}, ("two files", "part00005.png", "part00006.svg")),
        }  # fmt: skip
        for name, (more, words) in cases.items():
            with self.subTest(name):
                reason = daemon.refused(f"{name}.sl1", sl1(self.LAYERS, more=more))
                self.assertEqual(len(reason.splitlines()), 1)
                self.assert_words(reason, *words)
        packed = sl1(self.LAYERS)
        self.assert_words(daemon.refused("cut.sl1", packed[: len(packed) // 2]), "archive", "copy it again")
        self.assert_words(daemon.refused("words.sl1", b"no archive"), "not")
        many = {f"part{n:05}.png": b"" for n in range(10_001)}
        self.assert_words(daemon.refused("many.sl1", sl1(self.LAYERS, more=many)), "entries, and the limit is 10000")

    def test_submit_refuses_settings_for_models_at_once(self):
        path = self.write("part.sl1", sl1(self.LAYERS))
        os.makedirs(self.path("spool", "incoming"))
        # The spool has no contourd and no configuration, which could refuse the job.
        result = contourctl("submit", path, "--hollow", "2", "--spool", self.path("spool"), "--yes")
        self.assert_refusal(result, BAD_DATA, "part.sl1", "finished layers", "hollow")
        self.assertEqual(os.listdir(self.path("spool", "incoming")), [])

    def test_a_gamma_correction_by_the_slicer_is_warned_of(self):
        daemon = self.printer()
        for gamma, is_warned in ((1, False), (2.2, True)):
            report = daemon.printed(f"gamma {gamma}.sl1", sl1(self.LAYERS, slicer=slicer_ini(WIDTH, HEIGHT, gamma_correction=gamma)))
            self.assertEqual(any("gamma of 2.2" in warning for warning in report["model"]["warnings"]), is_warned)

    def test_pictures_are_part_of_no_plate(self):
        daemon = self.printer()
        daemon.drop_plate("plate", {"models": [{"file": "part.sl1"}, {"file": "slab.stl"}]}, {"part.sl1": sl1(self.LAYERS), "slab.stl": SLAB})
        self.assert_words(daemon.wait_refused("plate"), "part.sl1 holds finished layers", "by itself")

    def test_submit_takes_an_archive_and_the_tools_say_what_they_cannot_do_with_it(self):
        daemon = self.printer()
        path = self.write("part.sl1", sl1(self.LAYERS))
        self.assertEqual(daemon.ctl("submit", path, "--yes").returncode, OK)
        daemon.wait_done("part")
        self.assertEqual(self.masks("part"), self.LAYERS)
        contourctl("slice", path, "--printer", daemon.config_path, "--masks", self.path("sliced"), expect=OK)
        self.assertEqual([read_png(self.path("sliced", f"{n:04}.png")).rows for n in range(1, 7)], self.LAYERS)
        analysis = contourctl("analyze", path, "--printer", daemon.config_path, expect=OK)
        self.assert_words((analysis.stdout + analysis.stderr).decode(), "finished pictures")
        contourctl("preview", path, "--printer", daemon.config_path, "--layer", "3", "-o", self.path("layer.png"), expect=OK)
        self.assert_refusal(contourctl("slice", path, "--z", "1"), BAD_DATA, "finished layers", "--printer")
        self.assert_refusal(contourctl("cure", path, "--printer", daemon.config_path), BAD_DATA, "finished layers")
        self.assert_refusal(contourctl("inspect", path), BAD_DATA, "finished layers")
        self.assert_refusal(contourctl("submit", self.write("bad.sl1", sl1(self.LAYERS, more={"part00002.png": None})), "--spool", daemon.spool, "--yes"), BAD_DATA, "part00002.png")


class Outlines(SpoolTest):
    """Archives whose layers are outlines, of a wedge on a display of 3.2 x 2 mm with pixels of 50 um."""

    SIZE_MM = (WIDTH * 0.05, HEIGHT * 0.05)
    WEDGE = (2.0137, 1.0071, 0.3)
    # A grey level is a 255th of a pixel's area. Rounding to 1 um moves a side by 0.5 um, a hundredth of a pixel: 2.55 levels; a
    # pixel in a corner has two sides.
    ROUNDING = 6

    def layers(self, mirror=1):
        width, depth, height = self.WEDGE
        layers = []
        for number in range(6):
            right = width * (1 - (0.025 + 0.05 * number) / height) - width / 2
            ring = [(-width / 2, -depth / 2), (right, -depth / 2), (right, depth / 2), (-width / 2, depth / 2)]
            layers.append(svg([[(mirror * x, y) for x, y in ring]], *self.SIZE_MM))
        return layers

    def masks(self, *folder):
        names = sorted(name for name in os.listdir(self.path(*folder)) if name.endswith(".png"))
        return [read_png(self.path(*folder, name)).rows for name in names]

    def assert_alike(self, masks, expected):
        self.assertEqual(len(masks), len(expected))
        for rows, others in zip(masks, expected):
            self.assertLessEqual(max(abs(a - b) for row, other in zip(rows, others) for a, b in zip(row, other)), self.ROUNDING)
            self.assertGreater(sum(map(sum, rows)), 0)

    def printer(self, **resin):
        return self.daemon(DISPLAY, resin, masks=True).start()

    def test_the_masks_of_outlines_are_those_of_the_model_with_the_resins_growth(self):
        model = self.write("wedge.stl", binary_stl(wedge(*self.WEDGE)))
        for case, resin in {"plain": {}, "grown": {"growth_um": 130, "elephant_foot_um": 60, "elephant_foot_height_um": 200}}.items():
            with self.subTest(case):
                daemon = self.printer(**resin)
                slicer = slicer_ini(WIDTH, HEIGHT)
                report = daemon.printed(f"{case}.sl1_svg", sl1_svg(self.layers(), slicer=slicer))
                mirrored_slicer = slicer_ini(WIDTH, HEIGHT, display_mirror_x=1)
                daemon.printed(f"{case} mirrored.sl1", sl1_svg(self.layers(-1), slicer=mirrored_slicer))
                contourctl("slice", model, "--printer", daemon.config_path, "--masks", self.path(case), expect=OK)
                own = self.masks(case)
                self.assert_alike(self.masks("masks", case), own)
                self.assert_alike(self.masks("masks", f"{case} mirrored"), own)
                self.assertEqual((report["layers"], report["layer_height_um"], report["model"]["format"]), (6, 50, "sl1_svg"))
                self.assertTrue(any("finished outlines of layers" in warning for warning in report["model"]["warnings"]))
                self.assertIn("outlines of layers", daemon.read("done", f"{case}.report.html"))
                daemon.stop()
        self.assertNotEqual(self.masks("plain"), self.masks("grown"))

    def test_outlines_are_printed_on_a_display_of_another_resolution(self):
        daemon = self.daemon({"display": {"width_px": WIDTH // 2, "height_px": HEIGHT // 2, "pixel_pitch_um": 100}}, masks=True).start()
        report = daemon.printed("part.sl1_svg", sl1_svg(self.layers(), slicer=slicer_ini(WIDTH, HEIGHT)))
        width, depth, _ = self.WEDGE
        self.assertAlmostEqual(report["layer_records"][0]["area_mm2"], width * depth * (1 - 0.025 / 0.3), delta=0.01)

    def test_outlines_beside_the_plate_are_refused_by_how_much_they_reach_over_it(self):
        daemon = self.daemon({"display": {"width_px": 40, "height_px": 39}}).start()
        reason = daemon.refused("part.sl1_svg", sl1_svg(self.layers(), slicer=slicer_ini(WIDTH, HEIGHT)))
        self.assert_words(reason, "over the left edge", "2.00 x 1.95 mm")

    def test_hostile_outlines_are_refused_with_one_sentence(self):
        daemon = self.printer()
        layers = self.layers()
        bomb = layers[0].replace("</svg>", " " * 100_000_000 + "</svg>")
        entities = layers[0].replace("svg10.dtd\">", 'svg10.dtd" [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>')
        cases = {
            "entities": ({"part00001.svg": entities}, ("document type",)),
            "outside": ({"part00001.svg": layers[0].replace(' standalone="yes"', "").replace(" l ", " l &nbsp; ")}, ("part00001.svg", "standalone")),
            "bomb": ({"part00001.svg": bomb}, ("part00001.svg", "bytes")),
            "cut": ({"part00001.svg": layers[0][:-20]}, ("part00001.svg", "XML")),
            "open": ({"part00001.svg": layers[0].replace(" z", "")}, ("part00001.svg", "not closed")),
            "infinite": ({"part00001.svg": layers[0].replace(" l ", " l 1e300 0 ")}, ("part00001.svg", "beside the viewBox")),
            "missing": ({"part00002.svg": None}, ("outline of layer 3, part00002.svg, is missing",)),
            "million": ({"config.ini": config_ini(1_000_000)}, ("names 1000000 layers", "of 6")),
            "empty": ({f"part{n:05}.svg": svg([], *self.SIZE_MM) for n in range(6)}, ("none of its layers",)),
        }  # fmt: skip
        for name, (more, words) in cases.items():
            with self.subTest(name):
                reason = daemon.refused(f"{name}.sl1_svg", sl1_svg(layers, slicer=slicer_ini(WIDTH, HEIGHT), more=more))
                self.assertEqual(len(reason.splitlines()), 1)
                self.assert_words(reason, *words)
        self.assert_words(daemon.refused("words.sl1_svg", b"no archive"), "sliced archive", "no ZIP file")
        daemon.printed("part.sl1_svg", sl1_svg(layers, slicer=slicer_ini(WIDTH, HEIGHT)))


class FromPrusaSlicer(SpoolTest):
    """A file that the real PrusaSlicer slices for the simulated printer's display."""

    MODEL = box((0, 0, 0), (20, 4, 2)) + box((0, 4, 0), (4, 10, 1))
    SETTINGS = {"printer_technology": "SLA", "layer_height": 0.05, "initial_layer_height": 0.05, "supports_enable": 0, "pad_enable": 0, "exposure_time": 3,
                "initial_exposure_time": 20, "faded_layers": 5, "bed_shape": "0x0,96x0,96x54,0x54"}  # fmt: skip

    def test_an_archive_of_the_real_prusaslicer_is_printed_as_it_is_and_as_the_model_itself(self):
        if not shutil.which("prusa-slicer"):
            self.skipTest("there is no prusa-slicer")
        model = self.write("part.stl", binary_stl(self.MODEL))
        daemon = self.daemon(masks=True).start()
        settings = "".join(f"{key} = {value}\n" for key, value in self.SETTINGS.items()) + slicer_ini(1920, 1080, display_mirror_x=1)
        result = subprocess.run(["prusa-slicer", "--export-sla", "--load", self.write("p.ini", settings.encode()), "--output", self.path("part.sl1"), model],
                                capture_output=True, text=True, timeout=300, check=False, env={**os.environ, "HOME": self.folder})  # fmt: skip
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        daemon.printed("part.sl1", contents(self.path("part.sl1")))
        contourctl("slice", model, "--layer-height-um", "50", "--masks", self.path("own"), expect=OK)
        names = sorted(os.listdir(self.path("own")))
        self.assertEqual(sorted(os.listdir(self.path("masks", "part"))), names)
        for name in names:
            sliced, own = read_png(self.path("masks", "part", name)), read_png(self.path("own", name))
            self.assertEqual(sliced, own, name)
