"""Continuous prints: profiles that ask for them, rises in the light, reports, and power cuts within a rise."""

import json
import os

from harness import BAD_DATA, NIMBLE_RESIN, OK, SpoolTest, binary_stl, box, contents, contourctl, realtime, wait_until, wedge

WINDOW = {
    "working_curve": {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "dead_zone_um": 30, "overcure_um": 50, "bottom_overcure_um": 150},
    "continuous": {"margin": 4, "window_s": 3600, "recovery_s": 1800, "layered_mm": 0.2},
    "viscosity_mpa_s": 1, "exposure_ms": None, "bottom_exposure_ms": None, "bottom_layers": 2, "fade_layers": 0, "mode": "continuous",
}  # fmt: skip
NEEDLE = binary_stl(box((0, 0, 0), (2, 2, 2)))


CURING_S = 300  # the thread that computes the cured part gives way to all others


class Continuous(SpoolTest):
    def window_daemon(self, config=None, **continuous):
        resin = json.loads(json.dumps(WINDOW))
        resin["continuous"] |= continuous
        return self.daemon(config, resin).start()

    def test_a_rise_at_the_speed_of_the_masks_is_not_interrupted(self):
        for name, config in (("bright", {"projector": {"irradiance_mw_cm2": 100}}), ("slow", {"display": {"refresh_hz": 10}})):
            daemon = self.window_daemon(config)
            report = daemon.printed(f"{name}.stl", NEEDLE)
            self.assertEqual(report["interruptions"], [])
            self.assertEqual(report["frames"]["missed"], 0)
            self.assertAlmostEqual(report["exposed_volume_mm3"], 8, delta=0.05)
            daemon.stop()

    def test_a_wide_middle_section_is_layered_and_rests_let_the_window_recover(self):
        resin = {**WINDOW, "viscosity_mpa_s": 2000, "continuous": {**WINDOW["continuous"], "window_s": 80, "recovery_s": 30}}
        daemon = self.daemon(None, resin).start()
        flange = binary_stl(box((-2, -2, 0), (2, 2, 3.6)) + box((-20, -20, 1.6), (20, 20, 1.8)))
        report = daemon.printed("flange.stl", flange)
        self.assertEqual(report["interruptions"], [])
        self.assertEqual(report["frames"]["missed"], 0)
        plan = report["continuous"]
        layered = [each for each in plan["ranges"] if each["limit"] is None]
        self.assertEqual(len(layered), 2)
        self.assertTrue(1.3 < layered[1]["bottom_mm"] <= 1.6 and 1.8 <= layered[1]["top_mm"] < 2.1, layered)
        self.assertGreater(plan["rests"], 0)
        self.assertAlmostEqual(report["states_s"]["recovering"], plan["rests_s"], delta=0.01)
        for each in plan["ranges"]:
            # First masks, light on and off, and the lift after a layer, which counts for what follows. The forecast of layers samples
            # the faces that press out resin, so that the wait of one may be missing: up to a minute.
            self.assertAlmostEqual(each["took_s"], each["time_s"], delta=12 if each["limit"] else 72)
        planned, took = report["time"]["forecast"]["causes_s"], report["time"]["took_s"]
        self.assertEqual(list(planned), list(took))
        self.assertAlmostEqual(sum(planned.values()), report["time"]["forecast"]["time_s"], delta=1e-6)
        self.assertAlmostEqual(sum(took.values()), report["print_time_s"], delta=1e-6)
        for cause in ("light", "recovering", "resting"):
            self.assertAlmostEqual(took[cause], planned[cause], delta=0.01 * planned[cause] + 1, msg=cause)
        self.assertGreater(took["recovering"], 25)
        self.assertNotIn("light", report["time"]["differs"])
        found = contourctl("analyze", self.write("flange.stl", flange), "--printer", self.path("contourd.json"), "--json", expect=OK)
        for each in plan["ranges"]:
            del each["took_s"]
        self.assertEqual(plan.pop("changed"), [])
        self.assertEqual(json.loads(found.stdout)["continuous"], plan)
        self.assertEqual(json.loads(found.stdout)["forecast"], report["time"]["forecast"])

    def test_steps_too_coarse_for_masks_are_refused(self):
        daemon = self.window_daemon({"z_axis": {"microsteps_per_mm": 100}})
        self.assert_words(daemon.refused("needle.stl", NEEDLE), "microsteps of 10 um", "mask_step_um")

    def test_a_dry_run_has_no_cured_part_and_a_rise_that_was_not_printed_is_said_to_be_in_layers(self):
        daemon = self.window_daemon()
        needle, ticket = self.write("needle.stl", NEEDLE), self.write("dry.json", b'{"dry": true}')
        daemon.drop("needle.stl", NEEDLE, contents(ticket))
        daemon.wait_ended("needle")
        arguments = ("cure", needle, "--printer", self.path("contourd.json"))
        self.assert_refusal(contourctl(*arguments, "--report", daemon.file("done", "needle.report.json")), BAD_DATA, "a dry run")
        self.assert_words(contourctl(*arguments, expect=OK).stdout, "rises without a stop", "--report")

    def test_a_print_without_a_rise_is_layered_and_the_report_says_why(self):
        daemon = self.window_daemon()
        report = daemon.printed("low.stl", binary_stl(box((0, 0, 0), (2, 2, 0.3))))
        self.assertEqual(report["settings"]["mode"], "layered")
        self.assertIsNone(report.get("continuous"))
        self.assert_words(json.dumps(report), "layered, not continuous", "0.30 mm high")

    def test_the_cured_part_is_not_compared_with_single_masks_of_a_rise(self):
        daemon = self.window_daemon()
        model = binary_stl(wedge(4, 4, 2))
        report = daemon.printed("wedge.stl", model)
        self.assertAlmostEqual(report["exposed_volume_mm3"], 16, delta=0.05)
        result = contourctl("cure", "--json", self.write("wedge.stl", model), "--printer", self.path("contourd.json"),
                            "--report", daemon.file("done", "wedge.report.json"), expect=OK)  # fmt: skip
        self.assertNotIn("not those of the print", " ".join(json.loads(result.stdout)["warnings"]))

    def test_the_masks_of_a_rise_are_on_record_beside_the_report(self):
        daemon = self.window_daemon()
        model = binary_stl(wedge(4, 4, 2))
        report = daemon.printed("wedge.stl", model)
        self.assertEqual(report["frames"]["file"], "wedge.frames.bin")
        self.assertEqual(report["frames"]["lost"], 0)
        path = daemon.file("done", "wedge.frames.bin")
        found = json.loads(contourctl("frames", "--json", path, expect=OK).stdout)
        self.assertTrue(found["complete"])
        self.assertEqual(found["masks"], report["frames"]["recorded"])
        self.assertEqual(found["masks"], report["frames"]["shown"])
        self.assertAlmostEqual(found["lit_s"], sum(each["exposure_asked_ms"] for each in report["layer_records"] if each["frames"]) / 1000, delta=0.01)
        nearest, farthest = found["below_plate_um"]
        self.assertAlmostEqual(nearest, 0, delta=2)  # the mask at rest is that of the first section above the layers
        self.assertAlmostEqual(farthest, 73.2, delta=3)  # the gel gap at a margin of 4; a mask is up to 2 um behind
        self.assertLess(found["risen_um"], 5)
        self.assertLess(report["frames"]["farthest_um"], 5)
        lines = contourctl("frames", "--csv", path, expect=OK).stdout.splitlines()
        self.assertEqual(len(lines), found["masks"] + 1)
        self.assert_words(contourctl("frames", path, expect=OK).stdout, f"{found['masks']} in 1 rise", "complete")
        self.assert_refusal(contourctl("frames", daemon.file("done", "wedge.report.json")), BAD_DATA, "no record of frames")
        with open(path, "rb") as file:
            damaged = bytearray(file.read())
        damaged[100] ^= 1
        self.assert_refusal(contourctl("frames", self.write("damaged.frames.bin", bytes(damaged))), BAD_DATA, "first block is damaged")

    def test_the_cured_part_of_a_rise_is_that_of_its_masks(self):
        daemon = self.window_daemon()
        model = binary_stl(wedge(4, 4, 2))
        report = daemon.printed("wedge.stl", model)
        cured = wait_until(lambda: None if "has not finished" in (part := daemon.report("wedge")["cured_part"]).get("not_computed", "") else part, "the cured part", CURING_S)
        self.assertEqual(cured["rise"]["masks"], report["frames"]["recorded"])
        self.assertGreater(cured["rise"]["margin"], 3.9)
        arguments = ("cure", "--json", self.write("wedge.stl", model), "--printer", self.path("contourd.json"), "--report", daemon.file("done", "wedge.report.json"))
        result = json.loads(contourctl(*arguments, expect=OK).stdout)
        self.assertEqual(result["rise"]["masks"], cured["rise"]["masks"])
        contourctl(*arguments, "--html", self.path("cured.html"), expect=OK)
        self.assertIn(f'{result["rise"]["masks"]} masks in steps of', contents(self.path("cured.html")).decode())
        self.assertAlmostEqual(result["tops"]["median_um"], cured["tops"]["median_um"], delta=2)
        os.remove(daemon.file("done", "wedge.frames.bin"))
        result = json.loads(contourctl(*arguments, expect=OK).stdout)
        self.assertNotIn("rise", result)
        self.assert_words(" ".join(result["warnings"]), "taken from its slices", "wedge.frames.bin")

    @staticmethod
    def set_in_time(daemon, setting, value):
        """Sets a setting of the rise as soon as the last change allows it. Returns what the command said."""

        def answer():
            result = daemon.ctl("set", setting, str(value))
            return None if b"try again" in result.stderr else result

        return wait_until(answer, "the time between two changes")

    def test_speed_light_and_margin_change_while_the_plate_rises(self):
        nimble = {key: value for key, value in NIMBLE_RESIN.items() if "exposure" not in key}
        config = realtime(z_axis={"travel_mm": 30}, projector={"irradiance_mw_cm2": 25})
        daemon = self.daemon(config, {**nimble, **WINDOW, "mode": "continuous"}).start()
        daemon.drop("needle.stl", NEEDLE)
        daemon.wait_state("rising")
        left = daemon.status()["job"]["time_left_s"]
        self.assert_refusal(daemon.ctl("set", "speed", "1"), 1, "speed 1 mm/h is not allowed", "allow 5 to")
        self.assert_refusal(daemon.ctl("set", "exposure", "110%"), 1, "speeds that were planned")
        changes = [("light", 20), ("speed", 60), ("margin", 3), ("light", 100), ("speed", 300)]
        for setting, value in changes:
            changed = self.set_in_time(daemon, setting, value)
            self.assertEqual(changed.returncode, OK, changed)
            if setting == "speed" and value == 60:
                self.assertGreater(daemon.status()["job"]["time_left_s"], left + 5)
                self.assert_refusal(self.set_in_time(daemon, "margin", 99), 1, "margin 99", "least_speed_mm_h is 5")
        daemon.cancel("needle")
        report = json.loads(daemon.read("failed", "needle.report.json"))
        self.assertEqual([(each["setting"], each["value"]) for each in report["changes"]], changes)
        self.assertTrue(all(0.2 <= each["from_mm"] < 2 for each in report["changes"]), report["changes"])
        self.assertEqual([each["before"] for each in report["changes"] if each["setting"] == "light"], [100, 20])
        plans = report["continuous"]["changed"]
        self.assertEqual([each["from_mm"] for each in plans], [each["from_mm"] for each in report["changes"]])
        self.assertEqual([each["set"]["light_percent"] for each in plans], [20, 20, 20, 100, 100])
        self.assertAlmostEqual(plans[1]["speed_mm_h"][1], 60, delta=0.01)
        self.assertAlmostEqual(plans[3]["margin"][0], plans[2]["margin"][0] * 5, delta=0.2 * plans[3]["margin"][0])  # as fast, with more light
        for plan, following in zip(plans, plans[1:]):
            self.assertAlmostEqual(plan["ranges"][-1]["top_mm"], following["from_mm"], delta=1e-6)
        self.assertEqual(plans[-1]["ranges"][-1]["top_mm"], 2)
        self.assert_words(daemon.read("failed", "needle.report.html"), "light 20 % and margin 3")
        self.assert_words(contourctl("frames", "--csv", daemon.file("failed", "needle.frames.bin"), expect=OK).stdout, ",100.0\n", ",20.0\n")

    def test_a_layered_print_has_no_speed_light_or_margin(self):
        daemon = self.daemon(realtime(), {**NIMBLE_RESIN}).start()
        daemon.drop("needle.stl", NEEDLE)
        daemon.wait_state("exposing")
        self.assert_refusal(daemon.ctl("set", "light", "50"), 1, "does not rise")
        daemon.cancel("needle")

    def test_after_a_power_cut_within_a_rise_the_part_is_lifted_out_and_nothing_offers_to_resume(self):
        nimble = {key: value for key, value in NIMBLE_RESIN.items() if "exposure" not in key}
        daemon = self.daemon(realtime(z_axis={"travel_mm": 30}, projector={"irradiance_mw_cm2": 25}), {**nimble, **WINDOW}).start()
        daemon.drop("needle.stl", NEEDLE)
        daemon.wait_state("rising")
        daemon.kill()
        daemon.start()
        held = daemon.rpc("resume")["error"]["message"]
        self.assertIn("the print cannot go on", held)
        self.assertNotIn("contourctl resume", held)
        self.assert_refusal(daemon.ctl("resume", "--trust-position"), 1, "within its rise is not known")
        daemon.ctl("rescue", expect=OK)
