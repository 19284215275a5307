#!/usr/bin/env python3
"""contourctl logs: what it asks journalctl for. A program in journalctl's place says what it was asked."""

import os

from harness import BAD_USAGE, FAILED, OK, UNAVAILABLE, FolderTest, contourctl, main

ASKED = """#!/bin/sh
for word; do printf '%s\\n' "$word"; done
exit 7
"""
SILENT = "#!/bin/sh\necho nobody >&2\n"
FIRST_WORDS = ["--unit=contourd.service"]
HOW = ["--output=short", "--no-hostname"]


class Logs(FolderTest):
    def asked(self, *words, journalctl=ASKED, code=7):
        path = self.path("journalctl")
        with open(path, "w", encoding="utf-8") as file:
            file.write(journalctl)
        os.chmod(path, 0o755)
        told = contourctl("logs", *words, env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.assertEqual(told.returncode, code, told)
        return told

    def words(self, *words):
        return self.asked(*words).stdout.decode().splitlines()

    def test_all_of_a_job_the_latest_of_the_daemon_or_as_many_as_are_asked_for(self):
        self.assertEqual(self.words(), [*FIRST_WORDS, *HOW, "--lines=100"])
        self.assertEqual(self.words("part"), [*FIRST_WORDS, "JOB_ID=part", *HOW])
        self.assertEqual(self.words("part", "-n", "3"), [*FIRST_WORDS, "JOB_ID=part", *HOW, "--lines=3"])
        self.assertEqual(self.words("--lines", "7"), [*FIRST_WORDS, *HOW, "--lines=7"])

    def test_a_file_stands_for_its_job_and_a_name_is_as_the_log_has_it(self):
        self.assertEqual(self.words("part.stl"), [*FIRST_WORDS, "JOB_ID=part.stl", "JOB_ID=part", *HOW])
        self.assertEqual(self.words("two\nlines \x1b"), [*FIRST_WORDS, "JOB_ID=two?lines ?", *HOW])
        self.assertEqual(self.words("--", "--flush"), [*FIRST_WORDS, "JOB_ID=--flush", *HOW])

    def test_following_begins_also_where_there_is_nothing_yet(self):
        self.assertEqual(self.asked("-f", journalctl=SILENT, code=OK).stderr, b"nobody\n")
        self.assertEqual(self.words("part", "--follow"), [*FIRST_WORDS, "JOB_ID=part", *HOW, "--follow"])

    def test_where_nothing_can_be_read_it_says_so_in_a_line(self):
        told = self.asked("part", journalctl=SILENT, code=FAILED)
        self.assert_one_line(told.stderr, 'no lines of a job "part" that you may read')
        self.assertEqual(told.stdout, b"")

    def test_without_a_journal_it_says_so_in_a_line(self):
        told = contourctl("logs", env={**os.environ, "PATH": self.folder})
        self.assertEqual(told.returncode, UNAVAILABLE)
        self.assert_one_line(told.stderr, "there is no journal")

    def test_what_is_no_number_of_lines_is_refused(self):
        for wrong in ("0", "-1", "x", "", "1000001"):
            self.assertEqual(contourctl("logs", "-n", wrong).returncode, BAD_USAGE, wrong)
        self.assertEqual(contourctl("logs", "").returncode, BAD_USAGE)


if __name__ == "__main__":
    main()
