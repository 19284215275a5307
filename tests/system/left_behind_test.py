"""What an older contourd left on the disk, and today's goes on with (left_behind/README.md)."""

import json
import os
import shutil

from harness import CONTOURD, OK, SOURCE, Daemon, FolderTest, main, run, wait_until

LEFT_BEHIND = os.path.join(SOURCE, "tests", "system", "left_behind")
# Of the jobs that wait, as the older one printed them.
LAYERS = {"part": 6, "last": 6, "two": 5, "next": 4}


def left_behind(*parts):
    with open(os.path.join(LEFT_BEHIND, *parts), "rb") as file:
        return file.read()


class LeftBehind(FolderTest):
    def copy_configuration(self):
        for name in ("contourd.json", "real.json", "lamp.png"):
            shutil.copy(os.path.join(LEFT_BEHIND, name), self.folder)
        for folder in ("resins", "projectors"):
            shutil.copytree(os.path.join(LEFT_BEHIND, folder), self.path(folder), dirs_exist_ok=True)

    def daemon(self, name):
        """Today's daemon on what that one left; and what that one told of it."""
        daemon = Daemon(self)
        self.copy_configuration()
        for folder in ("spool", "spool.state"):
            shutil.copytree(os.path.join(LEFT_BEHIND, name, folder), self.path(folder))
        told = json.loads(left_behind(name, "told.json"))
        self.give_order([daemon.file("incoming", file) for file in told["queue"]])
        return daemon.start(), told

    def give_order(self, files):
        """Each is changed later than the one before, by the kernel's clock for files, which ticks every few milliseconds."""
        def changed(file):
            os.utime(file)
            return os.stat(file).st_ctime_ns
        last = 0
        for file in files:
            wait_until(lambda: changed(file) > last, "a later time")
            last = os.stat(file).st_ctime_ns

    def assert_told(self, daemon, told):
        wait_until(lambda: daemon.status()["queued"] == told["status"]["queued"], "the jobs that waited")
        status = daemon.status()
        self.assertEqual({key: status[key] for key in told["status"]}, told["status"])
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], told["queue"])

    def assert_goes_on(self, daemon, told):
        """The queue is printed, job by job, the plate cleared after each."""
        for number, file in enumerate(told["queue"]):
            job = os.path.splitext(file)[0]
            if number:
                self.assertEqual(daemon.ctl("plate-cleared").returncode, OK)
            report = daemon.wait_done(job)
            self.assertEqual((job, report["layers"]), (job, LAYERS[job]))
            self.assertEqual(daemon.status()["plate_job"], job)
        self.assertEqual((daemon.names_in("incoming"), daemon.names_in("printing")), ([], []))
        ended = daemon.rpc("history", this_run=True)["result"]["ended"]
        self.assertEqual([(job["job"], job["outcome"]) for job in ended],
                         [(os.path.splitext(file)[0], "done") for file in told["queue"]])  # fmt: skip
        daemon.stop()
        self.assertEqual(sorted(os.listdir(self.path("spool.state"))), ["history.sqlite", "plate-occupied"])

    def assert_unchanged(self, daemon, name, *files):
        for file in files:
            with open(daemon.file(*file.split("/")), "rb") as opened:
                self.assertEqual(opened.read(), left_behind(name, "spool", *file.split("/")), file)


class Spools(LeftBehind):
    def test_a_print_that_was_killed_is_filed_and_the_queue_goes_on_when_the_plate_is_clear(self):
        daemon, told = self.daemon("killed")
        self.assert_told(daemon, told)
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertIn("interrupted", daemon.read("failed", "held.reason.txt"))
        self.assertTrue(daemon.has("failed", "held.stl") and daemon.has("failed", "held.json"))
        self.assertEqual(daemon.ctl("plate-cleared").returncode, OK)
        self.assert_goes_on(daemon, told)
        self.assert_unchanged(daemon, "killed", "done/first.stl", "done/first.report.json", "done/first.report.html",
                              "done/first.preview.png", "failed/broken.stl", "failed/broken.reason.txt")  # fmt: skip

    def test_a_held_queue_and_an_occupied_plate_stay_so_until_the_owner_speaks(self):
        daemon, told = self.daemon("held")
        self.assert_told(daemon, told)
        daemon.stop()
        daemon.start()
        self.assert_told(daemon, told)
        self.assertEqual(daemon.ctl("plate-cleared").returncode, OK)
        self.assert_goes_on(daemon, told)
        self.assert_unchanged(daemon, "held", "failed/held.stl", "failed/held.json", "failed/held.reason.txt")

    def test_a_print_that_failed_and_was_not_filed_keeps_its_reason(self):
        daemon, told = self.daemon("unfiled")
        self.assert_told(daemon, told)
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertEqual([name for name in os.listdir(daemon.file("failed")) if name.startswith(".")], [])
        self.assert_unchanged(daemon, "unfiled", "failed/unfiled.reason.txt", "failed/unfiled.report.json")
        self.assertEqual(daemon.ctl("resume").returncode, OK)
        self.assert_goes_on(daemon, told)


class Configuration(LeftBehind):
    def test_the_files_of_a_simulated_and_a_real_printer_are_good(self):
        self.copy_configuration()
        for name in ("contourd.json", "real.json"):
            done = run(CONTOURD, "--check-config", self.path(name))
            self.assertEqual((done.returncode, done.stderr.count(b": error")), (OK, 0), done.stderr)


if __name__ == "__main__":
    main()
