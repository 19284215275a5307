"""Memory: a job's need is known before the job is read, and a model that ended the daemon is not read again."""

import contextlib
import json
import os
import signal
import struct
import unittest

from harness import BAD_DATA, ENDLESS, MAKE_MODEL, NIMBLE_RESIN, SANITIZED, SLAB, Daemon, FolderTest, contourctl, realtime, run, wait_until

HUGE = 85_899_344  # facets of 4 GB
# The cells of a ball, and a limit in MB that is enough to print one ball but not to read a second one at the same time.
CELLS = 200
LIMIT_FOR_ONE = 180


def sparse_stl(path, facets):
    """Writes a sparse file with this number of facets, all at the origin; it takes no room on the disk."""
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", facets))
        file.truncate(84 + 50 * facets)


@contextlib.contextmanager
def control_group(limit):
    """Yields the folder of a new control group (version 1 or 2) with this limit in bytes, or None if none can be made."""
    for root, limit_name in (("/sys/fs/cgroup", "memory.max"), ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")):
        group = os.path.join(root, f"contourd-test-{os.getpid()}")
        try:
            os.mkdir(group)
        except OSError:
            continue
        try:
            with open(os.path.join(group, limit_name), "r+", encoding="ascii") as file:
                file.write(str(limit))
        except OSError:
            os.rmdir(group)
            continue
        yield group
        os.rmdir(group)
        return
    yield None


class MemoryTest(FolderTest):
    def daemon(self, config=None, resin=None):
        return Daemon(self, realtime(**(config or {})), resin or {**NIMBLE_RESIN, **ENDLESS})

    def sphere(self, name, cells):
        path = self.path(name)
        self.assertEqual(run(MAKE_MODEL, "sphere", path, str(cells)).returncode, 0)
        return path

    def put_ball(self, daemon, name):
        """Puts a ball of 8 mm into the spool as a job of this name."""
        with open(daemon.file("incoming", name + ".json"), "w", encoding="ascii") as file:
            json.dump({"scale": 0.2}, file)
        self.put(daemon, self.sphere(name + ".stl", CELLS))

    def put(self, daemon, path):
        os.rename(path, daemon.file("incoming", os.path.basename(path)))

    def put_sparse(self, daemon, name, facets):
        sparse_stl(self.path(name), facets)
        self.put(daemon, self.path(name))

    def peak_bytes(self, daemon):
        with open(f"/proc/{daemon.process.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) * 1024 for line in file if line.startswith("VmHWM"))


@unittest.skipIf(SANITIZED, "memory limits are not tested with AddressSanitizer")
class Room(MemoryTest):
    def test_a_model_that_exceeds_the_limit_is_refused_during_a_print_without_being_read(self):
        daemon = self.daemon({"memory_limit_mb": 400}).start()
        daemon.begin("part.stl", SLAB)
        self.put_sparse(daemon, "huge.stl", HUGE)
        reason = daemon.wait_refused("huge")
        self.assertIn(f"the model holds {HUGE} facets, for which ", reason)
        self.assertRegex(reason, r"there is room for 3\d\d MB: memory_limit_mb is 400, and contourd holds \d+ MB")
        self.assertLess(self.peak_bytes(daemon), 100e6)
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_the_limit_of_a_control_group_applies_without_memory_limit_mb(self):
        with control_group(900_000_000) as group:
            if group is None:
                self.skipTest("no control group can be made")
            daemon = self.daemon()

            def join():
                self.write(os.path.join(group, "cgroup.procs"), str(os.getpid()))

            daemon.rights = {"preexec_fn": join}
            daemon.start()
            daemon.begin("part.stl", SLAB)
            self.put_sparse(daemon, "huge.stl", HUGE)
            self.assertRegex(daemon.wait_refused("huge"), r"\d+ MB are available in the control group, of which 64 MB stay free")
            self.assertEqual(daemon.status()["state"], "exposing")
            daemon.stop()

    def test_a_model_without_enough_memory_during_a_print_waits_for_its_end_and_is_printed(self):
        daemon = self.daemon({"memory_limit_mb": LIMIT_FOR_ONE}).start()
        self.put_ball(daemon, "first")
        daemon.wait_state("exposing")
        self.put_ball(daemon, "second")
        why = wait_until(lambda: daemon.status()["postponed"].get("second.stl"), "the second job to be postponed")
        self.assertRegex(why, r"for which \d+ MB of memory are needed, and there is room for \d+ MB: memory_limit_mb is")
        self.assertEqual(daemon.status()["postponed_more"], 0)
        self.assertIn(b"postponed second.stl: the model holds", daemon.ctl("status").stdout)
        self.assertIn("second.stl: will be read later, because there is not enough memory now: the model holds", daemon.log())
        # Small models are read meanwhile.
        daemon.refused("bad.stl", b"no model")
        daemon.rpc("cancel")
        wait_until(lambda: (daemon.status()["job"] or {}).get("name") == "second", "the second job to start")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["postponed"], {})
        self.assertLess(self.peak_bytes(daemon), LIMIT_FOR_ONE * 1e6)

    def test_a_postponed_model_is_read_after_the_print_even_before_its_turn(self):
        daemon = self.daemon({"memory_limit_mb": LIMIT_FOR_ONE, "wait_for_plate_cleared": True}).start()
        self.put_ball(daemon, "first")
        daemon.wait_state("exposing")
        self.put_ball(daemon, "second")
        wait_until(lambda: "second.stl" in daemon.status()["postponed"], "the second job to be postponed")
        daemon.rpc("cancel")
        wait_until(lambda: not daemon.status()["postponed"], "the second job to be read", 60)
        self.assertEqual(daemon.status()["queued"], 1)

    def test_only_the_next_job_is_prepared_during_a_print(self):
        daemon = self.daemon({"memory_limit_mb": 400}).start()
        daemon.begin("part.stl", SLAB)
        for job in ("next", "last"):
            daemon.drop(job + ".stl", SLAB)
        # Jobs are checked in their order, so these two have been checked when bad has.
        daemon.refused("bad.stl", b"no model")
        for job in ("next", "last"):
            daemon.rpc("cancel")
            wait_until(lambda job=job: (daemon.status()["job"] or {}).get("name") == job, "the job to start")
            daemon.wait_state("exposing")
        ready = [line for line in daemon.log().splitlines() if "first mask after" in line]
        self.assertEqual(["prepared while it waited" in line for line in ready], [True, True, False])

    def test_a_plate_that_names_a_file_sixty_times_reads_the_file_once(self):
        daemon = self.daemon({"memory_limit_mb": 155}).start()
        plate = self.path("plate")
        os.mkdir(plate)
        self.sphere("plate/ball.stl", 120)  # 368,000 facets: 18 MB with their index, 60 times 1,060 MB
        with open(os.path.join(plate, "plate.json"), "w", encoding="ascii") as file:
            json.dump({"models": [{"file": "ball.stl", "scale": 0.1}] * 60}, file)
        self.put(daemon, plate)
        daemon.wait_state("exposing")
        self.assertIn("60 models, 60 parts", daemon.log())
        self.assertLess(self.peak_bytes(daemon), 155e6)

    def test_too_many_files_and_a_wrong_facet_count_are_refused(self):
        daemon = self.daemon({"memory_limit_mb": 400}).start()
        plate = self.path("many")
        os.mkdir(plate)
        names = [f"{number}.stl" for number in range(500)]
        for name in names:
            sparse_stl(os.path.join(plate, name), 1000)
        with open(os.path.join(plate, "plate.json"), "w", encoding="ascii") as file:
            json.dump({"models": [{"file": name} for name in names]}, file)
        self.put(daemon, plate)
        self.assertIn("100", daemon.wait_refused("many"))
        self.assertIn("cut short: the header says 4294967295 facets", daemon.refused("claims.stl", SLAB[:80] + b"\xff\xff\xff\xff" + SLAB[84:-1]))
        # A text of 4 GB in a single line.
        with open(self.path("line.stl"), "wb") as file:
            file.write(b"solid".ljust(2000))
            file.truncate(4_000_000_000)
        self.put(daemon, self.path("line.stl"))
        self.assertIn(" MB of memory are needed", daemon.wait_refused("line"))
        self.assertLess(self.peak_bytes(daemon), 100e6)


class Contourctl(FolderTest):
    def test_every_command_refuses_a_model_larger_than_the_memory(self):
        path = self.path("huge.stl")
        sparse_stl(path, 0xFFFFFFFF)
        for arguments in (["inspect"], ["slice", "--z", "1"], ["analyze"]):
            done = contourctl(arguments[0], path, *arguments[1:])
            self.assert_refusal(done, BAD_DATA, path, "the model holds 4294967295 facets, for which ", "MB stay free")


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class EndedInReading(MemoryTest):
    def reading_daemon(self, beside_a_print):
        """Returns a daemon that is reading second.stl, beside a print or at its turn, and continues when the gate is removed."""
        daemon = self.daemon()
        self.gate = os.path.join(daemon.put_on_slow_disk(), "models")
        daemon.start()
        daemon.begin("first.stl", SLAB)
        if beside_a_print:
            self.write(self.gate, b"")
            daemon.drop("second.stl", SLAB)
        else:
            # Only the next job's preparation is kept until its turn.
            for name in ("other", "second"):
                daemon.drop(name + ".stl", SLAB)
                daemon.wait_job(name, "ready")
            daemon.rpc("queue_move", job="second", to=1)
            daemon.rpc("queue_remove", job="other")
            daemon.wait_status("queued", 1)
            self.write(self.gate, b"")
            daemon.cancel("first")
        wait_until(lambda: os.path.exists(os.path.join(os.path.dirname(self.gate), "waiting")), "the daemon to read the model")
        return daemon

    def start_again(self, daemon):
        os.unlink(self.gate)
        daemon.start()

    def assert_refused(self, daemon, name):
        reason = daemon.read("failed", name + ".reason.txt")
        self.assertIn("contourd ended while it read this", reason)
        self.assertIn("put it into incoming once more", reason)
        self.assertTrue(daemon.has("failed", name + ".stl"))

    def test_a_model_during_whose_reading_the_daemon_was_killed_is_refused_and_others_are_printed(self):
        daemon = self.reading_daemon(beside_a_print=True)
        daemon.drop("third.stl", SLAB)
        daemon.wait_status("queued", 2)
        daemon.kill(while_reading=True)
        self.start_again(daemon)
        daemon.wait_refused("second")
        self.assert_refused(daemon, "second")
        self.assertEqual(daemon.status()["interrupted"]["job"], "first")
        daemon.rpc("plate_cleared")
        daemon.wait_state("exposing")
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        self.assertEqual(daemon.status()["job"]["name"], "third")
        # The user has the model read again.
        os.rename(daemon.file("failed", "second.stl"), daemon.file("incoming", "second.stl"))
        daemon.wait_status("queued", 1)
        daemon.rpc("cancel")
        wait_until(lambda: (daemon.status()["job"] or {}).get("name", "").startswith("second"), "the second job to start")
        daemon.wait_state("exposing")

    def test_a_model_that_ends_the_daemon_at_its_turn_does_not_hold_the_queue(self):
        daemon = self.reading_daemon(beside_a_print=False)
        self.assertEqual(daemon.names_in("printing"), ["second.stl"])
        for _ in range(2):
            daemon.kill(while_reading=True)
            if os.path.exists(self.gate):
                self.start_again(daemon)
                self.assert_refused(daemon, "second")
            else:
                daemon.start()
        status = daemon.status()
        self.assertEqual((status["held"], status["plate_job"]), (None, "first"))  # not the second
        daemon.begin("next.stl", SLAB)

    def test_a_model_that_is_being_read_at_a_stop_is_read_again_at_the_next_start(self):
        for beside_a_print in (True, False):
            with self.subTest(beside_a_print=beside_a_print):
                self.setUp()
                daemon = self.reading_daemon(beside_a_print)
                daemon.process.send_signal(signal.SIGTERM)
                record = os.path.join(daemon.spool + ".state", "reading")
                wait_until(lambda: not os.path.exists(record), "the reading record to be deleted")
                self.start_again_after_end(daemon)
                self.assertFalse(daemon.has("failed", "second.stl"))
                self.assertNotIn("ended while it read", daemon.log())
                daemon.stop()

    def start_again_after_end(self, daemon):
        os.unlink(self.gate)
        self.assertEqual(daemon.process.wait(30), 0)
        daemon.start()
        daemon.rpc("resume")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "second")
