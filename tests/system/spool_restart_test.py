"""The spool: what becomes of jobs when the daemon stops, and when the disk is slow, full or read-only."""

import json
import os
import signal
import unittest

from harness import (
    CONTOURD, ENDLESS, MAKE_MODEL, NIMBLE_RESIN, REALTIME, SANITIZED, SLAB, WAITS, SpoolTest, binary_stl, box, realtime, run, wait_until,
)  # fmt: skip

THIN = binary_stl(box((0, 0, 0), (10, 5, 0.05)))  # a single layer


class Interruption(SpoolTest):
    def test_a_killed_print_is_filed_when_the_user_has_cleared_the_plate(self):
        daemon = self.printing_daemon(**WAITS)
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.kill()
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.start()
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), (["first.stl"], []))
        status = daemon.status()
        self.assertEqual((status["state"], status["plate"], status["plate_job"]), ("idle", "occupied", "first"))
        daemon.drop("next.stl", SLAB)
        daemon.wait_status("waiting_for")
        daemon.rpc("plate_cleared")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.names_in("printing"), ["next.stl"])
        self.assertIn("first.stl", daemon.names_in("failed"))
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))

    def test_after_a_killed_or_stopped_print_the_next_job_waits_for_the_user(self):
        # This is so even if no plate must be cleared.
        daemon = self.printing_daemon()
        for ended, end, release, following in (("first", daemon.kill, "plate_cleared", "second"),
                                               ("second", daemon.stop, "resume", "third")):  # fmt: skip
            with self.subTest(ended):
                daemon.drop(following + ".stl", SLAB)
                # Waits until the job has been read, since a kill during the reading would have it refused.
                daemon.wait_job(following, "ready")
                end()
                for _ in range(2):
                    daemon.start()
                    wait_until(lambda: daemon.status()["queued"] or daemon.status()["job"], "the next job")
                    self.looks_pass(daemon)
                    status = daemon.status()
                    self.assertEqual((status["state"], status["plate_job"]), ("idle", ended))
                    self.assertIn(ended, status["held"])
                    self.assertEqual(daemon.names_in("incoming"), [following + ".stl"])
                    daemon.stop()
                daemon.start()
                self.assertNotIn("error", daemon.rpc(release))
                daemon.wait_state("exposing")
                self.assertEqual(daemon.status()["job"]["name"], following)

    def test_a_killed_print_keeps_its_ticket(self):
        daemon = self.printing_daemon()
        daemon.rpc("cancel")
        daemon.begin("second.stl", SLAB, {"copies": 2})
        daemon.kill()
        daemon.start()
        daemon.rpc("plate_cleared")
        wait_until(lambda: daemon.has("failed", "second.stl"), "the killed job in failed")
        self.assertEqual(json.loads(daemon.read("failed", "second.json")), {"copies": 2})

    def end_by_signal(self, number):
        daemon = self.printing_daemon(**WAITS)
        daemon.process.send_signal(number)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertIn("light off", daemon.log().splitlines()[-1])
        self.assertFalse(os.path.exists(daemon.socket_path))
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertIn("stopped", daemon.read("failed", "first.reason.txt"))
        report = daemon.report("first", "failed")
        self.assertEqual(report["outcome"], "failed")
        self.assertIn("stopped", report["reason"])
        daemon.start()
        # The first layer was exposed in part, so something may stick to the plate.
        self.assertEqual(daemon.status()["plate"], "occupied")
        return daemon

    def test_sigterm_ends_a_print_with_the_light_off_and_a_restart_works(self):
        daemon = self.end_by_signal(signal.SIGTERM)
        daemon.rpc("plate_cleared")
        daemon.begin("next.stl", SLAB)
        self.assertEqual(daemon.status()["job"]["name"], "next")

    def test_sigint_ends_a_print_with_the_light_off(self):
        self.end_by_signal(signal.SIGINT).stop()

    def test_a_print_cancelled_in_its_first_exposure_leaves_the_plate_occupied(self):
        daemon = self.printing_daemon(**WAITS)
        daemon.cancel("first")
        self.assertEqual(daemon.status()["plate"], "occupied")

    def test_a_job_that_fails_before_its_first_exposure_does_not_clear_the_plate(self):
        daemon = self.daemon().start()
        daemon.printed("one.stl", SLAB)
        daemon.stop()
        daemon.config["simulation"]["limit_switch"] = "stuck_open"
        daemon.write_config()
        daemon.start()
        daemon.refused("two.stl", SLAB)
        status = daemon.status()
        self.assertEqual((status["plate"], status["plate_job"]), ("occupied", "one"))

    def test_a_job_that_is_being_read_at_sigterm_is_printed_at_the_next_start(self):
        large = self.path("large.stl")
        self.assertEqual(run(MAKE_MODEL, "gyroid-sphere", large, "120").returncode, 0)
        daemon = self.daemon(WAITS).start()
        os.rename(large, daemon.file("incoming", "large.stl"))
        daemon.wait_job("large", "checking")
        daemon.stop()
        os.replace(self.write("small", SLAB), os.fsencode(daemon.file("incoming", "large.stl")))
        daemon.start()
        self.assertFalse(daemon.has("failed", "large.stl"), "nothing was printed, yet it counts as interrupted")
        daemon.wait_done("large")

    def test_a_job_whose_ticket_alone_was_claimed_before_a_power_cut_keeps_its_ticket(self):
        # A claim renames two files. The power was cut in between.
        daemon = self.daemon()
        daemon.drop("part.stl", SLAB, {"copies": 3})
        os.makedirs(daemon.file("printing"))
        os.rename(daemon.file("incoming", "part.json"), daemon.file("printing", "part.json"))
        daemon.start()
        end = daemon.wait_next_end()
        if end["outcome"] == "done":
            self.assertEqual(daemon.report(end["job"])["model"]["copies"], 3)

    def test_a_job_whose_ticket_was_not_claimed_yet_keeps_its_ticket(self):
        # The model was claimed before its ticket. A ticket that is younger than the claim belongs to another job.
        daemon = self.daemon()
        for name in ("part", "other"):
            daemon.drop(name + ".stl", SLAB, {"copies": 3} if name == "part" else None)
            os.makedirs(daemon.file("printing"), exist_ok=True)
            os.rename(daemon.file("incoming", name + ".stl"), daemon.file("printing", name + ".stl"))
        self.write(os.path.relpath(daemon.file("incoming", "other.json"), self.path()), b"{}")
        daemon.start()
        self.assertTrue(daemon.has("failed", "part.json"))
        self.assertFalse(daemon.has("failed", "other.json"))
        self.assertEqual(daemon.names_in("incoming"), ["other.json"])

    def test_a_filed_job_gets_its_ticket_that_was_not_filed_yet(self):
        daemon = self.daemon()
        for folder in ("done", "failed"):
            daemon.drop(folder + ".stl", SLAB, {"copies": 3})
            os.makedirs(daemon.file(folder), exist_ok=True)
            os.makedirs(daemon.file("printing"), exist_ok=True)
            os.rename(daemon.file("incoming", folder + ".stl"), daemon.file(folder, folder + ".stl"))
            os.rename(daemon.file("incoming", folder + ".json"), daemon.file("printing", folder + ".json"))
        daemon.start()
        for folder in ("done", "failed"):
            self.assertEqual(daemon.names_in(folder), [folder + ".json", folder + ".stl"])

    def test_a_refused_job_is_filed_with_a_reason_that_was_written_earlier(self):
        daemon = self.daemon().start()
        self.write(os.path.relpath(daemon.file("failed", "bad.reason.txt"), self.path()), b"not a usable model")
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.names_in("failed"), ["bad.reason.txt", "bad.stl"])

    def test_a_second_daemon_does_not_touch_the_spool_of_the_first(self):
        daemon = self.printing_daemon()
        second = run(CONTOURD, "--config", daemon.config_path)
        self.assertNotEqual(second.returncode, 0)
        self.assert_one_line(second.stderr.splitlines(keepends=True)[-1], "another contourd")
        with_another_socket = self.second_daemon("other", daemon.config)
        with_another_socket.launch()
        self.assertNotEqual(with_another_socket.process.wait(30), 0)
        self.assertIn("another contourd uses the spool", with_another_socket.log())
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), (["first.stl"], []))
        self.assertEqual(daemon.status()["state"], "exposing")


