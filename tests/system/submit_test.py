"""contourctl submit: puts complete models with their tickets into the spool, under unused names."""

import json
import os
import pty
import re
import signal
import stat
import subprocess

from harness import (
    BAD_CONFIG, BAD_DATA, BAD_USAGE, CANNOT_CREATE, CONTOURCTL, ENDLESS, FAILED, NIMBLE_RESIN, NO_INPUT, OK, REALTIME, SMALL, UNAVAILABLE, Daemon,
    FolderTest, binary_stl, box, contents, contourctl,
)  # fmt: skip

# A spool without a running daemon, so that files stay in incoming/.
SPOOL_FOLDERS = ("incoming", "printing", "done", "failed")


class SubmitTest(FolderTest):
    def lines(self, result):
        self.assertEqual(result.returncode, OK, result.stderr)
        self.assertEqual(result.stderr, b"")
        return result.stdout.decode().splitlines()

    def spool(self):
        for folder in SPOOL_FOLDERS:
            os.makedirs(self.path("spool", folder), exist_ok=True)
        return self.path("spool")

    def incoming(self):
        return sorted(os.listdir(self.path("spool", "incoming")))


class WithContourd(SubmitTest):
    def test_a_model_is_printed_with_the_ticket_of_the_options(self):
        daemon = Daemon(self).start()
        model = self.write("two words.stl", SMALL)
        lines = self.lines(daemon.ctl("submit", model, "--copies", "3", "--layer-height-um=25", "--up", "0,0,1", "--unit", "mm", "--undersides", "plain", "--mode", "layered", "--wait", "--printer", daemon.config_path))
        self.assertRegex(lines[0], rf"^{re.escape(os.fsdecode(model))}: 8 layers in [\d.]+ (s|min \d\d s), 0\.0\d ml of standard$")
        self.assertEqual(lines[1], f"{os.fsdecode(model)}: job two words")
        self.assertEqual(lines[-1], "two words: done")
        report = daemon.report("two words")
        self.assertEqual(report["model"]["copies"], 3)
        self.assertEqual(report["layers"], 8)
        self.assertEqual(json.loads(daemon.read("done", "two words.json")), {
            "layer_height_um": 25, "unit": "mm", "up": {"x": 0, "y": 0, "z": 1}, "undersides": "plain", "mode": "layered", "copies": 3,
        })  # fmt: skip
        self.assertEqual(contents(model), SMALL)

    def test_the_forecast_of_the_time_contains_warm_up_homing_and_parking(self):
        daemon = Daemon(self, {"simulation": {"start_height_mm": 160}}).start()  # where a print parks the plate
        model = self.write("part.stl", SMALL)
        outlook = json.loads(self.lines(daemon.ctl("submit", model, "--json", "--wait", "--printer", daemon.config_path))[0])["outlook"]
        took = daemon.report("part")["print_time_s"]
        self.assertGreater(took, 60)
        self.assertAlmostEqual(outlook["print_time_s"], took, delta=0.02 * took)

    def test_a_name_that_is_in_use_gets_a_number(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS}).start()
        model = self.write("part.stl", SMALL)
        jobs = []
        for _ in range(3):
            lines = self.lines(daemon.ctl("submit", model, "--json"))
            jobs.append(json.loads(lines[0])["job"])
            if len(jobs) == 1:
                daemon.wait_state("exposing")
        self.assertEqual(jobs, ["part", "part-2", "part-3"])
        daemon.wait_status("queued", 2)

    def test_wait_fails_if_one_of_the_jobs_fails_but_waits_for_all(self):
        daemon = Daemon(self).start()
        good, flat = self.write("good.stl", SMALL), self.write("flat.stl", binary_stl(box((0, 0, 0), (5, 5, 0))))
        result = daemon.ctl("submit", "--wait", flat, good, expect=FAILED)
        output = result.stdout.decode()
        self.assertIn("flat: failed: ", output)
        self.assertIn("good: done", output)

    def test_the_model_appears_in_the_spool_at_once(self):
        daemon = Daemon(self).start()
        model = self.write("part.stl", SMALL)
        self.lines(daemon.ctl("submit", model))
        daemon.wait_done("part")
        # No process had the file open, so the daemon saw its arrival only once.
        self.assertEqual(daemon.log().count("part.stl: arrived"), 1)

    def test_a_model_can_come_from_another_file_system(self):
        daemon = Daemon(self).start()
        if os.stat("/dev/shm").st_dev == os.stat(self.path()).st_dev:
            self.skipTest("/dev/shm is on the same file system")
        path = f"/dev/shm/contourd-submit-{os.getpid()}.stl"
        self.addCleanup(os.unlink, path)
        self.write(path, SMALL)
        self.lines(daemon.ctl("submit", path, "--wait"))


