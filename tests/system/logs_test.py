"""contourctl logs: the arguments that it passes to journalctl. A script in journalctl's place prints them."""

import os

from harness import BAD_USAGE, FAILED, OK, UNAVAILABLE, FolderTest, contourctl

ASKED = """#!/bin/sh
for word; do printf '%s\\n' "$word"; done
exit 7
"""
SILENT = "#!/bin/sh\necho empty >&2\n"
FIRST_WORDS = ["--unit=contourd.service"]
HOW = ["--output=short", "--no-hostname"]


class Logs(FolderTest):
    def asked(self, *words, journalctl=ASKED, code=7):
        path = self.path("journalctl")
        self.write(path, journalctl)
        os.chmod(path, 0o755)
        result = contourctl("logs", *words, env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.assertEqual(result.returncode, code, result)
        return result

    def words(self, *words):
        return self.asked(*words).stdout.decode().splitlines()

    def test_it_shows_all_lines_of_a_job_the_latest_of_the_daemon_or_the_requested_number(self):
        self.assertEqual(self.words(), [*FIRST_WORDS, *HOW, "--lines=100"])
        self.assertEqual(self.words("part"), [*FIRST_WORDS, "JOB_ID=part", *HOW])
        self.assertEqual(self.words("part", "-n", "3"), [*FIRST_WORDS, "JOB_ID=part", *HOW, "--lines=3"])
        self.assertEqual(self.words("--lines", "7"), [*FIRST_WORDS, *HOW, "--lines=7"])

    def test_a_file_name_also_selects_its_job_and_control_characters_are_replaced(self):
        self.assertEqual(self.words("part.stl"), [*FIRST_WORDS, "JOB_ID=part.stl", "JOB_ID=part", *HOW])
        self.assertEqual(self.words("two\nlines \x1b"), [*FIRST_WORDS, "JOB_ID=two?lines ?", *HOW])
        self.assertEqual(self.words("--", "--flush"), [*FIRST_WORDS, "JOB_ID=--flush", *HOW])

    def test_following_works_even_without_a_line(self):
        self.assertEqual(self.asked("-f", journalctl=SILENT, code=OK).stderr, b"empty\n")
        self.assertEqual(self.words("part", "--follow"), [*FIRST_WORDS, "JOB_ID=part", *HOW, "--follow"])

    def test_without_a_readable_line_there_is_one_line_of_error(self):
        result = self.asked("part", journalctl=SILENT, code=FAILED)
        self.assert_one_line(result.stderr, 'no lines of a job "part" that you may read')
        self.assertEqual(result.stdout, b"")

    def test_without_a_journal_there_is_one_line_of_error(self):
        result = contourctl("logs", env={**os.environ, "PATH": self.folder})
        self.assert_refusal(result, UNAVAILABLE, "cannot read the journal")

    def test_a_wrong_number_of_lines_is_bad_usage(self):
        for wrong in ("0", "-1", "x", "", "1000001"):
            self.assertEqual(contourctl("logs", "-n", wrong).returncode, BAD_USAGE, wrong)
        self.assertEqual(contourctl("logs", "").returncode, BAD_USAGE)
