"""The notices about ended jobs that contourd sends to contourd-job-ended.socket, which starts a command of the user for each
notice. Nothing waits for the command."""

import contextlib
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import threading
import unittest

from harness import ENDLESS, REALTIME, SANITIZED, SOURCE, Daemon, FolderTest, binary_stl, contents, cube, source_json, wait_until

WITH_ENDED_JOB = os.path.join(SOURCE, "systemd", "with-ended-job")
HOSTILE = 'x"; touch $(pwd)/pwned; `touch pwned` \n--version\x1b[2J'
# The name of such a job in messages.
HARMLESS = 'x"; touch $(pwd)?pwned; `touch pwned` ?--version?[2J'


def unit(name):
    """Returns a dictionary from each setting of a unit to the list of its values."""
    with open(os.path.join(SOURCE, "systemd", name), encoding="utf-8") as file:
        settings = {}
        for key, value in re.findall(r"^(\w+)=(.*)$", file.read(), re.MULTILINE):
            settings.setdefault(key, []).append(value)
        return settings


class ServiceManager:
    """Starts the user's command for each connection, as contourd-job-ended.socket does."""

    def __init__(self, test, path, command):
        self.command = command
        self.heard = test.path("heard")
        os.makedirs(self.heard, exist_ok=True)
        self.started = []
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.bind(path)
        self.socket.listen(128)
        threading.Thread(target=self._accept, daemon=True).start()
        test.addCleanup(self.close)

    def _accept(self):
        while True:
            try:
                connection, _ = self.socket.accept()
            except OSError:
                return
            number = len(self.started)
            with connection, open(os.path.join(self.heard, f"{number}.log"), "wb") as log:
                self.started.append(subprocess.Popen(
                    [WITH_ENDED_JOB, self.command], stdin=connection, stdout=log, stderr=log,
                    env={"PATH": os.environ["PATH"], "NUMBER": str(number), "HEARD": self.heard},
                    start_new_session=True))  # fmt: skip

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()
        for process in self.started:
            # The whole session, as systemd does: the command may have started others.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def notices(self, count):
        """Waits until this number of commands has run, and returns their environments in the order of their start."""
        def all_there():
            return sum(name.endswith(".env") for name in os.listdir(self.heard)) >= count
        wait_until(all_there, f"{count} notices")
        found = []
        for number in range(count):
            with open(os.path.join(self.heard, f"{number}.env"), "rb") as file:
                pairs = (pair.split(b"=", 1) for pair in file.read().split(b"\0") if pair.startswith(b"CONTOURD_"))
                found.append({os.fsdecode(name).removeprefix("CONTOURD_"): os.fsdecode(value) for name, value in pairs})
        return found

    def log(self, number):
        self.started[number].wait()
        return contents(os.path.join(self.heard, f"{number}.log")).decode()


class JobEndedTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.command = self.script('env -0 >"$HEARD/$NUMBER.new" && mv "$HEARD/$NUMBER.new" "$HEARD/$NUMBER.env"')

    def script(self, body, name="command"):
        path = self.write(name, f"#!/bin/sh\n{body}\n")
        os.chmod(path, 0o755)
        return os.fsdecode(path)

    def listen(self, command=None):
        return ServiceManager(self, self.path("job-ended.socket"), command or self.command)

    def daemon(self, **options):
        return Daemon(self, **options)

    def test_the_notice_of_a_done_job_names_its_report(self):
        manager = self.listen()
        daemon = self.daemon().start()
        daemon.printed("gear.stl", binary_stl(cube(2)))
        (notice,) = manager.notices(1)
        self.assertEqual((notice["JOB"], notice["OUTCOME"], notice["REASON"]), ("gear", "done", ""))
        self.assertEqual(notice["PRINTER"], daemon.config["name"])
        self.assertEqual(notice["REPORT_HTML"], daemon.file("done", "gear.report.html"))
        self.assertEqual(json.loads(contents(notice["REPORT_JSON"]))["outcome"], "done")
        sent = json.loads(notice["NOTICE"])
        self.assertEqual(sent, {"printer": notice["PRINTER"], "job": "gear", "outcome": "done", "reason": "",
                                "report_json": notice["REPORT_JSON"], "report_html": notice["REPORT_HTML"]})  # fmt: skip
        self.assertEqual(manager.log(0), "gear: done\n")

    def test_a_job_that_is_refused_or_removed_in_the_queue_gives_a_notice(self):
        manager = self.listen()
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.begin("first.stl", binary_stl(cube(2)))
        reason = daemon.refused("bad.stl", b"no model").strip()
        daemon.drop("tired.stl", binary_stl(cube(2)))
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["tired.stl"], "the job in the queue")
        self.assertEqual(daemon.ctl("queue", "remove", "tired").returncode, 0)
        daemon.wait_ended("tired")
        daemon.ctl("cancel")
        daemon.wait_ended("first")
        bad, tired, first = manager.notices(3)
        self.assertEqual((bad["JOB"], bad["OUTCOME"], bad["REASON"], bad["REPORT_HTML"]), ("bad", "failed", reason, ""))
        self.assertEqual((tired["JOB"], tired["OUTCOME"]), ("tired", "cancelled"))
        self.assertEqual((first["JOB"], first["OUTCOME"]), ("first", "cancelled"))
        self.assertEqual(first["REPORT_JSON"], daemon.file("failed", "first.report.json"))

    def test_a_hostile_job_name_reaches_the_command_as_one_harmless_line(self):
        manager = self.listen()
        daemon = self.daemon().start()
        name = HOSTILE.replace("/", "\n")
        daemon.drop(name + ".stl", b"no model")
        daemon.drop(b"bytes \xff.stl".decode(errors="surrogateescape"), binary_stl(cube(2)))
        hostile, odd = manager.notices(2)
        self.assertEqual((hostile["JOB"], hostile["OUTCOME"]), (HARMLESS, "failed"))
        self.assertEqual(odd["OUTCOME"], "done")
        self.assertTrue(os.path.exists(odd["REPORT_HTML"]), odd["REPORT_HTML"])
        self.assertEqual(manager.log(0).count("\n"), 1)
        self.assertEqual([name for name in os.listdir(self.folder) if "pwned" in name], [])

    def test_many_jobs_that_end_at_once_all_give_a_notice(self):
        manager = self.listen()
        daemon = self.daemon().start()
        for number in range(30):
            daemon.drop(f"bad{number}.stl", b"no model")
        notices = manager.notices(30)
        self.assertEqual({notice["JOB"] for notice in notices}, {f"bad{number}" for number in range(30)})

    def test_a_command_that_hangs_delays_no_job(self):
        manager = self.listen(self.script("exec sleep 1000000", "hangs"))
        daemon = self.daemon().start()
        for number in range(80):
            daemon.drop(f"bad{number}.stl", b"no model")
        daemon.printed("good.stl", binary_stl(cube(2)))
        wait_until(lambda: len(manager.started) == 4, "four commands to start")
        self.assertEqual(daemon.log().count("no notice is sent"), 1, daemon.log())

    def print_two(self, command):
        manager = self.listen(command)
        daemon = self.daemon().start()
        for name in ("one", "two"):
            daemon.drop(f"{name}.stl", binary_stl(cube(2)))
            daemon.wait_done(name)
        wait_until(lambda: len(manager.started) == 2, "two commands to start")
        self.assertTrue(manager.log(0).startswith("one: done\n"))
        return manager

    def test_a_missing_command_is_reported_in_the_log_of_its_unit(self):
        manager = self.print_two(self.path("nowhere"))
        self.assertIn(f"{self.path('nowhere')}: there is no such command to run", manager.log(1))
        self.assertNotEqual(manager.started[1].returncode, 0)

    def test_a_command_that_fails_does_no_harm(self):
        manager = self.print_two(self.script("exit 7", "fails"))
        self.assertNotEqual(manager.started[0].returncode, 0)

    def test_a_command_that_prints_without_end_does_no_harm(self):
        self.print_two(self.script("yes | head -c 5000000", "floods"))

    def test_a_print_that_ends_by_a_stop_or_a_kill_gives_a_notice(self):
        manager = self.listen()
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.begin("stopped.stl", binary_stl(cube(2)))
        daemon.stop()
        (stopped,) = manager.notices(1)
        self.assertEqual((stopped["JOB"], stopped["OUTCOME"]), ("stopped", "failed"))
        self.assertIn("contourd was stopped", stopped["REASON"])
        daemon.start()
        daemon.ctl("resume")
        daemon.begin("killed.stl", binary_stl(cube(2)))
        daemon.kill()
        daemon.start()
        _, killed = manager.notices(2)
        self.assertEqual((killed["JOB"], killed["OUTCOME"]), ("killed", "failed"))
        self.assertIn("The print was interrupted", killed["REASON"])

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_a_print_that_ends_on_a_full_disk_before_a_stop_is_in_the_history_and_gives_one_notice(self):
        manager = self.listen()
        daemon = Daemon(self, REALTIME, ENDLESS)
        slow = daemon.put_on_slow_disk()
        gates = [os.path.join(slow, gate) for gate in ("full", "history-full")]
        for count, name in enumerate(("one", "two"), 1):  # the second print needs new spares
            daemon.start()
            daemon.begin(name + ".stl", binary_stl(cube(2)))
            for gate in gates:
                self.write(gate, b"")
            daemon.cancel(name)
            manager.notices(count)
            daemon.stop()
            self.assertTrue(daemon.has("failed", name + ".stl"))
            for gate in gates:
                os.unlink(gate)
        daemon.start()
        ended = daemon.rpc("history")["result"]["ended"]
        self.assertEqual([(job["job"], job["outcome"]) for job in ended], [("one", "cancelled"), ("two", "cancelled")])
        daemon.stop()
        self.assertEqual([notice["JOB"] for notice in manager.notices(2)], ["one", "two"])

    def test_without_a_listener_nothing_is_logged_or_left(self):
        daemon = self.daemon().start()
        daemon.printed("gear.stl", binary_stl(cube(2)))
        daemon.stop()
        self.assertNotIn("job-ended.socket", daemon.log())
        self.assertFalse(os.path.exists(self.path("job-ended.socket")))


