"""contourctl setup: from wired parts to a configuration; with and without a dialog, interrupted and continued."""

import contextlib
import fcntl
import glob
import json
import os
import pty
import select
import shutil
import signal
import struct
import subprocess
import termios
import unittest

from harness import (
    BAD_CONFIG, BAD_USAGE, CANNOT_CREATE, CONTOURCTL, CONTOURD, DEADLINE_S, FAILED, NIMBLE_RESIN, NO_INPUT, OK, SOURCE, Daemon, FolderTest, contents,
    contourctl, realtime, run, text_of, wait_until,
)  # fmt: skip

# Values of a machine that setup cannot know without asking.
UNKNOWN = {"screw_lead_mm": 4, "travel_mm": 150, "projector_table": "optoma", "serial_port": "/dev/ttyUSB0",
           "display_mode": "1920x1080@60", "build_width_mm": 96}  # fmt: skip
REAL = {"hardware": "real", "gpio_chip": "gpiochip0", "connector": "HDMI-A-1", **UNKNOWN}


class SetupTest(FolderTest):
    def setUp(self):
        super().setUp()
        for name in ("resins", "projectors"):
            shutil.copytree(os.path.join(SOURCE, "config", name), self.path(name))
        self.config = self.path("printer.json")
        self.record = self.path("printer.setup.json")

    def setup_words(self, *words, **answers):
        return ["setup", "--config", self.config, *words, *(word for key, value in answers.items() for word in ("--set", f"{key}={value}"))]

    def non_interactive(self, *words, code=OK, **answers):
        result = contourctl(*self.setup_words("--non-interactive", *words, **answers))
        self.assertEqual(result.returncode, code, result)
        if code != OK:
            self.assert_one_line(result.stderr)
        return result

    def written(self, path=None):
        return json.loads(contents(path or self.config))

    def files(self):
        return sorted(name for name in os.listdir(self.folder) if name not in ("resins", "projectors"))

    def assert_good(self):
        run(CONTOURD, "--check-config", self.config, expect=OK)


