"""contourd's command line, its configuration, and its notifications to systemd."""

import json
import os
import re
import signal
import socket
import subprocess
import time

from harness import (
    BAD_CONFIG, BAD_USAGE, CANNOT_CREATE, CONTOURD, DEADLINE_S, ENDLESS, MAKE_MODEL, NIMBLE_RESIN, OK, REALTIME, SLOWNESS, SOURCE, Client, Daemon,
    FolderTest, binary_stl, box, check_config, contents, contourctl, merge, run, source_json, text_of, wait_until,
)  # fmt: skip


def answers(daemon):
    """Says whether the daemon accepts clients: its socket is there some time before that."""
    try:
        return bool(daemon.status())
    except (FileNotFoundError, ConnectionRefusedError):
        return False


class ConfigTest(FolderTest):
    def setUp(self):
        super().setUp()
        os.mkdir(self.path("resins"))
        self.resin(source_json("resins", "standard.json"))

    def resin(self, profile, name="standard"):
        self.write(self.path("resins", name + ".json"), json.dumps(profile))

    def config(self, changes):
        path = self.path("contourd.json")
        self.write(path, json.dumps(merge(source_json("simulated.json"), changes)))
        return path

    def check(self, path):
        result = run(CONTOURD, "--check-config", path)
        if result.returncode == OK:
            self.assertEqual(result.stderr, b"")
        else:
            self.assertEqual(result.returncode, BAD_CONFIG, result)
            self.assertEqual(result.stdout, b"")
        return result

    def lines(self, path):
        result = self.check(path)
        self.assertEqual(result.returncode, BAD_CONFIG, "the configuration was accepted")
        return result.stderr.decode().splitlines()

    def refuses(self, path, *words):
        """Asserts that a check prints one line with these words and the file's name, and that the daemon does not start."""
        lines = self.lines(path)
        self.assertEqual(len(lines), 1, lines)
        self.assert_words(lines[0], os.path.basename(path), *words)
        started = run(CONTOURD, "--config", path)
        self.assertEqual((started.returncode, started.stderr.decode().splitlines()), (BAD_CONFIG, lines))
        self.assertFalse(os.path.exists(self.path("spool")), "contourd made folders although it cannot start")


class ConfigCommands(ConfigTest):
    """contourctl config."""

    def ctl(self, *words, code=OK):
        result = contourctl("config", *words)
        self.assertEqual(result.returncode, code, result)
        return (result.stdout if code == OK else result.stderr).decode()

    def test_config_check_prints_the_same_as_the_daemon_s_check(self):
        for changes in ({}, {"z_axis": {"travel_mm": -1}, "colour": 1}, {"simulation": {"pace": "slow"}}):
            path = self.config(changes)
            ctl, daemon = contourctl("config", "check", path), run(CONTOURD, "--check-config", path)
            self.assertEqual((ctl.returncode, ctl.stdout, ctl.stderr), (daemon.returncode, daemon.stdout, daemon.stderr))

    def test_config_show_prints_a_valid_configuration_with_all_defaults(self):
        path = self.config({"wait_for_plate_cleared": False})
        shown = json.loads(self.ctl("show", path))
        self.assertEqual((shown["wait_for_plate_cleared"], shown["min_free_disk_mb"], shown["display"]["mirror_x"]), (False, 100, False))
        self.write(path, json.dumps(shown))
        self.assertEqual(json.loads(self.ctl("show", path)), shown)

    def test_config_diff_shows_only_changed_values_with_their_defaults(self):
        lines = self.ctl("diff", self.config({"wait_for_plate_cleared": False, "min_free_disk_mb": 100, "name": "x\x1by"})).splitlines()
        self.assertIn("wait_for_plate_cleared = false (default true)", lines)
        self.assertIn("z_axis.travel_mm = 160", lines)
        self.assertIn('name = "x\\u001by"', lines)
        self.assertEqual([line for line in lines if "min_free_disk_mb" in line or "$schema" in line], [])

    def test_config_schema_prints_the_file_of_the_repository(self):
        for name, file in (("printer", "contourd"), ("resin", "resin"), ("projector", "projector"), ("ticket", "ticket"), ("plate", "plate")):
            with open(os.path.join(SOURCE, "config", f"{file}.schema.json"), encoding="utf-8") as schema:
                self.assertEqual(self.ctl("schema", name), schema.read())
        self.assertEqual(self.ctl("schema"), self.ctl("schema", "printer"))
        self.assertIn("FORMAT", self.ctl("schema", "none", code=BAD_USAGE))

    def test_each_mistake_is_reported_in_one_line(self):
        path = self.config({"z_axis": {"travel_mm": -1}, "colour": 1})
        for command in ("show", "diff", "check"):
            lines = self.ctl(command, path, code=BAD_CONFIG).splitlines()
            self.assertEqual([path in line for line in lines], [True, True], lines)
            self.assert_one_line(self.ctl(command, self.path("none"), code=BAD_CONFIG).encode(), "no such file")


