"""A print that a power cut ends: what the next start knows, and what the user can do. A kill stands for the cut."""

import os
import random
import time
import unittest

from harness import NIMBLE_RESIN, REALTIME, SLAB, SpoolTest, binary_stl, cube, wait_until

PHASES = ("lowering", "before the light", "lit", "lifting", "raising", "paused", "parking")
# Layers of some hundredths of a second, of which each phase takes a part.
QUICK = {**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 20, "settle_ms": 10, "rest_ms": 10, "lift_mm": 1}


# Layers whose light lasts for seconds.
SLOW = {**QUICK, "exposure_ms": 3000, "bottom_exposure_ms": 3000}


class PowerCut(SpoolTest):
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

    def test_an_interrupted_print_waits_with_its_layer_and_phase_until_the_user_decides(self):
        daemon = self.daemon(REALTIME, SLOW).start()
        daemon.begin("part.stl", SLAB)
        self.wait_layer(daemon, 2, "exposing")
        daemon.drop("next.stl", binary_stl(cube(1)))
        daemon.wait_job("next", "ready")
        for _ in range(2):
            status = self.cut(daemon)
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