class NonInteractive(SetupTest):
    @unittest.skipIf(glob.glob("/dev/gpiochip*"), "this computer has a GPIO chip")
    def test_without_devices_setup_lists_what_is_missing_and_writes_a_simulated_printer(self):
        output = self.non_interactive().stdout.decode()
        self.assertIn("GPIO: none. The motor's driver", output)
        self.assertIn("hardware = simulated: there is no GPIO chip", output)
        self.assertEqual(self.written()["hardware"], "simulated")
        self.assert_good()

    def test_given_values_are_written_with_defaults_for_the_rest_and_notes_with_reasons(self):
        self.non_interactive(**REAL, name="Mine")
        self.assert_good()
        profile = self.written()
        self.assertEqual((profile["hardware"], profile["name"]), ("real", "Mine"))
        self.assertEqual(profile["z_axis"]["microsteps_per_mm"], 800)
        self.assertEqual(profile["z_axis"]["step"], {"chip": "gpiochip0", "line": 17, "active_low": False})
        self.assertEqual(profile["projector"]["table"], "optoma")
        self.assertEqual(self.files(), ["printer.json", "printer.setup.json", "printer.setup.txt"])
        notes = text_of(self.path("printer.setup.txt"))
        self.assertIn("  travel_mm = 150: as answered\n", notes)
        self.assertIn("  switch_contact = normally_closed: a broken wire is then detected\n", notes)

    def test_all_usual_screws_steps_and_tables_make_a_valid_configuration(self):
        tables = [os.path.basename(path)[:-5] for path in glob.glob(self.path("projectors", "*.json"))]
        self.assertGreater(len(tables), 3)
        cases = [(lead, steps, "optoma") for lead in (2, 4, 8) for steps in (16, 32)] + [(4, 16, table) for table in (*tables, "none")]
        for lead, steps, table in cases:
            for chip in ("gpiochip0", "pinctrl-rp1"):
                with self.subTest(lead=lead, steps=steps, table=table, chip=chip):
                    self.non_interactive("--replace", "--restart", **{**REAL, "screw_lead_mm": lead, "microsteps": steps, "projector_table": table,
                                                                   "gpio_chip": chip, "light_line": 24})  # fmt: skip
                    self.assert_good()

    def test_a_missing_answer_is_an_error_and_nothing_is_written(self):
        for key in UNKNOWN:
            if key in ("serial_port", "display_mode"):  # this computer may have one
                continue
            with self.subTest(key):
                result = self.non_interactive(code=BAD_USAGE, **{name: value for name, value in REAL.items() if name != key})
                self.assertIn(f"no default is safe for {key}", result.stderr.decode())
                self.assertEqual(self.files(), [])

    def test_a_wrong_answer_is_an_error_and_nothing_is_written(self):
        for key, value, word in (("travel_mm", "high", "from 1 to 500 mm"), ("travel_mm", "", "from 1 to 500"), ("travel_mm", "nan", "from 1"),
                                 ("step_line", "27", "Line 27 is already used for step_line"), ("projector_table", "magic", "acer, anhua-df10"),
                                 ("name", "a\x1b[2J", "printable"), ("hardware", "both", "real, simulated"), ("colour", "red", "one of the keys hardware, name"),
                                 ("serial_port", "ttyUSB0", "below /dev"), ("switch_line", "-1", "from 0 to 65535")):  # fmt: skip
            with self.subTest(key=key, value=value):
                errors = self.non_interactive(code=BAD_USAGE, **{**REAL, key: value}).stderr
                self.assertIn(word, errors.decode())
                self.assertNotIn(b"\x1b", errors)
        self.assertIn(b"expected KEY=VALUE", self.non_interactive("--set", "travel_mm", code=BAD_USAGE).stderr)
        self.assertEqual(self.files(), [])

    def test_answers_can_come_from_a_file_and_options_override_it(self):
        answers = self.write("answers.json", json.dumps({**REAL, "wait_for_plate_cleared": False, "checks": {"switch": "passed"}}).encode())
        self.non_interactive("--answers", answers, travel_mm=77)
        profile = self.written()
        self.assertEqual((profile["z_axis"]["travel_mm"], profile["wait_for_plate_cleared"]), (77, False))
        # Checks of another printer do not count for this one.
        self.assertNotIn("switch", self.written(self.record).get("checks", {}))
        for text, word in (("[]", "not an object"), ("{", "answers.json"), ('{"colour": 1}', "/colour: no question"), ('{"name": []}', "/name"),
                           ('{"checks": 1}', "/checks"), ('{"name": "a", "name": "b"}', "name")):  # fmt: skip
            with self.subTest(text):
                self.write("answers.json", text.encode())
                self.assertIn(word, self.non_interactive("--answers", answers, code=BAD_CONFIG).stderr.decode())
        self.non_interactive("--answers", self.path("none"), code=BAD_CONFIG)

    def test_an_edited_configuration_is_replaced_only_with_replace_and_a_copy_is_kept(self):
        self.non_interactive(**REAL)
        edited = self.written()
        edited["z_axis"]["emergency_stop"] = {"line": 5, "active_low": True, "bias": "pull_up", "contact": "normally_closed"}
        edited["resin"] = "standard"
        self.write("printer.json", json.dumps(edited).encode())
        os.chmod(self.config, 0o640)
        before = self.written()
        result = self.non_interactive(code=BAD_USAGE, travel_mm=99)
        self.assertIn("--replace", result.stderr.decode())
        self.assertEqual(self.written(), before)
        for kept in ("printer.json.before-setup", "printer.json.before-setup-2"):
            self.non_interactive("--replace", travel_mm=99 + len(kept))
            self.assertIn(kept, self.files())
        self.assertEqual(self.written(self.path("printer.json.before-setup")), before)
        # Keys without a question keep their values.
        self.assertEqual(self.written()["z_axis"]["emergency_stop"], edited["z_axis"]["emergency_stop"])
        self.assertEqual(os.stat(self.config).st_mode & 0o777, 0o640)
        self.assertNotIn("printer.json.new", self.files())

    def test_an_invalid_configuration_is_not_written(self):
        self.non_interactive(**REAL)
        before = self.written()
        result = contourctl(*self.setup_words("--non-interactive", "--replace", top_speed_mm_s=0.5), expect=BAD_CONFIG)
        self.assertIn("the printer's top speed", result.stderr.decode())
        self.assertEqual(self.written(), before)
        self.assertEqual(self.files(), ["printer.json", "printer.setup.json", "printer.setup.txt"])

    def test_an_unreadable_file_is_an_error_and_a_damaged_record_can_be_discarded(self):
        os.mkfifo(self.config)
        self.assertIn(f"{self.config}: it is not a regular file", self.non_interactive(code=NO_INPUT).stderr.decode())
        os.unlink(self.config)
        self.write("printer.setup.json", b'{"name": ')
        self.assertIn("printer.setup.json", self.non_interactive(code=BAD_CONFIG, hardware="simulated").stderr.decode())
        self.non_interactive("--restart", hardware="simulated")
        self.assert_good()

    def test_a_folder_that_cannot_be_written_is_reported_at_once(self):
        self.config = self.path("none", "printer.json")
        self.assertIn("cannot write into", self.non_interactive(code=CANNOT_CREATE).stderr.decode())


