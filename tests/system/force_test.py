"""The force line of a simulated printer: resistance on the way down, parts that come off, peels in the report, a line that is stuck."""

import json

from harness import BAD_CONFIG, NIMBLE_RESIN, OK, Daemon, FolderTest, binary_stl, box, check_config, realtime, wait_until
from power_cuts import SWITCH_AT_THE_TOP, PowerCutTest

FORCE = {"z_axis": {"force": {}}, "simulation": {"peel_kpa": 100}}
BLOCK = binary_stl(box((0, 0, 0), (10, 10, 0.6)))  # 12 layers of 100 mm², which let go at 1.6 mm


def with_force(force=None, **simulation):
    return {"z_axis": {"force": force or {}}, "simulation": {**FORCE["simulation"], **simulation}}


class Force(FolderTest):
    def daemon(self, config):
        return Daemon(self, config).start()

    def paused(self, daemon, name):
        """Returns the interruption of the job, once it is paused."""
        daemon.drop(name + ".stl", BLOCK)
        daemon.wait_status("state", "paused")
        return daemon.status()["job"]

    def test_a_peel_that_ends_early_makes_the_lift_faster_and_is_in_the_report(self):
        daemon = self.daemon(FORCE)
        report = daemon.printed("block.stl", BLOCK)
        peel = report["peel"]
        self.assertEqual((peel["layers"], peel["felt"], peel["missed"]), (12, 12, 0))
        self.assertGreater(peel["saved_s"], 0)
        for layer in report["layer_records"]:
            self.assertAlmostEqual(layer["peel"]["distance_mm"], 1.59, delta=0.03)
        page = daemon.read("done", "block.report.html")
        self.assert_words(page, "felt in 12 of 12 layers", "Peel, mm until the layer let go of the film")
        daemon.stop()
        plain = Daemon(self, {"z_axis": {"force": None}}).start().printed("plain.stl", BLOCK)
        self.assertIsNone(plain["peel"])
        self.assertIsNone(plain["layer_records"][0]["peel"])
        self.assertAlmostEqual(plain["print_time_s"] - report["print_time_s"], peel["saved_s"], delta=0.5)

    def test_an_obstruction_pauses_the_print_which_goes_on_without_it(self):
        daemon = self.daemon(with_force(obstruction_mm=2.5, obstruction_after_lifts=3))
        job = self.paused(daemon, "block")
        self.assert_words(json.dumps(job), "the plate met resistance at 2.700 mm on its way down to 0.200 mm")
        self.assertIn("the plate met resistance at 2.700 mm", daemon.log())
        self.assertEqual(daemon.ctl("resume").returncode, OK)
        report = daemon.wait_done("block")
        self.assertEqual(report["layers_exposed"], 12)
        self.assertEqual(len(report["interruptions"]), 1)
        self.assertTrue(all(layer["exposure_parts"] == 1 for layer in report["layer_records"]))

    def test_an_obstruction_ends_the_print_if_the_printer_says_so(self):
        daemon = self.daemon(with_force({"resistance": "fail"}, obstruction_mm=2.5, obstruction_after_lifts=3))
        daemon.drop("block.stl", BLOCK)
        last = daemon.wait_ended("block")
        self.assertEqual(last["outcome"], "failed")
        self.assert_words(last["reason"], "the plate met resistance at 2.700 mm", "force is expected only below 2.200 mm")

    def test_a_part_that_comes_off_is_reported_at_its_layer(self):
        daemon = self.daemon(with_force(part_lost_after_lifts=5))
        job = self.paused(daemon, "block")
        self.assert_words(json.dumps(job), "no force was felt while layer 6 of 100 mm", "come off")
        self.assertEqual(daemon.ctl("cancel").returncode, OK)
        report = daemon.wait_ended("block")
        self.assertEqual(report["outcome"], "cancelled")
        daemon.stop()
        config = realtime(**with_force({"no_peel": "tell"}, part_lost_after_lifts=5))
        daemon = Daemon(self, config, {**NIMBLE_RESIN, "bottom_exposure_ms": 3000, "lift_mm": 2.5}).start()
        daemon.begin("told.stl", BLOCK)
        self.assertEqual(daemon.ctl("pause", "--at-layer", "8").returncode, OK)
        told = daemon.wait_state("paused") and daemon.status()["job"]["warnings"]
        self.assert_words(told[0], "no force was felt while layer 6 of 100 mm", "come off")
        self.assertEqual((len(told), daemon.status()["job"]["warnings_more"]), (1, 0))
        self.assert_words(daemon.ctl("status").stdout.decode(), "warning", "no force was felt while layer 6")
        self.assertEqual(daemon.ctl("resume").returncode, OK)
        report = daemon.wait_done("told")
        self.assertEqual((report["interruptions"], report["peel"]["missed"]), ([], 1))
        self.assertTrue(report["layer_records"][5]["peel"]["missed"])
        self.assertIn("no force was felt while layer 6", daemon.log())

    def test_a_line_that_is_stuck_active_keeps_jobs_waiting(self):
        daemon = self.daemon(with_force(force_line="stuck_active"))
        daemon.drop("block.stl", BLOCK)
        daemon.wait_job("block", "ready")
        daemon.wait_status("waiting_for")
        wants = "the force line (simulated) is active although the plate is at rest"
        self.assertIn(wants, daemon.ctl("preflight", "block").stdout.decode())
        self.assertIn(b"force           active", daemon.ctl("switches", "--once").stdout)
        self.assertIn("block.stl waits: " + wants, daemon.log())
        self.assertIn(b"resistance stopped the plate on its way down", daemon.ctl("home").stderr)

    def test_the_check_of_the_configuration_names_what_is_wrong(self):
        for force, words in (
            ({"contact_from_mm": 500}, ["/z_axis/force/contact_from_mm"]),
            ({"contact_from_mm": 49}, ["/z_axis/force/contact_from_mm", "49 is not less than z_axis/travel_mm, 45 mm: no force would ever be resistance"]),
            ({"least_peel_area_mm2": 0}, ["/z_axis/force/least_peel_area_mm2"]),
            ({"no_peel": "never"}, ["/z_axis/force/no_peel"]),
        ):
            Daemon(self, {"z_axis": {"travel_mm": 45, "force": force}})
            code, _, last = check_config(self.path("contourd.json"))
            self.assertEqual(code, BAD_CONFIG)
            self.assert_words(last, *words)


