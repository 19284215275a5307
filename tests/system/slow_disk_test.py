"""A disk that does not answer delays neither light nor motor, nor an answer to a client: no file is written on the event loop."""

import os
import signal
import unittest

from harness import ENDLESS, ISLAND, NIMBLE_RESIN, REALTIME, SANITIZED, SLAB, SMALL, Daemon, FolderTest, realtime, text_of, wait_until


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


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class Loop(FolderTest):
    """The event loop's thread makes no call on a file of the spool, the state folder, the configuration or the profiles."""

    maxDiff = None

    def setUp(self):
        super().setUp()
        self.daemon = Daemon(self, realtime(wait_for_plate_cleared=True, ask_before=["islands"], metrics_file="metrics.prom"), {**NIMBLE_RESIN, **ENDLESS})
        self.slow = self.daemon.put_on_slow_disk()
        self.daemon.start()
        self.calm = self.daemon.client()
        self.write("slow/loop", b"")

    def call(self, method, **parameters):
        answer = self.calm.call(method, **parameters)
        self.assertNotIn("error", answer)
        return answer["result"]

    def wait_manual(self, state):
        wait_until(lambda: self.call("status")["manual"]["state"] == state, f"the printer to be {state}")

    def wait_for_log(self, text):
        wait_until(lambda: text in self.daemon.log(), text)

    def end(self):
        """Stops the daemon, and checks that its loop asked the disk for nothing."""
        self.daemon.stop()
        self.check_calls()

    def check_calls(self):
        path = os.path.join(self.slow, "calls")
        calls = sorted(set(text_of(path).splitlines())) if os.path.exists(path) else []
        # The socket and the history are closed when the loop has ended.
        self.assertEqual([call for call in calls if "/control.sock" not in call and "/history.sqlite" not in call], [])

    def test_in_a_print_and_its_pause(self):
        daemon = self.daemon
        daemon.write_resin("quick", {**NIMBLE_RESIN, "exposure_ms": 50, "bottom_exposure_ms": 50})
        daemon.drop("part.stl", SLAB, {"resin": "quick", "copies": 2})
        daemon.wait_state("exposing")
        self.call("pause")
        daemon.wait_state("paused")
        self.call("resume")
        daemon.wait_state("exposing")
        daemon.cancel("part")
        self.call("plate_cleared")
        self.end()

    def test_while_jobs_wait_are_moved_accepted_removed_and_refused(self):
        daemon = self.daemon
        daemon.begin("part.stl", SMALL)
        daemon.drop("island.stl", ISLAND)
        self.wait_for_log("contourctl accept island")
        daemon.drop("other.stl", SMALL, {"resin": "standard"})
        daemon.drop("bad.stl", b"no model")
        daemon.wait_refused("bad")
        daemon.drop("bad-ticket.stl", SMALL, "no ticket")
        daemon.wait_refused("bad-ticket")
        daemon.drop_plate("plate", {"models": [{"file": "a.stl"}]}, {"a.stl": SMALL})
        self.wait_for_log("plate: arrived")
        self.call("accept", job="island")
        self.call("queue_move", job="plate", to=1)
        self.call("queue_remove", job="other")
        self.call("history")
        self.call("queue")
        self.end()

    def test_by_hand_and_with_an_occupied_plate(self):
        daemon = self.daemon
        daemon.begin("part.stl", SMALL)
        daemon.cancel("part")
        daemon.drop("next.stl", SMALL)
        self.wait_for_log("next.stl waits")
        self.call("home", plate_is_clear=True)
        self.wait_manual("idle")
        self.call("light_on", seconds=30, in_resin=True)
        self.wait_manual("lit")
        self.call("stop")
        self.wait_manual("idle")
        self.call("plate_cleared")
        daemon.wait_state("exposing")
        self.end()

    def test_at_a_stop_while_the_next_job_is_read(self):
        daemon = self.daemon
        daemon.begin("part.stl", SMALL)
        for name in ("other", "next"):
            daemon.drop(name + ".stl", SMALL)
            daemon.wait_job(name, "ready")
        # Only the next job's preparation is kept until its turn.
        self.call("queue_move", job="next", to=1)
        models, writes = os.path.join(self.slow, "models"), os.path.join(self.slow, "writes")
        self.write(models, b"")
        daemon.cancel("part")
        self.call("plate_cleared")
        wait_until(lambda: os.path.exists(os.path.join(self.slow, "waiting")), "the model to be read")
        self.write(writes, b"")
        os.unlink(os.path.join(self.slow, "waiting"))
        daemon.process.send_signal(signal.SIGTERM)
        wait_until(lambda: os.path.exists(os.path.join(self.slow, "waiting")), "the job to be moved")
        for _ in range(3):
            self.assertEqual(self.call("status")["job"]["name"], "next")
        os.unlink(writes)
        wait_until(lambda: daemon.has("incoming", "next.stl"), "the job to be given back")
        os.unlink(models)
        daemon.wait_stopped()
        self.check_calls()
