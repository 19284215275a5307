"""Settings of the resin profile that a ticket overrides: allowed within the profile's limits, reported everywhere, and refused
beyond the limits."""

import json
import os

from harness import (
    BAD_CONFIG, BAD_USAGE, CONTOURD, ENDLESS, NIMBLE_RESIN, OK, REALTIME, SMALL, Daemon, FolderTest, contourctl, run, source_json, wait_until,
)  # fmt: skip

LIMITS = {"exposure_ms": [2000, 8000], "bottom_exposure_ms": [4000, 60000], "lift_mm": [1, 10], "settle_ms": [0, 5000], "rest_ms": [0, 2000]}
# The shipped resin has 3000 and 30000 ms, 2 mm, 200 and 500 ms.
ASKED = {"exposure_ms": 4000.5, "bottom_exposure_ms": 9000, "lift_mm": 8, "settle_ms": 250, "rest_ms": 0}
REPORTED = "exposure_ms 4000.5 instead of 3000, bottom_exposure_ms 9000 instead of 30000, lift_mm 8 instead of 2, " \
    "settle_ms 250 instead of 200, rest_ms 0 instead of 500"
BOTTOM = {"bottom_layers": 2, "fade_layers": 0, "ticket_limits": LIMITS}


def overrides(asked, profile):
    return [{"setting": key, "asked": value, "profile": profile[key]} for key, value in asked.items()]


class OverridesTest(FolderTest):
    def refusal(self, daemon, job, *words):
        """Waits until the job is refused, and returns the reason: one sentence that contains these words."""
        reason = daemon.wait_refused(job).rstrip("\n")
        self.assertNotIn("\n", reason)
        self.assertTrue(reason.startswith("the job ticket is wrong: "), reason)
        sentence = reason.removeprefix("the job ticket is wrong: ")
        self.assert_words(sentence, *words)
        return sentence

    def queued(self, daemon, job):
        """Waits until the queued job has been checked, and returns its entry."""
        def entry():
            jobs = [each for each in daemon.rpc("queue")["result"]["jobs"] if each["job"] == job]
            return jobs and jobs[0]["state"] == "ready" and jobs[0]
        return wait_until(entry, f"{job} to be checked")