class WithoutContourd(SubmitTest):
    def test_without_a_daemon_the_model_waits_in_the_spool(self):
        model = self.write("part.stl", SMALL)
        self.assert_refusal(contourctl("submit", model, "--socket", self.path("none")), UNAVAILABLE, "cannot reach contourd")
        self.lines(contourctl("submit", model, "--spool", self.spool()))
        self.assertEqual(self.incoming(), ["part.stl"])
        mode = os.stat(self.path("spool", "incoming", "part.stl")).st_mode
        self.assertTrue(mode & stat.S_IRGRP)

    def test_a_given_ticket_is_copied_unchanged(self):
        model, ticket = self.write("part.stl", SMALL), self.write("t", b'{"copies":   2}')
        self.lines(contourctl("submit", model, "--spool", self.spool(), "--ticket", ticket))
        self.assertEqual(self.incoming(), ["part.json", "part.stl"])
        self.assertEqual(contents(self.path("spool", "incoming", "part.json")), b'{"copies":   2}')

    def test_another_jobs_files_are_left_alone(self):
        model = self.write("part.stl", SMALL)
        self.spool()
        self.write("spool/incoming/part.stl", b"old")
        self.write("spool/incoming/part-2.json", b"{}")
        self.write("spool/done/part-3.stl", b"done")
        self.write("spool/failed/part-4", b"failed")
        self.assertEqual(json.loads(self.lines(contourctl("submit", model, "--spool", self.spool(), "--json"))[0])["job"], "part-5")
        self.assertEqual(self.incoming(), ["part-2.json", "part-5.stl", "part.stl"])

    def test_wrong_files_and_options_are_reported_before_anything_is_queued(self):
        good, bad = self.write("good.stl", SMALL), self.write("bad.stl", b"no model")
        spool = self.spool()
        os.mkdir(self.path("folder.stl"))
        os.symlink("nowhere", self.path("link.stl"))
        for arguments, code, word in (
            ([bad], BAD_DATA, "bad.stl"),
            ([self.write("part.step", SMALL)], BAD_DATA, ".stl"),
            ([self.write(".part.stl", SMALL)], BAD_DATA, "dot"),
            ([self.path("none.stl")], NO_INPUT, "none.stl"),
            ([self.path("folder.stl")], NO_INPUT, "folder.stl"),
            ([self.path("link.stl")], NO_INPUT, "link.stl"),
            (["--copies", "1000"], BAD_USAGE, "copies"),
            (["--resin", "../x"], BAD_USAGE, "resin"),
            (["--scale", "nan"], BAD_USAGE, "scale"),
            (["--up", "0,0,0"], BAD_USAGE, "up"),
            (["--ticket", self.write("bad.json", b'{"copy": 1}')], BAD_CONFIG, "copy"),
            (["--ticket", self.path("none.json")], BAD_CONFIG, "none.json"),
        ):
            with self.subTest(arguments):
                self.assert_refusal(contourctl("submit", good, *arguments, "--spool", spool), code, word)
                self.assertEqual(self.incoming(), [])

    def test_options_that_exclude_each_other_are_bad_usage(self):
        good, ticket = self.write("good.stl", SMALL), self.write("t.json", b"{}")
        for arguments in (["--ticket", ticket, "--copies", "2"], ["--fit", "--scale", "2"], ["--up", "1,2"], ["--resin", ""]):
            with self.subTest(arguments):
                contourctl("submit", good, *arguments, "--spool", self.spool(), expect=BAD_USAGE)
                self.assertEqual(self.incoming(), [])

    def test_a_spool_that_cannot_be_written_is_an_error_and_stays_empty(self):
        model = self.write("part.stl", SMALL)
        self.not_written(contourctl("submit", model, "--spool", self.path("none")), "none/incoming", "No such file")
        os.makedirs(self.path("full", "incoming"))
        if os.geteuid() != 0 or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", self.path("full", "incoming")], capture_output=True, check=False
        ).returncode:
            self.skipTest("no file system can be mounted")
        self.addCleanup(subprocess.run, ["umount", self.path("full", "incoming")], check=True)
        large = self.write("large.stl", binary_stl(box((0, 0, 0), (10, 5, 0.2)) * 100))
        self.not_written(contourctl("submit", large, "--spool", self.path("full")), "No space left")
        self.assertEqual(os.listdir(self.path("full", "incoming")), [])

    def not_written(self, result, *words):
        """Asserts that submit failed after it had printed the outlook: no job, and one line with these words."""
        self.assertEqual(result.returncode, CANNOT_CREATE, result)
        self.assertNotIn(b": job ", result.stdout)
        self.assert_one_line(result.stderr, *words)

    def test_a_killed_submit_leaves_only_complete_models(self):
        spool = self.spool()
        model = self.write("part.stl", SMALL)
        # Killed after the first job, at any point of the others.
        process = subprocess.Popen([CONTOURCTL, "submit", *[model] * 50, "--spool", spool], stdout=subprocess.PIPE)
        while b": job " not in process.stdout.readline():
            pass
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        self.assertIn("part.stl", self.incoming())
        for name in self.incoming():
            self.assertEqual(contents(os.path.join(spool, "incoming", name)), SMALL, name)


