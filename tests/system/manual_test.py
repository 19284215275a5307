"""Manual control: contourctl home, move, light and so on; who may use it, what ends it, and its exclusion of prints."""

import contextlib
import fcntl
import json
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import termios
import time
import unittest

from harness import (
    BAD_CONFIG, BAD_USAGE, CONTOURCTL, CONTOURD, DEADLINE_S, ENDLESS, FAILED, NIMBLE_RESIN, OK, REALTIME, SLOWNESS, SMALL, UNAVAILABLE, Daemon,
    FolderTest, contourctl, realtime, text_of, wait_until,
)  # fmt: skip

# Every motion takes seconds, so that a test can end it.
SLOW = realtime(z_axis={"homing_speed_mm_s": 2, "travel_speed_mm_s": 2, "travel_mm": 100}, simulation={"start_height_mm": 60})


class ManualTest(FolderTest):
    def daemon(self, config=None, resin=None):
        return Daemon(self, config or REALTIME, resin or NIMBLE_RESIN).start()

    def run_ctl(self, daemon, *words, **options):
        return contourctl(*words, "--socket", daemon.socket_path, **options)

    def well(self, result, *words):
        self.assertEqual((result.returncode, result.stderr), (OK, b""), result)
        self.assert_words(result.stdout.decode(), *words)

    def manual(self, daemon):
        return daemon.status()["manual"]

    def start(self, daemon, *words, until=None):
        """Starts a command, and waits until the status of manual control is `until`."""
        process = subprocess.Popen([CONTOURCTL, *words, "--socket", daemon.socket_path], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        if until:
            wait_until(lambda: self.manual(daemon)["state"] == until, f"manual control to be {until}")
        return self.killed_at_the_end(process)


class Commands(ManualTest):
    def test_home_move_and_motor_off_print_the_height_of_the_plate(self):
        daemon = self.daemon()
        self.assert_refusal(self.run_ctl(daemon, "move", "--to", "3"), FAILED, "home first")
        self.well(self.run_ctl(daemon, "home"), "homing\n", "height    0.000 mm")
        self.well(self.run_ctl(daemon, "move", "--to", "3"), "moving\n", "height    3.000 mm")
        self.well(self.run_ctl(daemon, "move", "--by", "-1.5", "--speed", "20"), "height    1.500 mm")
        self.assert_refusal(self.run_ctl(daemon, "move", "--to", "13"), FAILED, "--to must be a number from 0 to 12 mm")
        self.well(self.run_ctl(daemon, "motor", "off"), "height    unknown")

    def test_a_refusal_names_the_options_of_contourctl(self):
        daemon = self.daemon()
        self.well(self.run_ctl(daemon, "home"))
        self.well(self.run_ctl(daemon, "motor", "off"))
        for arguments in ["move"], ["move", "--to", "1", "--by", "1"]:
            result = self.run_ctl(daemon, *arguments)
            self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), result)
            self.assertIn(b"1 option from [--to,--by] is required", result.stderr)
        for arguments, word in (
            (["move", "--by", "-3", "--unhomed"], "--by must be"), (["move", "--to", "1", "--speed", "1000"], "--speed must be"),
            (["light", "on", "--seconds", "9000", "--confirm"], "--seconds must be"), (["show", "white", "--seconds", "0"], "--seconds must be"),
            (["show", "what"], "PATTERN must be one of white"),
        ):  # fmt: skip
            self.assert_refusal(self.run_ctl(daemon, *arguments), FAILED, word)

    def test_light_needs_confirmation_has_a_limit_and_goes_off_at_the_end(self):
        daemon = self.daemon()
        self.assert_refusal(self.run_ctl(daemon, "light", "on", "--seconds", "1", stdin=subprocess.DEVNULL), BAD_USAGE, "--confirm")
        self.assert_refusal(self.run_ctl(daemon, "light", "on", "--seconds", "1", "--confirm"), FAILED, "in the resin")
        self.assert_refusal(self.run_ctl(daemon, "light", "on", "--seconds", "31", "--confirm", "--in-resin"), FAILED, "30 s")
        self.well(self.run_ctl(daemon, "light", "on", "--seconds", "0.1", "--confirm", "--in-resin"), "lit\n")
        self.assertEqual(self.manual(daemon)["state"], "idle")
        self.well(self.run_ctl(daemon, "light", "off"))

    def test_on_a_terminal_light_asks_for_confirmation(self):
        daemon = self.daemon()
        for word, code in (("no", FAILED), ("yes", OK)):
            mine, its = pty.openpty()
            self.addCleanup(os.close, mine)
            process = subprocess.Popen([CONTOURCTL, "light", "on", "--seconds", "0.1", "--in-resin", "--socket", daemon.socket_path],
                                       stdin=its, stdout=its, stderr=its)  # fmt: skip
            os.close(its)
            received = b""
            while b"yes/no" not in received:
                self.assertTrue(select.select([mine], [], [], DEADLINE_S)[0])
                received += os.read(mine, 4096)
            self.assertEqual(self.manual(daemon)["operations"], 0)
            os.write(mine, word.encode() + b"\n")
            self.assertEqual(process.wait(DEADLINE_S), code)
            if word == "no":
                self.assertIn(b'the light stays off: only "yes" turns it on', os.read(mine, 4096))
        self.assertEqual(self.manual(daemon)["operations"], 1)

    def test_the_projector_can_be_queried_and_switched(self):
        daemon = self.daemon()
        self.well(self.run_ctl(daemon, "projector", "status"), "projector off")
        self.well(self.run_ctl(daemon, "projector", "on"), "powering on", "projector on")
        self.well(self.run_ctl(daemon, "projector", "status"), "projector on")
        self.well(self.run_ctl(daemon, "projector", "off"), "projector is powering off")
        self.well(self.run_ctl(daemon, "projector", "status"), "projector off")

    def test_a_pattern_is_shown_for_its_time_and_an_unknown_one_is_an_error(self):
        daemon = self.daemon()
        began = time.monotonic()
        self.well(self.run_ctl(daemon, "show", "grid", "--seconds", "0.3"), "grid is shown")
        self.assertGreaterEqual(time.monotonic() - began, 0.3)
        self.assert_refusal(self.run_ctl(daemon, "show", "gird"), FAILED, "white, black, grid")

    def test_switches_are_printed_once_or_at_each_change(self):
        daemon = self.daemon()
        self.well(self.run_ctl(daemon, "switches", "--once"), "limit switch    reached             0 edges  simulated\n")
        inputs = json.loads(self.run_ctl(daemon, "switches", "--once", "--json").stdout)
        self.assertEqual(inputs, [{"name": "limit switch", "line": "simulated", "active": True, "edges": 0}])
        process = subprocess.Popen([CONTOURCTL, "switches", "--socket", daemon.socket_path], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)  # fmt: skip
        self.killed_at_the_end(process)
        self.assertIn("0 edges", process.stdout.readline())
        self.well(self.run_ctl(daemon, "home"))
        line = process.stdout.readline()
        while " 2 edges" not in line:  # it may report the edges one by one
            line = process.stdout.readline()
        self.assertIn("limit switch    reached", line)
        daemon.drop("part.stl", SMALL)
        self.assertEqual(process.communicate(timeout=DEADLINE_S)[1],
                         "contourctl: part is being printed: the inputs are read while nothing prints\n")  # fmt: skip
        self.assertEqual(process.returncode, FAILED)

    def test_without_a_daemon_each_command_says_so(self):
        for words in (["home"], ["move", "--to", "1"], ["stop"], ["motor", "off"], ["light", "off"], ["show", "grid"],
                      ["light", "on", "--seconds", "1", "--confirm"], ["projector", "status"], ["projector", "on"], ["switches"]):  # fmt: skip
            with self.subTest(words):
                self.assert_refusal(contourctl(*words, "--socket", self.path("none")), UNAVAILABLE, "cannot reach contourd")