class ExamplesTest(FolderTest):
    NOTICE = {"PRINTER": "p", "JOB": HARMLESS, "OUTCOME": "failed", "REASON": "-t --config=x", "REPORT_JSON": "",
              "REPORT_HTML": "/spool/failed/x.report.html", "NOTICE": '{"job": "x"}'}  # fmt: skip

    def run_example(self, name, program, variable):
        """Runs an example, and returns the arguments and the standard input of the program that it calls."""
        path = self.write(program, f"#!/bin/sh\nprintf '%s\\0' \"$@\" >{self.folder}/arguments\ncat >{self.folder}/input\n")
        os.chmod(path, 0o755)
        environment = {**os.environ, **{f"CONTOURD_{key}": value for key, value in self.NOTICE.items()}, variable: os.fsdecode(path)}
        subprocess.run([os.path.join(SOURCE, "config", "examples", name)], env=environment, cwd=self.folder, check=True, stdin=subprocess.DEVNULL)
        self.assertNotIn("pwned", os.listdir(self.folder))
        with open(self.path("arguments"), encoding="utf-8") as arguments, open(self.path("input"), encoding="utf-8") as given:
            return arguments.read().split("\0")[:-1], given.read()

    def test_the_mail_has_one_recipient_and_a_job_s_name_adds_no_header(self):
        arguments, mail = self.run_example("job-ended-mail", "sendmail", "SENDMAIL")
        self.assertEqual(arguments, ["-i", "--", "root@localhost"])
        headers, body = mail.split("\n\n", 1)
        self.assertEqual([line.split(":")[0] for line in headers.splitlines()],
                         ["To", "Subject", "Auto-Submitted", "MIME-Version", "Content-Type", "Content-Transfer-Encoding"])  # fmt: skip
        self.assertIn(f"Subject: p: {HARMLESS} failed\n", headers + "\n")
        self.assertEqual(body, f"{HARMLESS}: failed\n-t --config=x\n\nIts report: /spool/failed/x.report.html\n")

    def test_the_message_has_one_topic(self):
        arguments, _ = self.run_example("job-ended-mqtt", "mosquitto_pub", "MOSQUITTO_PUB")
        self.assertEqual(arguments, ["-h", "localhost", "-q", "1", "-t", "contourd/job-ended", "-m", '{"job": "x"}'])


class UnitsTest(unittest.TestCase):
    def test_only_the_daemon_can_use_the_socket_and_its_path_is_the_default(self):
        settings = unit("contourd-job-ended.socket")
        self.assertEqual(settings["ListenStream"], [source_json("contourd.schema.json")["properties"]["job_ended_socket"]["default"]])
        self.assertEqual((settings["SocketUser"], settings["SocketMode"]), (["contourd"], ["0600"]))
        # Four connections at a time, and the waiting ones when contourd stops (daemon/history/ended_job_notices.hpp).
        self.assertGreater(int(settings["MaxConnections"][0]), 4 + 64)
        self.assertEqual(settings["TriggerLimitIntervalSec"], ["0"])

    def test_a_command_has_limits_and_does_not_run_as_root(self):
        settings = unit("contourd-job-ended@.service")
        self.assertEqual(settings["DynamicUser"], ["yes"])
        for limit in ("TimeoutStartSec", "MemoryMax", "TasksMax", "LogRateLimitBurst"):
            self.assertIn(limit, settings)
        self.assertFalse(any(value.startswith("+") or value.startswith("!") for key in settings for value in settings[key] if key.startswith("Exec")))

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed")
    def test_systemd_accepts_the_units(self):
        units = (os.path.join(SOURCE, "systemd", name) for name in ("contourd-job-ended.socket", "contourd-job-ended@.service"))
        checked = subprocess.run(["systemd-analyze", "verify", "--man=no", *units], capture_output=True, text=True, check=False)
        # The command that the unit starts is not installed here.
        complaints = [line for line in checked.stderr.splitlines() if "contourd" in line and "not executable" not in line]
        self.assertEqual(complaints, [])