class TerminalTest(SetupTest):
    """contourctl setup with a dialog on a terminal."""

    def begin(self, *words, columns=80, **answers):
        mine, its = pty.openpty()
        self.addCleanup(self.close, mine)
        fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        process = subprocess.Popen([CONTOURCTL, *self.setup_words(*words, **answers)], stdin=its, stdout=its, stderr=its, start_new_session=True,
                                   preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))  # fmt: skip
        self.killed_at_the_end(process)
        os.close(its)
        self.mine, self.process, self.shown, self.at = mine, process, "", 0

    def close(self, descriptor):
        with contextlib.suppress(OSError):
            os.close(descriptor)

    def read_some(self):
        self.assertTrue(select.select([self.mine], [], [], DEADLINE_S)[0], self.shown)
        try:
            more = os.read(self.mine, 65536)
        except OSError:  # the other end has been closed
            more = b""
        self.shown += more.decode().replace("\r", "")
        return more

    def expect(self, *words):
        """Reads until these words have been shown, in this order, after the words that were expected last."""
        for word in words:
            while word not in self.shown[self.at:]:
                self.assertTrue(self.read_some(), f"{word!r} is not in {self.shown[self.at:]}")
            self.at = self.shown.index(word, self.at) + len(word)

    def type(self, *lines):
        for line in lines:
            os.write(self.mine, line.encode() + b"\n")

    def answer(self, *dialog):
        """Types each answer after its prompt."""
        for prompt, line in dialog:
            self.expect(prompt)
            self.type(line)

    def quit(self):
        self.type("quit")
        return self.ended(FAILED)

    def ended(self, code):
        while self.read_some():
            pass
        self.assertEqual(self.process.wait(DEADLINE_S), code, self.shown)
        return self.shown


