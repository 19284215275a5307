"""Memory: what a job needs is known before it is read, and a model that ended the daemon is not read again."""

import contextlib
import json
import os
import signal
import struct
import unittest

from harness import (
    BAD_DATA, ENDLESS, MAKE_MODEL, NIMBLE_RESIN, REALTIME, SANITIZED, Daemon, FolderTest, binary_stl, box, contourctl, main,
    merge, run, wait_until,
)  # fmt: skip

SMALL = binary_stl(box((0, 0, 0), (10, 5, 1)))  # 20 layers
HUGE = 85_899_344  # facets of 4 GB
# A ball of so many cells, and the MB with which one such job is printed but not read beside another.
CELLS = 200
LIMIT_FOR_ONE = 180


def sparse_stl(path, facets):
    """A file of so many facets, all at the origin, that takes no room on the disk."""
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", facets))
        file.truncate(84 + 50 * facets)


@contextlib.contextmanager
def control_group(limit):
    """A new group of so many bytes, of either version; nothing where there is none to be had."""
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
        return Daemon(self, merge(json.loads(json.dumps(REALTIME)), config or {}), resin or {**NIMBLE_RESIN, **ENDLESS})

    def sphere(self, name, cells):
        path = self.path(name)
        self.assertEqual(run(MAKE_MODEL, "sphere", path, str(cells)).returncode, 0)
        return path

    def put_ball(self, daemon, name):
        """A job of its own, 8 mm high."""
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


@unittest.skipIf(SANITIZED, "what AddressSanitizer takes says nothing")
class Room(MemoryTest):
    def test_a_model_that_fits_no_limit_is_refused_beside_a_print_without_being_read(self):
        daemon = self.daemon({"memory_limit_mb": 400}).start()
        daemon.drop("part.stl", SMALL)
        daemon.wait_state("exposing")
        self.put_sparse(daemon, "huge.stl", HUGE)
        reason = daemon.wait_refused("huge")
        self.assertIn(f"the model holds {HUGE} facets, for which ", reason)
        self.assertRegex(reason, r"there is room for 3\d\d MB: memory_limit_mb is 400, and contourd holds \d+ MB")
        self.assertLess(self.peak_bytes(daemon), 100e6)
        self.assertEqual(daemon.status()["state"], "exposing")
        daemon.stop()

    def test_in_a_control_group_its_limit_holds_without_a_key(self):
        with control_group(900_000_000) as group:
            if group is None:
                self.skipTest("there is no control group to be had")
            daemon = self.daemon()

            def join():
                with open(os.path.join(group, "cgroup.procs"), "w", encoding="ascii") as file:
                    file.write(str(os.getpid()))

            daemon.rights = {"preexec_fn": join}
            daemon.start()
            daemon.drop("part.stl", SMALL)
            daemon.wait_state("exposing")
            self.put_sparse(daemon, "huge.stl", HUGE)
            self.assertRegex(daemon.wait_refused("huge"), r"\d+ MB are available in the control group, of which 64 MB stay free")
            self.assertEqual(daemon.status()["state"], "exposing")
            daemon.stop()

    def test_what_does_not_fit_beside_a_print_waits_for_its_end_and_is_printed(self):
        daemon = self.daemon({"memory_limit_mb": LIMIT_FOR_ONE}).start()
        self.put_ball(daemon, "first")
        daemon.wait_state("exposing")
        self.put_ball(daemon, "second")
        why = wait_until(lambda: daemon.status()["postponed"].get("second.stl"), "its postponement")
        self.assertRegex(why, r"for which \d+ MB of memory are needed, and there is room for \d+ MB: memory_limit_mb is")
        self.assertEqual(daemon.status()["postponed_more"], 0)
        self.assertIn(b"postponed second.stl: the model holds", daemon.ctl("status").stdout)
        self.assertIn("second.stl: is read later, because there is not enough memory now: the model holds", daemon.log())
        # Small ones are read meanwhile.
        daemon.drop("bad.stl", b"no model")
        daemon.wait_refused("bad")
        daemon.rpc("cancel")
        wait_until(lambda: (daemon.status()["job"] or {}).get("name") == "second", "its turn")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["postponed"], {})
        self.assertLess(self.peak_bytes(daemon), LIMIT_FOR_ONE * 1e6)
        daemon.stop()

    def test_what_waits_for_room_is_read_when_the_print_has_ended_though_its_turn_has_not_come(self):
        daemon = self.daemon({"memory_limit_mb": LIMIT_FOR_ONE, "wait_for_plate_cleared": True}).start()
        self.put_ball(daemon, "first")
        daemon.wait_state("exposing")
        self.put_ball(daemon, "second")
        wait_until(lambda: "second.stl" in daemon.status()["postponed"], "its postponement")
        daemon.rpc("cancel")
        wait_until(lambda: not daemon.status()["postponed"], "its reading", 60)
        self.assertEqual(daemon.status()["queued"], 1)
        daemon.stop()

    def test_the_next_job_is_prepared_once_beside_a_print_and_another_behind_it_at_its_turn(self):
        daemon = self.daemon({"memory_limit_mb": 400}).start()
        daemon.drop("part.stl", SMALL)
        daemon.wait_state("exposing")
        for job in ("next", "last"):
            daemon.drop(job + ".stl", SMALL)
        # They are checked in their order.
        daemon.drop("bad.stl", b"no model")
        daemon.wait_refused("bad")
        for job in ("next", "last"):
            daemon.rpc("cancel")
            wait_until(lambda job=job: (daemon.status()["job"] or {}).get("name") == job, "its turn")
            daemon.wait_state("exposing")
        ready = [line for line in daemon.log().splitlines() if "first mask after" in line]
        self.assertEqual(["prepared while it waited" in line for line in ready], [False, True, False])
        daemon.stop()

    def test_a_plate_that_names_a_file_sixty_times_reads_it_once(self):
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
        daemon.stop()

    def test_five_hundred_files_and_a_count_that_no_file_has_are_refused_in_a_sentence(self):
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
        daemon.drop("claims.stl", SMALL[:80] + b"\xff\xff\xff\xff" + SMALL[84:-1])
        self.assertIn("cut short: the header says 4294967295 facets", daemon.wait_refused("claims"))
        # A text of one line without an end.
        with open(self.path("line.stl"), "wb") as file:
            file.write(b"solid".ljust(2000))
            file.truncate(4_000_000_000)
        self.put(daemon, self.path("line.stl"))
        self.assertIn(" MB of memory are needed", daemon.wait_refused("line"))
        self.assertLess(self.peak_bytes(daemon), 100e6)
        daemon.stop()


