"""contourctl without a daemon, without permission, in the wrong state, or with a wrong value: it exits with an error code and
one line that says what to do, and it changes nothing."""

import os
import subprocess

from harness import BAD_USAGE, CONTOURCTL, FAILED, NIMBLE_RESIN, REALTIME, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, contourctl

OTHER_USER = 65534
PART = binary_stl(box((0, 0, 0), (10, 5, 1)))
# Valid calls of every command that needs contourd, by the rights that the commands need.
QUERIES = (["status"], ["queue"], ["queue", "show", "part"], ["history"], ["usage"], ["mask"], ["watch"], ["watch", "--job", "part"],
          ["switches"], ["switches", "--once"])  # fmt: skip
CONTROLS = (["queue", "remove", "part"], ["queue", "move", "part", "--first"], ["accept", "part"], ["pause"], ["resume"], ["cancel"],
           ["plate-cleared"], ["replaced", "film"], ["stop"], ["light", "off"])  # fmt: skip
SERVICE = (["home"], ["move", "--to", "5"], ["move", "--by", "1"], ["move", "--by", "1", "--unhomed"], ["motor", "off"],
           ["light", "on", "--seconds", "1", "--confirm"], ["show", "grid"], ["projector", "status"], ["projector", "on"],
           ["projector", "off"])  # fmt: skip


class Refusals(FolderTest):
    def daemon(self):
        return Daemon(self, REALTIME, NIMBLE_RESIN).start()

    def refused(self, result, code, *parts):
        self.assert_refusal(result, code)
        self.assert_words(result.stderr.decode(), *parts)

    def test_without_a_daemon_the_error_says_how_to_check_whether_it_runs(self):
        for words in (*QUERIES, *CONTROLS, *SERVICE):
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", self.path("none")), UNAVAILABLE,
                             f"cannot reach contourd on {self.path('none')}: No such file", "systemctl status contourd shows")  # fmt: skip

    def as_other_user(self, *words):
        return subprocess.run([CONTOURCTL, *words], capture_output=True, check=False, timeout=60, user=OTHER_USER, group=OTHER_USER, extra_groups=[])

    def allow_other_user(self, daemon, mode):
        """Makes the socket's folder accessible to all users, and gives the socket this mode."""
        if os.geteuid() != 0:
            self.skipTest("only root can become another user")
        folder = os.path.dirname(daemon.socket_path)
        os.chmod(folder, 0o755)
        os.chmod(daemon.socket_path, mode)
        try:
            self.as_other_user("--version")
        except OSError as error:
            self.skipTest(f"another user cannot run contourctl here: {error}")
        if subprocess.run(["test", "-x", folder], check=False, user=OTHER_USER, group=OTHER_USER, extra_groups=[]).returncode:
            self.skipTest("another user cannot enter the folder of this test")

    def test_without_permission_the_error_names_the_required_group(self):
        daemon = self.daemon()
        self.allow_other_user(daemon, 0o660)
        for words in (*QUERIES, *CONTROLS, *SERVICE):
            with self.subTest(words):
                self.refused(self.as_other_user(*words, "--socket", daemon.socket_path), UNAVAILABLE, "Permission denied",
                             "sudo adduser NAME contourd, then log in again")  # fmt: skip

    def test_without_permission_to_move_the_error_names_the_service_group(self):
        daemon = self.daemon()
        self.allow_other_user(daemon, 0o666)
        before = daemon.status()
        for words in SERVICE:
            with self.subTest(words):
                self.refused(self.as_other_user(*words, "--socket", daemon.socket_path), FAILED,
                             "root and the group contourd-service: sudo adduser NAME contourd-service")  # fmt: skip
        self.assertEqual(daemon.status(), before)

    def test_unknown_jobs_and_wrong_states_are_errors_and_change_nothing(self):
        daemon = self.daemon()
        before = daemon.status()
        for words, part in ((["pause"], "no print"), (["cancel"], "no print"), (["queue", "show", "part"], "part"),
                            (["queue", "remove", "part"], "part"), (["queue", "move", "part", "--last"], "part"), (["accept", "part"], "part"),
                            (["mask"], "black"), (["move", "--to", "5"], "home first"), (["move", "--to", "5000"], "from 0 to 12 mm"),
                            (["move", "--by", "3", "--unhomed"], "from -2 to 2 mm"), (["light", "on", "--seconds", "3600", "--confirm"], "from 0.001 to"),
                            (["light", "on", "--seconds", "1", "--confirm"], "--in-resin"), (["show", "gird"], "white, black, grid")):  # fmt: skip
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", daemon.socket_path), FAILED, part)
        # contourctl first waits a moment, since the job may still arrive.
        result = contourctl("watch", "--job", "part", "--socket", daemon.socket_path)
        self.assertEqual((result.returncode, result.stdout), (FAILED, b""))
        self.assertIn("there is no job part", result.stderr.decode())
        self.assertEqual(daemon.status(), before)

    def test_bad_usage_is_reported_without_a_daemon(self):
        for words in (["hoem"], ["move", "--by", "far"], ["move", "--to", "1", "--by", "1"], ["move", "--to", "5", "--unhomed"],
                      ["move", "--by", "1", "--speed", "1", "--unhomed"], ["light", "on"], ["queue", "move", "part"], ["replaced", "screw"],
                      ["history", "--last", "0"], ["queue", "move", "part", "--to", "0"], ["show"], ["preview"]):  # fmt: skip
            with self.subTest(words):
                result = contourctl(*words, expect=BAD_USAGE)
                self.assertEqual(result.stdout, b"")
                self.assertLessEqual(len(result.stderr.decode().splitlines()), 2, result)

    def test_manual_commands_are_refused_during_a_print(self):
        daemon = self.daemon()
        daemon.begin("part.stl", PART)
        for words in SERVICE:
            with self.subTest(words):
                self.refused(contourctl(*words, "--socket", daemon.socket_path), FAILED, "part is being printed")