class Jog(ManualTest):
    def jog(self, daemon, *words, columns=80, terminal="xterm", until="step 1 mm   idle"):
        """Starts contourctl jog in a terminal. Returns the process, a function that types keys and waits for a text, and the terminal."""
        mine, its = pty.openpty()
        self.addCleanup(os.close, mine)
        termios.tcsetwinsize(its, (24, columns))
        process = subprocess.Popen([CONTOURCTL, "jog", "--socket", daemon.socket_path, *words], stdin=its, stdout=its, stderr=its,
                                   env={**os.environ, "TERM": terminal})  # fmt: skip
        self.killed_at_the_end(process)
        os.close(its)
        shown = b""

        def press(keys, until):
            nonlocal shown
            shown = b""
            os.write(mine, keys.encode())
            while until.encode() not in shown:
                self.assertTrue(select.select([mine], [], [], DEADLINE_S)[0], shown)
                shown += os.read(mine, 4096)
            return shown.decode()
        self.beginning = press("", until)
        return process, press, mine

    def quit(self, process, press, key="q"):
        press(key, "\n")
        self.assertEqual(process.wait(DEADLINE_S), OK)

    def test_keys_home_and_move_the_plate_and_refusals_are_shown(self):
        daemon = self.daemon()
        process, press, _ = self.jog(daemon)
        press("k", "home first")
        press("h", "height 0.000 mm   step 1 mm   idle")
        press("\x1b[A", "height 1.000 mm   step 1 mm   idle")
        press("2", "step 0.1 mm")
        press("\x1bOA", "height 1.100 mm   step 0.1 mm   idle")
        press("j", "height 1.000 mm   step 0.1 mm   idle")
        press("\x1b[1;5Cxyz4", "step 10 mm")  # keys without a meaning
        press("\x1b[B", "the plate cannot go to -9.000 mm")
        press("g", "idle   shows grid")
        press("g", "idle   shows border")
        press("m", "height unknown")
        self.quit(process, press)
        wait_until(lambda: self.manual(daemon)["picture"] is None, "the picture to be removed")

    def test_jog_shows_that_a_job_is_being_printed(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.begin("part.stl", SMALL)
        process, press, _ = self.jog(daemon, until="step 1 mm   printing")
        press("k", "part is being printed")
        self.quit(process, press)
        daemon.rpc("cancel")

    def test_nothing_is_wider_than_a_narrow_terminal(self):
        daemon = self.daemon()
        process, press, _ = self.jog(daemon, columns=40)
        said = self.beginning + press("h", "height 0.000 mm   step 1 mm   idle") + press("g", "step 1 mm   idle   s")
        for line in re.split("[\r\n]+", said.replace("\x1b[K", "")):
            self.assertLessEqual(len(line), 40, line)
        self.quit(process, press)

    def test_a_dumb_terminal_gets_no_control_sequences(self):
        daemon = self.daemon()
        process, press, _ = self.jog(daemon, terminal="dumb")
        said = self.beginning + press("k", "home first") + press("h", "height 0.000 mm   step 1 mm   idle\r\n")
        self.assertNotIn("\x1b", said)
        lines = said.replace("\r", "").splitlines()
        self.assertTrue(all(line != before for line, before in zip(lines[1:], lines)), lines)
        self.quit(process, press)

    def test_light_asks_for_confirmation_and_only_y_confirms(self):
        daemon = self.daemon()
        process, press, _ = self.jog(daemon, "--in-resin", "--light-seconds", "0.1")
        press("l", "Eyes protected")
        press("h", "idle")
        self.assertEqual(self.manual(daemon)["operations"], 0)
        press("l", "for 0.1 s")
        press("y", "lit")
        press("", "idle")
        self.quit(process, press, "\x03")

    def test_space_quitting_a_lost_terminal_and_a_signal_end_a_motion_and_restore_the_terminal(self):
        for how in ("space", "quit", "hang up", "terminate"):
            with self.subTest(how):
                daemon = self.daemon(SLOW)
                process, press, mine = self.jog(daemon)
                before = termios.tcgetattr(mine)
                self.assertFalse(before[3] & termios.ICANON)
                press("h", "homing")
                if how == "space":
                    press(" ", "stopped")
                    wait_until(lambda: self.manual(daemon)["state"] == "idle", "the motion to end")
                    press("q", "\n")
                elif how == "quit":
                    press("q", "\n")
                elif how == "hang up":
                    process.send_signal(signal.SIGHUP)
                else:
                    process.send_signal(signal.SIGTERM)
                self.assertEqual(process.wait(DEADLINE_S), OK)
                self.assertTrue(termios.tcgetattr(mine)[3] & termios.ICANON)
                wait_until(lambda: self.manual(daemon)["state"] == "idle", "the motion to end")
                self.assertIn("by hand: stopped", daemon.log())
                daemon.stop()

    def test_jog_without_a_terminal_is_bad_usage(self):
        daemon = self.daemon()
        self.assert_refusal(self.run_ctl(daemon, "jog", stdin=subprocess.DEVNULL), BAD_USAGE, "jog: this needs a terminal")


class Level(ManualTest):
    ENTER = ""

    def level(self, daemon, *answers):
        lines = "".join(answer + "\n" for answer in answers)
        return self.run_ctl(daemon, "level", "--config", daemon.config_path, input=lines.encode(), stdin=None)

    def config(self, daemon):
        return text_of(daemon.config_path)

    def test_the_height_found_with_the_paper_is_stored_and_nothing_else_is_changed(self):
        # Cases: the plate must go below 0, or the paper already drags above 0.
        for answers, stored in ((["0.5", "-0.2", ""], -0.2), (["", "0.35"], 0.45)):
            with self.subTest(stored):
                daemon = self.daemon()
                before = json.loads(self.config(daemon))
                result = self.level(daemon, "", "", "", *answers, "0.1", "")
                self.well(result, "homing", "height    0.000 mm", "mm (Enter: it touches)" if stored > 0 else "Now at 0.300 mm",
                          f"switch_height_mm changes from 0 to {stored:g}", "Written.")  # fmt: skip
                before["z_axis"]["switch_height_mm"] = stored
                self.assertEqual(json.loads(self.config(daemon)), before)
                self.assertEqual(self.manual(daemon)["height_mm"], 12)  # out of the way
                daemon.stop()

    def test_ending_at_any_question_changes_nothing(self):
        daemon = self.daemon()
        before = self.config(daemon)
        answers = ["", "", "", "0.3", "", "0.1", ""]
        for asked in range(len(answers)):
            for end in ([], ["q"]):
                result = self.level(daemon, *answers[:asked], *end)
                self.assertEqual((result.returncode, result.stderr), (FAILED, b""), result)
                self.assertIn(b"Nothing was changed.", result.stdout)
        self.assertEqual(self.config(daemon), before)

    def test_a_question_mark_explains_the_question_and_moves_nothing(self):
        daemon = self.daemon()
        result = self.level(daemon, "?", "?", "q")
        self.assertEqual(result.stdout.count(b"Press Enter to home the plate. \nEnter continues; q quits.\n"), 2, result)
        self.assertIsNone(self.manual(daemon)["height_mm"])
        result = self.level(daemon, "", "", "", "?", "q")
        self.assertIn(b"drags)? \nExpected a number from -12 to 12; q quits.\n", result.stdout)

    def test_lines_end_between_words_on_a_terminal_of_any_width(self):
        daemon = self.daemon()
        for columns in (40, 80, 200):
            terminal, its = pty.openpty()
            fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
            self.run_ctl(daemon, "level", "--config", daemon.config_path, input=b"\n\n\n0.5\nq\n", stdin=None, stdout=its)
            os.close(its)
            shown = b""
            with contextlib.suppress(OSError), open(terminal, "rb", buffering=0) as file:
                while data := file.read(65536):
                    shown += data
            lines = shown.decode().split("\r\n")
            self.assertLessEqual(max(map(len, lines)), columns + 1)  # and the space after a question
            for sentence in (
                "2. Loosen the plate's clamp, so that the plate swings freely, and lay a sheet of paper on the film.",
                "4. Find the height at which the paper just drags when it is pulled: enter distances in mm to move the plate, negative for down.",
                "Now at 0.000 mm. Move by (Enter: the paper just drags)?",
            ):  # fmt: skip
                self.assertIn(sentence, " ".join(shown.decode().split()))

    def test_a_wrong_number_or_an_impossible_move_is_reported_and_asked_again(self):
        daemon = self.daemon()
        result = self.level(daemon, "", "", "", "up", "-0.5", "+0.3", "", "1e9", "0.1", "")
        self.assertEqual(result.returncode, OK, result)
        self.assertIn(b"Expected a number from -12 to 12; q quits.", result.stdout)
        self.assertIn(b"Expected a number from 0 to 5; q quits.", result.stdout)
        self.assert_one_line(result.stderr, "the plate cannot go to -0.500 mm")

    def test_a_wrong_or_missing_configuration_is_not_touched(self):
        daemon = self.daemon()
        wrong = text_of(daemon.config_path).replace('"travel_mm": 12', '"travel_mm": -12')
        path = self.write("wrong.json", wrong.encode())
        result = self.run_ctl(daemon, "level", "--config", path, input=b"\n" * 9, stdin=None)
        self.assert_refusal(result, BAD_CONFIG, "wrong.json: /z_axis/travel_mm")
        self.assert_refusal(self.run_ctl(daemon, "level", "--config", self.path("none")), BAD_CONFIG, "none")


class Ends(ManualTest):
    """However the client of an operation ends, the motor stops, the light goes off and the screen goes black at once."""

    ENDED_S = 0.1 * SLOWNESS  # the required limit

    def ended_within(self, daemon, over, since):
        wait_until(over, "the operation to end")
        took = time.monotonic() - since
        self.assertLess(took, self.ENDED_S + 0.1)  # plus the time to poll

    def test_light_goes_off_when_its_client_is_killed(self):
        for number in (signal.SIGKILL, signal.SIGINT, signal.SIGHUP):
            with self.subTest(number):
                daemon = self.daemon()
                process = self.start(daemon, "light", "on", "--seconds", "30", "--confirm", "--in-resin", until="lit")
                process.send_signal(number)
                self.ended_within(daemon, lambda: self.manual(daemon)["state"] == "idle", time.monotonic())
                self.assertIn("by hand: stopped", daemon.log())
                daemon.stop()

    def test_the_plate_stops_when_its_client_is_killed(self):
        daemon = self.daemon(SLOW)
        process = self.start(daemon, "home", until="homing")
        process.kill()
        self.ended_within(daemon, lambda: self.manual(daemon)["state"] == "idle", time.monotonic())

    def test_a_picture_is_removed_only_when_its_own_client_ends(self):
        daemon = self.daemon(SLOW)
        shows, moves = self.start(daemon, "show", "grid"), self.start(daemon, "home")
        wait_until(lambda: self.manual(daemon)["picture"] and self.manual(daemon)["state"] == "homing", "both operations to run")
        shows.kill()
        self.ended_within(daemon, lambda: self.manual(daemon)["picture"] is None, time.monotonic())
        self.assertEqual(self.manual(daemon)["state"], "homing")
        moves.kill()

    def test_the_light_of_a_client_that_keeps_asking_goes_off_when_it_ends(self):
        daemon = self.daemon()
        client = socket.socket(socket.AF_UNIX)
        client.connect(daemon.socket_path)
        client.sendall(b'{"jsonrpc":"2.0","method":"light_on","params":{"seconds":30,"in_resin":true},"id":1}\n')
        wait_until(lambda: self.manual(daemon)["state"] == "lit", "the light to be on")
        client.setblocking(False)
        try:
            while True:
                client.send(b'{"jsonrpc":"2.0","method":"status","id":2}\n' * 100)
        except BlockingIOError:
            pass
        client.close()
        self.ended_within(daemon, lambda: self.manual(daemon)["state"] == "idle", time.monotonic())

    def test_sigterm_and_reload_end_the_operation_before_the_daemon_ends(self):
        for end in ("stop", "reload"):
            with self.subTest(end):
                daemon = self.daemon()
                process = self.start(daemon, "light", "on", "--seconds", "30", "--confirm", "--in-resin", until="lit")
                if end == "stop":
                    daemon.stop()
                else:
                    daemon.reload()
                    daemon.wait_restart()
                self.assertIn("light off, motor still", daemon.log())
                self.assertEqual(process.wait(DEADLINE_S), FAILED)  # it was notified

    def test_any_client_can_stop_the_operation(self):
        daemon = self.daemon(SLOW)
        process = self.start(daemon, "home", until="homing")
        self.well(self.run_ctl(daemon, "stop"))
        self.assertEqual(process.wait(DEADLINE_S), FAILED)
        self.assertEqual(self.manual(daemon)["problem"], "stopped")


class WithJobs(ManualTest):
    def test_manual_commands_are_refused_during_a_print(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        daemon.begin("part.stl", SMALL)
        for words in (["home"], ["move", "--to", "1"], ["stop"], ["motor", "off"], ["light", "off"], ["show", "grid"],
                      ["light", "on", "--seconds", "1", "--confirm"], ["projector", "status"], ["projector", "off"]):  # fmt: skip
            with self.subTest(words):
                self.assert_refusal(self.run_ctl(daemon, *words), FAILED, "part is being printed")
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_a_job_that_arrives_waits_until_the_operation_ends(self):
        daemon = self.daemon(SLOW)
        process = self.start(daemon, "home", until="homing")
        daemon.drop("part.stl", SMALL)
        daemon.wait_status("waiting_for")
        self.assertEqual(daemon.status()["waiting_for"], 'the printer is controlled by hand; "contourctl stop" ends that')
        process.kill()
        daemon.wait_state("homing")

    def test_the_plate_is_not_lowered_on_a_part(self):
        daemon = self.daemon({**REALTIME, "wait_for_plate_cleared": True})
        daemon.printed("part.stl", SMALL)
        self.assert_refusal(self.run_ctl(daemon, "home"), FAILED, "part is on the plate")
        self.assert_refusal(self.run_ctl(daemon, "move", "--by", "-1"), FAILED, "part is on the plate")
        self.well(self.run_ctl(daemon, "home", "--plate-is-clear"))
        daemon.rpc("plate_cleared")
        self.well(self.run_ctl(daemon, "home"))


@unittest.skipUnless(os.geteuid() == 0, "another user is needed")
class Rights(ManualTest):
    GROUP, SERVICE_GROUP, SERVICE, MEMBER = 64000, 64003, 64001, 64002  # ids of no other user or group

    def test_only_members_of_the_service_group_may_use_motor_and_light(self):
        daemon = Daemon(self, REALTIME, NIMBLE_RESIN)
        os.chmod(self.folder, 0o777)
        programs = [self.reachable(each) for each in (CONTOURD, CONTOURCTL)]
        daemon.program = programs[0]
        for name in ("run", "state"):
            os.mkdir(self.path(name))
            os.chown(self.path(name), self.SERVICE, self.GROUP)
        daemon.config["control_socket"] = daemon.socket_path = self.path("run", "control.sock")
        daemon.write_config()
        daemon.rights = {"user": self.SERVICE, "group": self.GROUP, "extra_groups": [], "umask": 0o002}
        daemon.environment["STATE_DIRECTORY"] = self.path("state")
        daemon.start()

        def member(*words, groups=(self.GROUP,)):
            return subprocess.run([programs[1], *words, "--socket", daemon.socket_path], user=self.MEMBER, group=self.MEMBER,
                                  extra_groups=list(groups), capture_output=True, check=False, timeout=DEADLINE_S)  # fmt: skip

        for words in (["home"], ["move", "--to", "1"], ["motor", "off"], ["light", "on", "--seconds", "1", "--confirm"],
                      ["show", "grid"], ["projector", "on"]):  # fmt: skip
            with self.subTest(words):
                self.assert_refusal(member(*words), FAILED, "contourd-service")
        self.assertEqual(self.manual(daemon)["operations"], 0)
        self.assertEqual(member("stop").returncode, OK)
