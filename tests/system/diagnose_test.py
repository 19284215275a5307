"""contourctl diagnose: an archive for someone who helps with a problem."""

import json
import os
import stat
import tarfile

from harness import BAD_USAGE, CANNOT_CREATE, ENDLESS, NIMBLE_RESIN, OK, SMALL, Daemon, FolderTest, contourctl, source_json, text_of

ALWAYS = {"README.txt", "configuration/check.txt", "configuration/contourd.json", "configuration/projectors.txt", "configuration/resins/standard.json", "displays.txt",
          "gpio.txt", "journal.txt", "kernel.txt", "serial.txt", "status.json", "versions.txt"}  # fmt: skip


class Diagnose(FolderTest):
    def setUp(self):
        super().setUp()
        self.output = self.path("out.tar.gz")

    def diagnose(self, *words, code=OK, **options):
        result = contourctl("diagnose", *words, **options)
        self.assertEqual(result.returncode, code, result)
        return result

    def files(self, path=None):
        """Returns the archive's files by name. Asserts that all are in one folder and belong to root."""
        found = {}
        with tarfile.open(path or self.output) as archive:
            for member in archive:
                self.assertTrue(member.isdir() or member.isreg(), member.name)
                self.assertEqual((member.uname, member.uid), ("root", 0))
                folder, _, name = member.name.partition("/")
                self.assertEqual(folder, "contourd-diagnosis")
                if member.isreg():
                    found[name] = archive.extractfile(member).read().decode()
        return found

    def configured(self, **changes):
        os.mkdir(self.path("resins"))
        self.write("resins/standard.json", json.dumps(source_json("resins", "standard.json")))
        return self.write("contourd.json", json.dumps({**source_json("simulated.json"), **changes}, indent=1))

    def test_without_a_daemon_the_archive_holds_the_other_files_and_lists_them(self):
        result = self.diagnose("-o", self.output, "--config", self.configured(), "--socket", self.path("none"))
        files = self.files()
        self.assertEqual(set(files), ALWAYS)
        self.assertIn("cannot reach contourd", files["status.json"])
        self.assertEqual(files["configuration/check.txt"], "good\n")
        self.assertIn(os.uname().release, files["kernel.txt"])
        for name in ALWAYS - {"README.txt"}:
            self.assertIn(name, result.stdout.decode())
            self.assertIn(name, files["README.txt"])
        self.assertEqual(stat.S_IMODE(os.stat(self.output).st_mode), 0o600)

    def test_the_archive_holds_the_status_and_the_latest_job_of_the_daemon(self):
        daemon = Daemon(self, {}, NIMBLE_RESIN).start()
        for name in ("one", "two"):
            daemon.drop(f"{name}.stl", SMALL)
            daemon.wait_done(name)
        self.diagnose("-o", self.output, "--config", self.path("contourd.json"), "--socket", daemon.socket_path)
        files = self.files()
        self.assertEqual(set(files) - ALWAYS, {"queue.json", "history.json", "job/journal.txt", "job/done.report.json"})
        self.assertEqual(json.loads(files["status.json"])["last"]["job"], "two")
        self.assertEqual(json.loads(files["job/done.report.json"])["job"], "two")
        other = self.path("other.tar.gz")
        self.diagnose("one", "-o", other, "--config", self.path("contourd.json"), "--socket", daemon.socket_path)
        self.assertEqual(json.loads(self.files(other)["job/done.report.json"])["job"], "one")

    def test_secrets_are_removed_even_from_invalid_json(self):
        config = self.configured(name="mine")
        self.write("contourd.json", '{"api_token": "hush1", "x": 1,\n "mqttPassword" : "hush2"\nKEY=hush3 hush4\n"spool": "/home/alice/spool"}\n')
        self.diagnose("-o", self.output, "--config", config, "--socket", self.path("none"))
        written = self.files()["configuration/contourd.json"]
        for word in ("hush", "alice"):
            self.assertNotIn(word, written)
        self.assert_words(written, '"api_token": ***', '"mqttPassword" : ***', "KEY= ***", "/home/***/spool")
        self.assertNotIn("alice", "".join(self.files().values()))

    def test_a_user_who_gave_a_command_is_not_named(self):
        daemon = Daemon(self, {}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.stop()
        journal = self.write("journalctl", "#!/bin/sh\necho 'pause requested by user alice (1000) (process 7)'\n")
        os.chmod(journal, 0o755)
        self.diagnose("-o", self.output, "--config", self.path("contourd.json"), "--socket", self.path("none"),
                      env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})  # fmt: skip
        self.assertEqual(self.files()["journal.txt"], "pause requested by user *** (process 7)\n")

    def test_a_report_that_is_a_link_is_not_followed(self):
        daemon = Daemon(self, {}, NIMBLE_RESIN).start()
        daemon.printed("one.stl", SMALL)
        report = daemon.file("done", "one.report.json")
        os.unlink(report)
        os.symlink(self.write("private", "hush"), report)
        self.diagnose("-o", self.output, "--config", self.path("contourd.json"), "--socket", daemon.socket_path)
        self.assertNotIn("hush", "".join(self.files().values()))
        self.assertIn("link", self.files()["job/done.report.json"])

    def test_a_huge_file_is_cut_short(self):
        config = self.configured()
        self.write("contourd.json", "x" * 30_000_000)
        self.diagnose("-o", self.output, "--config", config, "--socket", self.path("none"))
        written = self.files()["configuration/contourd.json"]
        self.assertLess(len(written), 1_001_000)
        self.assertTrue(written.endswith("(the rest is left out)\n"))

    def test_nothing_is_overwritten_and_a_failed_write_is_an_error(self):
        config = self.configured()
        self.write("out.tar.gz", "mine")
        os.symlink(self.path("nowhere"), self.path("link"))
        for name in (self.output, self.path("link"), self.path("none", "x"), self.path("resins")):
            result = self.diagnose("-o", name, "--config", config, "--socket", self.path("none"), code=CANNOT_CREATE)
            self.assert_one_line(result.stderr, name)
            self.assertEqual(result.stdout, b"")
        self.assertEqual(text_of(self.output), "mine")
        self.assertFalse(os.path.exists(self.path("nowhere")))
        self.assertIn(b"--output", self.diagnose("-o", "", code=BAD_USAGE).stderr)

    def test_without_output_the_archive_is_named_after_the_time(self):
        config = self.configured()
        self.diagnose("--config", config, "--socket", self.path("none"), cwd=self.path("resins"))
        (name,) = [name for name in os.listdir(self.path("resins")) if name != "standard.json"]
        self.assertRegex(name, r"^contourd-diagnosis-\d{8}-\d{6}\.tar\.gz$")
