"""Split exposures on the simulated printer: the light that the shown pictures give each pixel, summed by an independent computation."""

import collections
import itertools
import json
import unittest

from harness import OK, Daemon, FolderTest, binary_stl, box, contents, contourctl, read_png
from screen_test import png

WIDTH, HEIGHT, REFRESH_HZ = 80, 50, 60
FRAME_S = 1 / REFRESH_HZ
GAMMA = 3.0
# A slab on two pillars, whose outlines lie within pixels of 100 um.
BRIDGE = binary_stl(box((-2.97, -1.92, 0), (-2, 1.93, 0.52)) + box((2, -1.92, 0), (2.96, 1.93, 0.52)) + box((-2.97, -1.92, 0.52), (2.96, 1.93, 1)))
LAYERS = 20
RESIN = {"undersides": "dose", "exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 0, "fade_layers": 0,
         "working_curve": {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 50, "peel_memory": 1}}  # fmt: skip

Exposure = collections.namedtuple("Exposure", "pictures seconds light")


class SplitExposureTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.numbers = itertools.count()

    def printed(self, resin=None, **display):
        """Prints the bridge, and returns its report and the exposures that the machine has recorded."""
        config = {"display": {"refresh_hz": REFRESH_HZ, "width_px": WIDTH, "height_px": HEIGHT, "pixel_pitch_um": 100, **display}}
        self.job = f"part-{next(self.numbers)}"
        daemon = Daemon(self, config, {**RESIN, **(resin or {})}, masks=True).start()
        self.report = daemon.printed(self.job + ".stl", BRIDGE)
        self.log, self.config = daemon.log(), daemon.config_path
        self.page = daemon.read("done", self.job + ".report.html")
        daemon.stop()
        self.assertEqual(self.report["layers_exposed"], LAYERS)
        return self.exposures(display.get("grey_bits", 8), display.get("gamma", 1))

    def exposures(self, bits, gamma):
        """Returns the exposures of the last print: their pictures, their time, and the light of each pixel over white's."""
        exposures, name, lit_at, shown_at = [], None, None, None
        greatest = 2**bits - 1

        def end_picture(now):
            if lit_at is not None and name is not None and now > max(lit_at, shown_at):
                shown.append((name, now - max(lit_at, shown_at)))

        for line in contents(self.path("masks", self.job + ".shown.tsv")).decode().splitlines():
            now, event = line.split("\t")
            now = int(now) / 1e9
            if event == "light on":
                lit_at, shown = now, []
                continue
            end_picture(now)
            if event == "light off":
                light, seconds = [0.0] * (WIDTH * HEIGHT), now - lit_at
                for file, time in shown:
                    picture = b"".join(read_png(self.path("masks", self.job, file)).rows)
                    levels = [round(grey * greatest / 255) for grey in range(256)]
                    self.assertEqual({grey for grey in set(picture) if round(levels[grey] * 255 / greatest) != grey}, set())
                    share = [(level / greatest) ** gamma * time / seconds for level in levels]
                    for pixel, grey in enumerate(picture):
                        light[pixel] += share[grey]
                exposures.append(Exposure(len(shown), seconds, light))
                lit_at = None
            else:
                name, shown_at = None if event == "black" else event, now
        return exposures

    def assert_same_light(self, split, wanted, error):
        """Asserts that a split exposure gives the light of one mask. Each pixel changes once, at most half a refresh from its time."""
        late = FRAME_S / 2 / split.seconds
        rounding = 0.5 / 255
        for pixel, (given, asked) in enumerate(zip(split.light, wanted.light)):
            self.assertLessEqual(abs(given - asked), error + late + rounding, f"pixel {pixel}: {given} for {asked}")
        self.assertAlmostEqual(split.seconds, wanted.seconds, delta=1e-6)

    def assert_prints_the_masks_of_8_bits(self, most_pictures, **display):
        self.write("even.png", png(WIDTH, HEIGHT, [bytes(155 + x * 100 // WIDTH for x in range(WIDTH))] * HEIGHT))
        wanted = self.printed(uniformity_mask="even.png", gamma=1)
        split = self.printed(uniformity_mask="even.png", gamma=GAMMA, **display)
        self.assertEqual((len(wanted), len(split)), (LAYERS, LAYERS))
        records = self.report["layer_records"]
        for layer, (each, asked, record) in enumerate(zip(split, wanted, records)):
            with self.subTest(layer=layer):
                self.assertLessEqual(record["light_error_percent"], 1)
                self.assertEqual(each.pictures, record["pictures"])
                self.assertLessEqual(record["late_picture_ms"], 1000 * FRAME_S / 2 + 0.001)
                self.assert_same_light(each, asked, record["light_error_percent"] / 100)
        self.assertEqual(max(record["pictures"] for record in records), most_pictures)
        self.assertEqual(self.report["settings"]["grey_bits"], display["grey_bits"])
        self.assert_words(self.page, f"exposures split for {display['grey_bits']} bit", f"up to {most_pictures} a layer")
        self.assert_words(self.log, f"{most_pictures} pictures that give pixels their light to ")

    def test_contourctl_slices_the_sum_of_the_pictures(self):
        for bits in (1, 3):
            display = {"grey_bits": bits, "gamma": GAMMA}
            exposures = self.printed(**display)
            model, folder = self.write("model.stl", BRIDGE), self.path(f"sliced-{bits}")
            contourctl("slice", model, "--printer", self.config, "--masks", folder, expect=OK)
            for layer, exposure in enumerate(exposures, start=1):
                with self.subTest(bits=bits, layer=layer):
                    mask = b"".join(read_png(f"{folder}/{layer:04}.png").rows)
                    self.assert_same_light(exposure, Exposure(1, exposure.seconds, [grey / 255 for grey in mask]), 0)

    def test_contourctl_cures_the_light_of_the_pictures(self):
        model = self.write("model.stl", BRIDGE)

        def undersides(**display):
            daemon = Daemon(self, {"display": {"width_px": WIDTH, "height_px": HEIGHT, "pixel_pitch_um": 100, **display}}, RESIN)
            return json.loads(contourctl("cure", model, "--printer", daemon.config_path, "--json", expect=OK).stdout)["undersides"]

        exact = undersides()["p95_um"]
        self.assertLess(exact, 5)
        # One picture a second cannot give the darker layers their light.
        self.assertGreater(undersides(grey_bits=1, refresh_hz=1)["p95_um"], 15)
        for bits in (1, 3, 4):
            # 1 % of white's light is 8 um of depth for a pixel that gets 19 %.
            self.assertAlmostEqual(undersides(grey_bits=bits, gamma=GAMMA)["p95_um"], exact, delta=8)

    def test_exposures_that_are_too_short_are_told(self):
        self.printed(grey_bits=1, refresh_hz=5)
        errors = [record["light_error_percent"] for record in self.report["layer_records"]]
        self.assertGreater(max(errors), 1)
        self.assert_words(self.log, "exposures too short for more pictures: pixels get their light to "
                          f"{max(errors):.1f} % of white's")  # fmt: skip

    def test_a_panel_without_grey(self):
        self.assert_prints_the_masks_of_8_bits(24, grey_bits=1)

    def test_a_panel_of_3_bits(self):
        self.assert_prints_the_masks_of_8_bits(18, grey_bits=3)

    def test_a_panel_of_4_bits(self):
        self.assert_prints_the_masks_of_8_bits(10, grey_bits=4)

    def test_masks_without_grey_are_shown_as_they_are(self):
        plain = {"undersides": "plain"}
        wanted = self.printed(plain, anti_aliasing=False)
        self.assertEqual(self.printed(plain, anti_aliasing=False, grey_bits=1, gamma=GAMMA), wanted)
        self.assertEqual({record["pictures"] for record in self.report["layer_records"]}, {1})
        self.assertNotIn("a layer; pixels get", self.page)

    def test_one_share_of_the_light_is_exact_in_two_pictures(self):
        split = self.printed(anti_aliasing=False, grey_bits=1)
        pictures = [record["pictures"] for record in self.report["layer_records"]]
        self.assertEqual(set(pictures), {1, 2})
        self.assertEqual(max(record["light_error_percent"] for record in self.report["layer_records"]), 0)
        self.assertEqual([each.pictures for each in split], pictures)


if __name__ == "__main__":
    unittest.main()
