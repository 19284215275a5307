#!/usr/bin/env python3
"""What contourctl cannot do: without a daemon, without rights, in the wrong state, with a wrong value. One line that says what to
do, its exit code, and nothing changed."""

import json
import os
import subprocess
import unittest

from harness import (
    BAD_USAGE, CONTOURCTL, FAILED, NIMBLE_RESIN, REALTIME, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, contourctl, main,
)  # fmt: skip

NOBODY = 65534
PART = binary_stl(box((0, 0, 0), (10, 5, 1)))
# Each that wants contourd, as it would be right.
ASKING = (["status"], ["queue"], ["queue", "show", "part"], ["history"], ["usage"], ["mask"], ["watch"], ["watch", "--job", "part"],
          ["switches"], ["switches", "--once"])  # fmt: skip
TELLING = (["queue", "remove", "part"], ["queue", "move", "part", "--first"], ["accept", "part"], ["pause"], ["resume"], ["cancel"],
           ["plate-cleared"], ["replaced", "film"], ["stop"], ["light", "off"])  # fmt: skip
SERVICE = (["home"], ["move", "--to", "5"], ["move", "--by", "1"], ["move", "--by", "1", "--unhomed"], ["motor", "off"],
           ["light", "on", "--seconds", "1", "--confirm"], ["show", "grid"], ["projector", "status"], ["projector", "on"],
           ["projector", "off"])  # fmt: skip


class Refusals(FolderTest):
    def daemon(self):
        return Daemon(self, json.loads(json.dumps(REALTIME)), NIMBLE_RESIN).start()

    def refused(self, told, code, *parts):
        self.assertEqual(told.returncode, code, told)
        self.assertEqual(told.stdout, b"")
        self.assert_one_line(told.stderr)
        for part in parts:
            self.assertIn(part, told.stderr.decode())

    def test_without_a_daemon_each_says_how_to_see_whether_it_runs(self):
        for words in (*ASKING, *TELLING, *SERVICE):
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", self.path("none")), UNAVAILABLE,
                             f"cannot reach contourd on {self.path('none')}: No such file", "systemctl status contourd says")  # fmt: skip

    def as_nobody(self, *words):
        return subprocess.run([CONTOURCTL, *words], capture_output=True, check=False, timeout=60, user=NOBODY, group=NOBODY, extra_groups=[])

    def for_nobody(self, daemon, mode):
        """The socket's folder can be entered by all, the socket by its mode."""
        if os.geteuid() != 0:
            self.skipTest("only root can be somebody else")
        folder = os.path.dirname(daemon.socket_path)
        os.chmod(folder, 0o755)
        os.chmod(daemon.socket_path, mode)
        try:
            self.as_nobody("--version")
        except OSError as error:
            self.skipTest(f"nobody cannot run contourctl here: {error}")
        if subprocess.run(["test", "-x", folder], check=False, user=NOBODY, group=NOBODY, extra_groups=[]).returncode:
            self.skipTest("nobody cannot enter the folder of this test")

    def test_without_rights_each_says_which_group_it_takes(self):
        daemon = self.daemon()
        self.for_nobody(daemon, 0o660)
        for words in (*ASKING, *TELLING, *SERVICE):
            with self.subTest(words):
                self.refused(self.as_nobody(*words, "--socket", daemon.socket_path), UNAVAILABLE, "Permission denied",
                             "sudo adduser NAME contourd, then log in anew")  # fmt: skip
        daemon.stop()

    def test_who_may_ask_and_not_move_is_told_the_group_for_that(self):
        daemon = self.daemon()
        self.for_nobody(daemon, 0o666)
        before = daemon.status()
        for words in SERVICE:
            with self.subTest(words):
                self.refused(self.as_nobody(*words, "--socket", daemon.socket_path), FAILED,
                             "root and the group contourd-service: sudo adduser NAME contourd-service")  # fmt: skip
        self.assertEqual(daemon.status(), before)
        daemon.stop()

    def test_what_there_is_not_or_is_not_now_is_said_and_changes_nothing(self):
        daemon = self.daemon()
        before = daemon.status()
        for words, part in ((["pause"], "no print"), (["cancel"], "no print"), (["queue", "show", "part"], "part"),
                            (["queue", "remove", "part"], "part"), (["queue", "move", "part", "--last"], "part"), (["accept", "part"], "part"),
                            (["mask"], "black"), (["move", "--to", "5"], "home comes first"), (["move", "--to", "5000"], "home comes first"),
                            (["move", "--by", "3", "--unhomed"], "from -2 to 2 mm"), (["light", "on", "--seconds", "3600", "--confirm"], "from 0.001 to"),
                            (["light", "on", "--seconds", "1", "--confirm"], "--in-resin"), (["show", "gird"], "white, black, grid")):  # fmt: skip
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", daemon.socket_path), FAILED, part)
        told = contourctl("watch", "--job", "part", "--socket", daemon.socket_path)  # it may be on its way for a moment
        self.assertEqual((told.returncode, told.stdout), (FAILED, b""))
        self.assertIn("there is no job part", told.stderr.decode())
        self.assertEqual(daemon.status(), before)
        daemon.stop()

    def test_wrong_words_are_said_without_a_daemon_and_with_their_command(self):
        for words in (["hoem"], ["move", "--by", "far"], ["move", "--to", "1", "--by", "1"], ["move", "--to", "5", "--unhomed"],
                      ["move", "--by", "1", "--speed", "1", "--unhomed"], ["light", "on"], ["light"], ["queue", "move", "part"], ["replaced", "screw"],
                      ["history", "--last", "0"], ["queue", "move", "part", "--to", "0"], ["show"], ["preview"]):  # fmt: skip
            with self.subTest(words):
                told = contourctl(*words)
                self.assertEqual(told.returncode, BAD_USAGE, told)
                self.assertEqual(told.stdout, b"")
                self.assertLessEqual(len(told.stderr.decode().splitlines()), 2, told)

    def test_in_a_print_nothing_is_done_by_hand(self):
        daemon = self.daemon()
        daemon.drop("part.stl", PART)
        daemon.wait_state("exposing")
        for words in SERVICE:
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", daemon.socket_path), FAILED, "part is being printed")
        daemon.stop()


if __name__ == "__main__":
    main()
