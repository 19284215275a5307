"""A configuration for real hardware on a computer without that hardware: the daemon reports it and waits."""

import json
import os
import re
import signal

from harness import (
    BAD_CONFIG, BAD_USAGE, CONTOURD, OK, SOURCE, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, contents, run, source_json, wait_until,
)  # fmt: skip

MISSING_CHIP = "gpiochip-missing"


def real_config(**changes):
    """The shipped profile with devices that no computer has."""
    config = source_json("raspberry-pi-4.json")
    config.update({"spool_folder": "spool", "control_socket": "control.sock", "min_free_disk_mb": 0,
                   "projectors_folder": os.path.join(SOURCE, "config", "projectors")})  # fmt: skip
    for key in ("step", "direction", "enable", "limit_switch"):
        config["z_axis"][key]["chip"] = MISSING_CHIP
    config["display"]["card"] = "/dev/dri/card-missing"
    config["projector"]["port"] = "/dev/tty-missing"
    config.update(changes)
    return config


class RealHardwareTest(FolderTest):
    def daemon(self, **changes):
        daemon = Daemon(self)
        daemon.config = real_config(**changes)
        daemon.write_config()
        return daemon

    def check(self, daemon, *arguments, **options):
        return run(CONTOURD, "--config", daemon.config_path, *arguments, **options)


class Check(RealHardwareTest):
    def test_every_missing_device_is_reported_with_the_existing_ones(self):
        result = self.check(self.daemon(), "--check-hardware")
        self.assertEqual((result.returncode, result.stderr), (UNAVAILABLE, b""))
        *lines, last = result.stdout.decode().splitlines()
        # The first line is about the computer, which may be too slow for the printer.
        computer = [line for line in lines if line[5:].startswith("step thread")]
        self.assertEqual(len(computer), 1)
        self.assertRegex(computer[0], r"^(ok  |warn|BAD ) step thread +4000 steps/s needed \(5 mm/s\); .* sustains \d+ steps/s")
        lines.remove(computer[0])
        devices = [re.match(r"BAD  (step|direction|enable|limit switch|display|projector) +\S", line) for line in lines]
        self.assertEqual([match and match.group(1) for match in devices],
                         ["step", "direction", "enable", "limit switch", "display", "projector"])  # fmt: skip
        for line in lines:
            self.assertIn("-missing", line)
        self.assertRegex(lines[-1], "existing serial ports: |no serial port exists")
        self.assertEqual(last, f"{6 + computer[0].startswith('BAD')} problems prevent printing")

    def test_a_simulated_printer_has_no_hardware_to_check(self):
        daemon = self.daemon(hardware="simulated")
        result = self.check(daemon, "--check-hardware")
        self.assertEqual(result.returncode, OK)
        self.assertIn(b"simulated", result.stdout)
        self.assertEqual(self.check(daemon, "--light-off").returncode, OK)

    def test_a_check_creates_no_files(self):
        daemon = self.daemon()
        self.check(daemon, "--check-hardware")
        self.assertFalse(os.path.exists(daemon.spool))
        self.assertFalse(os.path.exists(daemon.socket_path))

    def test_a_light_that_cannot_be_reached_may_be_on(self):
        result = self.check(self.daemon(), "--light-off")
        self.assert_refusal(result, UNAVAILABLE, "the light may be on: the serial port /dev/tty-missing")

    def test_two_modes_at_once_are_bad_usage(self):
        daemon = self.daemon()
        modes = [["--check-hardware"], ["--light-off"], ["--print-states"], ["--check-config", daemon.config_path]]
        for one in modes:
            for other in modes:
                if one == other:
                    continue
                result = self.check(daemon, *one, *other)
                self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), one + other)
                for option in (one[0], other[0]):
                    self.assertIn(os.fsencode(option), result.stderr)

    def test_a_pace_is_allowed_only_for_the_simulated_printer(self):
        result = self.check(self.daemon(), "--pace", "fast")
        self.assert_refusal(result, BAD_USAGE, "--pace")


