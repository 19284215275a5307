"""The spool's folders: files of other users in them, files in the daemon's place, and folders that are replaced."""

import fcntl
import json
import os
import signal
import subprocess
import sys
import unittest

from harness import (
    CONTOURCTL, CONTOURD, MAKE_MODEL, NIMBLE_RESIN, SLAB, SMALL, SOURCE, WAITS, SpoolTest, contents, merge, realtime, run, text_of,
    wait_until,
)  # fmt: skip


@unittest.skipUnless(os.geteuid() == 0, "only root can run a daemon and a member of its group as users of their own")
class Members(SpoolTest):
    """The service runs as its own user, with the permissions that its folders have on a printer. Another user of its group, with
    the usual umask, drops files."""

    GROUP, SERVICE, MEMBER = 64000, 64001, 64002  # ids of no other user or group

    def setUp(self):
        super().setUp()
        self.printer = self.daemon()
        os.chmod(self.folder, 0o755)
        for name in ("home", "state", "run"):
            os.mkdir(self.path(name))
        os.chown(self.path("home"), self.MEMBER, self.MEMBER)
        for name in ("state", "run"):
            os.chown(self.path(name), self.SERVICE, self.GROUP)
        with open(os.path.join(SOURCE, "systemd", "contourd.tmpfiles"), encoding="utf-8") as file:
            folders = [line.split() for line in file if line.startswith("d /var/spool")]
        for _, path, mode, *_ in folders:
            folder = path.replace("/var/spool/contourd", self.printer.spool)
            os.mkdir(folder)
            os.chown(folder, self.SERVICE, self.GROUP)
            os.chmod(folder, int(mode, 8))
        self.printer.config["control_socket"] = self.printer.socket_path = self.path("run", "control.sock")
        self.printer.write_config()
        self.printer.environment["STATE_DIRECTORY"] = self.path("state")
        self.printer.program = self.reachable(CONTOURD)
        self.contourctl = self.reachable(CONTOURCTL)
        self.printer.rights = {"user": self.SERVICE, "group": self.GROUP, "extra_groups": [], "umask": 0o002}
        os.chmod(self.path(), 0o777)  # for the notify socket of the test
        self.printer.start()

    def member(self, command, umask="022"):
        """Runs a shell command as the member, in the member's home; $incoming is the spool's folder incoming/."""
        subprocess.run(
            ["sh", "-ec", f"umask {umask}; {command}"], cwd=self.path("home"), check=True, user=self.MEMBER,
            group=self.MEMBER, extra_groups=[self.GROUP], env={**os.environ, "incoming": self.printer.file("incoming")})  # fmt: skip

    def plate_at_home(self, name, ticket=None):
        self.member(f"mkdir {name}")
        for file, data in (("part.stl", SLAB), ("plate.json", json.dumps(ticket or {"models": [{"file": "part.stl"}]}))):
            path = self.write(f"home/{name}/{file}", data)
            os.chown(path, self.MEMBER, self.MEMBER)

    def are_deletable(self, *jobs):
        wait_until(lambda: self.printer.status()["deletable"] == list(jobs), f"{jobs} to be deletable")

    def is_not_printed_again(self, *jobs):
        """Asserts that the jobs are neither printed nor refused again, now or after a restart."""
        self.are_deletable(*jobs)
        self.printer.restart()
        self.printer.printed("another.stl", SLAB)
        self.are_deletable(*jobs)
        for job in jobs:
            self.assertFalse(any(name.startswith(job + "-2") for folder in ("done", "failed") for name in self.printer.names_in(folder)))

    def test_plates_copied_into_moved_to_or_made_in_incoming_are_printed_once_and_may_be_deleted(self):
        for plate in ("changed", "copied", "made", "moved"):
            self.plate_at_home(plate)
        self.member("cp -r changed copied $incoming/; mv moved $incoming/; mkdir $incoming/made; cp made/part.stl made/plate.json $incoming/made/")
        self.printer.wait_outcomes({"changed": "done", "copied": "done", "made": "done", "moved": "done"})
        self.assertTrue(self.printer.has("done", "copied", "part.stl"))
        self.assertTrue(self.printer.has("incoming", "copied", "part.stl"))
        self.assertIn("copied: printing a copy", self.printer.log())
        self.assertIn(b"deletable copied", self.printer.ctl("status").stdout)
        # A changed plate is printed again, and a removed one is forgotten.
        self.member("""echo '{"models": [{"file": "part.stl", "copies": 2}]}' > $incoming/changed/plate.json""")
        self.printer.wait_done("changed-2")
        self.member("rm -r $incoming/changed")
        self.are_deletable("copied", "made", "moved")
        # With other permissions and another name, it is still the same plate.
        self.member("chmod -R a+r $incoming/copied; mv $incoming/copied $incoming/renamed")
        self.is_not_printed_again("made", "moved", "renamed")

    def cut_off_copy(self):
        """Puts the copy of a printed plate into printing/ again. Returns its inode, and the mark of its original."""
        self.plate_at_home("plate")
        self.member("cp -r plate $incoming/")
        self.printer.wait_done("plate")
        # While the end is on record, the next start completes the filing of the job as done.
        wait_until(lambda: not os.path.exists(self.path("state", "ended-jobs")), "the record of the job's end to be used up")
        self.printer.kill()
        os.rename(self.printer.file("done", "plate"), self.printer.file("printing", "plate"))
        for name in self.printer.names_in("done"):
            os.remove(self.printer.file("done", name))
        return os.stat(self.printer.file("printing", "plate")).st_ino, text_of(self.path("state", "copied-originals"))

    def test_a_plate_is_not_printed_again_after_a_power_cut_that_followed_its_copy(self):
        inode, mark = self.cut_off_copy()
        self.write("state/copied-originals", f"copying {inode} {mark}")
        self.printer.start()
        self.assertEqual(self.printer.names_in("failed"), ["plate", "plate.reason.txt"])
        self.printer.rpc("plate_cleared")
        self.is_not_printed_again("plate")

    def test_a_power_cut_before_the_copy_is_complete_loses_no_plate(self):
        inode, mark = self.cut_off_copy()
        self.write("state/copied-originals", f"copying {inode} {mark}")
        os.rename(self.printer.file("printing", "plate"), self.path("home", "gone"))
        self.printer.start()
        self.printer.wait_done("plate")
        self.is_not_printed_again("plate")

    def test_models_of_any_owner_are_moved(self):
        self.write("home/model.stl", SLAB)
        self.member("cp model.stl $incoming/copied.stl")
        self.printer.wait_done("copied")
        self.member("cp model.stl mine.stl; mv mine.stl $incoming/moved.stl")
        self.printer.wait_done("moved")
        self.assertEqual(self.printer.names_in("incoming"), [])

    def test_bad_plates_and_unreadable_files_are_refused_once(self):
        self.plate_at_home("bad", {"models": [{"file": "part.stl", "colour": "red"}]})
        self.plate_at_home("closed")
        self.plate_at_home("odd")
        self.write("home/model.stl", SLAB)
        self.member("cp -r bad $incoming/; mkdir $incoming/folder.stl")
        self.member("cp -r closed $incoming/; cp model.stl $incoming/secret.stl", umask="077")
        self.member('chmod 0 odd/part.stl; mv odd "$incoming/line\nbreak"')
        reasons = {"bad": "colour", "closed": "Permission denied", "folder": "folder", "line\nbreak": "Permission denied", "secret": "Permission denied"}
        self.printer.wait_outcomes(dict.fromkeys(reasons, "failed"))
        for job, word in reasons.items():
            reason = self.printer.read("failed", job + ".reason.txt")
            self.assertIn(word, reason)
            self.assertEqual(reason.count("\n"), 1, reason)
        self.is_not_printed_again("bad", "closed", "folder.stl", "line\nbreak")

    def test_a_bad_plate_is_refused_while_another_job_waits(self):
        # The jobs are checked while they wait in the queue for the plate to be cleared.
        self.printer.stop()
        merge(self.printer.config, WAITS)
        self.printer.write_config()
        self.printer.start()
        self.printer.printed("first.stl", SLAB)
        self.plate_at_home("bad", {"models": [{"file": "part.stl", "colour": "red"}]})
        self.plate_at_home("good")
        self.member("cp -r bad good $incoming/")
        self.assertIn("colour", self.printer.wait_refused("bad"))
        self.printer.rpc("plate_cleared")
        self.printer.wait_done("good")

    def flood(self, request=b""):
        """Opens 200 connections of the member, which each send a request and then stay idle."""
        script = (
            "import os, socket, sys, time\n"
            f"os.setgroups([{self.GROUP}])\n"
            f"os.setresgid({self.MEMBER}, {self.MEMBER}, {self.MEMBER})\n"
            f"os.setresuid({self.MEMBER}, {self.MEMBER}, {self.MEMBER})\n"
            "held = []\n"
            "for _ in range(200):\n"
            "    held.append(socket.socket(socket.AF_UNIX))\n"
            "    held[-1].connect(sys.argv[1])\n"
            "    held[-1].send(sys.argv[2].encode())\n"
            "print('held', flush=True)\n"
            "time.sleep(600)\n")  # fmt: skip
        flood = subprocess.Popen(
            [sys.executable, "-c", script, self.printer.socket_path, request.decode()], stdout=subprocess.PIPE)
        self.killed_at_the_end(flood)
        self.addCleanup(flood.stdout.close)
        flood.stdout.readline()

    def test_idle_connections_and_watchers_of_one_user_do_not_block_others(self):
        for request in (b"", b'{"jsonrpc":"2.0","method":"watch","id":1}\n'):
            self.flood(request)
            for _ in range(3):
                self.assertEqual(self.printer.status()["state"], "idle")
        # The daemon's first watcher, which is root's, is still connected.
        self.printer.printed("part.stl", SLAB)

    def test_a_command_is_logged_with_its_user_and_a_query_is_not_logged(self):
        call = [self.contourctl, "cancel", "--socket", self.printer.socket_path]
        result = subprocess.run(call, user=self.MEMBER, group=self.MEMBER, extra_groups=[self.GROUP], capture_output=True, check=False)
        self.assertIn(b"no print to cancel", result.stderr)
        self.assertIn(f"cancel requested by user {self.MEMBER} (process ", self.printer.log())
        self.printer.rpc("pause")
        self.assertIn("pause requested by user root (0) (process ", self.printer.log())
        self.printer.status()
        self.assertNotIn("status requested", self.printer.log())

    def test_a_member_can_neither_replace_nor_remove_the_spools_folders(self):
        for folder in ("incoming", "printing", "done", "failed"):
            with self.assertRaises(subprocess.CalledProcessError):
                self.member(f"mv $incoming/../{folder} $incoming/../elsewhere 2>/dev/null")
        with self.assertRaises(subprocess.CalledProcessError):
            self.member("ls $incoming/../../state 2>/dev/null")


