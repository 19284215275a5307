"""A print that a power cut ended: how the user lifts the part out, or goes on with it."""

import glob
import json
import os
import random
import shutil
import time

from harness import BAD_USAGE, FAILED, OK, binary_stl, contents, cube, merge, read_png, realtime, wait_until, wedge
from power_cuts import QUICK, SLOW, RAMP, SWITCH_AT_THE_TOP, PowerCutTest


class Rescue(PowerCutTest):
    def test_rescue_lifts_the_part_out_and_nothing_else_happens_until_the_plate_is_clear(self):
        for name, axis in (("bottom", {}), ("top", SWITCH_AT_THE_TOP)):
            with self.subTest(switch=name):
                daemon = self.cut_in_layer_2(name, z_axis=axis)
                result = daemon.ctl("rescue")
                self.assertEqual(result.returncode, OK, result.stderr)
                status = daemon.status()
                self.assertEqual((status["manual"]["operations"], status["manual"]["problem"]), (1, None))
                self.assertEqual((status["interrupted"]["layer"], status["plate_job"]), (2, name))
                # The plate stands elsewhere now.
                self.assert_refusal(daemon.ctl("resume", "--trust-position", "--yes"), FAILED, "moved by hand")
                daemon.rpc("plate_cleared")
                wait_until(lambda: daemon.has("failed", f"{name}.stl"), "the job in failed")
                self.assert_refusal(daemon.ctl("rescue"), FAILED, "no print was interrupted")
                daemon.stop()

    def test_a_part_that_was_lifted_out_is_not_printed_on_even_after_a_restart(self):
        for policy, axis, options in (("hold", {}, ("--trust-position", "--yes")), ("resume", SWITCH_AT_THE_TOP, ())):
            with self.subTest(policy):
                daemon = self.cut_in_layer_2(policy, z_axis=axis)
                daemon.config["after_power_cut"] = policy
                daemon.write_config()
                self.assertEqual(daemon.ctl("rescue").returncode, OK)
                wait_until(lambda: daemon.status()["manual"]["state"] == "idle", "the end of the rescue")
                daemon.stop()
                daemon.start("--pace", "fast")
                found = daemon.status()["interrupted"]
                self.assertEqual((found["layer"], found["phase"], found["trust"]), (2, "moved by hand", None))
                self.assertGreater(found["most_height_mm"], 1)
                self.looks_pass(daemon)
                self.assert_still(daemon)
                self.assert_refusal(daemon.ctl("resume", *options), FAILED, "the plate was moved by hand since the power cut")
                daemon.rpc("plate_cleared")
                wait_until(lambda: daemon.has("failed", f"{policy}.stl"), "the job in failed")
                daemon.stop()

    def test_a_move_by_hand_ends_what_is_known_of_the_position_even_after_a_restart(self):
        daemon = self.cut_in_layer_2()
        self.assertNotIn("error", daemon.rpc("move", unhomed=True, by_mm=1, plate_is_clear=True))
        wait_until(lambda: daemon.status()["manual"]["state"] == "idle", "the end of the move")
        for _ in range(2):
            self.assert_refusal(daemon.ctl("resume", "--trust-position", "--yes"), FAILED, "the plate was moved by hand")
            daemon.stop()
            daemon.start("--pace", "fast")
        self.assertEqual(daemon.ctl("rescue").returncode, OK)


