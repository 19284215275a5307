"""Calibration: contourctl calibrate and fit, with a simulated owner who measures what a hidden resin would have become."""

import json
import math
import os
import random
import re
import unittest

from harness import (
    BAD_CONFIG, BAD_DATA, BAD_USAGE, FAILED, OK, REALTIME, SMALL, Daemon, FolderTest, binary_stl, box, contourctl, read_png, text_of,
)  # fmt: skip

DEPTH_UM, CRITICAL_MJ_CM2, GAMMA = 150, 8, 2.2  # hidden from the program
NOISE_UM = 10
# Light by hand is in real time: exposures of milliseconds keep the test short.
PRINTER = {**REALTIME, "projector": {"warm_up_s": 0, "irradiance_mw_cm2": 400}, "manual": {"light_limit_s": 1}}
RESIN = {"exposure_ms": 40, "bottom_exposure_ms": 200, "layer_height_um": 50}


class Owner:
    """Measures each window three times, with noise."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def thickness_um(self, dose):
        depth = DEPTH_UM * math.log(dose / CRITICAL_MJ_CM2)
        return sum(depth + self.random.gauss(0, NOISE_UM) for _ in range(3)) / 3


class CalibrationTest(FolderTest):
    def daemon(self, config=None, resin=None):
        return Daemon(self, config or PRINTER, resin or RESIN, masks=True).start()

    def run_ctl(self, daemon, *words):
        return contourctl(*words, "--printer", daemon.config_path, *(["--socket", daemon.socket_path] if words[0] == "calibrate" else []))

    def well(self, result, *words):
        self.assertEqual((result.returncode, result.stderr), (OK, b""), result)
        self.assert_words(result.stdout.decode(), *words)
        return result.stdout.decode()

    def given(self, output):
        """Returns the numbers before the question marks of the command that calibrate prints."""
        return [float(number) for number in re.findall(r" ([0-9.e+]+)=\?", output)]

    def resin_file(self, daemon):
        return os.path.join(daemon.folder, "resins", "standard.json")

    def read(self, path):
        return json.loads(text_of(path))

    def assert_page(self, path, measurements, *words):
        """Asserts that a page shows that many measurements in its figure, and needs nothing but itself."""
        page = text_of(path)
        self.assertEqual(page.count("<circle"), measurements)
        self.assertEqual(page.count("<svg"), 1)
        self.assertNotRegex(page, r"(?i)<script|<link|https?://|\bnan\b|\binf\b")
        self.assertTrue(page.endswith("</html>\n"))
        self.assert_words(page, "Content-Security-Policy", *words)

    def measured_curve(self, daemon, seed=1):
        owner = Owner(seed)
        output = self.well(self.run_ctl(daemon, "calibrate", "curve", "standard", "--confirm", "--in-resin"), "\n\nWait a minute, pour the resin off")
        return [f"{dose:g}={owner.thickness_um(dose):.1f}" for dose in self.given(output)]


class Windows(CalibrationTest):
    def test_a_hidden_curve_is_found_from_windows_and_the_profile_follows_it(self):
        daemon = self.daemon()
        measured = self.measured_curve(daemon)
        self.assertEqual(len(measured), 9)
        before = text_of(self.resin_file(daemon))

        command = ("fit", "curve", "standard", *measured, "--lamp-hours", "120")
        self.well(self.run_ctl(daemon, *command), "penetration_depth_um", "now absent", "Nothing was written: --accept")
        self.assertEqual(text_of(self.resin_file(daemon)), before)

        page = self.path("curve.html")
        self.well(self.run_ctl(daemon, *command, "--html", page))
        self.assert_page(page, 9, "working_curve/penetration_depth_um", "dose, mJ/cm²", "standard.json")
        self.assertEqual(text_of(self.resin_file(daemon)), before)
        for file in (daemon.config_path, self.resin_file(daemon)):
            self.assert_refusal(self.run_ctl(daemon, *command, "--json", "--accept", "--html", file), BAD_USAGE, "this file is a configuration")
            self.assertEqual(text_of(self.resin_file(daemon)), before)
        # A page that cannot be written: nothing is accepted.
        self.assertEqual(self.run_ctl(daemon, *command, "--accept", "--html", self.path("missing", "page.html")).returncode, 73)
        self.assertEqual(text_of(self.resin_file(daemon)), before)

        self.well(self.run_ctl(daemon, *command, "--accept"), "Written to ", "those of a layer of the profile's height stay as they are")
        profile = self.read(self.resin_file(daemon))
        curve = profile["working_curve"]
        self.assertAlmostEqual(curve["penetration_depth_um"], DEPTH_UM, delta=4)
        self.assertAlmostEqual(curve["critical_energy_mj_cm2"] / CRITICAL_MJ_CM2, 1, delta=0.05)
        self.assertNotIn("exposure_ms", profile)
        # The same light as before: 40 ms at 400 mW/cm² for a layer of 50 um.
        depth = curve["penetration_depth_um"] * math.log(16 / curve["critical_energy_mj_cm2"])
        self.assertAlmostEqual(curve["overcure_um"] + 50, depth, delta=0.1)
        kept = profile["calibrations"][0]
        self.assertEqual((kept["kind"], kept["lamp_hours"]), ("curve", 120))
        self.well(contourctl("config", "check", daemon.config_path))

        self.well(self.run_ctl(daemon, "fit", "undo", "standard"), "the calibration curve of ")
        self.assertEqual(self.read(self.resin_file(daemon)), {**json.loads(before)})
        self.assert_refusal(self.run_ctl(daemon, "fit", "undo", "standard"), BAD_DATA, "there is no calibration to undo")

    def test_a_second_curve_keeps_the_cure_depths_and_tells_the_new_exposure(self):
        daemon = self.daemon()
        measured = self.measured_curve(daemon)
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *measured, "--accept"))
        first = self.read(self.resin_file(daemon))["working_curve"]
        twice = [f"{float(dose) * 2}={thickness}" for dose, thickness in (word.split("=") for word in measured)]
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *twice, "--accept"), "note: the exposure of a normal layer changes from ")
        second = self.read(self.resin_file(daemon))["working_curve"]
        self.assertAlmostEqual(second["critical_energy_mj_cm2"] / first["critical_energy_mj_cm2"], 2, places=2)
        self.assertEqual(second["overcure_um"], first["overcure_um"])

    def test_a_curve_without_a_temperature_removes_that_of_the_previous_curve(self):
        daemon = self.daemon()
        measured = self.measured_curve(daemon)
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *measured, "--temperature-c", "23", "--accept"))
        self.assertEqual(self.read(self.resin_file(daemon))["working_curve"]["temperature_c"], 23)
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *measured, "--accept"), "note: temperature_c is that of the previous curve")
        self.assertNotIn("temperature_c", self.read(self.resin_file(daemon))["working_curve"])
        self.well(self.run_ctl(daemon, "fit", "undo", "standard"))
        self.assertEqual(self.read(self.resin_file(daemon))["working_curve"]["temperature_c"], 23)
        # The command that the next calibration prints asks for the temperature.
        self.well(self.run_ctl(daemon, "calibrate", "curve", "standard", "--confirm", "--in-resin"), "=? --temperature-c ? --printer ", "Type the temperature of the resin")

    def test_a_new_curve_removes_the_memory_that_was_measured_with_the_previous_one(self):
        daemon = self.daemon()
        measured = self.measured_curve(daemon)
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *measured, "--accept"))
        profile = self.read(self.resin_file(daemon))
        profile["working_curve"]["peel_memory"] = 0.9
        profile["undersides"] = "dose"
        self.write(self.resin_file(daemon), json.dumps(profile).encode())
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *measured, "--accept"), "working_curve/peel_memory ", "measure it again")
        self.assertNotIn("peel_memory", self.read(self.resin_file(daemon))["working_curve"])
        model = self.write("model.stl", binary_stl(box((0, 0, 0), (2, 2, 1))))
        cured = contourctl("cure", model, "--printer", daemon.config_path)
        self.assert_words(cured.stdout.decode() + cured.stderr.decode(), "has no peel_memory")
        self.well(self.run_ctl(daemon, "fit", "undo", "standard"))
        self.assertEqual(self.read(self.resin_file(daemon))["working_curve"]["peel_memory"], 0.9)

    def test_a_hidden_gamma_is_found_from_grey_windows_and_goes_to_the_printers_file(self):
        daemon = self.daemon()
        self.assert_refusal(self.run_ctl(daemon, "fit", "grey", "standard", "255=400"), BAD_DATA, "calibrate the curve first")
        self.assert_refusal(self.run_ctl(daemon, "calibrate", "grey", "standard", "--confirm", "--in-resin"), BAD_DATA, "calibrate the curve first")
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *self.measured_curve(daemon), "--accept"))
        output = self.well(self.run_ctl(daemon, "calibrate", "grey", "standard", "--confirm", "--in-resin"))
        greys = self.given(output)
        folder = os.path.join(daemon.folder, "masks", "test pattern picture")
        shown = read_png(os.path.join(folder, max(os.listdir(folder))))
        self.assertEqual(set().union(*shown.rows) - {0}, {int(grey) for grey in greys})

        owner = Owner(2)
        dose = 16 * 16  # 16 times the normal exposure
        measured = [f"{grey:g}={owner.thickness_um(dose * (grey / 255) ** GAMMA):.1f}" for grey in greys]
        self.well(self.run_ctl(daemon, "fit", "grey", "standard", *measured, "--accept", "--html", self.path("grey.html")), "display/gamma", "Written to ")
        self.assert_page(self.path("grey.html"), 9, "display/gamma", "grey value")
        config = self.read(daemon.config_path)
        uncertainty = config["calibrations"][0]["values"][0]["uncertainty"]
        self.assertLess(uncertainty, 0.15)
        self.assertAlmostEqual(config["display"]["gamma"], GAMMA, delta=3 * uncertainty)
        self.well(self.run_ctl(daemon, "fit", "undo"), "the calibration grey of ")
        self.assertNotIn("gamma", self.read(daemon.config_path)["display"])

    def test_measurements_that_cannot_be_are_refused_and_nothing_is_written(self):
        daemon = self.daemon()
        before = text_of(self.resin_file(daemon))
        sound = [f"{dose:g}={150 * math.log(dose / 8):g}" for dose in (16, 32, 64, 128, 256)]
        for code, words, why in (
            (BAD_USAGE, ["16"], '"16" is not a measurement'),
            (BAD_USAGE, ["16=x"], '"16=x" is not a measurement'),
            (BAD_DATA, ["16=100", "256=500"], "2 windows do not determine a curve"),
            (BAD_DATA, [*sound[:4], "256=-1"], "both must be more than 0"),
            (BAD_DATA, ["16=500", "32=400", "64=300", "128=200", "256=100"], "the thickness does not grow with the dose"),
            (BAD_DATA, ["16=100", "32=400", "64=100", "128=500", "256=300"], "the thicknesses scatter by"),
            # Thicknesses in mm.
            (BAD_DATA, [f"{dose:g}={0.15 * math.log(dose / 8):g}" for dose in (16, 32, 64, 128, 256)], "type thicknesses in um"),
            # Exposures of the profile that do not cure a layer, by this curve.
            (BAD_DATA, [f"{float(word.split('=')[0]) * 10}={word.split('=')[1]}" for word in sound], "cures -"),
        ):
            with self.subTest(words):
                result = self.run_ctl(daemon, "fit", "curve", "standard", *words, "--accept")
                self.assertEqual((result.returncode, result.stdout), (code, b""), result)
                self.assert_words(result.stderr.decode(), why)
                self.assertEqual(text_of(self.resin_file(daemon)), before)
        # A second curve by which the profile's cure depth needs too much light.
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *sound, "--accept"))
        before = text_of(self.resin_file(daemon))
        shallow = [f"{dose * 50:g}={16 * math.log(dose / 8):g}" for dose in (16, 32, 64, 128, 256)]
        for accept in ((), ("--accept",)):
            result = self.run_ctl(daemon, "fit", "curve", "standard", *shallow, *accept)
            self.assertEqual((result.returncode, result.stdout), (BAD_DATA, b""), result)
            self.assert_words(result.stderr.decode(), "with this curve, a layer of 50 um would last", "penetration_depth_um 16")
            self.assertEqual(text_of(self.resin_file(daemon)), before)
        # A temperature that the profile must not have is refused with the option's name.
        result = self.run_ctl(daemon, "fit", "curve", "standard", *sound, "--temperature-c", "400")
        self.assert_refusal(result, BAD_USAGE, "--temperature-c: 400 is not a number from 0 to 80")
        # Exact thicknesses are as uncertain as their rounding makes them.
        exact = json.loads(self.run_ctl(daemon, "fit", "curve", "standard", *[f"{8 * math.exp(i / 2):.6f}={75 * i}" for i in range(1, 8)], "--json").stdout)
        self.assertGreater(exact["values"][0]["uncertainty"], 0.05)
        self.assert_refusal(self.run_ctl(daemon, "fit", "curve", "nosuch", *sound), BAD_CONFIG, "nosuch")

    def test_light_is_refused_as_by_hand(self):
        daemon = self.daemon()
        result = self.run_ctl(daemon, "calibrate", "curve", "standard", "--confirm")
        self.assertEqual(result.returncode, FAILED)
        self.assert_words(result.stderr.decode(), "it may be in the resin; add --in-resin")
        result = self.run_ctl(daemon, "calibrate", "grey", "standard", "--confirm", "--in-resin", "--seconds", "1.1")
        self.assertEqual(result.returncode, BAD_USAGE)
        self.assert_words(result.stderr.decode(), "the longest exposure would be 1.1 s, and manual.light_limit_s allows")


class Temperature(CalibrationTest):
    def test_exposures_follow_the_sensor_as_it_is_when_the_turn_of_a_job_comes(self):
        self.write("temperature", b"23000\n")
        fast = {key: value for key, value in PRINTER.items() if key not in REALTIME or key == "projector"}
        config = {**fast, "resin_temperature": {"sensor": self.path("temperature")}, "wait_for_plate_cleared": True}
        daemon = self.daemon(config, {**RESIN, "bottom_layers": 0, "fade_layers": 0})
        self.well(self.run_ctl(daemon, "fit", "curve", "standard", *self.measured_curve(daemon), "--temperature-c", "23", "--accept"))
        daemon.printed("first.stl", SMALL)
        first = daemon.report("first")
        self.assertEqual(first["settings"]["temperature"], {"resin_c": 23, "curve_c": 23, "light": 1})
        daemon.drop("second.stl", SMALL)  # is prepared while it waits for the cleared plate
        daemon.wait_job("second", "ready")
        self.write("temperature", b"33000\n")
        self.well(contourctl("plate-cleared", "--socket", daemon.socket_path))
        daemon.wait_done("second")
        second = daemon.report("second")
        light = math.exp(30000 / 8.314462618 * (1 / 306.15 - 1 / 296.15))
        self.assertAlmostEqual(second["settings"]["temperature"]["light"], light, places=4)
        asked = [report["layer_records"][2]["exposure_asked_ms"] for report in (first, second)]
        self.assertAlmostEqual(asked[1] / asked[0], light, places=4)
        self.assertIn("light for resin of 33.0 degrees C", daemon.log())

    def test_forecasts_follow_the_temperature(self):
        self.write("temperature", b"23000\n")
        curve = {"penetration_depth_um": 150, "critical_energy_mj_cm2": 800, "overcure_um": 50, "bottom_overcure_um": 50, "temperature_c": 23}
        resin = {"exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 0, "fade_layers": 0, "working_curve": curve}
        daemon = Daemon(self, {**PRINTER, "resin_temperature": {"sensor": self.path("temperature")}}, resin)
        model = self.write("small.stl", SMALL)

        for folder in ("incoming", "printing", "done", "failed"):
            os.makedirs(self.path("spool", folder), exist_ok=True)

        def forecasts():
            analyzed = contourctl("analyze", model, "--json", "--printer", daemon.config_path, expect=OK)
            queued = contourctl("submit", "--json", "--spool", self.path("spool"), "--printer", daemon.config_path, model, expect=OK)
            return [json.loads(analyzed.stdout)["layer_time_s"], json.loads(queued.stdout.splitlines()[0])["outlook"]["print_time_s"]]

        cold = forecasts()
        self.write("temperature", b"33000\n")
        warm = forecasts()
        light = math.exp(30000 / 8.314462618 * (1 / 306.15 - 1 / 296.15))
        layers = json.loads(contourctl("analyze", model, "--json", "--printer", daemon.config_path, expect=OK).stdout)["layers"]
        exposure_s = 800 * math.exp(100 / 150) / 400
        for before, after in zip(cold, warm):
            self.assertAlmostEqual(before - after, layers * exposure_s * (1 - light), delta=0.01)


if __name__ == "__main__":
    unittest.main()
