"""Compares docs/control-api.md with the program, in both directions: methods, fields, types, states, notifications, error
codes and examples."""

import json
import os
import pathlib
import re
import subprocess
import sys

from harness import (
    CONTOURD, DEADLINE_S, ENDLESS, ISLAND, NIMBLE_RESIN, SMALL, SOURCE, Daemon, FolderTest, binary_stl, box, check_generated, run, wait_until,
)  # fmt: skip

PAGE = (pathlib.Path(SOURCE) / "docs/control-api.md").read_text(encoding="utf-8")
# The code for an exception, which no request can cause.
INTERNAL_ERROR = -32603
# The code for a caller of another user and group, tested in manual_test.py.
NOT_ALLOWED = -32001


def section(title, page=PAGE):
    """Returns the text between this heading and the next one of its level or above."""
    level = title.split(" ")[0]
    found = re.search(rf"^{re.escape(title)}\n(.*?)(?=^#{{1,{len(level)}}} |\Z)", page, re.MULTILINE | re.DOTALL)
    assert found, f"there is no heading {title!r}"
    return found[1]


def rows(title):
    """Returns the rows of the section's table as lists of cells, the first cell without its backticks."""
    lines = [line.strip("|").split("|") for line in section(title).splitlines() if line.startswith("| ")]
    assert len(lines) > 1, f"{title!r} has no table"
    return [[cells[0].strip().strip("`"), *(cell.strip() for cell in cells[1:])] for cells in lines[1:]]


