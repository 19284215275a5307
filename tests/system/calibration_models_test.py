"""Calibration prints of models: contourctl makes them, contourd prints them, and contourctl computes the figures."""

import json
import math
import os
import random

from harness import BAD_CONFIG, BAD_DATA, BAD_USAGE, OK, Daemon, FolderTest, contents, contourctl

CURVE = {"exposure_ms": None, "bottom_exposure_ms": None,
         "working_curve": {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 200}}  # fmt: skip
LIMITS = {"ticket_limits": {"exposure_ms": [2000, 5000]}}
LADDER = [("", 30), ("", 21), ("", 10), ("", 3), ("", 2), ("gap", 5), ("gap", 9), ("gap", 8)]


def bridge_um(layers, memory, depth=150, layer=50, overcure=50):
    """Returns the thickness of a bridge whose light is remembered from peel to peel. Shares no code with contourd."""
    dose = greatest = 0
    for number in range(1, layers + 1):
        dose = dose * memory + math.exp((layer + overcure - number * layer) / depth)
        greatest = max(greatest, dose)
    return layers * layer + depth * math.log(greatest)


class CalibrationTest(FolderTest):
    def calibrate(self, kind, *arguments, expect=OK):
        return contourctl("calibrate", kind, "standard", "--printer", self.path("contourd.json"), "-o", self.path("out"), *arguments, expect=expect)

    def fit(self, kind, *arguments, expect=OK):
        return contourctl("fit", kind, "standard", *arguments, "--printer", self.path("contourd.json"), expect=expect)

    def printed(self, daemon, kind, job=None):
        """Prints the calibration's model with its ticket, as a job of its name or another; returns the report."""
        self.calibrate(kind)
        ticket = contents(self.path("out", kind + ".json")).decode()
        return daemon.printed((job or kind) + ".stl", contents(self.path("out", kind + ".stl")), ticket)

    def profile(self):
        return json.loads(contents(self.path("resins", "standard.json")))

    def assert_plain(self, report):
        """Asserts that the model was printed whole and as it is."""
        self.assertEqual(report["layers_exposed"], report["layers"])
        self.assertEqual(report["model"]["warnings"], [])
        self.assertIsNone(report["supports"])


