"""A disk that does not answer delays neither light nor motor, nor an answer to a client: no file is written on the event loop."""

import os
import unittest

from harness import NIMBLE_RESIN, REALTIME, SANITIZED, Daemon, FolderTest, binary_stl, box, realtime, wait_until

SMALL = binary_stl(box((0, 0, 0), (10, 5, 0.2)))


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class SlowDisk(FolderTest):
    def occupied(self, **config):
        """Starts a daemon whose plate holds a part, homes it by hand, and stops its disk."""
        self.daemon = Daemon(self, realtime(wait_for_plate_cleared=True, **config), NIMBLE_RESIN)
        self.gate = os.path.join(self.daemon.put_on_slow_disk(), "writes")
        os.mkdir(self.daemon.state_folder, 0o700)
        self.write(os.path.join(self.daemon.state_folder, "plate-occupied"), b"part\n")
        self.daemon.start()
        self.client = self.daemon.client()
        self.by_hand("home", plate_is_clear=True)
        self.wait_for("idle")
        self.write(self.gate, b"")

    def by_hand(self, method, **parameters):
        answer = self.client.call(method, **parameters)
        self.assertNotIn("error", answer)
        return answer["result"]

    def wait_for(self, state):
        wait_until(lambda: self.daemon.status()["manual"]["state"] == state, f"the printer to be {state}")

    def clear_plate(self):
        """Reports the plate as clear, which is answered when it is on the disk, and waits until a thread waits for the disk."""
        self.clearing = self.daemon.client()
        self.clearing.send(b'{"jsonrpc": "2.0", "method": "plate_cleared", "id": 1}\n')
        wait_until(lambda: os.path.exists(os.path.join(os.path.dirname(self.gate), "waiting")), "a thread to wait for the disk")

    def end(self):
        self.assertTrue(os.path.exists(self.gate))  # all that was waited for happened without the disk
        os.unlink(self.gate)
        self.assertEqual(self.clearing.next()["result"]["plate"], "clear")
        self.daemon.stop()

    def test_light_by_hand_goes_off_at_its_end(self):
        self.occupied()
        self.by_hand("light_on", seconds=0.5, in_resin=True)
        self.wait_for("lit")
        self.clear_plate()
        self.wait_for("idle")
        self.assertTrue(self.daemon.status()["dark"])
        self.end()

    def test_a_motion_is_stopped(self):
        self.occupied(z_axis={"travel_speed_mm_s": 2, "travel_mm": 100})
        self.by_hand("move", to_mm=90)
        self.wait_for("moving")
        self.clear_plate()
        self.by_hand("stop")
        self.wait_for("idle")
        self.assertLess(self.daemon.status()["manual"]["height_mm"], 90)
        self.end()


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class Order(FolderTest):
    def test_a_print_begins_only_when_the_disk_has_recorded_that_the_plate_is_not_clear(self):
        daemon = Daemon(self, REALTIME, NIMBLE_RESIN)
        gate = os.path.join(daemon.put_on_slow_disk(), "plate")
        daemon.start()
        self.write(gate, b"")
        daemon.drop("part.stl", SMALL)
        wait_until(lambda: daemon.status()["state"] == "preparing" and os.path.exists(os.path.join(os.path.dirname(gate), "waiting")),
                   "the record to wait for the disk")  # fmt: skip
        for _ in range(3):
            self.assertEqual(daemon.status()["state"], "preparing")
        os.unlink(gate)
        self.assertEqual(daemon.wait_done("part")["layers_exposed"], 4)
        self.assertEqual(daemon.status()["plate_job"], "part")
        daemon.stop()

    def test_a_job_that_is_moved_to_printing_delays_no_answer(self):
        daemon = Daemon(self, REALTIME, NIMBLE_RESIN)
        gate = os.path.join(daemon.put_on_slow_disk(), "writes")
        daemon.start()
        self.write(gate, b"")
        daemon.drop("part.stl", SMALL)
        wait_until(lambda: os.path.exists(os.path.join(os.path.dirname(gate), "waiting")), "the move to wait for the disk")
        for _ in range(3):
            self.assertEqual(daemon.status()["state"], "idle")
        self.assertTrue(os.path.exists(gate))
        os.unlink(gate)
        self.assertEqual(daemon.wait_done("part")["layers_exposed"], 4)
        daemon.stop()