class PlantedFiles(SpoolTest):
    """Files other than models that a member of the group may put into the spool."""

    def test_fifos_of_any_name_block_neither_a_print_nor_a_refusal_nor_a_restart(self):
        daemon = self.daemon(WAITS).start()
        for suffix in ("report.json", "report.html", "preview.png", "reason.txt"):
            for folder in ("done", "failed"):
                for name in (f"part.{suffix}", f".part.{suffix}.new", f"bad.{suffix}", f".bad.{suffix}.new"):
                    os.mkfifo(daemon.file(folder, name))
        for name in ("plate-occupied", ".plate-occupied.new", "queue-held", ".queue-held.new"):
            os.mkfifo(daemon.file(name))
        daemon.drop("bad.stl", b"no model")
        # If a name is taken, a job that ends gets a number.
        end = daemon.wait_next_end()
        self.assertEqual(end["outcome"], "failed")
        daemon.drop("part.stl", SLAB)
        end = daemon.wait_next_end()
        self.assertEqual(end["outcome"], "done")
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], end["job"])

    def test_files_named_like_the_daemon_s_own_change_neither_queue_nor_plate(self):
        daemon = self.daemon(WAITS)
        os.makedirs(daemon.spool)
        for name in ("plate-occupied", "queue-held"):
            self.write(daemon.file(name), "something\n")
        daemon.start()
        status = daemon.status()
        self.assertEqual((status["held"], status["plate"]), (None, "clear"))
        daemon.printed("part.stl", SLAB)
        for name in ("plate-occupied", "queue-held"):
            os.unlink(daemon.file(name))
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], "part")
        # Only the daemon can access its own files: a user who can read the lock file could hold the lock.
        self.assertEqual(os.stat(daemon.spool + ".state").st_mode & 0o777, 0o700)
        self.assertEqual(os.stat(daemon.file(".lock")).st_mode & 0o777, 0o600)

    def test_the_state_folder_of_the_service_manager_is_used_if_there_is_one(self):
        daemon = self.daemon(WAITS)
        os.mkdir(self.path("own"))
        os.chmod(self.path("own"), 0o2775)
        daemon.environment["STATE_DIRECTORY"] = self.path("own")
        daemon.start()
        daemon.printed("part.stl", SLAB)
        daemon.stop()
        self.assertIn("plate-occupied", os.listdir(self.path("own")))
        self.assertEqual(os.stat(self.path("own")).st_mode & 0o777, 0o700)
        self.assertFalse(os.path.exists(daemon.spool + ".state"))

    def test_a_spool_with_a_link_in_place_of_a_folder_is_refused(self):
        daemon = self.daemon()
        os.makedirs(daemon.spool)
        os.mkdir(self.path("elsewhere"))
        os.symlink(self.path("elsewhere"), daemon.file("done"))
        daemon.launch()
        self.assertGreater(daemon.process.wait(30), 0)
        self.assertIn("done is a symbolic link", daemon.log())


