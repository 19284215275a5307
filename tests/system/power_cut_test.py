"""A print that a power cut ends: what the next start knows, and what the user can do. A kill stands for the cut."""

import os
import random
import time
import unittest

from harness import (
    BAD_USAGE, FAILED, NIMBLE_RESIN, OK, REALTIME, SLAB, SpoolTest, binary_stl, contents, cube, read_png, realtime, wait_until, wedge,
)  # fmt: skip

PHASES = ("lowering", "before the light", "lit", "lifting", "raising", "paused", "parking")
# Layers of some hundredths of a second, of which each phase takes a part.
QUICK = {**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 20, "settle_ms": 10, "rest_ms": 10, "lift_mm": 1}


# Layers whose light lasts for seconds, after a wait in which even a slow disk takes the record.
SLOW = {**QUICK, "exposure_ms": 3000, "bottom_exposure_ms": 3000, "settle_ms": 500}


# A part whose masks differ from layer to layer: 20 layers.
RAMP = binary_stl(wedge(10, 5, 1))
SWITCH_AT_THE_TOP = {"homes_upwards": True, "switch_height_mm": 12}


class PowerCutTest(SpoolTest):
    def wait_layer(self, daemon, layer, state):
        wait_until(lambda: (s := daemon.status())["job"] and s["job"].get("layer", 0) == layer and s["state"] == state,
                   f"layer {layer}, {state}")  # fmt: skip

    def cut(self, daemon):
        daemon.kill()
        daemon.start()
        return daemon.status()

    def assert_still(self, daemon):
        status = daemon.status()
        self.assertEqual((status["state"], status["dark"], status["job"]), ("idle", True, None))
        self.assertIsNone(status["manual"]["height_mm"], "the plate was moved")

    def cut_in_layer_2(self, job="part", masks=False, **config):
        """Returns a daemon that was started again after a cut in the light of the job's second layer. Its machine is as fast as
        it can be."""
        daemon = self.daemon(realtime(**config), SLOW, masks=masks).start()
        daemon.begin(job + ".stl", RAMP)
        self.wait_layer(daemon, 2, "exposing")
        daemon.kill()
        return daemon.start("--pace", "fast")