LOST = "the light may be on: the serial port /dev/tty-missing"


class LightOff(RealHardwareTest):
    """contourd --light-off, which turns the light off after the daemon has died, even if the configuration has changed."""

    def record(self):
        return self.path("light.json")

    def killed(self, **environment):
        """Starts a daemon and kills it."""
        daemon = self.daemon()
        daemon.start(**environment)
        daemon.process.kill()
        daemon.process.wait()
        return daemon

    def light_off(self, daemon, **environment):
        return self.check(daemon, "--light-off", env={**os.environ, **environment})

    def assert_tried(self, daemon, *words, **environment):
        result = self.light_off(daemon, **environment)
        self.assertEqual(result.returncode, UNAVAILABLE, result.stderr)
        for word in (LOST, *words):
            self.assertIn(os.fsencode(word), result.stderr)
        return result

    def test_a_mistake_that_does_not_concern_the_light_is_only_mentioned(self):
        daemon = self.daemon(display={**real_config()["display"], "colour": "blue"}, resin="missing")
        result = self.assert_tried(daemon, "/display/colour: ")
        self.assertEqual(result.stderr.count(b"\n"), 2, result.stderr)

    def test_a_mistake_in_the_projector_table_that_does_not_concern_the_light_is_only_mentioned(self):
        table = source_json("projectors", "optoma.json")
        table["commands"]["power_on"]["accepted"] = "[P"
        self.write("optoma.json", json.dumps(table))
        self.assert_tried(self.daemon(projectors_folder="."), "/commands/power_on/accepted: ")

    def test_a_mistake_that_concerns_the_light_is_an_error(self):
        for projector in ({"light": {"line": True}}, {"port": 5}, {"table": "missing"}):
            config = real_config()
            config["projector"].update(projector)
            result = self.light_off(self.daemon(projector=config["projector"]))
            self.assertEqual(result.returncode, BAD_CONFIG, result.stderr)
            self.assertIn(b"/projector/" + os.fsencode(next(iter(projector))), result.stderr)
            self.assertIn(b"the light may be on: ", result.stderr)

    def test_without_any_configuration_the_light_may_be_on(self):
        daemon = self.daemon()
        os.unlink(daemon.config_path)
        result = self.light_off(daemon)
        self.assert_refusal(result, BAD_CONFIG, "the light may be on: ", "contourd.json: there is no such file")

    def test_the_daemon_records_what_light_off_needs(self):
        daemon = self.killed()
        record = json.loads(contents(self.record()))
        self.assertEqual(record["port"], "/dev/tty-missing")
        self.assertEqual(record["table"]["commands"]["light_off"],
                         source_json("projectors", "optoma.json")["commands"]["light_off"])  # fmt: skip
        # Even if the configuration is simulated now, names another port, or is broken, the running daemon's record is used.
        daemon.config["hardware"] = "simulated"
        daemon.config["projector"]["port"] = "/dev/tty-other"
        daemon.write_config()
        self.assert_tried(daemon, self.record())
        self.assertTrue(os.path.exists(self.record()))
        self.write("contourd.json", '{"control_socket": "control.sock", "display": 7}')
        self.assert_tried(daemon)

    def test_the_record_is_in_the_runtime_directory_if_there_is_one(self):
        os.mkdir(self.path("run"))
        environment = {"RUNTIME_DIRECTORY": self.path("run") + ":/run/other"}
        daemon = self.killed(**environment)
        self.assertFalse(os.path.exists(self.record()))
        self.write("contourd.json", "no JSON")
        self.assert_tried(daemon, self.path("run", "light.json"), **environment)

    def test_an_unreadable_record_is_mentioned_and_the_configuration_is_used(self):
        daemon = self.daemon()
        self.write("light.json", '{"projector": {"port": ')
        self.assert_tried(daemon, self.record())

    def test_the_record_is_deleted_when_the_light_is_off(self):
        daemon = self.daemon()
        self.write("light.json", "{}")  # the record of a machine without a light that could stay on
        result = self.light_off(daemon)
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        self.assertFalse(os.path.exists(self.record()))
        self.assert_tried(daemon)  # the configuration is used again

    def test_a_simulated_printer_writes_no_record(self):
        daemon = self.daemon(hardware="simulated")
        daemon.start()
        daemon.stop()
        self.assertFalse(os.path.exists(self.record()))