class OnTerminal(TerminalTest):
    def test_the_dialog_leads_to_a_valid_configuration_and_repeats_questions_after_wrong_answers(self):
        self.begin(gpio_chip="gpiochip0", connector="HDMI-A-1", display_mode="1920x1080@60")
        self.answer(("hardware:", "maybe"), ("Expected one of: real, simulated.\nhardware:", "?"), ("Expected one of: real, simulated. Enter accepts simulated; back returns", "real"), ("name:", "Mine"),
                    ("screw_lead_mm:", "?"), ("Expected a number from 0.1 to 100 mm", "-1"), ("Expected a number from 0.1 to 100 mm", "4"), ("steps_per_turn:", "1.5"), ("whole number", ""),
                    ("microsteps:", "16"), ("travel_mm:", ""), ("top_speed_mm_s:", ""), ("step_line:", ""), ("direction_line:", "17"),
                    ("Line 17 is already used for step_line.", "27"), ("direction_active_low:", "y"), ("enable_line:", "none"), ("switch_line:", ""),
                    ("switch_contact:", ""), ("switch_wired_to:", ""), ("switch_end:", ""), ("projector_table:", "acer"), ("serial_port:", ""),
                    ("light_line:", "none"), ("This line is needed", "24"), ("light_active_low:", ""), ("build_width_mm:", "57.6"),
                    ("mirror:", ""), ("irradiance_mw_cm2:", ""), ("wait_for_plate_cleared:", ""))  # fmt: skip
        self.expect("microsteps = 16: all three jumpers", "Enter: write")
        self.assertFalse(os.path.exists(self.config))
        self.type("?")
        self.expect("Expected a key above, Enter, back", "Enter: write")
        self.type("top_speed")
        self.expect("not one of the keys", "Enter: write")
        self.type("travel_mm")
        self.answer(("Enter: 160, as answered before", "120"), ("travel_mm = 120: as answered", ""), ("skip: no checks:", "skip"))
        self.expect("Not checked:", "the limit switch: contourctl switches", "the light's end")
        self.ended(OK)
        self.assert_good()
        profile = self.written()
        self.assertEqual((profile["z_axis"]["travel_mm"], profile["display"]["pixel_pitch_um"]), (120, 30))
        self.assertTrue(profile["z_axis"]["direction"]["active_low"])
        self.assertNotIn("enable", profile["z_axis"])

    def test_an_interrupted_dialog_can_be_continued_and_go_back(self):
        def hang_up():
            os.close(self.mine)
            self.process.wait(DEADLINE_S)

        def interrupt():
            os.write(self.mine, b"\x03")
            self.assertEqual(self.process.wait(DEADLINE_S), -signal.SIGINT)

        def leave():
            self.assertIn(f"Quit. contourctl setup --config {self.config} continues from here", " ".join(self.quit().split()))

        self.begin(hardware="real")
        self.answer(("name:", "Mine"))
        for end, prompt, answer in ((hang_up, "screw_lead_mm:", "2"), (interrupt, "steps_per_turn:", "400"), (leave, "microsteps:", "8")):
            with self.subTest(prompt):
                self.answer((prompt, answer))
                wait_until(lambda key=prompt[:-1]: key in self.written(self.record), "the answer to be stored")
                end()
                self.begin()
                self.expect("Continuing with", "--restart", "Each answer is saved")
        self.answer(("travel_mm:", "back"), ("Enter: 8, as answered before", ""), ("travel_mm:", ""))
        self.expect("top_speed_mm_s:")
        leave()
        self.assertEqual(self.written(self.record) | {"microsteps": "8", "steps_per_turn": "400", "screw_lead_mm": "2", "name": "Mine"}, self.written(self.record))
        self.begin("--restart")
        self.expect("hardware:")
        self.assertNotIn("Continuing", self.shown)
        self.assertEqual(self.files(), ["printer.setup.json"])

    def test_a_copy_of_an_existing_configuration_is_kept(self):
        self.non_interactive(**REAL)
        before = self.written()
        self.begin(travel_mm=90)
        self.answer(("Enter: replace", ""))
        self.expect("printer.json.before-setup", "skip: no checks:")
        self.quit()
        self.assertEqual(self.written(self.path("printer.json.before-setup")), before)
        self.assertEqual(self.written()["z_axis"]["travel_mm"], 90)

    def test_no_line_is_wider_than_the_terminal(self):
        words = {}
        for columns in (40, 80, 200):
            with self.subTest(columns):
                self.begin("--restart", columns=columns, **REAL)
                self.answer(("name:", "?"), ("name:", ""))
                self.answer(*((f"{key}:", "") for key in ("steps_per_turn", "microsteps", "top_speed_mm_s", "step_line")))
                self.expect("direction_line:")
                shown = self.quit()
                words[columns] = shown.partition("Quit.")[0].split()  # without the path, which may be wider
                for line in shown.splitlines():
                    if self.folder not in line:
                        self.assertLessEqual(len(line), min(columns, 100), line)
        # Lines end only between words.
        self.assertEqual(words[40], words[200])
        self.assertEqual(words[80], words[200])