class Resume(PowerCutTest):
    def test_a_print_goes_on_only_from_a_known_position_and_is_the_same_but_for_its_seam(self):
        for name, axis, options in (("bottom", {}, ("--trust-position", "--yes")), ("top", SWITCH_AT_THE_TOP, ())):
            with self.subTest(switch=name):
                daemon = self.cut_in_layer_2(name, masks=True, z_axis=axis)
                if not axis:
                    self.assertIn("the plate has stood at 0.100 mm since", daemon.status()["interrupted"]["trust"])
                    self.assert_refusal(daemon.ctl("resume"), FAILED, "resume --trust-position")
                    unconfirmed = daemon.ctl("resume", "--trust-position")
                    self.assertEqual(unconfirmed.returncode, BAD_USAGE)
                    self.assertIn(b"the plate has stood at 0.100 mm since", unconfirmed.stdout)
                    self.assert_still(daemon)
                first = self.masks(name)
                self.assertEqual(daemon.ctl("resume", *options).returncode, OK)
                daemon.wait_done(name)
                rest, report = self.masks(name), daemon.report(name)
                daemon.rpc("plate_cleared")
                whole_report = daemon.printed(f"whole-{name}.stl", RAMP)
                whole = self.masks(f"whole-{name}")
                self.assertEqual((len(first), len(rest), len(whole)), (2, 19, 20))
                self.assertEqual(first, whole[:2])
                self.assertEqual(rest, whole[1:])
                self.assertEqual(self.exposures(report), self.exposures(whole_report)[1:])
                seam = "a power cut interrupted the print in layer 2: the layer was lit again in full"
                self.assertIn(seam, report["interruptions"][0])
                done, failed = (job for job in reversed(daemon.rpc("history")["result"]["ended"]) if job["job"] == name)
                if done["outcome"] != "done":
                    done, failed = failed, done
                self.assertEqual((done["outcome"], failed["outcome"]), ("done", "failed"))
                self.assertTrue(any(seam in warning for warning in done["warnings"]), done["warnings"])
                self.assertIsNone(daemon.status()["interrupted"])
                daemon.stop()

    def test_a_changed_model_ticket_or_resin_does_not_go_on(self):
        daemon = self.cut_in_layer_2()
        model = daemon.file("printing", "part.stl")
        resin = self.path("resins", "standard.json")
        for path, told in ((model, "its model or its ticket has changed"), (resin, "the resin's profile")):
            before = os.stat(path)
            with open(path, "ab") as file:
                file.write(b" ")
            self.assert_refusal(daemon.ctl("resume", "--trust-position", "--yes"), FAILED, told)
            self.assert_still(daemon)
            with open(path, "r+b") as file:
                file.truncate(before.st_size)
            os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
        daemon.wait_done("part")

    def test_a_print_whose_printer_has_changed_does_not_go_on(self):
        daemon = self.cut_in_layer_2(supports="auto")
        before = json.loads(json.dumps(daemon.config))
        for changes in ({"supports": "off"}, {"display": {"gamma": 2.2}}, {"z_axis": {"microsteps_per_mm": 1600}}):
            with self.subTest(changes):
                daemon.stop()
                daemon.config = merge(json.loads(json.dumps(before)), changes)
                daemon.write_config()
                daemon.start("--pace", "fast")
                self.assert_refusal(daemon.ctl("resume", "--trust-position", "--yes"), FAILED, "have changed since it began")
                self.assert_still(daemon)
        daemon.stop()
        daemon.config = before
        daemon.write_config()
        daemon.start("--pace", "fast")
        self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
        daemon.wait_done("part")

    def test_a_job_that_cannot_be_read_to_go_on_waits_for_the_user_again(self):
        daemon = self.cut_in_layer_2(model=binary_stl(wedge(10, 5, 3)))
        daemon.stop()
        daemon.config["z_axis"]["travel_mm"] = 2  # less than the part's height
        daemon.write_config()
        daemon.start("--pace", "fast")
        self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
        wait_until(lambda: "the print did not go on" in (daemon.status()["held"] or ""), "the refusal")
        self.assert_still(daemon)
        self.assertTrue(daemon.has("printing", "part.stl"))
        daemon.stop()
        daemon.config["z_axis"]["travel_mm"] = 12
        daemon.write_config()
        daemon.start("--pace", "fast")
        self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
        daemon.wait_done("part")

    def test_a_print_whose_spool_is_not_mounted_at_the_start_holds_the_queue_and_goes_on_once_it_is(self):
        for wait in (False, True):
            with self.subTest(wait_for_plate_cleared=wait):
                job = f"part-{wait}"
                daemon = self.cut_in_layer_2(job, wait_for_plate_cleared=wait)
                daemon.stop()
                os.rename(daemon.spool, self.path("disk"))
                daemon.start("--pace", "fast")
                self.assertIn("its files are not in", daemon.status()["held"])
                daemon.drop("next.stl", RAMP)
                self.looks_pass(daemon)
                self.assert_still(daemon)
                if not wait:
                    self.assert_refusal(daemon.ctl("resume"), FAILED, "its part may hang on the plate", "plate-cleared")
                daemon.stop()
                shutil.rmtree(daemon.spool)
                os.rename(self.path("disk"), daemon.spool)
                daemon.start("--pace", "fast")
                self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
                daemon.wait_done(job)
                daemon.rpc("plate_cleared")
                daemon.stop()

    def test_a_damaged_record_lets_no_job_begin_before_the_plate_is_clear(self):
        daemon = self.cut_in_layer_2(wait_for_plate_cleared=False)
        daemon.stop()
        with open(os.path.join(daemon.state_folder, "print-progress"), "r+b") as file:
            size = os.path.getsize(file.name)
            file.write(b"\xff" * size)
        daemon.start("--pace", "fast")
        for word in ("the record of its progress is damaged", "may hang on the plate", "plate-cleared"):
            self.assertIn(word, daemon.status()["held"])
        daemon.drop("next.stl", RAMP)
        self.assert_refusal(daemon.ctl("resume"), FAILED, "plate-cleared")
        self.looks_pass(daemon)
        self.assert_still(daemon)
        daemon.rpc("plate_cleared")
        daemon.wait_done("next")

    def test_what_was_changed_while_it_printed_holds_after_the_cut(self):
        daemon = self.daemon(realtime(), SLOW, masks=True).start()
        daemon.begin("part.stl", RAMP, {"copies": 2})
        self.wait_layer(daemon, 1, "exposing")
        daemon.rpc("set", setting="exposure", value=110)
        self.assertNotIn("error", daemon.rpc("exclude", copy="1"))
        self.wait_layer(daemon, 3, "exposing")
        daemon.kill()
        daemon.start("--pace", "fast")
        self.assertEqual(daemon.ctl("resume", "--trust-position", "--yes").returncode, OK)
        report = daemon.wait_done("part")
        self.assertEqual(set(self.exposures(report)), {3300})
        self.assertEqual([(each["number"], each["from_layer"]) for each in report["excluded"]], [(1, 3)])
        self.assertEqual([(each["setting"], each["value"], each["from_layer"]) for each in report["changes"]],
                         [("exposure", 110, 3)])  # fmt: skip
        for mask in self.masks("part"):
            middle = mask.width // 2
            self.assertFalse(any(any(row[:middle]) for row in mask.rows))
            self.assertTrue(any(any(row[middle:]) for row in mask.rows))

    def test_a_print_with_its_switch_at_the_top_goes_on_after_a_cut_at_any_instant(self):
        chance = random.Random(int(os.environ.get("SEED", "1")))
        daemon = self.daemon(realtime(z_axis=SWITCH_AT_THE_TOP), QUICK, masks=True).start()
        whole_report, whole = daemon.printed("whole.stl", RAMP), self.masks("whole")
        resumed = 0
        for number in range(int(os.environ.get("CUTS", "8"))):
            job = f"part{number}"
            daemon.begin(job + ".stl", RAMP)
            time.sleep(chance.uniform(0.05, 1.5))
            daemon.kill()
            self.remove_incomplete_mask(job)
            first = self.masks(job)
            daemon.start("--pace", "fast")
            found = daemon.status()["interrupted"]
            if found is not None and "error" not in daemon.rpc("go_on"):
                resumed += 1
                daemon.wait_done(job)
                report, rest = daemon.report(job), self.masks(job)
                self.assertEqual(self.exposures(report), self.exposures(whole_report)[20 - len(rest):])
                self.assertEqual(rest, whole[20 - len(rest):])
                self.assertEqual(first, whole[:len(first)])
                # No layer is missing, and only the one in which the print was cut is lit twice, or the one before, too, if the
                # disk took longer for the record than such a layer, of some hundredths of a second, takes.
                self.assertIn(len(first) + len(rest), (20, 21, 22))
            daemon.rpc("plate_cleared")
            daemon.restart()
        self.assertGreater(resumed, 0)

    def test_a_print_goes_on_by_itself_only_if_the_printer_says_so(self):
        for policy in ("resume", "hold"):
            with self.subTest(policy):
                daemon = self.cut_in_layer_2(policy, z_axis=SWITCH_AT_THE_TOP, after_power_cut=policy)
                if policy == "resume":
                    daemon.wait_done(policy)
                    self.assertIn("the layer was lit again in full", daemon.log())
                    daemon.stop()
                    continue
                daemon.drop("next.stl", binary_stl(cube(2)))
                daemon.wait_status("waiting_for")
                self.looks_pass(daemon)
                self.assert_still(daemon)

    def masks(self, job):
        folder = self.path("masks", job)
        return [read_png(os.path.join(folder, name)) for name in sorted(os.listdir(folder))]

    def remove_incomplete_mask(self, job):
        """Removes the file of the mask at whose writing the simulated display was killed."""
        files = sorted(glob.glob(self.path("masks", job, "*.png")))
        if files and not contents(files[-1]).endswith(b"IEND\xaeB`\x82"):
            os.unlink(files[-1])

    def exposures(self, report):
        return [layer["exposure_asked_ms"] for layer in report["layer_records"]]