class ReplacedFolders(SpoolTest):
    WATCHED = "the new folder is watched"

    def put(self, daemon, name, data=SLAB, folder="incoming"):
        self.write(daemon.file(folder, name), data)

    def printed(self, daemon, name):
        self.put(daemon, name + ".stl")
        return daemon.wait_done(name)

    def mount_over_incoming(self, daemon):
        self.mount_over(daemon, "incoming")

    def mount_over(self, daemon, folder):
        os.makedirs(daemon.file(folder), exist_ok=True)
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "none", daemon.file(folder)], check=False).returncode != 0:
            self.skipTest("nothing can be mounted here")
        self.addCleanup(subprocess.run, ["umount", "-q", daemon.file(folder)], check=False)

    def stopped_while_it_reads(self, daemon, meanwhile=lambda: None):
        """Stops the daemon while it prepares big.stl, which has a ticket, for its print."""
        large = self.path("large.stl")
        self.assertEqual(run(MAKE_MODEL, "gyroid-sphere", large, "50").returncode, 0)
        daemon.start()
        self.printed(daemon, "first")
        # Only the next job's preparation is kept until its turn.
        self.put(daemon, "other.stl")
        daemon.wait_job("other", "ready")
        self.put(daemon, "big.json", b"{}")
        self.put(daemon, "big.stl", contents(large))
        daemon.wait_job("big", "ready")
        daemon.rpc("queue_move", job="big", to=1)
        os.unlink(daemon.file("incoming", "other.stl"))
        daemon.wait_status("queued", 1)
        daemon.rpc("plate_cleared")
        daemon.wait_status("state", "preparing")
        meanwhile()
        self.assertEqual(daemon.status()["state"], "preparing", "the model is read too fast for this test")
        daemon.stop()

    def test_an_incoming_folder_that_was_replaced_by_a_rename_is_watched(self):
        daemon = self.daemon().start()
        os.mkdir(daemon.file("other"))
        os.rename(daemon.file("incoming"), daemon.file("old"))
        os.rename(daemon.file("other"), daemon.file("incoming"))
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")
        self.put(daemon, "late.stl", folder="old")
        self.printed(daemon, "next")
        self.assertTrue(daemon.has("old", "late.stl"))

    def test_jobs_of_the_old_folder_leave_the_queue_and_jobs_of_the_new_one_arrive(self):
        daemon = self.printing_daemon()
        daemon.drop("old.stl", SLAB)
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["old.stl"], "the job in the queue")
        os.mkdir(daemon.file("other"))
        self.put(daemon, "new.stl", folder="other")
        os.rename(daemon.file("incoming"), daemon.file("before"))
        os.rename(daemon.file("other"), daemon.file("incoming"))
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["new.stl"], "only the new folder's job in the queue")
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_jobs_that_were_removed_while_events_were_lost_leave_the_queue(self):
        daemon = self.printing_daemon()
        daemon.drop("waits.stl", SLAB)
        os.mkdir(daemon.file("incoming", "plate"))
        self.put(daemon, "plate.json", json.dumps({"models": [{"file": "part.stl"}]}).encode(), "incoming/plate")
        wait_until(lambda: "plate" in daemon.status()["incomplete"] and daemon.status()["queued"] == 1, "the job and the plate to wait")
        with open("/proc/sys/fs/inotify/max_queued_events", encoding="ascii") as file:
            most = int(file.read())
        os.kill(daemon.process.pid, signal.SIGSTOP)
        for _ in range(most // 3 + 1):  # one event each for creation, closing and removal
            self.put(daemon, "noise", b"")
            os.unlink(daemon.file("incoming", "noise"))
        os.unlink(daemon.file("incoming", "waits.stl"))
        os.rename(daemon.file("incoming", "plate"), daemon.file("plate"))
        self.put(daemon, "new.stl")
        os.kill(daemon.process.pid, signal.SIGCONT)
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["new.stl"], "only the new job in the queue")
        wait_until(lambda: not daemon.status()["incomplete"], "the plate to be removed")

    def test_a_spool_that_was_replaced_is_locked_and_watched(self):
        daemon = self.daemon().start()
        os.rename(daemon.spool, daemon.spool + ".old")
        os.mkdir(daemon.spool)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")
        second = self.second_daemon("second", {"spool_folder": "spool"})
        second.launch()
        self.assertNotEqual(second.process.wait(), 0)
        self.assertIn("another contourd uses the spool", second.log())

    def test_a_print_whose_spool_was_replaced_ends_and_the_queue_goes_on(self):
        daemon = self.printing_daemon()
        os.rename(daemon.spool, daemon.spool + ".old")
        os.mkdir(daemon.spool)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.assertEqual(daemon.status()["state"], "exposing")
        daemon.cancel("first")
        self.put(daemon, "next.stl")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "next")
        self.assertTrue(os.path.exists(os.path.join(daemon.spool + ".old", "printing", "first.stl")))

    def test_a_spool_of_another_daemon_is_left_to_it(self):
        daemon = self.daemon().start()
        os.mkdir(self.path("others"))
        with open(self.path("others", ".lock"), "wb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            os.rename(daemon.spool, daemon.spool + ".old")
            os.rename(self.path("others"), daemon.spool)
            wait_until(lambda: "another contourd uses the spool" in daemon.log(), "the warning")
            self.assertEqual(daemon.log().count("nothing arrives"), 1)
            self.assertNotIn(self.WATCHED, daemon.log())
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")

    def test_a_mount_over_incoming_is_watched_and_after_unmounting_the_folder_below_it(self):
        daemon = self.daemon().start()
        self.mount_over_incoming(daemon)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.assertEqual(self.printed(daemon, "part")["layers"], 20)
        self.assertEqual(daemon.names_in("incoming"), [])  # even though nothing can be moved to another file system
        self.put(daemon, "bad.stl", b"no model")
        daemon.wait_refused("bad")
        subprocess.run(["umount", daemon.file("incoming")], check=True)
        wait_until(lambda: daemon.log().count(self.WATCHED) == 2, "the old folder to be watched again")
        self.printed(daemon, "under")

    def test_a_job_that_has_not_begun_returns_to_a_mounted_incoming_folder(self):
        daemon = self.daemon(WAITS)
        self.mount_over_incoming(daemon)
        self.stopped_while_it_reads(daemon)
        self.assertEqual(daemon.names_in("incoming"), ["big.json", "big.stl"])
        self.assertEqual(daemon.names_in("printing"), [])

    def test_ended_jobs_are_copied_to_folders_that_are_mounted(self):
        daemon = self.daemon(realtime(wait_for_plate_cleared=True), NIMBLE_RESIN)
        for folder in ("done", "failed"):
            os.makedirs(daemon.file(folder))
            self.mount_over(daemon, folder)
        daemon.start()
        daemon.printed("one.stl", SMALL, {"copies": 1})
        daemon.drop("two.stl", SMALL, {"copies": 1})
        daemon.drop_plate("plate", {"models": [{"file": "a.stl"}]}, {"a.stl": SMALL, "note.txt": b"a user's file"})
        daemon.wait_job("plate", "ready")
        for job in ("two", "plate"):
            daemon.rpc("queue_remove", job=job)
            self.assertEqual(daemon.wait_ended(job)["outcome"], "cancelled")
        daemon.refused("bad.stl", b"no model")
        daemon.restart()
        self.assertEqual((daemon.names_in("incoming"), daemon.names_in("printing")), ([], []))
        for file in ("done/one.stl", "done/one.json", "failed/two.stl", "failed/two.json", "failed/plate/note.txt", "failed/bad.stl"):
            self.assertTrue(daemon.has(*file.split("/")), file)
        self.assertEqual([name for folder in ("done", "failed") for name in daemon.names_in(folder) if name.startswith(".")], [])
        daemon.rpc("plate_cleared")
        daemon.printed("next.stl", SMALL)
        daemon.stop()

    def test_a_job_that_returns_to_incoming_does_not_overwrite_another_job(self):
        daemon = self.daemon(WAITS)
        self.stopped_while_it_reads(daemon, lambda: self.put(daemon, "big.stl"))
        self.assertEqual(daemon.names_in("incoming"), ["big-2.json", "big-2.stl", "big.stl"])