class Contourctl(FolderTest):
    def test_every_command_that_reads_a_model_refuses_one_that_no_memory_holds(self):
        path = self.path("huge.stl")
        sparse_stl(path, 0xFFFFFFFF)
        for arguments in (["inspect"], ["slice", "--z", "1"], ["analyze"]):
            done = contourctl(arguments[0], path, *arguments[1:])
            self.assertEqual(done.returncode, BAD_DATA, done)
            self.assert_one_line(done.stderr, path, "the model holds 4294967295 facets, for which ", "MB stay free")


@unittest.skipIf(SANITIZED, "AddressSanitizer wants to be loaded first")
class EndedInReading(MemoryTest):
    def reading_daemon(self, beside_a_print):
        """A daemon that is reading second.stl, and goes on when the gate is removed."""
        daemon = self.daemon()
        self.gate = os.path.join(daemon.put_on_slow_disk(), "models")
        daemon.start()
        if beside_a_print:
            daemon.drop("first.stl", SMALL)
            daemon.wait_state("exposing")
        open(self.gate, "wb").close()
        daemon.drop("second.stl", SMALL)
        wait_until(lambda: os.path.exists(os.path.join(os.path.dirname(self.gate), "waiting")), "the reading")
        return daemon

    def start_again(self, daemon):
        os.unlink(self.gate)
        daemon.start()

    def assert_refused(self, daemon, name):
        reason = daemon.read("failed", name + ".reason.txt")
        self.assertIn("contourd ended while it read this", reason)
        self.assertIn("put it into incoming once more", reason)
        self.assertTrue(daemon.has("failed", name + ".stl"))

    def test_a_model_at_which_the_daemon_was_killed_is_refused_and_the_others_go_on(self):
        daemon = self.reading_daemon(beside_a_print=True)
        daemon.drop("third.stl", SMALL)
        wait_until(lambda: daemon.status()["queued"] == 2, "both in the queue")
        daemon.kill(while_reading=True)
        self.start_again(daemon)
        daemon.wait_refused("second")
        self.assert_refused(daemon, "second")
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        daemon.rpc("resume")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "third")
        # Its owner has it tried again.
        os.rename(daemon.file("failed", "second.stl"), daemon.file("incoming", "second.stl"))
        wait_until(lambda: daemon.status()["queued"] == 1, "its arrival")
        daemon.rpc("cancel")
        wait_until(lambda: (daemon.status()["job"] or {}).get("name", "").startswith("second"), "its turn")
        daemon.wait_state("exposing")
        daemon.stop()

    def test_a_model_that_ends_the_daemon_at_its_turn_holds_no_queue(self):
        daemon = self.reading_daemon(beside_a_print=False)
        wait_until(lambda: daemon.names_in("printing"), "its claim")
        for _ in range(2):
            daemon.kill(while_reading=True)
            if os.path.exists(self.gate):
                self.start_again(daemon)
                self.assert_refused(daemon, "second")
            else:
                daemon.start()
        status = daemon.status()
        self.assertEqual((status["held"], status["plate"]), (None, "clear"))
        daemon.drop("next.stl", SMALL)
        daemon.wait_state("exposing")
        daemon.stop()

    def test_a_model_that_is_being_read_when_the_daemon_is_stopped_is_read_at_the_next_start(self):
        for beside_a_print in (True, False):
            with self.subTest(beside_a_print=beside_a_print):
                self.setUp()
                daemon = self.reading_daemon(beside_a_print)
                daemon.process.send_signal(signal.SIGTERM)
                record = os.path.join(daemon.spool + ".state", "reading")
                wait_until(lambda: not os.path.exists(record), "its word")
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


if __name__ == "__main__":
    main()
