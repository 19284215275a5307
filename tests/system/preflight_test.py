"""The checks before the first light: dry runs, the resin in the vat, and the pre-flight of a job."""

import json
import re
import unittest

from harness import BAD_USAGE, FAILED, NIMBLE_RESIN, OK, SLAB, WAITS, Daemon, FolderTest, binary_stl, box, realtime, wait_until

BLOCK = binary_stl(box((0, 0, 0), (40, 40, 1)))  # 20 layers, 1.6 ml


class PreflightTest(FolderTest):
    def daemon(self, config=None, resin=None):
        return Daemon(self, config, resin).start()

    def vat_ml(self, daemon):
        return daemon.rpc("vat")["result"]["ml"]


class DryRun(PreflightTest):
    def test_a_dry_run_shows_every_mask_without_light_and_counts_as_no_use(self):
        daemon = Daemon(self, masks=True).start()
        daemon.printed("first.stl", SLAB)  # parks the plate, from which height the others home
        plain = daemon.printed("plain.stl", SLAB)
        usage = daemon.rpc("usage")["result"]
        daemon.rpc("plate_cleared")
        self.write("dry.stl", SLAB)
        self.assertEqual(daemon.ctl("submit", self.path("dry.stl"), "--dry", "--yes").returncode, OK)
        report = daemon.wait_done("dry")
        self.assertEqual((plain["dry"], report["dry"], report["layers_exposed"], report["exposed_volume_mm3"]), (False, True, 0, 0))
        self.assertEqual(len(report["layer_records"]), len(plain["layer_records"]))
        for dry, lit in zip(report["layer_records"], plain["layer_records"]):
            self.assertEqual((dry["area_mm2"], dry["plate_height_mm"]), (lit["area_mm2"], lit["plate_height_mm"]))
            self.assertEqual((dry["exposure_most_ms"], dry["complete"]), (0, False))
        self.assertAlmostEqual(report["print_time_s"], plain["print_time_s"], delta=2)
        self.assertIn("dry run, without light", daemon.read("done", "dry.report.html"))
        self.assertIn("dry run, without light", daemon.log())
        after = daemon.rpc("usage")["result"]
        self.assertEqual([after[key] for key in ("layers", "lamp_h", "resin_ml")], [usage[key] for key in ("layers", "lamp_h", "resin_ml")])
        self.assertEqual(daemon.status()["plate"], "clear")

    def test_a_ticket_whose_dry_is_no_truth_value_is_refused(self):
        daemon = self.daemon()
        daemon.drop("part.stl", SLAB, {"dry": "yes"})
        self.assert_words(daemon.wait_refused("part"), "/dry")


class Vat(PreflightTest):
    def test_prints_use_up_what_was_filled_in_also_after_a_restart(self):
        daemon = self.daemon()
        self.assertIsNone(self.vat_ml(daemon))
        self.assertIn(b"unknown", daemon.ctl("vat").stdout)
        self.assertIn(b"about 150 ml", daemon.ctl("vat", "filled", "150").stdout)
        used = daemon.printed("part.stl", BLOCK)["exposed_volume_mm3"] / 1000
        self.assertGreater(used, 1)
        self.assertAlmostEqual(self.vat_ml(daemon), 150 - used, 6)
        wait_until(lambda: daemon.status()["state"] == "idle", "the print to be filed")
        daemon.stop()
        self.assertAlmostEqual(self.vat_ml(Daemon(self).start()), 150 - used, delta=0.001)

    def test_a_vat_that_runs_low_interrupts_the_print_until_it_is_resumed(self):
        daemon = self.daemon(realtime(), {**NIMBLE_RESIN, "exposure_ms": 1})
        self.assertEqual(daemon.ctl("vat", "filled", "10.5").returncode, OK)
        daemon.drop("part.stl", BLOCK)
        paused = daemon.wait_state("paused")
        self.assertIn("the vat holds about 10 ml of resin: fill it", paused["job"]["interruption"])
        self.assertIn(paused["job"]["layers_done"], range(6, 9))
        daemon.rpc("vat", filled_ml=100)
        daemon.rpc("resume")
        report = daemon.wait_done("part")
        self.assertEqual((report["layers_exposed"], len(report["interruptions"])), (20, 1))

    def test_an_amount_that_no_vat_holds_is_refused(self):
        daemon = self.daemon()
        self.assertEqual(daemon.ctl("vat", "filled", "full").returncode, BAD_USAGE)
        for ml in ("-1", "100001"):
            self.assertEqual(daemon.ctl("vat", "filled", ml).returncode, FAILED)
        self.assertIsNone(self.vat_ml(daemon))


class Checks(PreflightTest):
    def test_a_waiting_job_is_checked_with_the_printer(self):
        daemon = self.daemon(WAITS)
        daemon.printed("first.stl", SLAB)
        daemon.drop("part.stl", BLOCK)
        wait_until(lambda: any(job["state"] == "ready" for job in daemon.rpc("queue")["result"]["jobs"]), "the job to be checked")
        daemon.rpc("vat", filled_ml=50)
        result = daemon.ctl("preflight", "part", "--json")
        self.assertEqual(result.returncode, FAILED)
        reply = json.loads(result.stdout)["result"]
        verdicts = {each["check"]: each["verdict"] for each in reply["checks"]}
        self.assertEqual(list(verdicts), ["model", "time", "resin", "machine", "display", "disk", "queue", "temperature", "wear", "findings"])
        # The plate is not cleared.
        self.assertEqual((verdicts.pop("queue"), reply["verdict"]), ("refuse", "refuse"))
        self.assertEqual(verdicts.pop("resin"), "warn")  # not analyzed
        self.assertEqual(set(verdicts.values()), {"pass"})
        self.assert_words(daemon.ctl("preflight", "part").stdout.decode(), "20 layers, 1.00 mm high", "light, ", "lifting", "1920 x 1080 pixels", "lamp", "film")
        nothing = daemon.ctl("preflight", "other")
        self.assertEqual((nothing.returncode, nothing.stdout), (FAILED, b""))
        self.assertIn(b'no job "other" waits', nothing.stderr)

    def test_a_job_that_needs_more_than_the_vat_holds_is_warned_about(self):
        daemon = self.daemon({**WAITS, "ask_before": ["islands"]})
        daemon.printed("first.stl", SLAB)
        daemon.rpc("vat", filled_ml=1)
        daemon.drop("part.stl", BLOCK)
        wait_until(lambda: any(job["resin_ml"] for job in daemon.rpc("queue")["result"]["jobs"]), "the job to be analyzed")
        self.assertIn(b"warn    resin       the vat holds about 1 ml, the job needs 1.6 ml", daemon.ctl("preflight", "part").stdout)
        daemon.rpc("plate_cleared")
        wait_until(lambda: re.search(r"part: needs \d\.\d ml of resin from now on, the vat holds about", daemon.log()), "the warning in the log")


if __name__ == "__main__":
    unittest.main()