class Checks(TerminalTest):
    """The checks on a printer. Here contourd runs a simulated printer with its own configuration, and a restart of it stands for
    a restart with the new configuration."""

    def setUp(self):
        super().setUp()
        for name in ("resins", "projectors"):
            shutil.rmtree(self.path(name))
        self.config = None

    def daemon(self, **simulation):
        return Daemon(self, realtime(name="Mine", simulation=simulation), NIMBLE_RESIN).start()

    def checked_daemon(self, **simulation):
        """Returns a daemon that has restarted with a new configuration, whose checks setup begins."""
        daemon = self.daemon(**simulation)
        self.configured(daemon)
        self.restarted(daemon)
        return daemon

    def configured(self, daemon):
        """Writes a configuration, and begins setup on a terminal with all questions answered."""
        folder = self.path("etc")
        os.mkdir(folder)
        for name in ("resins", "projectors"):
            shutil.copytree(os.path.join(SOURCE, "config", name), os.path.join(folder, name))
        self.config = os.path.join(folder, "printer.json")
        self.record = os.path.join(folder, "printer.setup.json")
        self.non_interactive(**{**REAL, "name": "Mine", "travel_mm": 12})
        self.begin("--socket", daemon.socket_path)
        self.answer(("is up to date, continue:", ""))

    def restarted(self, daemon):
        """Restarts the daemon, as setup asks the user to do."""
        self.expect("skip: no checks:")
        daemon.restart()
        self.type("")

    def manual(self, daemon):
        return json.loads(contourctl("status", "--json", "--socket", daemon.socket_path).stdout)["result"]["manual"]

    def outcomes(self):
        return self.written(self.record)["checks"]

    def test_a_daemon_that_still_runs_with_the_old_configuration_is_detected(self):
        daemon = self.daemon()
        self.configured(daemon)
        self.answer(("skip: no checks:", ""))
        self.expect("contourd has not restarted yet")
        self.restarted(daemon)
        self.expect("Check: the limit switch.")
        self.assertEqual(self.outcomes()["configuration"], "taken")
        self.quit()

    def test_a_daemon_of_another_printer_is_detected(self):
        daemon = self.daemon()
        self.configured(daemon)
        daemon.config["name"] = "Other"
        daemon.write_config()
        self.restarted(daemon)
        self.expect("contourd runs as Other, not as Mine.")
        self.quit()

    def test_without_a_daemon_setup_lists_what_was_not_checked(self):
        daemon = self.checked_daemon()
        self.expect("Check: the limit switch.", "skip:")
        daemon.stop()
        self.type("")
        self.answer(("cannot reach contourd", ""), ("skip:", ""), ("cannot reach contourd", "skip"))
        for check, answer in (("the motor's direction", "skip"), ("homing", "skip"), ("the length of a millimetre", "skip"),
                              ("the projector's answers", "skip"), ("the picture's orientation", ""), ("the picture's shape", ""), ("the pixels' size", ""), ("the light's end", "")):  # fmt: skip
            self.expect(f"Check: {check}.")
            self.answer(("yes)?" if answer == "" else "skip:", answer))
        self.expect("Not checked:", "the limit switch: contourctl switches", "the light's end: contourctl light on --seconds 2")
        self.ended(OK)
        self.assertEqual(set(self.outcomes().values()), {"taken", "skipped"})

    def test_each_check_is_made_and_its_result_is_written_to_the_configuration(self):
        daemon = self.checked_daemon(pace="fast", start_height_mm=6)
        self.answer(("Check: the limit switch.", ""))
        self.expect("Enter: skip.")
        self.assertEqual(contourctl("home", "--socket", daemon.socket_path).returncode, OK)
        self.assertEqual(contourctl("move", "--to", "6", "--socket", daemon.socket_path).returncode, OK)
        self.expect("Its line changes: the switch is wired.\n")
        self.answer(("Check: the motor's direction.", ""), ("It moved:", "up"))
        self.assertIsNone(self.manual(daemon)["height_mm"])
        self.answer(("Check: homing.", ""), ("The switch was found 0.0 um higher than at the previous homing.", ""), ("both times", "yes"))
        self.answer(("move the plate to 3 mm", ""), ("3 mm further up", ""), ("did the plate rise", "1.5"))
        self.expect("microsteps, not 800")
        self.answer(("(no or yes)?", "yes"))
        self.restarted(daemon)
        self.assertEqual(self.written()["z_axis"]["microsteps_per_mm"], 1600)
        self.answer(("Check: the projector's answers.", ""))
        self.answer(("Check: the picture's orientation.", "yes"), ("The square was:", "x"))
        self.restarted(daemon)
        self.answer(("UV light", "yes"), ("The square was:", "right"))
        self.answer(("Check: the picture's shape.", "yes"), ("The grid is right", "bent"), ("keystone", "yes"), ("The grid is right", "blurred"),
                    ("the focus", "yes"), ("The grid is right", "yes"))  # fmt: skip
        self.answer(("Check: the pixels' size.", "yes"), ("Up to which tick", "50"), ("How long is this distance", "49"))
        self.restarted(daemon)
        self.answer(("Check: the light's end.", "yes"), ("go off by itself", "yes"))
        self.expect("All checks passed.")
        self.ended(OK)
        self.assertEqual(self.outcomes(), {"configuration": "taken", **dict.fromkeys(
            ("switch", "direction", "homing", "steps", "projector", "picture", "grid", "pixels", "light"), "passed")})  # fmt: skip
        display = self.written()["display"]
        self.assertEqual((display["mirror_x"], display["mirror_y"], display["pixel_pitch_um"]), (True, False, 49))
        self.assert_good()
        # Passed checks are not repeated.
        self.begin("--socket", daemon.socket_path)
        self.answer(("is up to date, continue:", ""))
        self.expect("All checks passed.")
        self.ended(OK)

    def test_a_plate_that_moves_the_wrong_way_inverts_dir(self):
        daemon = self.checked_daemon(start_height_mm=6)
        self.answer(("Check: the limit switch.", "skip"), ("Check: the motor's direction.", ""), ("It moved:", "down"))
        self.expect("DIR is inverted.")
        self.restarted(daemon)
        self.assertTrue(self.written()["z_axis"]["direction"]["active_low"])
        self.answer(("Enter: move;", ""), ("It moved:", "no"), ("Check the driver's supply", ""), ("It moved:", "up"))
        self.expect("Check: homing.")
        self.assertEqual(self.outcomes()["direction"], "passed")
        self.quit()

    def test_a_switch_contact_of_the_other_kind_is_detected(self):
        daemon = self.checked_daemon(start_height_mm=0)
        self.answer(("Check: the limit switch.", ""))
        self.expect("Enter: skip.")
        self.assertEqual(contourctl("home", "--socket", daemon.socket_path).returncode, OK)
        self.expect("switch_contact is changed")
        self.restarted(daemon)
        self.expect("Check: the motor's direction.")
        self.assertEqual(self.written()["z_axis"]["limit_switch"]["contact"], "normally_open")
        self.quit()