class ForceAfterPowerCut(PowerCutTest):
    """The line is stuck active when contourd starts again."""

    def cut(self, job, axis):
        daemon = self.cut_in_layer_2(job, z_axis={"force": {"contact_from_mm": 0.2}, **axis})
        daemon.stop()
        daemon.config["simulation"]["force_line"] = "stuck_active"
        daemon.write_config()
        return daemon.start("--pace", "fast")

    def test_a_stuck_line_keeps_no_part_from_being_lifted_out(self):
        daemon = self.cut("part", {})
        self.assertEqual(daemon.ctl("rescue").returncode, OK)
        manual = wait_until(lambda: daemon.status()["manual"]["state"] == "idle" and daemon.status()["manual"], "the end of the rescue")
        self.assertEqual((manual["operations"], manual["problem"]), (1, None))

    def test_a_print_that_goes_on_lifts_the_part_and_pauses_before_the_plate_comes_down(self):
        for job, axis, options in (("bottom", {}, ("--trust-position", "--yes")), ("top", SWITCH_AT_THE_TOP, ())):
            with self.subTest(switch=job):
                daemon = self.cut(job, axis)
                self.assertEqual(daemon.ctl("resume", *options).returncode, OK)
                daemon.wait_status("state", "paused")
                self.assertIn("the plate met resistance at", daemon.status()["job"]["interruption"])
                self.assertEqual(daemon.ctl("cancel").returncode, OK)
                daemon.wait_ended(job)
                daemon.rpc("plate_cleared")
                daemon.stop()