class CheckConfig(ConfigTest):
    def test_the_documented_profile_is_valid_and_its_table_explains_every_key(self):
        section = text_of(os.path.join(SOURCE, "docs/configuration.md")).split("## A resin's profile, explained")[1].split("\n## ")[0]
        profile = json.loads(section.split("```json")[1].split("```")[0])
        self.resin(profile)
        self.assertEqual(self.check(self.config({})).returncode, OK)
        explained = {key for row in section.splitlines() if row.startswith("| `") for key in re.findall("`([a-z_0-9]+)`", row.split("|")[1])}
        self.assertEqual(explained, set(profile) - {"$schema"})
        required = source_json("resin.schema.json")["required"]
        self.assertLessEqual(set(required), set(profile))

    def test_the_configurations_of_the_repository_are_valid(self):
        for name in ("contourd.json", "raspberry-pi-3.json", "raspberry-pi-4.json", "raspberry-pi-5.json", "simulated.json"):
            result = self.check(os.path.join(SOURCE, "config", name))
            self.assertEqual(result.returncode, OK, result.stderr)
            self.assertIn(b"good", result.stdout)

    def test_an_emergency_stop_that_a_broken_wire_disables_gives_a_warning(self):
        stop = {"emergency_stop": {"line": 5, "active_low": True, "bias": "pull_up"}}
        step, direction, switch = {"line": 17}, {"line": 27}, {"line": 23, "bias": "pull_down", "contact": "normally_closed"}
        axis = {"top_speed_mm_s": 6, "step": step, "direction": direction, "limit_switch": switch, **stop}
        path = self.config({"hardware": "real", "z_axis": axis, "projector": {"light": {"line": 24}}})
        (warning,) = self.warnings(path)
        self.assertTrue(warning.startswith("/z_axis/emergency_stop: "), warning)
        self.assertIn("a broken wire goes unnoticed", warning)

    def warnings(self, path):
        """Returns the warnings about a valid configuration, without the file's name."""
        code, warnings, last = check_config(path)
        self.assertEqual((code, last), (OK, f"{path}: good"))
        for warning in warnings:
            self.assertIn(": warning: ", warning)
        return [warning.partition(": warning: ")[2] for warning in warnings]

    def test_implausible_values_give_warnings(self):
        self.assertEqual(self.warnings(self.config({})), [])
        self.resin({**source_json("resins", "standard.json"), "exposure_ms": 3})
        (warning,) = self.warnings(self.config({}))
        self.assertRegex(warning, r"^/exposure_ms: 3(\.0)? ms .*usual$")
        display = {"width_px": 1080, "height_px": 1920}
        exchanged, exposure = self.warnings(self.config({"display": display}))
        self.assertIn("swapped", exchanged)
        self.assertTrue(exposure.startswith("/exposure_ms: "), exposure)

    def test_profiles_that_only_tickets_name_are_checked_too(self):
        self.resin({**source_json("resins", "standard.json"), "exposure_ms": 3}, "quick")
        self.resin({**source_json("resins", "standard.json"), "lift_mm": "high"}, "broken")
        broken, quick = self.warnings(self.config({}))
        self.assertTrue(broken.startswith("/lift_mm: "), broken)
        self.assertTrue(quick.startswith("/exposure_ms: "), quick)

    def test_a_socket_path_that_is_taken_by_another_file_is_an_error(self):
        self.write("file.sock", b"")
        os.mkdir(self.path("folder.sock"))
        os.symlink("control.sock", self.path("link.sock"))
        for name in ("file.sock", "folder.sock", "link.sock"):
            self.refuses(self.config({"control_socket": name}), "/control_socket", name, "exists and is not a socket")
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(self.path("control.sock"))
            self.assertEqual(self.check(self.config({})).returncode, OK)

    def test_output_that_cannot_be_written_is_an_error(self):
        path = self.config({})
        for arguments in (["--check-config", path], ["--print-states"], ["--config", path, "--check-hardware"], ["--help"],
                          ["--version"]):  # fmt: skip
            with self.subTest(arguments), open("/dev/full", "wb") as full:
                result = run(CONTOURD, *arguments, stdout=full)
                self.assert_refusal(result, CANNOT_CREATE, "No space left")
        closed = subprocess.run(["sh", "-c", f"exec {CONTOURD} --print-states >&-"], stderr=subprocess.PIPE, check=False)
        self.assertEqual(closed.returncode, CANNOT_CREATE, closed)

    def test_messages_contain_no_control_characters(self):
        odd = "\x1b[31m\x9b2J\u202e\u2066\u2028\x07\r\n"
        path = self.config({odd: odd, "resin": odd, "name": odd * 100, "control_socket": odd, "hardware": odd})
        os.rename(path, self.path(f"{odd}.json"))
        for arguments in (["--check-config", self.path(f"{odd}.json")], ["--config", self.path(f"{odd}.json")],
                          ["--check-config", self.path(odd)], [f"--{odd}"], ["--pace", odd],
                          ["--config", self.path(f"{odd}.json"), "--light-off"]):  # fmt: skip
            with self.subTest(arguments):
                result = run(CONTOURD, *arguments)
                output = (result.stdout + result.stderr).decode("utf-8")
                self.assertNotEqual(result.returncode, OK)
                for char in "\x1b\x9b\u202e\u2066\u2028\x07\r":
                    self.assertNotIn(char, output)

    def test_a_check_creates_no_files(self):
        self.check(self.config({}))
        self.assertEqual(sorted(os.listdir(self.folder)), ["contourd.json", "resins"])

    def test_ten_mistakes_give_ten_lines_with_file_place_value_and_limit(self):
        path = self.config({
            "name": "", "colour": "red", "min_free_disk_mb": -5, "hardware": "imagined",
            "z_axis": {"travel_mm": 9999, "microsteps_per_mm": "many"},
            "display": {"width_px": 0, "height_px": 1.5},
            "projector": {"warm_up_s": None},
            "simulation": {"pace": "slow"},
        })  # fmt: skip
        expected = {
            "/name": "empty", "/colour": "key", "/min_free_disk_mb": "-5", "/hardware": "simulated",
            "/z_axis/travel_mm": "500", "/z_axis/microsteps_per_mm": "many", "/display/width_px": "1",
            "/display/height_px": "1.5", "/projector/warm_up_s": "missing", "/simulation/pace": "realtime",
        }  # fmt: skip
        lines = self.lines(path)
        self.assertEqual(len(lines), 10, lines)
        for pointer, word in expected.items():
            (line,) = [line for line in lines if f": {pointer}: " in line]
            self.assertTrue(line.startswith(path), line)
            self.assertIn(word, line)

    def test_broken_json_says_where(self):
        text = json.dumps(source_json("simulated.json"), indent=2)
        for name, broken in {"cut": text[:200], "comma": text.replace('"resin": "standard",', '"resin": "standard",,'),
                             "empty": "", "comment": "// hello\n" + text, "list": "[]", "twice": text + text,
                             "nan": text.replace("160", "NaN", 1)}.items():  # fmt: skip
            with self.subTest(name):
                lines = self.lines(os.fsdecode(self.write("contourd.json", broken)))
                self.assertEqual(len(lines), 1, lines)
                self.assertIn("contourd.json", lines[0])
                if name in ("cut", "comma", "comment"):
                    self.assertRegex(lines[0], r"line \d+")

    def test_a_missing_or_irregular_file_is_an_error(self):
        for path in (self.path("none.json"), self.folder, "/dev/null", "/dev/zero"):
            for option in ("--check-config", "--config"):
                result = run(CONTOURD, option, path, timeout=10)
                self.assert_refusal(result, BAD_CONFIG, path)

    def test_the_daemon_refuses_values_outside_the_limits_of_the_schema(self):
        # Tries a value below each minimum and one above each maximum of the schema.
        schema = source_json("contourd.schema.json")
        tried = 0
        for section, rules in [((), schema)] + [((name,), rule) for name, rule in schema["properties"].items()
                                                if rule.get("type") == "object"]:  # fmt: skip
            for key, rule in rules["properties"].items():
                for limit, step in (("minimum", -1), ("maximum", 1)):
                    if limit not in rule:
                        continue
                    changes = {key: rule[limit] + step}
                    for name in reversed(section):
                        changes = {name: changes}
                    lines = self.lines(self.config(changes))
                    pointer = "/" + "/".join((*section, key))
                    self.assertTrue(any(f": {pointer}: " in line for line in lines), (pointer, lines))
                    tried += 1
        self.assertGreater(tried, 20)