class Outlook(SubmitTest):
    """The outlook on time, resin and warnings that submit prints before it queues a job."""

    def setUp(self):
        super().setUp()
        self.daemon = Daemon(self, {"ask_before": ["islands"]})
        self.island = self.write("island.stl", binary_stl([*box((0, 0, 0), (10, 5, 0.2)), *box((15, 0, 0.1), (20, 5, 0.2))]))

    def submit(self, *arguments):
        return contourctl("submit", "--spool", self.spool(), "--printer", self.daemon.config_path, *arguments)

    def in_terminal(self, keys, *arguments):
        """Returns the text on the terminal and the exit code; `keys` are typed after the question."""
        command = [CONTOURCTL, "submit", "--spool", self.spool(), "--printer", self.daemon.config_path, *arguments]
        child, terminal = pty.fork()
        if child == 0:
            os.execv(command[0], command)
        seen = b""
        with open(terminal, "r+b", buffering=0) as file:
            while True:
                try:
                    data = file.read(4096)
                except OSError:  # the other end is closed
                    break
                if not data:
                    break
                asked = b"[Y/n] " in seen
                seen += data
                if not asked and b"[Y/n] " in seen:
                    file.write(keys)
        _, status = os.waitpid(child, 0)
        return seen.decode(), os.waitstatus_to_exitcode(status)

    def test_time_resin_and_warnings_are_printed_first_and_without_a_terminal_there_is_no_question(self):
        lines = self.lines(self.submit(self.island))
        self.assertRegex(lines[0], r"island\.stl: 4 layers in .*, 0\.0\d ml of standard$")
        self.assertRegex(lines[1], r"^  warning: 1 island begins with nothing under it: layer 3 ")
        self.assertEqual(lines[2], "  the printer will ask before it prints this: islands")
        self.assertRegex(lines[3], r"island\.stl: job island$")
        outlook = json.loads(self.lines(self.submit(self.island, "--json"))[0])["outlook"]
        self.assertEqual((outlook["layers"], outlook["resin"], outlook["asks"], outlook["unknown"]), (4, "standard", ["islands"], None))
        self.assertEqual(len(outlook["warnings"]), 1)
        self.assertAlmostEqual(outlook["resin_ml"], (10 * 5 * 0.2 + 5 * 5 * 0.1) / 1000, 4)

    def test_on_a_terminal_a_warning_leads_to_a_question(self):
        for keys, code, queued in ((b"n\n", FAILED, []), (b"\x04", FAILED, []), (b"\x03", -signal.SIGINT, []), (b"\n", OK, ["island.stl"]), (b"y\n", OK, ["island-2.stl", "island.stl"])):
            with self.subTest(keys):
                seen, ended = self.in_terminal(keys, self.island)
                self.assertIn("Queue it anyway? [Y/n] ", seen)
                self.assertEqual((ended, self.incoming()), (code, queued), seen)

    def test_without_a_warning_or_with_yes_there_is_no_question(self):
        for arguments in ([self.write("sound.stl", SMALL)], [self.island, "--yes"]):
            seen, ended = self.in_terminal(b"n\n", *arguments)
            self.assertEqual(ended, OK, seen)
            self.assertNotIn("[Y/n]", seen)
        self.assertEqual(self.incoming(), ["island.stl", "sound.stl"])

    def test_a_model_that_contourd_would_refuse_is_not_queued_nor_are_the_models_beside_it(self):
        flat, wide = self.write("flat.stl", binary_stl(box((0, 0, 0), (5, 5, 0)))), self.write("wide.stl", binary_stl(box((0, 0, 0), (500, 5, 5))))
        good = self.write("good.stl", SMALL)
        for models, reason in (([flat], "flat"), ([wide], "500"), ([good, wide], "500"), ([wide, good, "--json"], "500"), ([wide, "--yes"], "500"), ([good, "--scale", "1000"], "good.stl"), ([good, "--copies", "100"], "good.stl")):
            with self.subTest(models):
                self.assert_refusal(self.submit(*models), BAD_DATA, "contourd would refuse it: ", reason, "; nothing was queued")
                self.assertEqual(self.incoming(), [])
        result = self.submit(flat, good, wide)
        self.assertEqual((result.returncode, result.stdout, len(result.stderr.splitlines())), (BAD_DATA, b"", 2), result)
        seen, ended = self.in_terminal(b"y\n", wide)
        self.assertEqual((ended, "[Y/n]" in seen, self.incoming()), (BAD_DATA, False, []), seen)

    def test_a_resin_that_does_not_exist_is_refused_and_a_broken_profile_is_waited_for(self):
        good = self.write("good.stl", SMALL)
        self.assert_refusal(self.submit(good, "--resin", "none"), BAD_DATA, "no resin profile", "standard")
        self.write("resins/broken.json", b"{}")
        lines = self.lines(self.submit(good, "--resin", "broken"))
        self.assertRegex(lines[1], '^  warning: contourd cannot print it at present: the resin profile "broken" cannot be used: ')
        self.assertEqual(self.incoming(), ["good.json", "good.stl"])

    def test_an_unknown_printer_is_reported_and_the_model_is_queued(self):
        flat = self.write("flat.stl", binary_stl(box((0, 0, 0), (5, 5, 0))))
        lines = self.lines(contourctl("submit", flat, "--spool", self.spool()))
        self.assertRegex(lines[0], r"flat\.stl: time and resin unknown: the printer is unknown: .*; specify it by --printer FILE$")
        self.assertEqual(self.incoming(), ["flat.stl"])

    def test_a_large_file_is_queued_without_being_read_first(self):
        large = self.path("large.stl")
        with open(large, "wb") as file:
            file.write(b"\0" * 80 + (2_100_000).to_bytes(4, "little"))
            file.truncate(84 + 50 * 2_100_000)
        lines = self.lines(self.submit(large))
        self.assertIn("105 MB is too large for a forecast", lines[0])

    def test_a_wrong_configuration_is_an_error_and_nothing_is_queued(self):
        for file, code in ((self.path("none.json"), BAD_CONFIG), (self.write("bad.json", b"{}"), BAD_CONFIG)):
            result = contourctl("submit", self.island, "--spool", self.spool(), "--printer", file)
            self.assertEqual(result.returncode, code, result)
            self.assertEqual((result.stdout, self.incoming()), (b"", []))
