"""A print that a power cut ends: what the next start knows."""

import os
import random
import time

from harness import REALTIME, SLAB, binary_stl, contents, cube, realtime, wait_until
from power_cuts import PHASES, QUICK, SLOW, RAMP, PowerCutTest


class PowerCut(PowerCutTest):
    def test_an_interrupted_print_waits_with_its_layer_and_phase_until_the_user_decides(self):
        daemon = self.daemon(REALTIME, SLOW).start()
        daemon.begin("part.stl", SLAB)
        self.wait_layer(daemon, 2, "exposing")
        daemon.drop("next.stl", binary_stl(cube(2)))
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