class Printed(CalibrationTest):
    def test_bridges_are_printed_in_whole_layers_and_give_the_memory(self):
        daemon = Daemon(self, resin=CURVE).start()
        report = self.printed(daemon, "memory")
        self.assert_plain(report)
        areas = [layer["area_mm2"] for layer in report["layer_records"]]
        # From the top down, each bridge of 4 by 3 mm ends after its layers.
        self.assertEqual([round(areas[-below] - areas[-below - 1]) for below in (1, 2, 4, 8, 16)], [12] * 5)
        noise = random.Random(3)
        measured = [f"{layers}={bridge_um(layers, 0.85) + noise.gauss(0, 10):.0f}" for _ in range(3) for layers in (1, 2, 4, 8, 16)]
        text = self.fit("memory", *measured).stdout.decode()
        self.assertIn("Nothing was written", text)
        self.assertIn("the uncertainty of the resin's curve is not known", text)
        self.assertNotIn("peel_memory", self.profile()["working_curve"])
        alone = json.loads(self.fit("memory", *measured, "--json").stdout)["values"][0]["uncertainty"]
        self.assertNotIn("correlated", text)
        curve = [{"key": "/working_curve/penetration_depth_um", "after": 150, "uncertainty": 3.7}, {"key": "/working_curve/critical_energy_mj_cm2", "after": 8, "uncertainty": 0.45, "correlation": 0.9}]
        self.write("resins/standard.json", json.dumps({**self.profile(), "calibrations": [{"kind": "curve", "date": "2026-11-27", "values": curve}]}).encode())
        self.assertIn("by penetration_depth_um +- 3.7 and", self.fit("memory", *measured).stdout.decode())
        found = json.loads(self.fit("memory", *measured, "--json", "--accept", "--html", self.path("memory.html")).stdout)
        self.assertEqual(contents(self.path("memory.html")).count(b"<circle"), 15)
        self.assertAlmostEqual(found["values"][0]["value"], 0.85, delta=0.03)
        self.assertGreater(found["values"][0]["uncertainty"], 1.1 * alone)
        self.assertEqual(self.profile()["working_curve"]["peel_memory"], found["values"][0]["value"])
        self.assertAlmostEqual(found["scatter_um"], 10, delta=5)

    def test_the_ladder_is_printed_and_gives_shrinkage_and_growth(self):
        daemon = Daemon(self, resin={"growth_um": -10, "shrinkage_percent": {"x": 0.5}}).start()
        self.assert_plain(self.printed(daemon, "dimensions"))
        text = contents(self.path("out", "dimensions.txt")).decode()
        # The owner finds both axes 0.4 % short, and 30 um more at each side.
        measured = []
        for axis in "xy":
            for kind, drawn in LADDER:
                self.assertIn(f"{axis}{kind}{drawn}=?", text)
                measured.append(f"{axis}{kind}{drawn}={drawn * 0.996 + (-0.06 if kind else 0.06):.4f}")
        found = json.loads(self.fit("dimensions", *measured, "--json", "--accept", "--html", self.path("dimensions.html")).stdout)
        page = contents(self.path("dimensions.html")).decode()
        self.assertEqual((page.count("<circle"), page.count("<polyline")), (16, 4))
        values = {value["key"]: value["value"] for value in found["values"]}
        self.assertAlmostEqual(values["/shrinkage_percent/x"], 100 * (1 - 0.996 * 0.995), delta=0.01)
        self.assertAlmostEqual(values["/shrinkage_percent/y"], 0.4, delta=0.01)
        self.assertAlmostEqual(values["/growth_um"], -40, delta=0.5)
        self.assertEqual(self.profile()["growth_um"], values["/growth_um"])
        self.assertEqual(self.profile()["shrinkage_percent"]["y"], values["/shrinkage_percent/y"])

    def test_each_step_of_the_tower_gets_its_exposure(self):
        daemon = Daemon(self, resin=LIMITS).start()
        report = self.printed(daemon, "exposure")
        self.assert_plain(report)
        steps = json.loads(contents(self.path("out", "exposure.json")))["exposure_steps"]
        self.assertEqual((len(steps), steps[0]["exposure_ms"], steps[-1]["exposure_ms"]), (9, 5000, 2000))
        normal = [layer["exposure_asked_ms"] for layer in report["layer_records"]][20:]
        self.assertEqual(normal, [step["exposure_ms"] for step in steps for _ in range(40)])
        self.assertEqual(report["settings"]["exposure_steps"], steps)
        for number, step in enumerate(steps, 1):
            self.assertIn(f"{number:>4} {step['exposure_ms']:>13g}\n", contents(self.path("out", "exposure.txt")).decode())

    def test_the_best_step_of_the_tower_becomes_the_exposure_and_can_be_undone(self):
        Daemon(self, resin=LIMITS)
        text = self.calibrate("exposure").stdout.decode()
        before, ticket = self.profile(), self.path("out", "exposure.json")
        self.assertIn(f"\ncontourctl fit exposure standard ? --ticket {ticket} --printer {self.path('contourd.json')}\n", text)
        steps = [step["exposure_ms"] for step in json.loads(contents(ticket))["exposure_steps"]]
        self.assertIn("Nothing was written", self.fit("exposure", "4", "--ticket", ticket).stdout.decode())
        self.assertEqual(self.profile(), before)
        found = json.loads(self.fit("exposure", "4", "--ticket", ticket, "--lamp-hours", "12", "--accept", "--json").stdout)
        self.assertEqual((found["values"][0]["key"], found["values"][0]["value"]), ("/exposure_ms", steps[3]))
        # A uniform distribution as wide as the step.
        self.assertAlmostEqual(found["values"][0]["uncertainty"] / steps[3], math.log(steps[3] / steps[4]) / math.sqrt(12), places=4)
        profile = self.profile()
        self.assertEqual(profile["exposure_ms"], steps[3])
        self.assertEqual([profile["calibrations"][0][key] for key in ("kind", "lamp_hours")], ["exposure", 12])
        self.fit("undo")
        self.assertEqual(self.profile(), before)
        for step, said in ((1, "longest"), (9, "shortest")):
            self.assertIn(f"the best step is the tower's {said}", self.fit("exposure", str(step), "--ticket", ticket).stdout.decode())

    def test_the_best_step_of_a_resin_with_a_curve_becomes_its_overcure(self):
        daemon = Daemon(self, resin={**CURVE, "ticket_limits": {"exposure_ms": [100, 10000]}})
        text, ticket = self.calibrate("exposure").stdout.decode(), self.path("out", "exposure.json")
        overcures = [float(line.split()[-1]) for line in text.splitlines() if "   overcure_um " in line]
        for step, overcure in enumerate(overcures, 1):
            found = json.loads(self.fit("exposure", str(step), "--ticket", ticket, "--json").stdout)["values"][0]
            self.assertEqual(found["key"], "/working_curve/overcure_um")
            self.assertAlmostEqual(found["value"], overcure, delta=0.06)
        # 5 degrees less than at the curve's measurement: the same light cures 30 um less deep.
        daemon.write_resin("standard", {**CURVE, "working_curve": {**CURVE["working_curve"], "temperature_c": 30}})
        cold = json.loads(self.fit("exposure", "1", "--ticket", ticket, "--temperature-c", "25", "--json").stdout)["values"][0]
        self.assertAlmostEqual(overcures[0] - cold["value"], 30, delta=1)
        self.assertIn("give --temperature-c", self.fit("exposure", "1", "--ticket", ticket).stdout.decode())

    def test_every_step_of_a_tower_can_become_the_exposure(self):
        daemon = Daemon(self, resin=LIMITS)
        curve = CURVE["working_curve"]
        profiles = {
            "fixed": LIMITS,
            "no longer than bottom layers": {**LIMITS, "bottom_exposure_ms": 3100.7},
            "odd limits": {"ticket_limits": {"exposure_ms": [1999.3, 4321.9]}},
            "a curve": {**CURVE, "ticket_limits": {"exposure_ms": [1, 120000]}},
            "little overcure of bottom layers": {**CURVE, "working_curve": {**curve, "bottom_overcure_um": 77.77}, "ticket_limits": {"exposure_ms": [1, 120000]}},
            "thin layers": {**CURVE, "layer_height_um": 25, "working_curve": {**curve, "overcure_um": 30, "bottom_overcure_um": 61.3}, "ticket_limits": {"exposure_ms": [1, 120000]}},
            "a clear resin": {**CURVE, "working_curve": {**curve, "penetration_depth_um": 733, "critical_energy_mj_cm2": 3.3, "overcure_um": 400, "bottom_overcure_um": 2000}, "ticket_limits": {"exposure_ms": [1, 120000]}},
        }  # fmt: skip
        for name, profile in profiles.items():
            with self.subTest(name):
                daemon.write_resin("standard", profile)
                self.calibrate("exposure")
                steps = json.loads(contents(self.path("out", "exposure.json")))["exposure_steps"]
                self.assertGreater(len({step["exposure_ms"] for step in steps}), 5)
                for step in range(1, len(steps) + 1):
                    self.fit("exposure", str(step), "--ticket", self.path("out", "exposure.json"))

    def test_bridges_get_all_their_light_even_if_the_resin_s_undersides_are_dimmed(self):
        daemon = Daemon(self, resin=CURVE).start()
        plain = self.printed(daemon, "memory")
        daemon.write_resin("standard", {**CURVE, "undersides": "dose", "working_curve": {**CURVE["working_curve"], "peel_memory": 1}})
        again = self.printed(daemon, "memory", "again")
        self.assertEqual([layer["area_mm2"] for layer in again["layer_records"]], [layer["area_mm2"] for layer in plain["layer_records"]])

    def test_every_step_of_a_resin_with_a_curve_bonds(self):
        Daemon(self, resin={**CURVE, "ticket_limits": {"exposure_ms": [100, 10000]}})
        text = self.calibrate("exposure").stdout.decode()
        overcures = [float(line.split()[-1]) for line in text.splitlines() if "   overcure_um " in line]
        self.assertEqual(len(overcures), 9)
        self.assertAlmostEqual(overcures[0], 50 + 150 * math.log(2), delta=0.1)  # twice the light
        self.assertAlmostEqual(overcures[-1], 0, delta=0.1)

    def test_a_resin_that_shrinks_in_height_has_bridges_in_whole_layers_too(self):
        daemon = Daemon(self, resin={**CURVE, "shrinkage_percent": {"z": 3}}).start()
        areas = [layer["area_mm2"] for layer in self.printed(daemon, "memory")["layer_records"]]
        self.assertEqual([round(areas[-below] - areas[-below - 1]) for below in (1, 2, 4, 8, 16)], [12] * 5)
        measured = [f"{layers}={bridge_um(layers, 0.9) * 0.97:.1f}" for layers in (1, 2, 4, 8, 16)]
        found = json.loads(self.fit("memory", *measured, "--json").stdout)
        self.assertAlmostEqual(found["values"][0]["value"], 0.9, delta=0.002)

    def test_the_noise_of_rounding_is_no_difference(self):
        Daemon(self, resin=CURVE)
        exact = [f"{8 * math.exp(i / 2)}={75 * i}" for i in range(1, 8)]
        page = self.path("curve.html")
        text = self.fit("curve", *exact, "--html", page).stdout.decode()
        self.assertEqual([line.split()[-1] for line in text.splitlines() if line.split()[1:2] in ([str(75 * i)] for i in range(1, 8))], ["0"] * 7)
        self.assertNotRegex(text + contents(page).decode(), r"\de-1\d")