def messages(text):
    """Returns every line of the section's JSON blocks, parsed."""
    return [json.loads(line) for block in re.findall(r"^```json\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
            for line in block.splitlines()]  # fmt: skip


METHODS = re.findall(r"^### `(\w+)`$", section("## Methods") + section("## By hand"), re.MULTILINE)
# The reply's table, by the link to its heading, or the reply itself.
REPLIES = {name: re.search(r"Reply:\s+(?:a\s+\[\w+\]\(#([\w-]+)\)|`(\w+)`)", section(f"### `{name}`")) for name in METHODS}
TITLES = {title.lower().replace(" ", "-"): title for title in re.findall(r"^### ([A-Z].*)$", PAGE, re.MULTILINE)}
NOTIFICATIONS = [name for name, _ in rows("## Notifications")]
STATUS, JOB, ANALYSIS = rows("### A status"), rows("### A job"), rows("### An analysis")
ENDED_JOB, MANUAL = rows("### An ended job"), rows("### A manual operation")
WAITING, OVERRIDE = rows("### A waiting job"), rows("### An override")
SUPPORTS, FORECAST = rows("### Supports"), rows("### A forecast")
PAST_JOB = rows("### A job of the history")
INPUT = rows("### An input")
PART = rows("### A part that wears")
METHOD, PARAMETER = rows("### A method"), rows("### A parameter")
STATES = {name for name, _ in rows("### States")}
CODES = {int(code) for code, _ in rows("## Errors")}
TYPES = {"text": str, "number": (int, float), "object": dict, "list": list, "true": bool, "false": bool, "null": type(None)}


def is_of_type(value, described):
    types = [TYPES[word] for word in described.split(" or ")]
    if isinstance(value, bool):
        return bool in types
    return any(isinstance(value, each) for each in types)


def generated(method):
    """Returns the lines about a method that the page has from the program."""
    is_changing, needs_rights = method["changes"], method["needs_service_rights"]
    notes = [*(["changes the printer"] if is_changing else []), *(["needs service rights"] if needs_rights else [])]
    lines = [method["description"] + (f" The method {' and '.join(notes)}." if notes else "")]
    if method["parameters"]:
        lines += ["", "| parameter | valid values | meaning |", "|---|---|---|"]
        lines += [f"| `{each['name']}`{', needed' if each['needed'] else ''} | {each['must_be']} | {each['meaning']} |"
                  for each in method["parameters"]]  # fmt: skip
    return "".join(line + "\n" for line in lines)


class ControlApiTest(FolderTest):
    def fast(self):
        return Daemon(self).start()

    def printing(self, simulation=None, **more):
        """Starts a daemon whose print stays in its first exposure."""
        resin = {**ENDLESS, "ticket_limits": {"settle_ms": [0, 100]}}
        return FolderTest.printing(self, "part.stl", SMALL, resin, {"copies": 2}, simulation=simulation or {}, **more)

    def assert_fields(self, value, table, without=()):
        expected = [name for name, *_ in table if name not in without]
        self.assertEqual(list(value), expected)
        for name, described, _ in table:
            if name not in without:
                self.assertTrue(is_of_type(value[name], described), f"{name}: {value[name]!r} is not {described}")

    def assert_status(self, status):
        self.assert_fields(status, STATUS)
        self.assertIn(status["state"], STATES)
        if status["job"] is not None:
            # The table marks these fields with "from here on only while it prints".
            names = [name for name, *_ in JOB]
            first = next(i for i, (_, _, meaning) in enumerate(JOB) if "only while it prints" in meaning)
            prints = status["state"] not in ("preparing", "finishing")
            self.assert_fields(status["job"], JOB, () if prints else names[first:])
            if status["job"]["analysis"] is not None:
                self.assert_fields(status["job"]["analysis"], ANALYSIS)
        self.assert_fields(status["manual"], MANUAL)
        if status["camera"] is not None:
            self.assert_fields(status["camera"], rows("### A camera"))
        if status["last"] is not None:
            self.assert_fields(status["last"], ENDED_JOB)

    def assert_reply(self, method, result):
        reply = REPLIES[method]
        self.assertIsNotNone(reply, f"{method} has no reply")
        if reply[2]:
            return self.assertEqual(result, json.loads(reply[2]))
        if reply[1] == "a-status":
            return self.assert_status(result)
        self.assert_fields(result, rows(f"### {TITLES[reply[1]]}"))
        for each in result.get("entries", ()):
            self.assert_fields(each, rows("### An entry of the log"))
        for each in result.get("settings", ()):
            self.assert_fields(each, rows("### A setting"))
        for each in result.get("inputs", ()):
            self.assert_fields(each, INPUT)
        for job in result["jobs"] if reply[1] == "a-queue" else ():
            self.assert_fields(job, WAITING)
            self.assertIn(f"`{job['state']}`", WAITING[3][2])
            if job["forecast"]:
                self.assert_fields(job["forecast"], FORECAST)
                for cause in job["forecast"]["causes_s"]:
                    self.assertIn(f"`{cause}`", section("### A forecast"))
            if job["supports"]:
                self.assert_fields(job["supports"], SUPPORTS)
            for each in job["overrides"] or ():
                self.assert_fields(each, OVERRIDE)
                self.assertIn(f"`{each['setting']}`", OVERRIDE[0][2])
        for part in result.get("parts", ()):
            self.assert_fields(part, PART)
        for each in result.get("methods", ()):
            self.assert_fields(each, METHOD)
            for parameter in each["parameters"]:
                self.assert_fields(parameter, PARAMETER)
        for job in result.get("ended", ()):
            self.assert_fields(job, PAST_JOB)
        for resin in result["resins"] if reply[1] == "a-list-of-resins" else ():
            self.assert_fields(resin, rows("### A resin"))
            for calibration in resin["calibrations"]:
                self.assert_fields(calibration, rows("### A calibration"))
                for value in calibration["values"]:
                    self.assert_fields(value, rows("### A calibrated value"))

    def test_the_page_lists_the_methods_of_the_program(self):
        message = self.fast().rpc("no such method")["error"]["message"]
        self.assertEqual(sorted(METHODS), sorted(message.split("there are ")[1].split(", ")))

    def test_a_mistyped_method_leads_to_the_nearest_one(self):
        message = self.fast().rpc("statsu")["error"]["message"]
        self.assertTrue(message.startswith('no method "statsu"; there are '), message)
        self.assertTrue(message.endswith("; did you mean status?"), message)

    def test_every_method_takes_the_documented_parameters(self):
        client = self.fast().client()
        for method in METHODS:
            with self.subTest(method):
                names = re.findall(r"^\| `(\w+)`", section(f"### `{method}`"), re.MULTILINE)
                client.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": {"no": 1}, "id": method}).encode() + b"\n")
                error = client.wait_for(lambda m, method=method: m.get("id") == method, method)["error"]
                self.assertEqual(error["code"], -32602)
                # The error of a method with parameters lists them.
                _, _, listed = error["message"].partition("there are ")
                self.assertEqual(names, listed.split(", ") if listed else [], error["message"])

    def test_the_descriptions_of_the_methods_come_from_the_program(self):
        described = {each["name"]: generated(each) for each in self.fast().rpc("methods")["result"]["methods"]}
        self.assertEqual(sorted(described), sorted(METHODS))
        check_generated(self, "docs/control-api.md", "<!-- begin {} -->\n", "<!-- end -->\n", described)

    def test_every_reply_has_the_documented_fields(self):
        daemon = self.printing(ask_before=["islands"])
        answers = {}
        for name, model in (("one", SMALL), ("two", ISLAND)):
            daemon.drop(f"{name}.stl", model, {"settle_ms": 10})
        wait_until(lambda: [job["state"] for job in daemon.rpc("queue")["result"]["jobs"]] == ["ready", "unaccepted"], "both jobs to be checked")
        parameters_of = {"queue_move": {"job": "two", "to": 1}, "accept": {"job": "two"}, "queue_remove": {"job": "one"}, "replaced": {"part": "film"}, "set": {"setting": "rest", "value": 300},
                         "exclude": {"copy": "2"}, "ticket": {"job": "two"}, "queue_ticket": {"job": "two", "ticket": {"settle_ms": 20}}, "preview": {"job": "one"}}
        self.assert_fields(daemon.rpc("copies")["result"]["copies"][0], rows("### A copy"))
        answers["preflight"] = daemon.client().call("preflight", job="two")
        for each in answers["preflight"]["result"]["checks"]:
            self.assert_fields(each, rows("### A preflight check"))
        for method in ("watch", "status", "queue", "history", "usage", "replaced", "queue_move", "accept", "ticket", "preview", "queue_ticket", "queue_remove", "pause", "resume", "set", "settings", "copies", "exclude", "cancel"):
            answers[method] = daemon.client().call(method, **parameters_of.get(method, {}))
        daemon.rpc("queue_remove", job="two")
        self.assertEqual(daemon.wait_ended("part")["outcome"], "cancelled")
        answers["report"] = daemon.rpc("report", job="part")
        os.mkdir(daemon.file("failed", "part.pictures"))
        for method, name in (("picture", "00001.jpg"), ("time_lapse", "time-lapse.mp4"), ("pictures", "00002.jpg")):
            self.write(daemon.file("failed", "part.pictures", name), b"content")
            answers[method] = daemon.rpc(method, job="part")
        answers["plate_cleared"] = daemon.rpc("plate_cleared")
        manual = {"home": {}, "stop": {}, "light_off": {}, "show": {"pattern": "grid"}, "mask": {}, "upload": {"from": 0, "data": "AAAA"}, "light_on": {"seconds": 0.01, "in_resin": True},
                   "projector": {}, "motor_off": {}, "inputs": {}, "move": {"to_mm": 1}}  # fmt: skip
        for method, parameters in manual.items():
            if method == "move":
                daemon.client().call("home")
                wait_until(lambda: daemon.status()["manual"]["height_mm"] == 0, "the plate to be at home")
            wait_until(lambda: daemon.status()["manual"]["state"] == "idle", "the manual operation to end")
            answers[method] = daemon.client().call(method, **parameters)
        daemon.rpc("stop")  # ends the picture
        daemon.begin("cut.stl", SMALL)
        for method, parameters in (("go_on", {"trust_position": True}), ("rescue", {})):
            wait_until(lambda: daemon.records_a_part(), "the record of the print")
            daemon.kill()
            daemon.start()
            answers[method] = daemon.rpc(method, **parameters)
        for method in METHODS:
            if method not in answers:
                example = messages(section(f"### `{method}`"))[0]
                answers[method] = daemon.client().call(method, **example.get("params", {}))
        for method, answer in answers.items():
            with self.subTest(method):
                self.assertIn("result", answer)
                self.assert_reply(method, answer["result"])

    def test_a_job_has_the_documented_fields_in_each_of_its_states(self):
        daemon = self.fast()
        daemon.printed("part.stl", SMALL)
        statuses = [message["params"] for message in daemon.watcher.seen if message.get("method") in NOTIFICATIONS]
        self.assertIn("finishing", [status["state"] for status in statuses])
        self.assertIn("resting", [status["state"] for status in statuses])
        for status in statuses:
            with self.subTest(status["state"]):
                if "printer" in status:  # the harness adds notifications that hold only a job
                    self.assert_status(status)
        for job in [*daemon.rpc("history")["result"]["ended"], *daemon.rpc("history", this_run=True)["result"]["ended"]]:
            self.assert_fields(job, PAST_JOB)
            self.assert_fields(job["analysis"], ANALYSIS)

    def test_the_page_lists_the_notifications_of_the_program(self):
        daemon = self.printing({"lid_opened_after_light_s": 0.05, "lid_open_s": 0.05}, ask_before=["islands"])
        daemon.watcher.wait_for(lambda m: m.get("method") == "machine", "the lid")
        daemon.wait_state("paused")
        daemon.cancel("part")
        daemon.write_resin("standard", NIMBLE_RESIN)
        daemon.rpc("plate_cleared")
        daemon.drop("thin.stl", binary_stl(box((0, 0, 0), (10, 5, 0.05))))
        daemon.wait_ended("thin")
        daemon.drop("odd.stl", ISLAND)
        daemon.watcher.wait_for(lambda m: m.get("method") == "question", "a question")
        daemon.rpc("replaced", part="film")
        daemon.watcher.wait_for(lambda m: m.get("method") == "reminders", "the new film")
        daemon.rpc("projector")
        daemon.watcher.wait_for(lambda m: m.get("method") == "manual", "the projector")
        notifications = [message for message in daemon.watcher.seen if "id" not in message]
        self.assertEqual({message["method"] for message in notifications}, set(NOTIFICATIONS))
        for message in notifications:
            self.assertEqual(list(message), ["jsonrpc", "method", "params"])
            self.assert_status(message["params"])

    def test_every_notification_in_the_sources_is_documented(self):
        sources = "".join(path.read_text() for path in (pathlib.Path(SOURCE) / "daemon").rglob("*.cpp"))
        in_sources = set(re.findall(r'\bnotify\w*\(\s*"(\w+)"', sources))
        self.assertTrue(in_sources)
        self.assertEqual(in_sources - set(NOTIFICATIONS), set())

    def test_the_page_lists_the_states_of_the_program(self):
        # Other tables than the layered print's are drawn as subgraphs.
        graph = run(CONTOURD, "--print-states").stdout.decode()
        drawn = graph.partition("subgraph")[0]
        states = {end for ends in re.findall(r'^  "([^"]+)" -> "([^"]+)"', drawn, re.MULTILINE) for end in ends}
        rise = set(re.findall(r'"continuous: ([^"]+)" \[', graph))
        self.assertIn("layering", rise)  # the states of a layered print
        self.assertEqual(STATES, (states | rise) - {"any state", "layering"} | {"preparing", "finishing"})
        manual = set(re.findall(r'"by hand: ([^"]+)" \[', graph))
        self.assertEqual(set(re.findall(r"`([^`]+)`", MANUAL[0][2])), manual)

    def test_the_page_lists_the_error_codes_of_the_program(self):
        client = self.fast().client()
        codes = {INTERNAL_ERROR, NOT_ALLOWED}
        for line in ("{", "1", '{"jsonrpc":"2.0","method":"fly","id":1}', '{"jsonrpc":"2.0","method":"pause","id":1}',
                     '{"jsonrpc":"2.0","method":"status","params":[1],"id":1}'):  # fmt: skip
            client.send(line.encode() + b"\n")
            codes.add(client.next()["error"]["code"])
        self.assertEqual(codes, CODES)

    def test_the_page_lists_the_limits_of_the_program(self):
        limits = {limit: is_ for limit, is_, _ in rows("## How to talk")}
        bytes_, in_batch = (int(limits[name].split()[0]) for name in ("a message", "a batch"))
        client = self.fast().client()

        def answer(line):
            client.send(line + b"\n")
            return client.next()

        fits = b'{"jsonrpc":"2.0","method":"queue","id":1}'
        self.assertIn("result", answer(fits.ljust(bytes_)))
        self.assertIn(str(bytes_), answer(b" " * (2 * bytes_))["error"]["message"])
        self.assertEqual(len(answer(b"[" + b",".join([b"1"] * in_batch) + b"]")), in_batch)
        self.assertIn(f"1 to {in_batch}", answer(b"[" + b",".join([b"1"] * (in_batch + 1)) + b"]")["error"]["message"])

    def test_every_example_matches_the_program(self):
        """An answer must have the fields and types of its example; an error must be equal to its example."""
        daemon = self.fast()
        for title in ("## Errors", *(f"### `{method}`" for method in METHODS)):
            with self.subTest(title):
                request, reply = messages(section(title))
                client = daemon.client()
                client.send(json.dumps(request).encode() + b"\n")
                answer = client.next()
                if "error" in reply:
                    self.assertEqual(answer, reply)
                else:
                    self.assertEqual((list(answer), answer["id"]), (list(reply), reply["id"]))
                    self.assert_reply(request["method"], reply["result"])
        (ended,) = messages(section("## Notifications"))
        self.assertIn(ended["method"], NOTIFICATIONS)
        self.assert_status(ended["params"])

    def test_the_python_example_runs(self):
        daemon = self.fast()
        (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=DEADLINE_S, check=False,
                               env={**os.environ, "CONTOURD_SOCKET": daemon.socket_path})  # fmt: skip
        self.assertEqual((ended.returncode, ended.stdout), (0, b"idle\n"), ended.stderr)