class PowerCut(PowerCutTest):
    def test_an_interrupted_print_waits_with_its_layer_and_phase_until_the_user_decides(self):
        daemon = self.daemon(REALTIME, SLOW).start()
        daemon.begin("part.stl", SLAB)
        self.wait_layer(daemon, 2, "exposing")
        daemon.drop("next.stl", binary_stl(cube(1)))
        daemon.wait_job("next", "ready")
        for _ in range(2):
            status = self.cut(daemon)
            trust = status["interrupted"].pop("trust")
            self.assertRegex(trust, "the plate has stood at 0.100 mm since [-0-9T:]+Z, .* within 2 full steps .*40 um for this screw")
            self.assertEqual(status["interrupted"], {
                "job": "part", "layer": 2, "layers": 20, "phase": "before the light", "light_s": 0, "exposure_s": 3,
                "least_height_mm": 0.1, "most_height_mm": 0.1})  # fmt: skip
            self.assertIn("in layer 2 of 20, before, during or just after its light, with the plate at 0.100 mm", status["held"])
            daemon.wait_status("waiting_for")
            self.looks_pass(daemon)
            self.assert_still(daemon)
            self.assertEqual((daemon.names_in("printing"), daemon.names_in("incoming")), (["part.stl"], ["next.stl"]))
            (end,) = [job for job in daemon.rpc("history")["result"]["ended"] if job["job"] == "part"]
            self.assertEqual(end["outcome"], "failed")
            self.assertIn("in layer 2 of 20", end["reason"])
        self.assertNotIn("error", daemon.rpc("plate_cleared"))
        wait_until(lambda: daemon.has("failed", "part.stl"), "the interrupted job in failed")
        self.assertIn("in layer 2 of 20", daemon.read("failed", "part.reason.txt"))
        daemon.wait_state("exposing")
        self.assertEqual((daemon.status()["job"]["name"], daemon.status()["interrupted"]), ("next", None))

    def test_a_cut_before_the_first_layer_leaves_nothing_to_decide(self):
        daemon = self.daemon({**REALTIME, "projector": {"warm_up_s": 100}}).start()
        daemon.drop("part.stl", SLAB)
        daemon.wait_state("warming up")
        status = self.cut(daemon)
        self.assertIsNone(status["interrupted"])
        self.assertTrue(daemon.has("failed", "part.stl"))

    def test_a_damaged_record_or_one_of_another_version_is_reported_and_nothing_moves(self):
        for damage, told in ((b"contourd-progress 2 ", "is of another version of contourd"), (b"x" * 30, "is damaged")):
            with self.subTest(told):
                daemon = self.daemon(REALTIME, SLOW).start()
                daemon.begin("part.stl", SLAB)
                self.wait_layer(daemon, 2, "exposing")
                daemon.kill()
                with open(os.path.join(daemon.state_folder, "print-progress"), "r+b") as record:
                    for copy in (0, 65536):
                        record.seek(copy)
                        record.write(damage)
                daemon.start()
                self.assertIn(told, daemon.log())
                self.assertIn("part was interrupted", daemon.status()["held"])
                self.assertIsNone(daemon.status()["interrupted"])
                self.assert_still(daemon)
                self.assertTrue(daemon.has("failed", "part.stl"))
                daemon.rpc("plate_cleared")
                daemon.stop()
                os.unlink(daemon.file("failed", "part.stl"))

    def test_after_a_cut_at_any_instant_the_layer_and_the_phase_are_known(self):
        chance = random.Random(int(os.environ.get("SEED", "1")))
        daemon = self.daemon(REALTIME, QUICK).start()
        seen = set()
        for number in range(int(os.environ.get("CUTS", "20"))):
            job = f"part{number}"
            daemon.begin(job + ".stl", SLAB)
            time.sleep(chance.uniform(0.02, 1.5))
            before = daemon.status()
            if before["job"] is None:
                daemon.rpc("plate_cleared")
                continue
            status = self.cut(daemon)
            found = status["interrupted"]
            self.assert_still(daemon)
            if found is not None:
                self.assertEqual((found["job"], found["layers"]), (job, 20))
                self.assertIn(found["phase"], PHASES)
                seen.add(found["phase"])
                # The print goes on between the question and the cut, and a record may be on its way to the disk.
                self.assertLessEqual(abs(found["layer"] - before["job"].get("layer", 1)), 1)
            daemon.rpc("plate_cleared")
            wait_until(lambda: not daemon.names_in("printing"), "the job to be filed")
        self.assertGreater(len(seen), 2)


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


class Record(PowerCutTest):
    def test_the_record_of_a_print_that_was_given_up_is_not_that_of_a_later_job_of_its_name(self):
        for given_up in (True, False):
            with self.subTest(given_up=given_up):
                daemon = self.cut_in_layer_2()
                record = os.path.join(daemon.state_folder, "print-progress")
                if given_up:
                    daemon.rpc("plate_cleared")
                    wait_until(lambda: not os.path.exists(record), "the record to be removed")
                    daemon.stop()
                    self.assertTrue(daemon.has("failed", "part.stl"))
                else:
                    daemon.kill()
                    os.rename(daemon.file("printing", "part.stl"), daemon.file("failed", "part.stl"))
                    daemon.start("--pace", "fast")
                    self.assertIsNone(daemon.status()["interrupted"])
                    daemon.stop()
                self.assertFalse(os.path.exists(record))
                os.unlink(daemon.file("failed", "part.stl"))

    def test_a_record_that_is_not_a_file_is_reported_and_nothing_moves(self):
        for kind in ("FIFO", "folder", "link"):
            with self.subTest(kind):
                daemon = self.cut_in_layer_2(kind)
                daemon.kill()
                record = os.path.join(daemon.state_folder, "print-progress")
                os.rename(record, self.path("record"))
                {"FIFO": os.mkfifo, "folder": os.mkdir, "link": lambda path: os.symlink(self.path("record"), path)}[kind](record)
                daemon.start("--pace", "fast")
                self.assertIn("print-progress cannot be used: it is ", daemon.log())
                self.assertIn(f"{kind} was interrupted", daemon.status()["held"])
                self.assertIsNone(daemon.status()["interrupted"])
                self.assert_still(daemon)
                self.assertTrue(daemon.has("failed", f"{kind}.stl"))
                daemon.rpc("plate_cleared")
                daemon.stop()