class CommandLine(ConfigTest):
    def test_bad_usage_gives_64(self):
        for arguments in (["--pace", "warp"], ["--pace"], ["--config"], ["--check-config"], ["--nonsense"], ["extra"]):
            result = run(CONTOURD, *arguments, expect=BAD_USAGE)
            self.assertGreater(len(result.stderr), 10)

    def test_help_version_and_print_states_succeed(self):
        for arguments in (["--help"], ["--version"], ["--print-states"]):
            result = run(CONTOURD, *arguments)
            self.assertEqual((result.returncode, result.stderr), (OK, b""))
            self.assertGreater(len(result.stdout), 4)

    def test_print_states_prints_a_graph_of_the_states(self):
        graph = run(CONTOURD, "--print-states").stdout.decode()
        self.assertTrue(graph.startswith("digraph"))
        self.assertEqual(graph.count("{"), graph.count("}"))
        for state in ("idle", "warming up", "homing", "exposing", "paused", "parking"):
            self.assertIn(f'"{state}"', graph)

    def test_the_pace_of_the_command_line_overrides_the_configuration(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        daemon.start("--pace", "fast")
        report = daemon.printed("part.stl", binary_stl(box((0, 0, 0), (5, 5, 1))))  # 20 layers of two minutes each
        self.assertGreater(report["print_time_s"], 2400)
        daemon.stop()
        daemon.config["simulation"]["pace"] = "fast"
        daemon.write_config()
        daemon.start("--pace", "realtime")
        daemon.begin("slow.stl", binary_stl(box((0, 0, 0), (5, 5, 1))))

    def test_relative_paths_start_from_the_configurations_folder(self):
        daemon = Daemon(self, {"spool_folder": "a/../b/spool/", "control_socket": "./c.sock"})
        daemon.socket_path = self.path("c.sock")
        daemon.start()
        self.assertTrue(os.path.isdir(self.path("b", "spool", "incoming")))

    def test_a_spool_that_cannot_be_made_is_an_error(self):
        self.write("file", b"")
        # /proc looks like any other folder until something is to be made in it.
        for option, folder, code in (("--check-config", "file/spool", BAD_CONFIG), ("--config", "file/spool", BAD_CONFIG),
                                     ("--config", "/proc/spool", 70)):  # fmt: skip
            result = run(CONTOURD, option, self.config({"spool_folder": folder}))
            self.assert_refusal(result, code, "spool")

    def test_a_socket_in_a_folder_that_is_not_there_is_found_by_a_check(self):
        result = run(CONTOURD, "--check-config", self.config({"control_socket": "missing/control.sock"}))
        self.assert_refusal(result, BAD_CONFIG, "/control_socket", "there is no folder")

    def test_a_closed_log_does_not_stop_a_print(self):
        daemon = Daemon(self)
        reader, writer = os.pipe()
        os.close(reader)
        process = subprocess.Popen([CONTOURD, "--config", daemon.config_path], stdout=writer, stderr=writer)
        self.killed_at_the_end(process)
        os.close(writer)
        daemon.drop("part.stl", binary_stl(box((0, 0, 0), (5, 5, 1))))
        end = time.monotonic() + DEADLINE_S
        while not daemon.has("done", "part.stl") and time.monotonic() < end and process.poll() is None:
            time.sleep(0.01)
        self.assertTrue(daemon.has("done", "part.stl"))
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(DEADLINE_S), 0)

    def test_a_full_log_blocks_nothing_however_long_its_lines_are(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        reader, writer = os.pipe()  # never read
        self.addCleanup(os.close, reader)
        daemon.process = subprocess.Popen([CONTOURD, "--config", daemon.config_path], stdout=writer, stderr=writer)
        os.close(writer)
        wait_until(lambda: answers(daemon), "the daemon to answer")
        daemon.drop("part.stl", binary_stl(box((0, 0, 0), (5, 5, 1))))
        daemon.wait_status("state", "exposing")
        # Each incomplete plate is logged with the names of all its files, 11 kB.
        plate = {"models": [{"file": f"{'m' * 180}{number}.stl"} for number in range(60)]}
        names = {f"plate{number}" for number in range(10)}
        for name in names:
            daemon.drop_plate(name, plate, {})
        wait_until(lambda: set(daemon.status()["incomplete"]) == names, "all plates to be reported as incomplete")
        self.assertEqual(daemon.status()["state"], "exposing")


class Systemd(FolderTest):
    """The protocol of sd_notify(3), with the test in systemd's place."""

    def setUp(self):
        super().setUp()
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.notify.close)
        self.notify.bind(self.path("n.sock"))
        self.notify.settimeout(DEADLINE_S)

    def launch(self, daemon, **environment):
        """Starts the daemon. WATCHDOG_PID="self" stands for the daemon's own process id."""
        command = [CONTOURD, "--config", daemon.config_path]
        if environment.get("WATCHDOG_PID") == "self":
            del environment["WATCHDOG_PID"]
            command = ["/bin/sh", "-c", 'export WATCHDOG_PID=$$; exec "$@"', "sh", *command]
        with open(daemon.log_path, "ab") as log:
            daemon.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env={**os.environ, "NOTIFY_SOCKET": self.path("n.sock"), **environment})  # fmt: skip
        return daemon

    def receive(self):
        return self.notify.recv(4096).decode().splitlines()

    def wait_for(self, word):
        while True:
            if word in self.receive():
                return time.monotonic()

    def test_ready_comes_when_the_control_socket_answers(self):
        daemon = self.launch(Daemon(self))
        self.wait_for("READY=1")
        client = Client(daemon.socket_path)  # at the first attempt
        self.assertEqual(client.call("status")["result"]["state"], "idle")
        client.close()
        daemon.process.send_signal(signal.SIGTERM)
        self.wait_for("STOPPING=1")
        self.assertEqual(daemon.process.wait(DEADLINE_S), 0)

    def test_ready_is_not_sent_if_the_daemon_cannot_start(self):
        daemon = Daemon(self, {"control_socket": "missing/control.sock"})
        self.launch(daemon)
        self.assertGreater(daemon.process.wait(DEADLINE_S), 0)
        self.notify.setblocking(False)
        with self.assertRaises(BlockingIOError):
            while "READY=1" not in self.receive():
                pass

    def test_interrupted_prints_are_filed_before_ready_is_sent(self):
        daemon = Daemon(self)
        for number in range(20):
            daemon.drop("staged.stl", binary_stl(box((0, 0, 0), (5, 5, 1))))
            os.makedirs(daemon.file("printing"), exist_ok=True)
            os.rename(daemon.file("incoming", "staged.stl"), daemon.file("printing", f"part{number}.stl"))
        self.launch(daemon)
        self.wait_for("READY=1")
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertEqual(len([name for name in daemon.names_in("failed") if name.endswith(".reason.txt")]), 20)

    def assert_fed(self, daemon, watchdog_s):
        """Asserts that the watchdog is fed in time, from readiness until the job `part` has ended."""
        watchdog_s *= SLOWNESS
        self.launch(daemon, WATCHDOG_USEC=f"{watchdog_s * 1e6:.0f}", WATCHDOG_PID="self")
        self.wait_for("READY=1")
        client = Client(daemon.socket_path)
        client.call("watch")
        daemon.drop("part.stl", self.model)
        last, longest, pings = time.monotonic(), 0.0, 0
        self.notify.settimeout(watchdog_s * 3)
        ended = False
        while not (ended and pings > 3):
            if "WATCHDOG=1" in self.receive():
                now = time.monotonic()
                last, longest, pings = now, max(longest, now - last), pings + 1
            self.assertLess(time.monotonic() - last, watchdog_s * 3)
            while not client.messages.empty():
                message = client.next()
                if message.get("method") == "ended":
                    self.assertEqual(message["params"]["last"]["outcome"], "done", daemon.log())
                    ended = True
        client.close()
        daemon.stop()
        self.assertLess(longest, watchdog_s)

    def test_the_watchdog_is_fed_during_a_fast_print(self):
        self.model = binary_stl(box((0, 0, 0), (20, 20, 100)))  # 2000 layers
        self.assert_fed(Daemon(self), 0.4)

    def test_the_watchdog_is_fed_while_a_large_model_is_read_and_its_report_made(self):
        path = self.path("large.stl")
        self.assertEqual(run(MAKE_MODEL, "gyroid-sphere", path, "100").returncode, 0)
        self.model = contents(path)
        # Coarse layers, since this test is about the reading, the first mask and the preview.
        self.assert_fed(Daemon(self, None, {"layer_height_um": 500, "layer_height_max_um": 500}), 1.0)

    def test_the_watchdog_is_fed_during_a_print_in_real_time(self):
        self.model = binary_stl(box((0, 0, 0), (5, 5, 1)))
        resin = {**NIMBLE_RESIN, "exposure_ms": 50, "bottom_exposure_ms": 50}
        self.assert_fed(Daemon(self, REALTIME, resin), 0.2)

    def test_a_print_goes_on_if_the_supervisor_does_not_read(self):
        # The supervisor's socket is soon full: waiting for it with the light on would ruin the part.
        daemon = self.launch(Daemon(self), WATCHDOG_USEC="100000", WATCHDOG_PID="self")
        self.wait_for("READY=1")
        client = Client(daemon.socket_path)
        client.call("watch")
        daemon.drop("part.stl", binary_stl(box((0, 0, 0), (5, 5, 50))))  # 1000 layers
        client.wait_for(lambda m: m.get("method") == "ended", "the end")
        client.close()
        self.notify.close()

    def test_another_process_s_watchdog_is_not_fed(self):
        self.launch(Daemon(self), WATCHDOG_USEC="50000", WATCHDOG_PID="1")
        self.wait_for("READY=1")
        self.notify.settimeout(0.3)
        with self.assertRaises(TimeoutError):
            self.receive()

    def test_a_machine_that_cannot_print_is_ready_and_its_status_line_says_why(self):
        daemon = Daemon(self)
        daemon.config = source_json("raspberry-pi-4.json")
        daemon.config.update({"spool_folder": "spool", "control_socket": "control.sock",
                              "projectors_folder": os.path.join(SOURCE, "config", "projectors")})  # fmt: skip
        daemon.config["projector"]["port"] = "/dev/tty-missing"
        daemon.write_config()
        self.launch(daemon)
        status = next(line for line in iter(lambda: self.receive()[0], "") if line.startswith("STATUS="))
        self.assertTrue(status.startswith("STATUS=Cannot print: the serial port /dev/tty-missing"), status)
        self.wait_for("READY=1")

    def test_the_unit_waits_for_readiness_and_has_a_watchdog(self):
        unit = dict(re.findall(r"^(\w+)=(.*)$", text_of(os.path.join(SOURCE, "systemd", "contourd.service")), re.M))
        self.assertEqual(unit["Type"], "notify")
        self.assertIn("WatchdogSec", unit)
        self.assertIn("--config", unit["ExecStart"])
        # The light goes off however the daemon ended.
        self.assertIn("--light-off", unit["ExecStopPost"])
        # systemd does not restart the daemon if its configuration is wrong.
        self.assertIn(str(BAD_CONFIG), unit["RestartPreventExitStatus"])