class Degraded(RealHardwareTest):
    def test_the_daemon_starts_without_its_devices_reports_them_and_lets_jobs_wait(self):
        daemon = self.daemon()
        daemon.start()
        status = daemon.status()
        self.assertEqual(status["state"], "idle")
        self.assert_words(status["not_ready_reason"], MISSING_CHIP, "card-missing", "tty-missing")
        self.assertIn("the printer cannot print: ", daemon.log())
        self.assertIn(b"machine   the serial port", daemon.ctl("status").stdout)
        daemon.drop("part.stl", binary_stl(box((0, 0, 0), (10, 5, 1))))
        status = daemon.wait_status("waiting_for")
        self.assertEqual((status["waiting_for"], status["queued"]), (status["not_ready_reason"], 1))
        # A model that cannot be printed is refused even now.
        daemon.refused("bad.stl", b"no model")
        daemon.stop()
        self.assertEqual(daemon.names_in("incoming"), ["part.stl"])
        self.assertEqual(daemon.names_in("failed"), ["bad.reason.txt", "bad.stl"])

    def test_the_same_configuration_prints_on_the_simulated_machine(self):
        daemon = self.daemon(hardware="simulated", simulation={"pace": "fast"})
        daemon.start()
        self.assertEqual(daemon.printed("part.stl", binary_stl(box((0, 0, 0), (10, 5, 1))))["layers_exposed"], 20)
        self.assertIsNone(daemon.status()["not_ready_reason"])


def command_name(process):
    try:
        with open(f"/proc/{process}/comm", encoding="ascii") as file:
            return file.read().strip()
    except FileNotFoundError:
        return None


def light_watchdogs(daemon):
    """Returns the ids of the daemon's light watchdogs that are alive."""
    with open(f"/proc/{daemon.process.pid}/task/{daemon.process.pid}/children", encoding="ascii") as file:
        return [int(child) for child in file.read().split() if command_name(child) == "contourd-light"]


class LightWatchdog(RealHardwareTest):
    def test_it_ignores_the_signals_that_end_a_daemon_and_ends_with_the_daemon(self):
        daemon = self.daemon()
        daemon.start()
        (watchdog,) = light_watchdogs(daemon)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGABRT, signal.SIGQUIT):
            os.kill(watchdog, number)
        daemon.status()
        self.assertEqual(light_watchdogs(daemon), [watchdog])
        # The light watchdog has only the descriptors that it was given.
        self.assertEqual(sorted(os.listdir(f"/proc/{watchdog}/fd")), ["0", "1", "2", "3"])
        daemon.process.kill()
        daemon.process.wait()
        wait_until(lambda: command_name(watchdog) is None, "the light watchdog to end")

    def test_a_dead_light_watchdog_is_replaced_and_both_events_are_logged(self):
        daemon = self.daemon()
        daemon.start()
        (watchdog,) = light_watchdogs(daemon)
        os.kill(watchdog, signal.SIGKILL)
        wait_until(lambda: "the light watchdog is running again" in daemon.log(), "a new light watchdog")
        self.assertIn("the light watchdog has died; no light is turned on without it", daemon.log())
        (another,) = light_watchdogs(daemon)
        self.assertNotEqual(another, watchdog)
        self.assertNotIn("watchdog", daemon.status()["not_ready_reason"])
        daemon.stop()
        wait_until(lambda: command_name(another) is None, "the light watchdog to end")

    def test_a_simulated_printer_has_no_light_watchdog(self):
        daemon = self.daemon(hardware="simulated")
        daemon.start()
        self.assertEqual(light_watchdogs(daemon), [])