class Printed(OverridesTest):
    def assert_light(self, report):
        """Asserts that layers got the light that the ticket asks for; the simulated lamp is exact except for delays of the loop."""
        layers = report["layer_records"]
        self.assertEqual([layer["exposure_asked_ms"] for layer in layers], [9000, 9000, 4000.5, 4000.5])
        for layer in layers:
            self.assertGreaterEqual(layer["exposure_least_ms"], layer["exposure_asked_ms"] - 0.001)
            self.assertTrue(layer["complete"])

    def test_light_lift_and_waits_come_from_the_ticket_and_are_reported(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        report = daemon.printed("part.stl", SMALL, ASKED)
        self.assert_light(report)
        for key, value in ASKED.items():
            self.assertEqual(report["settings"][key], value)
        self.assertEqual(report["overrides"], overrides(ASKED, source_json("resins", "standard.json")))
        self.assertIn(f"part: standard: exposure 4000.5 ms, 9000 ms in 2 bottom layers", daemon.log())
        self.assertIn(f"by its ticket: {REPORTED}", daemon.log())
        self.assertIn(f"by its ticket: {REPORTED}", daemon.read("done", "part.report.html"))
        ended = daemon.rpc("history")["result"]["ended"][-1]
        self.assertTrue(ended["settings"].endswith(f"by its ticket: {REPORTED}"), ended)
        self.assertEqual(ended["light_asked_s"], 26.001)
        # On the machine's clock, from one mask to the next: light of 9 and 30 s, settle, rest, lift and return. The ticket's lift
        # of 8 mm instead of 2 takes 4 s and its return 1.2 s longer.
        shown = [layer["shown_at_s"] for layer in report["layer_records"]]
        plain = daemon.printed("plain.stl", SMALL)
        self.assertEqual(plain["overrides"], [])
        self.assertNotIn("by its ticket", daemon.read("done", "plain.report.html"))
        slower = [layer["shown_at_s"] for layer in plain["layer_records"]]
        self.assertGreater(slower[1] - slower[0], shown[1] - shown[0] + 21 - 6)

    def test_steps_of_exposure_by_height_are_printed_and_reported(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        steps = [{"from_mm": 0.1, "exposure_ms": 5000}, {"from_mm": 0.15, "exposure_ms": 2500}]
        report = daemon.printed("part.stl", SMALL, {"exposure_steps": steps})
        self.assertEqual([layer["exposure_asked_ms"] for layer in report["layer_records"]], [30000, 30000, 5000, 2500])
        self.assertEqual(report["settings"]["exposure_steps"], steps)
        self.assertEqual(report["overrides"], [{"setting": "exposure_steps.exposure_ms", "asked": step["exposure_ms"], "profile": 3000}
                                               for step in steps])
        self.assertIn("5000 ms from 0.1 mm, 2500 ms from 0.15 mm", daemon.log())
        daemon.drop("long.stl", SMALL, {"exposure_steps": [{"from_mm": 1, "exposure_ms": 9000}]})
        self.refusal(daemon, "long", "/exposure_steps/0/exposure_ms: 9000", "2000 to 8000")

    def test_the_overrides_of_a_plate_apply_to_all_its_models_and_copies(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        models = [{"file": "a.stl", "copies": 3}, {"file": "a.stl", "rotation_deg": {"z": 90}}]
        daemon.drop_plate("plate", {**ASKED, "models": models}, {"a.stl": SMALL})
        report = daemon.wait_done("plate")
        self.assertEqual([len(model["positions_mm"]) for model in report["models"]], [3, 1])
        self.assert_light(report)
        self.assertEqual(len(report["overrides"]), 5)

    def test_an_exposure_override_replaces_the_working_curve_for_the_ticket_s_layer_height(self):
        curve = {"exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 1, "fade_layers": 0,
                 "working_curve": {"penetration_depth_um": 150, "critical_energy_mj_cm2": 9, "overcure_um": 60, "bottom_overcure_um": 200},
                 "ticket_limits": {"exposure_ms": [1000, 9000]}}  # fmt: skip
        daemon = Daemon(self, resin=curve).start()
        asked = [layer["exposure_asked_ms"] for layer in daemon.printed("plain.stl", SMALL, {"layer_height_um": 100})["layer_records"]]
        report = daemon.printed("part.stl", SMALL, {"layer_height_um": 100, "exposure_ms": 7000})
        self.assertEqual([layer["exposure_asked_ms"] for layer in report["layer_records"]], [asked[0], 7000])
        self.assertEqual(report["overrides"], [{"setting": "exposure_ms", "asked": 7000, "profile": asked[1]}])
        daemon.drop("thin.stl", SMALL, {"adaptive_layers": {"cusp_um": 10}, "exposure_ms": 7000})
        self.refusal(daemon, "thin", "/exposure_ms: ", "adaptive_layers")


class Refused(OverridesTest):
    def test_an_override_beyond_the_limits_or_of_a_wrong_type_prints_nothing(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        profile = self.path("resins", "standard.json")
        for job, (ticket, *words) in {
            "long": ('{"exposure_ms": 8000.001}', "/exposure_ms: 8000.001 is asked for", "2000 to 8000", profile),
            "short": ('{"exposure_ms": 1999}', "/exposure_ms: 1999", "2000 to 8000"),
            "none": ('{"exposure_ms": 0}', "/exposure_ms: 0 is less"),
            "negative": ('{"lift_mm": -6}', "/lift_mm: -6 is less"),
            "huge": ('{"settle_ms": 1e308}', "/settle_ms: 1e+308 is more"),
            "infinite": ('{"settle_ms": 1e999}', "1e999\" is too large"),
            "nan": ('{"rest_ms": "NaN"}', "/rest_ms: expected a number"),
            "bare": ('{"rest_ms": NaN}', "bare.json"),
            "upside": ('{"exposure_ms": 8000, "bottom_exposure_ms": 4000}', "/exposure_ms: ", "8000", "4000"),
        }.items():
            with self.subTest(job):
                daemon.drop(job + ".stl", SMALL, ticket)
                self.refusal(daemon, job, f"{job}.json", *words)
                self.assertTrue(daemon.has("failed", job + ".stl"))
                self.assertEqual(daemon.read("failed", job + ".json"), ticket)
        self.assertNotIn("EVENT=layer", daemon.log())
        self.assertNotIn("layer 1 of", daemon.log())

    def test_a_profile_without_limits_allows_no_overrides(self):
        daemon = Daemon(self).start()
        for key, value in ASKED.items():
            daemon.drop(key + ".stl", SMALL, {key: value})
            self.refusal(daemon, key, f"/{key}: {value} is asked for", "no ticket_limits", self.path("resins", "standard.json"))

    def test_limits_that_changed_while_a_job_waited_apply_to_it(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS, "ticket_limits": {"settle_ms": [0, 5000]}}).start()
        daemon.begin("first.stl", SMALL)
        for job in ("second", "third"):
            daemon.drop(job + ".stl", SMALL, {"settle_ms": 100 if job == "third" else 3000})
        waiting = self.queued(daemon, "second")
        self.queued(daemon, "third")
        self.assertEqual(waiting["overrides"], [{"setting": "settle_ms", "asked": 3000, "profile": 0}])
        self.assertIn(b"settle_ms 3000 instead of 0", daemon.ctl("queue", "show", "second").stdout)
        self.assertIn(b"by its ticket: settle_ms 100 instead of 0", daemon.ctl("queue").stdout)
        daemon.write_resin("standard", {**NIMBLE_RESIN, "ticket_limits": {"settle_ms": [0, 2000]}})
        daemon.rpc("cancel")
        self.refusal(daemon, "second", "/settle_ms: 3000 is asked for", "0 to 2000")
        report = daemon.wait_done("third")
        self.assertEqual(report["overrides"], [{"setting": "settle_ms", "asked": 100, "profile": 0}])


class Checked(OverridesTest):
    def check(self, limits, *words):
        daemon = Daemon(self, resin={"ticket_limits": limits})
        result = run(CONTOURD, "--check-config", daemon.config_path)
        self.assertEqual(result.returncode, BAD_CONFIG if words else OK, result)
        self.assert_words(result.stderr.decode(), *words)

    def test_limits_are_checked_with_the_configuration(self):
        self.check(LIMITS)
        self.check({})
        self.check({"exposure_ms": [2000, 120001]}, "/ticket_limits/exposure_ms/1: 120001 is more than the limit, 120000 ms")
        self.check({"exposure_ms": [8000, 2000]}, "/ticket_limits/exposure_ms: the least, 8000, is more than the most, 2000")
        self.check({"exposure_ms": [3001, 8000]}, "/ticket_limits/exposure_ms: ", "exclude the profile's own exposure_ms, 3000")
        self.check({"lift_mm": [1, 200]}, "/ticket_limits/lift_mm/1: 200 is more")
        self.check({"lift_mm": [5]}, "/ticket_limits/lift_mm: ")
        self.check({"lift_speed_mm_s": [1, 2]}, "there is no key")


class Submitted(OverridesTest):
    OPTIONS = ("--exposure-ms=4000.5", "--bottom-exposure-ms", "9000", "--lift-mm=8", "--settle-ms=250", "--rest-ms=0")

    def test_options_become_the_ticket(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        daemon.ctl("submit", self.write("part.stl", SMALL), *self.OPTIONS, "--wait", expect=OK)
        self.assertEqual(json.loads(daemon.read("done", "part.json")), ASKED)
        self.assertEqual(len(daemon.report("part")["overrides"]), 5)

    def test_with_a_configuration_submit_checks_the_options_before_it_copies_anything(self):
        daemon = Daemon(self, resin=BOTTOM)
        os.makedirs(daemon.file("incoming"))
        submit = ["submit", self.write("part.stl", SMALL), "--spool", daemon.spool, "--printer", daemon.config_path]
        for options, code, *words in (
            (["--exposure-ms", "8001"], BAD_USAGE, "the options: /exposure_ms: 8001 is asked for", "2000 to 8000", "standard.json"),
            (["--ticket", self.write("t.json", '{"lift_mm": 11}')], BAD_CONFIG, "t.json: /lift_mm: 11 is asked for", "1 to 10"),
            (["--printer", self.path("none.json"), "--rest-ms", "1"], BAD_CONFIG, "none.json"),
        ):
            with self.subTest(options):
                result = contourctl(*submit[:4], *(submit[4:] if "--printer" not in options else ()), *options)
                self.assert_refusal(result, code, *words)
                self.assertEqual(os.listdir(daemon.file("incoming")), [])
        for value in ("nan", "1e308", "-1", "0", "120001"):
            with self.subTest(value):
                result = contourctl(*submit[:4], f"--exposure-ms={value}")
                self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), result)
        self.assertEqual(os.listdir(daemon.file("incoming")), [])
        # If the profile cannot be used here, the daemon checks the options.
        self.write("resins/gold.json", b"{}")
        self.assertEqual(contourctl(*submit, "--resin", "gold", "--exposure-ms", "4000").returncode, OK)
        self.assertEqual(contourctl(*submit, *self.OPTIONS).returncode, OK)
        self.assertEqual(sorted(os.listdir(daemon.file("incoming"))), ["part-2.json", "part-2.stl", "part.json", "part.stl"])

    def test_without_a_configuration_the_daemon_checks_the_options(self):
        daemon = Daemon(self, resin=BOTTOM).start()
        daemon.ctl("submit", self.write("part.stl", SMALL), "--exposure-ms", "8001", expect=OK)
        self.refusal(daemon, "part", "/exposure_ms: 8001 is asked for")