class Outcome(SpoolTest):
    def test_a_print_whose_done_folder_was_removed_is_done(self):
        daemon = self.daemon().start()
        os.rmdir(daemon.file("done"))
        daemon.printed("part.stl", SLAB)
        self.assertTrue(daemon.has("done", "part.stl"))

    def test_a_print_that_cannot_be_filed_is_filed_at_the_next_start_with_its_outcome(self):
        daemon = self.daemon().start()
        os.rmdir(daemon.file("done"))
        self.write(daemon.file("done"), b"")
        daemon.drop("part.stl", SLAB)
        self.assertEqual(daemon.wait_ended("part")["outcome"], "done")
        self.assertEqual(daemon.names_in("printing"), ["part.stl"])
        daemon.drop("next.stl", SLAB)
        status = daemon.wait_status("waiting_for")
        self.assertIn("part is not filed yet", status["waiting_for"])
        # Files are read one after the other. A file that is being read when the daemon is killed would not be read again.
        daemon.refused("last.stl", b"no model")
        daemon.kill()
        os.unlink(daemon.file("done"))
        daemon.start()
        self.assertIn("contourd stopped before it moved the files of this print, which was done", daemon.log())
        self.assertTrue(daemon.has("done", "part.stl"))
        daemon.wait_done("next")
        self.assertEqual(daemon.names_in("failed"), ["last.reason.txt", "last.stl"])

    def test_partly_written_files_of_a_killed_daemon_are_removed_at_the_start(self):
        daemon = self.daemon().start()
        daemon.kill()
        left = [daemon.file(folder, ".contourd-0123456789abcdef.new") for folder in ("printing", "done", "failed")]
        left.append(os.path.join(daemon.spool + ".state", ".contourd-0123456789abcdef.new"))
        for path in left:
            self.write(path, b"")
        os.mkdir(daemon.file("printing", ".copies"))
        self.write(daemon.file("printing", ".copies", "half.stl"), b"")
        daemon.start()
        self.assertEqual([path for path in left if os.path.lexists(path)], [])
        self.assertEqual(daemon.names_in("printing"), [])


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class SlowDisk(SpoolTest):
    """A print goes on while the disk does not answer, as slow cards do for seconds."""

    def printing_on_slow_disk(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, "exposure_ms": 150, "bottom_exposure_ms": 150})
        slow = daemon.put_on_slow_disk()
        daemon.start()
        daemon.begin("part.stl", SLAB)
        return daemon, slow

    def goes_on(self, daemon, slow, gate):
        """Asserts that layers are printed while the daemon waits for the disk; then lets the disk answer again."""
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "a thread to wait for the disk")
        done = daemon.status()["job"]["layers_done"]
        daemon.watcher.wait_for(
            lambda m: m.get("method") == "layer" and m["params"]["job"]["layers_done"] >= done + 3, "three layers")
        self.assertTrue(os.path.exists(os.path.join(slow, gate)))
        os.unlink(os.path.join(slow, gate))

    def test_a_refusal_that_waits_for_the_disk_does_not_delay_a_print(self):
        daemon, slow = self.printing_on_slow_disk()
        self.write(os.path.join(slow, "writes"), b"")
        daemon.drop("bad.stl", b"no model")
        self.goes_on(daemon, slow, "writes")
        self.assertIn("bad.stl", "".join(daemon.names_in("failed") + daemon.names_in("incoming")))
        daemon.wait_refused("bad")
        self.assertTrue(daemon.has("failed", "bad.stl"))
        self.assertEqual(daemon.wait_done("part")["layers_exposed"], 20)
        self.assertNotIn("removed from incoming", daemon.log())

    def test_a_file_that_is_removed_while_it_is_refused_leaves_the_queue(self):
        daemon = self.daemon(WAITS)
        slow = daemon.put_on_slow_disk()
        daemon.environment["STATE_DIRECTORY"] = self.path("state")  # on another disk, which answers
        daemon.start()
        daemon.printed("first.stl", SLAB)
        self.write(os.path.join(slow, "writes"), b"")
        daemon.drop("bad.stl", b"no model")
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the refusal to wait for the disk")
        os.rename(daemon.file("incoming", "bad.stl"), self.path("bad.stl"))
        for _ in range(2):
            daemon.status()  # once it answers, the daemon has seen the events
        self.assertEqual(daemon.status()["queued"], 1)
        os.unlink(os.path.join(slow, "writes"))
        wait_until(lambda: daemon.status()["queued"] == 0, "the queue to be empty", 10)
        self.assertIn("bad.stl: removed from incoming by a user", daemon.log())
        self.assertFalse(daemon.has("failed", "bad.reason.txt"))

    def arrives(self, name):
        daemon, slow = self.printing_on_slow_disk()
        self.write(os.path.join(slow, "reads"), b"")
        os.rename(self.path(name), daemon.file("incoming", name))
        self.goes_on(daemon, slow, "reads")
        daemon.wait_done("part")
        daemon.wait_done("next")
        daemon.stop()

    def test_a_look_at_a_model_that_waits_for_the_disk_does_not_delay_a_print(self):
        self.write("next.stl", THIN)
        self.arrives("next.stl")

    def test_a_look_at_a_plate_that_waits_for_the_disk_does_not_delay_a_print(self):
        os.mkdir(self.path("next"))
        self.write("next/next.stl", THIN)
        self.write("next/plate.json", json.dumps({"models": [{"file": "next.stl"}]}))
        self.arrives("next")


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class SlowFiling(SpoolTest):
    """A print is over, but its report or picture waits for the disk."""

    def finishing_daemon(self, gate="pictures", end="cancel", resin=None):
        daemon = self.daemon(REALTIME, resin or {**NIMBLE_RESIN, **ENDLESS})
        slow = daemon.put_on_slow_disk()
        self.gate = os.path.join(slow, gate)
        daemon.start()
        daemon.begin("first.stl", SLAB)
        self.write(self.gate, b"")
        if end:
            daemon.rpc(end)
        daemon.wait_status("state", "finishing")
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the archivist to wait for the disk")
        return daemon

    def test_while_a_print_is_filed_the_daemon_answers_and_the_next_job_waits(self):
        daemon = self.finishing_daemon()
        daemon.drop("next.stl", SLAB)
        self.assertIn("no print", daemon.rpc("cancel")["error"]["message"])
        status = daemon.wait_status("queued")
        self.assertEqual((status["state"], status["job"]["name"], status["last"]), ("finishing", "first", None))
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("incoming")), (["first.stl"], ["next.stl"]))
        self.assertEqual(daemon.rpc("plate_cleared")["result"]["plate"], "clear")
        os.unlink(self.gate)
        self.assertEqual(daemon.wait_ended("first")["outcome"], "cancelled")
        self.assertTrue(daemon.has("failed", "first.stl"))
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "next")

    def test_a_stop_waits_until_the_print_is_filed(self):
        daemon = self.finishing_daemon()
        daemon.process.send_signal(signal.SIGTERM)
        daemon.wait_status("state", "finishing")
        os.unlink(self.gate)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertTrue(daemon.has("failed", "first.preview.png"))

    def test_a_stop_waits_only_some_seconds_for_a_disk_that_does_not_answer(self):
        daemon = self.finishing_daemon()
        daemon.process.send_signal(signal.SIGTERM)
        # The daemon waits 15 s for the disk, and there is no other event to wait for.
        wait_until(lambda: "not filed after 15 s" in daemon.log(), "the daemon to give up")
        wait_until(lambda: "contourd has stopped" in daemon.log(), "the daemon to stop")
        os.unlink(self.gate)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertEqual((daemon.names_in("printing"), daemon.has("failed", "first.stl")), ([], True))

    def restarted_after_kill(self, daemon):
        daemon.kill()
        os.unlink(self.gate)
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.start()
        self.assertEqual(daemon.names_in("printing"), [])
        return daemon

    def test_a_done_print_that_was_killed_before_it_was_filed_is_done(self):
        daemon = self.finishing_daemon(end=None, resin={**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 20})
        self.restarted_after_kill(daemon)
        self.assertIn("first.stl", daemon.names_in("done"))
        self.assertEqual(daemon.names_in("failed"), [])
        self.assertEqual(daemon.report("first")["outcome"], "done")
        self.assertIn("was done", daemon.log())
        status = daemon.status()
        self.assertEqual((status["plate_job"], status["held"]), ("first", None))

    def test_a_cancelled_print_that_was_killed_before_it_was_filed_does_not_hold_the_queue(self):
        daemon = self.restarted_after_kill(self.finishing_daemon())
        self.assertIn("Cancelled", daemon.read("failed", "first.reason.txt"))
        self.assertIsNone(daemon.status()["held"])

    def test_a_failed_print_that_was_killed_before_it_was_filed_holds_the_queue_with_its_reason(self):
        # Homing fails, since the limit switch never closes.
        daemon = self.daemon(realtime(simulation={"limit_switch": "stuck_open"}), NIMBLE_RESIN)
        slow = daemon.put_on_slow_disk()
        self.gate = os.path.join(slow, "pictures")
        self.write(self.gate, b"")
        daemon.start()
        daemon.drop("first.stl", SLAB)
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the archivist to wait for the disk")
        self.restarted_after_kill(daemon)
        self.assertIn("homing failed", daemon.read("failed", "first.reason.txt"))
        self.assertIn("homing failed", daemon.status()["held"])

    def test_a_print_that_was_killed_before_its_outcome_was_stored_counts_as_interrupted(self):
        daemon = self.restarted_after_kill(self.finishing_daemon("writes"))
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        self.assertIn("first", daemon.status()["held"])


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class DiskThatTakesNothing(SpoolTest):
    def printing_daemon(self, **config):
        daemon = self.daemon(realtime(**config), {**NIMBLE_RESIN, **ENDLESS})
        self.slow = daemon.put_on_slow_disk()
        daemon.start()
        daemon.begin("first.stl", SLAB)
        return daemon

    def becomes(self, state):
        self.write(os.path.join(self.slow, state), b"")

    def is_repaired(self, state):
        os.unlink(os.path.join(self.slow, state))

    def test_a_print_cancelled_on_a_full_disk_is_filed_without_its_reason(self):
        daemon = self.printing_daemon()
        self.becomes("full")
        daemon.cancel("first")
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), ([], ["first.stl"]))
        self.assertIn("cannot write its reason file", daemon.log())
        self.assertIn("no report", daemon.log())

    def restarts_on_a_disk_that_is(self, state):
        """Kills a daemon during a print and restarts it on this disk, twice. No job begins and nothing is lost; once the disk is
        repaired, the interrupted print is filed. Returns the log up to the repair."""
        daemon = self.printing_daemon()
        daemon.drop("next.stl", SLAB)
        # A file that is being read when the daemon is killed would not be read again.
        daemon.refused("bad.stl", b"no model")
        for name in ("bad.stl", "bad.reason.txt"):
            os.unlink(daemon.file("failed", name))
        self.becomes(state)
        for _ in range(2):
            daemon.kill()
            daemon.start()
            status = daemon.wait_status("waiting_for")
            self.assertEqual((status["plate_job"], status["queued"]), ("first", 1))
            self.assertIn("first", status["held"])
            self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), (["first.stl"], []))
        log = daemon.log()
        self.assertNotIn("moved to failed", log)
        self.assertEqual(state == "read-only", "ReadWritePaths" in log)
        self.assertEqual(log.count("cannot save the state for the next start"), 2, log)
        self.is_repaired(state)
        daemon.drop("more.stl", SLAB)
        wait_until(lambda: "queue-held" in os.listdir(daemon.state_folder), "the hold on the disk")
        self.assertIn("first", daemon.state("queue-held"))
        daemon.rpc("plate_cleared")
        wait_until(lambda: daemon.has("failed", "first.stl"), "first in failed")
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        daemon.wait_state("exposing")
        self.assertEqual(daemon.names_in("printing"), ["next.stl"])
        daemon.stop()
        return log

    def test_the_error_about_a_spool_that_cannot_be_made_names_the_unit_s_setting(self):
        daemon = self.daemon(REALTIME)
        self.slow = daemon.put_on_slow_disk()
        self.becomes("read-only")
        daemon.launch()
        self.assertGreater(daemon.process.wait(30), 0)
        self.assertIn("ReadWritePaths", daemon.log())

    def test_the_daemon_starts_on_a_full_disk_after_a_kill(self):
        self.assertIn("No space left", self.restarts_on_a_disk_that_is("full"))

    def test_the_daemon_starts_on_a_read_only_disk_after_a_kill(self):
        self.assertIn("Read-only file system", self.restarts_on_a_disk_that_is("read-only"))

    def test_a_job_that_cannot_be_claimed_stays_in_the_queue_and_is_tried_again(self):
        daemon = self.printing_daemon()
        self.becomes("printing-read-only")
        for name in ("one", "two"):
            daemon.drop(name + ".stl", SLAB)
        daemon.wait_status("queued", 2)
        daemon.cancel("first")
        status = daemon.wait_status("waiting_for")
        self.assertEqual(status["queued"], 2)
        self.assertIn("one.stl cannot be claimed", status["waiting_for"])
        for name in ("three", "four"):  # each arrival makes the daemon try the first job again
            daemon.drop(name + ".stl", SLAB)
        daemon.wait_status("queued", 4)
        self.assertEqual(daemon.log().count("cannot be claimed"), 1, daemon.log())
        self.is_repaired("printing-read-only")
        daemon.begin("five.stl", SLAB)
        self.assertEqual(daemon.status()["job"]["name"], "one")
        self.assertIsNone(daemon.status()["waiting_for"])
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], ["two.stl", "three.stl", "four.stl", "five.stl"])

    def test_a_print_goes_on_if_incoming_is_removed_and_cannot_be_made_again(self):
        daemon = self.printing_daemon()
        self.becomes("read-only")
        os.rmdir(daemon.file("incoming"))
        wait_until(lambda: "incoming folder" in daemon.log(), "the warning")
        self.assertEqual(daemon.status()["state"], "exposing")
        self.is_repaired("read-only")
        wait_until(lambda: daemon.has("incoming"), "the new incoming folder")
        daemon.drop("next.stl", SLAB)
        daemon.wait_status("queued", 1)
        self.assertEqual(daemon.log().count("incoming folder"), 1)