class Refused(CalibrationTest):
    def test_prints_that_the_profile_does_not_allow(self):
        daemon = Daemon(self)
        self.assert_refusal(self.calibrate("memory", expect=None), BAD_DATA, "no working_curve", "contourctl calibrate curve standard")
        self.assert_refusal(self.calibrate("exposure", expect=None), BAD_DATA, '"ticket_limits": {"exposure_ms": [1800, 6000]}')
        daemon.write_resin("standard", {"ticket_limits": {"exposure_ms": [2900, 3100]}})
        self.assert_refusal(self.calibrate("exposure", expect=None), BAD_DATA, "2900 to 3100 ms")
        daemon.write_resin("standard", {**LIMITS, "exposure_ms": 2000, "bottom_exposure_ms": 2300})
        self.assert_refusal(self.calibrate("exposure", expect=None), BAD_DATA, "2000 to 2300 ms", "bottom layers' 2300 ms", "raise bottom_exposure_ms")
        daemon.write_resin("standard", {**CURVE, "working_curve": {**CURVE["working_curve"], "overcure_um": 5, "bottom_overcure_um": 20}, **LIMITS})
        self.assert_refusal(self.calibrate("exposure", expect=None), BAD_DATA, "cures its own height", "raise bottom_overcure_um")
        self.assertFalse(os.path.exists(self.path("out")))
        missing = contourctl("calibrate", "memory", "none", "--printer", self.path("contourd.json"), "-o", self.path("out"))
        self.assert_refusal(missing, BAD_CONFIG, "none")

    def test_steps_that_are_none(self):
        daemon = Daemon(self, resin=LIMITS)
        self.calibrate("exposure")
        ticket, before = self.path("out", "exposure.json"), self.profile()
        plain = self.write("plain.json", b'{"resin": "standard"}')
        other = self.write("other.json", contents(ticket).replace(b'"standard"', b'"other"'))
        for step, of, code, said in (
            ("0", ticket, BAD_USAGE, "1 to 9"),
            ("10", ticket, BAD_USAGE, "1 to 9"),
            ("x", ticket, BAD_USAGE, "x"),
            ("4", plain, BAD_USAGE, "no falling exposure_steps"),
            ("4", other, BAD_USAGE, "of the resin other"),
        ):
            with self.subTest(step, of=of):
                result = self.fit("exposure", step, "--ticket", of, "--accept", expect=None)
                self.assertEqual(result.returncode, code, result)
                self.assert_words(result.stderr.decode(), said)
        self.assertIn("it is a folder, not a file", self.fit("exposure", "4", "--ticket", self.path("out"), expect=None).stderr.decode())
        self.assertEqual(self.fit("exposure", "4", "--ticket", ticket, "--temperature-c", "20", expect=None).returncode, BAD_USAGE)
        for option in ("--temperature-c", "--lamp-hours"):
            for number in ("nan", "-300", "1e300"):
                result = self.fit("exposure", "4", "--ticket", ticket, option, number, expect=None)
                self.assert_refusal(result, BAD_USAGE, option, "is not a number from 0 to")
        self.assertEqual(self.profile(), before)
        # A layer gets no more light than a bottom layer, and the exposures are those of the profile's layers.
        daemon.write_resin("standard", {**LIMITS, "bottom_exposure_ms": 3000})
        self.assert_refusal(self.fit("exposure", "1", "--ticket", ticket, expect=None), BAD_DATA, "step 1 got 5000 ms", "raise bottom_exposure_ms")
        thick = self.write("thick.json", json.dumps({**json.loads(contents(ticket)), "layer_height_um": 100}).encode())
        self.assert_refusal(self.fit("exposure", "9", "--ticket", thick, expect=None), BAD_USAGE, "a layer height of its own")
        # A curve by which the step would not even cure its layer.
        daemon.write_resin("standard", {**CURVE, "working_curve": {**CURVE["working_curve"], "critical_energy_mj_cm2": 20}})
        self.assert_refusal(self.fit("exposure", "9", "--ticket", ticket, expect=None), BAD_DATA, "less than a layer of 50 um")

    def test_measurements_that_are_none(self):
        Daemon(self, resin=CURVE)
        for word in ("8", "8=", "=8", "1.5=100", "0=100", "101=100", "nan=100", "8=high"):
            with self.subTest(word):
                self.assertEqual(self.fit("memory", word, expect=None).returncode, BAD_USAGE)
        for word in ("30=29", "x=29", "z30=29", "xgap=3", "x30", "x30=", "x30=long"):
            with self.subTest(word):
                self.assertEqual(self.fit("dimensions", word, expect=None).returncode, BAD_USAGE)
        self.assert_refusal(self.fit("memory", "99999999=100", expect=None), BAD_USAGE, "99999999=100: a bridge has a whole number of layers, 1 to 100")
        self.assert_refusal(self.fit("memory", "2=200", "4=300", "8=500", expect=None), BAD_DATA, "3 thicknesses")
        self.assert_refusal(self.fit("memory", *["16=2000"] * 4, expect=None), BAD_DATA, "thicker")
        self.assert_refusal(self.fit("dimensions", "x30=29.9", expect=None), BAD_DATA, "1 lengths do not determine")
        self.assertNotIn("calibrations", self.profile())