PAUSED = b"6"  # the number of PrintPhase::Paused


class Pause(PowerCutTest):
    def paused(self):
        daemon = self.daemon(realtime(z_axis={"travel_mm": 50}), SLOW).start()
        daemon.begin("part.stl", RAMP)
        daemon.rpc("pause")
        daemon.wait_state("paused")
        wait_until(lambda: PAUSED in self.recorded_phases(daemon), "the record of the pause")
        return daemon

    def recorded_phases(self, daemon):
        """Returns the phases in the two copies of the record."""
        record = contents(os.path.join(daemon.state_folder, "print-progress"))
        return [copy.split(b"\0")[7] for copy in (record[:4096], record[65536 : 65536 + 4096]) if copy.count(b"\0") > 7]

    def test_the_plate_leaves_the_height_of_a_pause_only_once_the_record_says_so(self):
        daemon = self.paused()
        record = os.path.join(daemon.state_folder, "print-progress")
        client = daemon.client()
        with daemon.held_thread("contourd-place"):
            before = contents(record)
            client.send(b'{"jsonrpc": "2.0", "id": 1, "method": "resume"}\n')
            time.sleep(0.5)
            self.assertEqual((daemon.status()["state"], contents(record)), ("paused", before))
        self.assertNotIn("error", client.wait_for(lambda message: message.get("id") == 1, "the reply"))
        self.wait_layer(daemon, 2, "exposing")

    def test_a_print_stays_paused_if_the_disk_does_not_answer(self):
        daemon = self.paused()
        with daemon.held_thread("contourd-place"):
            self.assertIn("the disk does not answer", daemon.rpc("resume")["error"]["message"])
            self.assertEqual(daemon.status()["state"], "paused")
        self.assertNotIn("error", daemon.rpc("resume"))
        self.wait_layer(daemon, 2, "exposing")

    def test_after_a_cut_as_a_pause_ends_its_height_is_not_trusted(self):
        daemon = self.paused()
        self.assertIsNotNone(self.cut(daemon)["interrupted"]["trust"])
        daemon.rpc("plate_cleared")
        wait_until(lambda: not daemon.names_in("printing"), "the job to be filed")
        daemon.begin("next.stl", RAMP)
        daemon.rpc("pause")
        daemon.wait_state("paused")
        self.assertNotIn("error", daemon.rpc("resume"))
        found = self.cut(daemon)["interrupted"]
        self.assertLess(found["least_height_mm"], 1)
        self.assertIsNone(found["trust"])


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
                # No layer is missing, and only the one in which the print was cut may be lit twice.
                self.assertIn(len(first) + len(rest), (20, 21))
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
                daemon.drop("next.stl", binary_stl(cube(1)))
                daemon.wait_status("waiting_for")
                self.looks_pass(daemon)
                self.assert_still(daemon)

    def masks(self, job):
        folder = self.path("masks", job)
        return [read_png(os.path.join(folder, name)) for name in sorted(os.listdir(folder))]

    def exposures(self, report):
        return [layer["exposure_asked_ms"] for layer in report["layer_records"]]
