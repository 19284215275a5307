"""The control socket, used directly and by contourctl."""

import json
import os
import signal
import socket
import subprocess
import threading
import time

from harness import (
    BAD_USAGE, CONTOURCTL, CONTOURD, DEADLINE_S, ENDLESS, FAILED, NIMBLE_RESIN, OK, REALTIME, SANITIZED, SLAB, SMALL, UNAVAILABLE, Daemon, FolderTest,
    binary_stl, box, contents, contourctl, realtime, run, wait_until,
)  # fmt: skip

TALL = binary_stl(box((0, 0, 0), (5, 5, 100)))  # 2000 layers

PARSE_ERROR, INVALID_REQUEST, METHOD_NOT_FOUND, INVALID_PARAMS, REFUSED = -32700, -32600, -32601, -32602, -32000


class ControlTest(FolderTest):
    def fast(self, **config):
        self.daemon = Daemon(self, config).start()
        return self.daemon

    def realtime(self, resin=None, config=None):
        """Starts a daemon in real time. Without a resin, its print stays in its first exposure; otherwise layers take milliseconds."""
        self.daemon = Daemon(self, realtime(**(config or {})), {**NIMBLE_RESIN, **(ENDLESS if resin is None else resin)}).start()
        return self.daemon

    def printing(self):
        daemon = self.realtime()
        daemon.begin("part.stl", SLAB)
        return daemon

    def assert_error(self, answer, code, number=None):
        self.assertEqual(answer["jsonrpc"], "2.0")
        self.assertEqual(answer["error"]["code"], code, answer)
        self.assertGreater(len(answer["error"]["message"]), 10)
        self.assertEqual(answer["id"], number)
        self.assertNotIn("result", answer)


class Protocol(ControlTest):
    def setUp(self):
        super().setUp()
        self.fast()
        self.client = self.daemon.client()

    def tearDown(self):
        # Whatever a test has sent, the connection and the daemon must still work.
        self.assertIn("result", self.client.call("status"))
        self.daemon.printed("good.stl", SLAB)
        self.daemon.stop()

    def answer(self, line):
        self.client.send(line if isinstance(line, bytes) else line.encode() + b"\n")
        answer = self.client.next()
        self.assertIsNotNone(answer, "disconnected")
        return answer

    def test_status_has_every_key_when_idle(self):
        result = self.client.call("status")["result"]
        self.assertEqual(result, {
            "printer": "Simulated printer", "spool": self.daemon.spool, "state": "idle", "job": None, "queued": 0, "incomplete": {},
            "incomplete_more": 0, "postponed": {}, "postponed_more": 0, "unaccepted": {}, "unaccepted_more": 0, "ignored": {}, "ignored_more": 0, "deletable": [],
            "deletable_more": 0, "plate": "clear", "plate_job": None, "not_ready_reason": None, "held": None, "interrupted": None, "waiting_for": None,
            "reminders": [],
            "last": None,
            "dark": True,
            "manual": {"state": "idle", "operations": 0, "problem": None, "dark": True, "height_mm": None, "homing_shift_um": None,
                       "picture": None,
                       "projector": None},
            "camera": None,
        })  # fmt: skip

    def test_the_error_about_an_unknown_method_lists_the_known_methods(self):
        answer = self.answer('{"jsonrpc":"2.0","method":"fly","id":7}')
        self.assert_error(answer, METHOD_NOT_FOUND, 7)
        self.assert_words(answer["error"]["message"], "status", "queue", "watch", "pause", "resume", "cancel", "plate_cleared", "fly")

    def test_invalid_json_gets_a_parse_error(self):
        for line in ("{", "hello", "}", '{"jsonrpc":"2.0","method":"status"', "'status'", "[1,", "\x00", "NaN",
                     '{"jsonrpc":"2.0","method":"status","id":1} {}', "GET / HTTP/1.1"):  # fmt: skip
            with self.subTest(line):
                self.assert_error(self.answer(line), PARSE_ERROR)
        self.assert_error(self.answer(b'{"method":"\xff\xfe"}\n'), PARSE_ERROR)

    def test_json_that_is_no_request_gets_an_invalid_request_error(self):
        for line in ("1", '"status"', "null", "true", "{}", '{"method":"status","id":null}',
                     '{"jsonrpc":"1.0","method":"status"}', '{"jsonrpc":2.0,"method":"status"}',
                     '{"jsonrpc":"2.0","method":1}', '{"jsonrpc":"2.0","method":["status"]}',
                     '{"jsonrpc":"2.0","result":{}}', "[]"):  # fmt: skip
            with self.subTest(line):
                self.assert_error(self.answer(line), INVALID_REQUEST)

    def test_ids_may_be_strings_and_numbers_and_nothing_else(self):
        for number in (0, -1, 1.5, 2**53, "", "a \u00e4 \u2028", None, {}, [], [1], True, {"a": 1}):
            with self.subTest(number):
                answer = self.answer(json.dumps({"jsonrpc": "2.0", "method": "queue", "id": number}))
                if isinstance(number, (bool, list, dict)):
                    self.assertEqual(answer.get("error", {}).get("code"), INVALID_REQUEST, answer)
                else:
                    self.assertEqual((answer["id"], answer["result"]), (number, {"queue": [], "more": 0, "jobs": [], "arriving": []}))
        self.assert_error(self.answer('{"method":"status","id":"abc"}'), INVALID_REQUEST, "abc")

    def test_deep_nesting_crashes_nothing(self):
        depth = 3500
        deep = "[" * depth + "]" * depth
        for line in (deep, f'{{"jsonrpc":"2.0","method":"status","params":{deep},"id":1}}',
                     f'{{"jsonrpc":"2.0","method":"status","id":{deep}}}', f'{{"a":{deep}}}', "[" * 8000,
                     '{"a":' * 1300 + "1" + "}" * 1300):  # fmt: skip
            # Read as bytes, since the answer may be nested as deeply.
            with socket.socket(socket.AF_UNIX) as client:
                client.connect(self.daemon.socket_path)
                client.settimeout(DEADLINE_S)
                client.sendall(line.encode() + b"\n")
                received = b""
                while not received.endswith(b"\n"):
                    data = client.recv(1 << 20)
                    self.assertTrue(data, "disconnected")
                    received += data

    def test_params_are_refused_unless_empty(self):
        for params in ("{}", "[]", "null"):
            self.assertIn("result", self.answer(f'{{"jsonrpc":"2.0","method":"status","params":{params},"id":1}}'), params)
        for params in ('{"a":1}', "[1]", '"x"', "1"):
            answer = self.answer(f'{{"jsonrpc":"2.0","method":"status","params":{params},"id":1}}')
            self.assertIn(answer["error"]["code"], (INVALID_PARAMS, INVALID_REQUEST), params)

    def test_blank_lines_and_notifications_alone_or_in_a_batch_get_no_answer(self):
        for lines in (b'{"jsonrpc":"2.0","method":"status"}\n{"jsonrpc":"2.0","method":"nonsense"}\n', b'[{"jsonrpc":"2.0","method":"status"}]\n',
                      b"\n\r\n   \n"):  # fmt: skip
            self.client.send(lines + b'{"jsonrpc":"2.0","method":"queue","id":"after"}\r\n')
            self.assertEqual(self.client.next()["id"], "after", lines)

    def test_a_batch_is_answered_in_one_message(self):
        self.client.send(b'[{"jsonrpc":"2.0","method":"status","id":1},{"jsonrpc":"2.0","method":"queue"},5,'
                         b'{"jsonrpc":"2.0","method":"fly","id":"x"},{"jsonrpc":"2.0","method":"queue","id":2}]\n')  # fmt: skip
        answers = self.client.next()
        self.assertEqual([answer["id"] for answer in answers], [1, None, "x", 2])
        self.assertIn("result", answers[0])
        self.assert_error(answers[1], INVALID_REQUEST)
        self.assert_error(answers[2], METHOD_NOT_FOUND, "x")

    def test_the_largest_batch_is_answered(self):
        self.client.send(b"[" + b",".join([b"1"] * 4000) + b"]\n")
        answers = self.client.next()
        self.assertIsNotNone(answers, "disconnected instead of answered")

    def test_a_line_that_is_too_long_gets_one_error(self):
        for size in (70000, 1 << 20, 5 << 20):
            self.client.send(b"x" * size + b"\n")
            answer = self.client.next()
            self.assert_error(answer, INVALID_REQUEST)
            self.assertIn("8192", answer["error"]["message"])
            self.client.send(b'{"jsonrpc":"2.0","method":"queue","id":3}\n')
            self.assertEqual(self.client.next()["id"], 3)

    def test_a_line_may_arrive_in_pieces(self):
        line = b'{"jsonrpc":"2.0","method":"queue","id":4}\n'
        other = self.daemon.client()
        for piece in (line[:1], line[1:20], line[20:-1]):
            self.client.send(piece)
            self.assertIn("result", other.call("status"))
        self.client.send(line[-1:] + line)
        self.assertEqual([self.client.next()["id"], self.client.next()["id"]], [4, 4])

    def test_many_requests_at_once_are_all_answered_in_order(self):
        self.client.send(b"".join(b'{"jsonrpc":"2.0","method":"queue","id":%d}\n' % number for number in range(2000)))
        self.assertEqual([self.client.next()["id"] for _ in range(2000)], list(range(2000)))

    def test_all_clients_of_one_user_share_a_limit_of_some_hundred_answers_per_second(self):
        clients = [self.daemon.client() for _ in range(10)]
        begin = time.monotonic()
        for client in clients:
            client.send(b'{"jsonrpc":"2.0","method":"queue","id":1}\n' * 150)
        for client in clients:
            for _ in range(150):
                client.next()
            client.close()
        # 200 answers come at once, and one for each client that waits for its turn; each other answer takes 2 ms on any computer.
        self.assertGreater(time.monotonic() - begin, (1500 - 200 - 10) * 0.002)

    def test_a_client_that_closes_its_sending_side_still_gets_its_answer(self):
        # `echo ... | nc -U` closes its sending side at once.
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(self.daemon.socket_path)
            client.sendall(b'{"jsonrpc":"2.0","method":"queue","id":6}\n')
            client.shutdown(socket.SHUT_WR)
            client.settimeout(DEADLINE_S)
            received = b""
            while data := client.recv(4096):
                received += data
        self.assertEqual(json.loads(received)["id"], 6)

    def test_clients_that_vanish_do_no_harm(self):
        for line in (b"", b'{"jsonrpc"', b'{"jsonrpc":"2.0","method":"watch","id":1}\n',
                     b'{"jsonrpc":"2.0","method":"status","id":1}\n' * 500):  # fmt: skip
            for _ in range(20):
                client = socket.socket(socket.AF_UNIX)
                client.connect(self.daemon.socket_path)
                client.sendall(line)
                client.close()
        self.assertTrue(self.daemon.alive())

    def test_forty_clients_are_served_at_the_same_time(self):
        clients = [self.daemon.client() for _ in range(40)]
        for client in clients:
            self.assertIn("result", client.call("watch"))
        self.daemon.drop("part.stl", SLAB)
        for client in clients:
            client.wait_for(lambda m: m.get("method") == "ended", "the end")
        for client in clients:
            client.close()

    def test_too_many_clients_do_no_harm(self):
        clients = [self.daemon.client() for _ in range(100)]
        answered = 0
        for client in clients:
            try:
                answered += "result" in client.call("status")
            except (AssertionError, OSError):
                pass  # turned away
        self.assertGreaterEqual(answered, 40)
        for client in clients:
            client.close()
        wait_until(self.reconnects, "a new client to be served")
        self.client = self.daemon.client()  # the old connection was idle, and was closed to make room

    def reconnects(self):
        try:
            return "result" in self.daemon.rpc("status")
        except (AssertionError, OSError):
            return False


class Watching(ControlTest):
    def test_notifications_carry_state_progress_and_the_end(self):
        daemon = self.fast()
        daemon.printed("part.stl", SLAB)
        seen = [m for m in daemon.watcher.seen if "method" in m]
        layers = [m["params"]["job"]["layers_done"] for m in seen if m["method"] == "layer"]
        self.assertEqual(layers, list(range(1, 21)))
        states = [m["params"]["state"] for m in seen if m["method"] == "state"]
        self.assert_words(states, "warming up", "homing", "exposing", "lifting", "parking")
        left = [m["params"]["job"]["time_left_s"] for m in seen if m["method"] == "layer"]
        self.assertEqual(left, sorted(left, reverse=True))
        last = seen[-1]["params"]
        self.assertEqual(last["last"], {"job": "part", "outcome": "done", "reason": ""})
        self.assertEqual((last["state"], last["job"]), ("idle", None))

    def test_what_a_method_or_the_queue_changes_is_notified_at_once(self):
        daemon = self.printing()
        for method, parameters, shown in (("pause", {}, lambda job: job["pause_pending"]), ("resume", {}, lambda job: not job["pause_pending"]),
                                          ("pause", {"at_layer": 3}, lambda job: job["planned_pause"])):  # fmt: skip
            self.assertIn("result", daemon.client().call(method, **parameters))
            change = daemon.watcher.wait_for(lambda m: m.get("method") == "change", "the change")
            self.assertTrue(shown(change["params"]["job"]), method)
        daemon.drop("next.stl", SMALL)
        daemon.watcher.wait_for(lambda m: m.get("method") == "change" and m["params"]["queued"] == 1, "the arrival")

    def test_a_client_that_does_not_watch_gets_no_notifications(self):
        daemon = self.fast()
        client = daemon.client()
        daemon.printed("part.stl", SLAB)
        client.send(b'{"jsonrpc":"2.0","method":"queue","id":1}\n')
        self.assertEqual(client.next()["id"], 1)

    def memory_kb(self):
        if SANITIZED:
            return 0
        with open(f"/proc/{self.daemon.process.pid}/status", encoding="ascii") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1])

    def test_a_client_that_never_reads_neither_stops_the_print_nor_fills_the_memory(self):
        daemon = self.fast()
        daemon.printed("warm.stl", SLAB)
        before = self.memory_kb()
        deaf = []
        for _ in range(5):
            client = socket.socket(socket.AF_UNIX)
            client.connect(daemon.socket_path)
            client.sendall(b'{"jsonrpc":"2.0","method":"watch","id":1}\n')
            deaf.append(client)
        # Each of the five clients is sent about 18,000 notifications of about 400 bytes.
        daemon.printed("tall.stl", TALL)
        self.assertIn("result", daemon.rpc("status"))
        # For each client the server holds at most 4 MiB; the rest is for the print.
        self.assertLess(self.memory_kb() - before, 5 * 4096 + 20000)
        for client in deaf:
            client.close()

    def test_a_client_that_reads_late_still_receives_the_end(self):
        daemon = self.fast()
        late = socket.socket(socket.AF_UNIX)
        late.connect(daemon.socket_path)
        late.sendall(b'{"jsonrpc":"2.0","method":"watch","id":1}\n')
        daemon.printed("tall.stl", TALL)
        late.settimeout(DEADLINE_S)
        received = b""
        while b'"method":"ended"' not in received:
            data = late.recv(1 << 20)
            self.assertTrue(data, "disconnected")
            received += data
        *lines, _ = received.split(b"\n")
        for line in lines:
            json.loads(line)  # a notification is either whole or left out
        late.close()

    def test_a_client_that_keeps_asking_and_never_reads_is_disconnected(self):
        daemon = self.fast()
        before = self.memory_kb()
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(daemon.socket_path)
            client.settimeout(DEADLINE_S)
            request = b'{"jsonrpc":"2.0","method":"status","id":1}\n' * 100
            with self.assertRaises(OSError):
                for _ in range(20000):
                    client.sendall(request)
        self.assertLess(self.memory_kb() - before, 20000)


class Commands(ControlTest):
    def error(self, method):
        answer = self.daemon.rpc(method)
        self.assertEqual(answer.get("error", {}).get("code"), REFUSED, answer)
        return answer["error"]["message"]

    def test_a_pause_begins_after_the_layer_and_resume_continues_the_print(self):
        daemon = self.realtime({"exposure_ms": 1})
        daemon.begin("part.stl", SLAB)
        self.assertIn("result", daemon.rpc("pause"))
        paused = daemon.wait_state("paused")
        done = paused["job"]["layers_done"]
        self.assertGreaterEqual(done, 1)
        status = daemon.status()
        self.assertEqual((status["state"], status["job"]["layers_done"]), ("paused", done))
        self.assertIn("result", daemon.rpc("resume"))
        report = daemon.wait_done("part")
        self.assertEqual(report["layers_exposed"], 20)
        self.assertEqual([layer["layer"] for layer in report["layer_records"]], list(range(1, 21)))
        # The plate returned to the height of its layer.
        for layer in report["layer_records"]:
            self.assertAlmostEqual(layer["plate_height_mm"], layer["layer"] * 0.05, delta=1e-6)

    def test_during_a_print_a_pause_can_be_taken_back_and_the_plate_cannot_be_cleared(self):
        daemon = self.printing()
        self.assertTrue(daemon.rpc("pause")["result"]["job"]["pause_pending"])
        self.assertTrue(daemon.rpc("pause")["result"]["job"]["pause_pending"])
        self.assertFalse(daemon.rpc("resume")["result"]["job"]["pause_pending"])
        self.assertIn("not paused", self.error("resume"))
        self.assertIn("part is being printed", self.error("plate_cleared"))
        status = daemon.status()
        self.assertEqual((status["state"], status["plate"]), ("exposing", "occupied"))

    def slow_to_move(self):
        return self.realtime({"exposure_ms": 1}, {"z_axis": {"travel_speed_mm_s": 4, "homing_speed_mm_s": 4},
                                                  "simulation": {"start_height_mm": 10}})  # fmt: skip

    def test_the_status_says_when_a_pending_pause_will_begin(self):
        daemon = self.slow_to_move()
        daemon.drop("part.stl", SLAB)
        daemon.wait_state("homing")
        job = daemon.rpc("pause")["result"]["job"]
        self.assertEqual((job["pause_pending"], job["pause"]), (True, "before the first layer"))
        self.assertIn(b"pause before the first layer", daemon.ctl("status").stdout)
        paused = daemon.wait_state("paused")
        self.assertEqual((paused["job"]["layers_done"], paused["job"]["pause"]), (0, None))
        daemon.rpc("resume")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.rpc("pause")["result"]["job"]["pause"], "after this layer")

    def test_a_planned_pause_begins_before_its_layer(self):
        daemon = self.realtime({"exposure_ms": 1})
        daemon.begin("part.stl", SLAB)
        daemon.rpc("pause")
        layer = daemon.wait_state("paused")["job"]["layer"]
        late = daemon.ctl("pause", "--at-layer", str(layer))
        self.assertEqual((late.returncode, late.stdout), (FAILED, b""))
        self.assertIn(f"a pause before layer {layer} comes too late: layer {layer} of 20 is under way".encode(), late.stderr)
        self.assertIn(b"there is no layer 21 to pause before: the print has 20 layers", daemon.ctl("pause", "--at-layer", "21").stderr)
        self.assertIn(b"the last one lies at 0.950 mm", daemon.ctl("pause", "--at-mm", "0.96").stderr)
        self.assertIn(f"pause before layer {layer + 3}".encode(), daemon.ctl("pause", "--at-layer", str(layer + 3)).stdout)
        self.assertEqual(daemon.status()["job"]["planned_pause"], f"before layer {layer + 3}")
        daemon.rpc("resume")
        self.assertEqual(daemon.wait_state("paused")["job"]["layers_done"], layer + 2)
        self.assertIn(b"pause at 0.910 mm", daemon.ctl("pause", "--at-mm", "0.91").stdout)
        daemon.rpc("resume")
        self.assertEqual(daemon.wait_state("paused")["job"]["layers_done"], 19)
        daemon.rpc("resume")
        self.assertEqual(daemon.wait_done("part")["layers_exposed"], 20)

    def test_set_changes_the_layers_to_come_and_is_reported(self):
        daemon = self.slow_to_move()
        refused = daemon.ctl("set", "rest", "700")
        self.assertEqual((refused.returncode, refused.stdout), (FAILED, b""))
        self.assertIn(b"nothing prints: ", refused.stderr)
        daemon.begin("part.stl", SLAB)
        daemon.rpc("pause")
        next_layer = daemon.wait_state("paused")["job"]["layer"] + 1
        before = daemon.status()["job"]["time_left_s"]
        self.assertEqual(daemon.ctl("set", "exposure", "300%").returncode, OK)
        self.assertEqual(daemon.ctl("set", "rest", "20").returncode, OK)
        self.assertIn(b"allow 0.01 to 50 mm/s", daemon.ctl("set", "lift-speed", "60").stderr)
        self.assertEqual(daemon.ctl("set", "lift", "far").returncode, BAD_USAGE)
        self.assertGreater(daemon.status()["job"]["time_left_s"], before)
        daemon.rpc("resume")
        report = daemon.wait_done("part")
        asked = [layer["exposure_asked_ms"] for layer in report["layer_records"]]
        self.assertEqual(asked[next_layer - 1:], [3] * (20 - next_layer + 1))
        self.assertEqual(asked[:next_layer - 1], [1] * (next_layer - 1))
        self.assertEqual([(each["from_layer"], each["setting"], each["value"]) for each in report["changes"]],
                         [(next_layer, "exposure", 300), (next_layer, "rest", 20)])
        text = f"from layer {next_layer} on exposure 300 % instead of 100 %"
        self.assertIn(text, daemon.read("done", "part.report.html"))
        self.assertIn(text, daemon.rpc("history")["result"]["ended"][-1]["settings"])

    def test_a_print_that_is_being_cancelled_cannot_be_paused(self):
        daemon = self.slow_to_move()
        daemon.begin("part.stl", SLAB)
        daemon.rpc("cancel")
        daemon.wait_state("parking")
        self.assertIn("being cancelled", self.error("pause"))
        self.assertIn("result", daemon.rpc("cancel"))  # a second cancel is no error
        result = daemon.ctl("pause")
        self.assertEqual((result.returncode, result.stdout), (FAILED, b""))
        self.assertEqual(daemon.wait_ended("part")["outcome"], "cancelled")

    def test_a_cancel_during_an_exposure_ends_the_print(self):
        daemon = self.printing()
        self.assertIn("result", daemon.rpc("cancel"))
        end = daemon.wait_ended("part")
        self.assertEqual(end["outcome"], "cancelled")
        self.assertIn("ancel", daemon.read("failed", "part.reason.txt"))
        self.assertEqual(daemon.report("part", "failed")["outcome"], "cancelled")
        for method in ("pause", "resume", "cancel"):
            self.assertIn("no print", self.error(method))

    def test_a_paused_print_can_be_cancelled(self):
        daemon = self.realtime({"exposure_ms": 1})
        daemon.begin("part.stl", SLAB)
        daemon.rpc("pause")
        daemon.wait_state("paused")
        self.assertIn("is being printed", self.error("plate_cleared"))
        daemon.rpc("pause")
        self.assertEqual(daemon.status()["state"], "paused")
        self.assertEqual(daemon.cancel("part")["outcome"], "cancelled")
        self.assertEqual(daemon.printed("next.stl", SLAB)["layers_exposed"], 20)

    def test_commands_in_any_order_do_no_harm(self):
        daemon = self.realtime({"exposure_ms": 1})
        client = daemon.client()
        commands = ("pause", "resume", "cancel", "plate_cleared", "status", "queue")
        for number in range(6):
            daemon.drop(f"part{number}.stl", SLAB)
        ended = 0
        for step in range(3000):
            method = commands[(step * step + step // 7) % len(commands)]
            if method == "cancel" and step % 5:
                continue
            answer = client.call(method)
            if "error" in answer:
                self.assertEqual(answer["error"]["code"], REFUSED, answer)
            elif method == "status" and answer["result"]["state"] == "idle" and answer["result"]["queued"] == 0:
                ended += 1
                if ended > 3:
                    break
        client.close()
        if daemon.status()["job"] is not None and daemon.status()["state"] == "paused":
            daemon.rpc("resume")
        outcomes = [daemon.wait_ended(f"part{number}")["outcome"] for number in range(6)]
        self.assertLessEqual(set(outcomes), {"done", "cancelled"})

    def test_a_job_can_be_cancelled_while_the_lamp_warms_up(self):
        self.daemon = Daemon(self, {**REALTIME, "projector": {"warm_up_s": 60}}, {**NIMBLE_RESIN, **ENDLESS}).start()
        self.daemon.drop("part.stl", SLAB)
        self.daemon.wait_state("warming up")
        self.assertEqual(self.daemon.cancel("part")["outcome"], "cancelled")
        self.assertEqual(self.daemon.status()["plate"], "clear")


class Contourctl(ControlTest):
    def ctl(self, *arguments):
        result = self.daemon.ctl(*arguments, expect=OK)
        self.assertEqual(result.stderr, b"")
        return result.stdout.decode()

    def refused(self, command, word):
        for arguments in ([command], [command, "--json"]):
            result = self.daemon.ctl(*arguments, expect=FAILED)
            if "--json" in arguments:
                self.assertEqual(json.loads(result.stdout)["error"]["code"], REFUSED)
            else:
                self.assertEqual(result.stdout, b"")
                self.assert_one_line(result.stderr, word)

    def test_status_and_queue_while_idle(self):
        self.fast()
        text = self.ctl("status")
        self.assert_words(text, "Simulated printer", "idle", "clear")
        self.assertEqual(json.loads(self.ctl("status", "--json"))["result"]["state"], "idle")
        self.assertIn("empty", self.ctl("queue"))
        self.assertEqual(json.loads(self.ctl("queue", "--json"))["result"], {"queue": [], "more": 0, "jobs": [], "arriving": []})
        for command in ("pause", "resume", "cancel"):
            self.refused(command, "no print")
        self.ctl("plate-cleared")

    def test_status_and_queue_during_a_print(self):
        daemon = self.printing()
        daemon.drop("second.stl", SLAB)
        daemon.drop("third.stl", SLAB)
        daemon.wait_status("queued", 2)
        text = self.ctl("status")
        self.assert_words(text, "part", "exposing", "1 of 20", "occupied")
        lines = self.ctl("queue").splitlines()
        self.assertEqual([line for line in lines if line[:5].strip()], ["  1  second.stl", "  2  third.stl"])
        self.refused("plate-cleared", "is being printed")
        self.assertIn("pause after this layer", self.ctl("pause"))
        self.assertFalse(json.loads(self.ctl("resume", "--json"))["result"]["job"]["pause_pending"])
        self.refused("resume", "not paused")
        self.ctl("cancel")
        self.assertEqual(daemon.wait_ended("part")["outcome"], "cancelled")

    def test_history_has_the_jobs_that_ended(self):
        daemon = self.fast()
        self.assertIn("no job has ended", self.ctl("history"))
        daemon.printed("first.stl", SLAB)
        daemon.drop("sec\x1bond.stl", b"no model")
        daemon.wait_ended("sec\x1bond")
        lines = self.ctl("history").splitlines()
        self.assertRegex(lines[0], r"^20\d\d-\d\d-\d\d \d\d:\d\d  first: done \(20 of 20 layers, .* ml of standard\)$")
        self.assertRegex(lines[1], r"  sec.*ond: failed: not a usable model")
        self.assertNotIn("\x1b", lines[1])
        self.assertEqual(self.ctl("history", "--last", "1").splitlines(), lines[1:])
        ended = json.loads(self.ctl("history", "--last=1", "--json"))["result"]["ended"]
        self.assertEqual([job["outcome"] for job in ended], ["failed"])
        for wrong in (0, 101, "1", None, 1.5):
            self.assertEqual(daemon.rpc("history", last=wrong)["error"]["code"], INVALID_PARAMS, wrong)
        for wrong in ("0", "10001", "x", ""):
            result = daemon.ctl("history", "--last", wrong, expect=BAD_USAGE)
            self.assertIn(b"--last", result.stderr)

    def test_names_with_control_characters_do_not_reach_the_terminal(self):
        daemon = self.printing()
        daemon.drop("two\nlines \x1b[31mred.stl", SLAB)
        daemon.wait_status("queued", 1)
        self.assertEqual(self.ctl("queue").splitlines()[0], "  1  two?lines ?[31mred.stl")
        self.assertNotIn("\x1b", self.ctl("queue"))
        daemon.cancel("part")
        daemon.wait_state("exposing")
        self.assertNotIn("\x1b", self.ctl("status"))

    def test_plate_cleared_lets_the_next_job_start(self):
        daemon = self.fast(wait_for_plate_cleared=True)
        daemon.printed("one.stl", SLAB)
        daemon.drop("two.stl", SLAB)
        daemon.wait_status("waiting_for")
        text = self.ctl("status")
        self.assertIn("occupied by one", text)
        self.assertIn("plate-cleared", text)
        self.ctl("plate-cleared")
        daemon.wait_done("two")

    def watch(self, *arguments):
        process = subprocess.Popen([CONTOURCTL, "watch", "--socket", self.daemon.socket_path, *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.killed_at_the_end(process)
        wait_until(lambda: self.watches(process), "contourctl watch to connect")
        return process

    def test_watch_follows_a_print_to_its_end(self):
        daemon = self.fast()
        watcher = self.watch("--job", "part")
        daemon.drop("part.stl", SLAB)
        out, err = watcher.communicate(timeout=DEADLINE_S)
        self.assertEqual((watcher.returncode, err), (OK, b""))
        self.assertIn(b"%", out)
        self.assertIn(b"part: done", out.splitlines()[-1])
        self.assertNotIn(b"\x1b", out)  # no terminal

    def test_watch_without_a_terminal_prints_a_line_for_each_warning_and_change(self):
        daemon = self.realtime({})
        watcher = self.watch("--job", "part")
        daemon.drop("part.stl", binary_stl(box((0, 0, 0), (10, 5, 1)) + box((20, 0, 0.5), (25, 5, 1))))
        out, err = watcher.communicate(timeout=DEADLINE_S)
        self.assertEqual((watcher.returncode, err), (OK, b""))
        lines = out.decode().splitlines()
        self.assertEqual(len([line for line in lines if line.startswith("part: warning: 1 island")]), 1)
        self.assertEqual(lines[-1], "part: done")
        self.assertNotEqual(lines[-2], "part: waits")  # a job that has ended does not wait
        progress = [line for line in lines if "layer" in line and "warning" not in line]
        self.assertEqual(len(progress), len(set(progress)))
        self.assertLess(len(progress), 20)

    def test_watch_of_a_failed_print_fails(self):
        daemon = self.fast()
        watcher = self.watch("--job", "bad")
        daemon.drop("bad.stl", b"no model")
        out, _ = watcher.communicate(timeout=DEADLINE_S)
        self.assertEqual(watcher.returncode, FAILED)
        self.assertIn(b"bad: failed", out)

    def test_watch_of_an_unknown_job_fails(self):
        daemon = self.printing()
        daemon.drop("next.stl", SLAB)
        names, options = ("nothere", "par", "\x1b[31m\u202e"), ([], ["--json"])
        for watcher in [self.watch("--job", name, *arguments) for name in names for arguments in options]:
            out, err = watcher.communicate(timeout=DEADLINE_S)
            self.assertEqual(watcher.returncode, FAILED)
            self.assertNotIn(b"%", out)  # no progress bar of another job
            self.assertNotIn(b"waits", out)
            self.assert_one_line(err, "there is no job")
            self.assertNotIn(b"\x1b", err)

    def test_watch_of_a_waiting_job_shows_no_other_job_and_ends_when_its_file_is_deleted(self):
        daemon = self.printing()
        daemon.drop("next.stl", SLAB)
        os.mkdir(daemon.file("incoming", "plate"))
        self.write(daemon.file("incoming", "plate", "plate.json"), json.dumps({"models": [{"file": "later.stl"}]}))
        slow = open(daemon.file("incoming", "slow.stl"), "wb")
        watchers = {name: self.watch("--job", name) for name in ("next", "plate", "slow.stl")}
        for name, watcher in watchers.items():
            name = name.removesuffix(".stl")
            self.assertIn(f"{name}: waits while part is printed".encode(), watcher.stdout.readline())
        slow.close()
        for file in ("next.stl", "slow.stl", "plate/plate.json"):
            os.unlink(daemon.file("incoming", file))
        os.rmdir(daemon.file("incoming", "plate"))
        for watcher in watchers.values():
            out, err = watcher.communicate(timeout=DEADLINE_S)
            self.assertEqual(watcher.returncode, FAILED)
            self.assertNotIn(b"%", out)
            self.assert_one_line(err, "there is no job")

    def test_watch_with_json_prints_one_message_a_line(self):
        daemon = self.fast()
        watcher = self.watch("--json")
        json.loads(watcher.stdout.readline())  # printed once it watches
        daemon.drop("part.stl", SLAB)
        out, _ = watcher.communicate(timeout=DEADLINE_S)
        self.assertEqual(watcher.returncode, OK)
        messages = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(messages[-1]["method"], "ended")

    def test_watch_does_not_end_with_another_job_that_is_refused(self):
        daemon = self.printing()
        watcher = self.watch()
        self.assertIn(b"part", watcher.stdout.readline())
        daemon.refused("bad.stl", b"no model")
        # Once this is answered, all earlier notifications have been sent to the watcher.
        self.assertIn("result", daemon.rpc("status"))
        daemon.cancel("part")
        out, _ = watcher.communicate(timeout=DEADLINE_S)
        self.assertIn(b"part: cancelled", out)

    def test_watch_of_a_job_that_has_ended_prints_its_outcome(self):
        daemon = self.fast()
        for name in ("one", "two"):
            daemon.printed(name + ".stl", SLAB)
        for name in ("two", "one"):
            out, _ = self.watch("--job", name).communicate(timeout=10)
            self.assertIn(f"{name}: done".encode(), out)

    def test_watch_ends_when_the_daemon_stops(self):
        daemon = self.fast()
        watcher = self.watch()
        daemon.stop()
        _, err = watcher.communicate(timeout=DEADLINE_S)
        self.assertEqual(watcher.returncode, UNAVAILABLE)
        self.assert_one_line(err, "closed the connection")

    def watches(self, process):
        # contourctl sleeps in recv once it has sent its request; a daemon stopped earlier would only refuse the connection.
        with open(f"/proc/{process.pid}/wchan", encoding="ascii") as file:
            where = file.read()
            return "unix_stream" in where or "poll" in where or process.poll() is not None

    def test_without_a_daemon_the_error_names_the_socket(self):
        for socket_path in (self.path("none.sock"), self.write("file", b""), self.folder, self.path("x" * 200)):
            for command in ("status", "queue", "queue show part", "queue remove part", "queue move part --first", "watch", "pause",
                            "resume", "cancel", "plate-cleared"):
                result = contourctl(*command.split(), "--socket", socket_path)
                self.assert_refusal(result, UNAVAILABLE, socket_path)

    def test_the_socket_can_come_from_the_environment(self):
        daemon = self.fast()
        contourctl("status", env={**os.environ, "CONTOURD_SOCKET": daemon.socket_path}, expect=OK)
        self.assertEqual(contourctl("status", "extra").returncode, BAD_USAGE)


class Socket(ControlTest):
    def test_only_owner_and_group_can_use_the_socket(self):
        daemon = self.fast()
        self.assertEqual(os.stat(daemon.socket_path).st_mode & 0o777, 0o660)
        daemon.stop()
        self.assertFalse(os.path.exists(daemon.socket_path))

    def test_the_socket_of_a_killed_daemon_is_replaced(self):
        daemon = self.fast()
        daemon.kill()
        self.assertTrue(os.path.exists(daemon.socket_path))
        daemon.start()
        self.assertEqual(daemon.status()["state"], "idle")

    def test_a_file_in_the_sockets_place_is_not_overwritten(self):
        daemon = Daemon(self)
        self.write("control.sock", b"precious")
        result = run(CONTOURD, "--config", daemon.config_path)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(b"control.sock", result.stderr)
        self.assertEqual(contents(self.path("control.sock")), b"precious")

    def test_a_missing_folder_of_the_socket_is_an_error(self):
        daemon = Daemon(self, {"control_socket": "missing/control.sock"})
        result = run(CONTOURD, "--config", daemon.config_path)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(b"/control_socket: there is no folder " + os.fsencode(self.path("missing")), result.stderr)

    def test_contourctl_waits_for_a_daemon_that_hangs(self):
        # A stopped process neither answers nor closes the connection: contourctl must wait instead of reporting an error.
        daemon = self.fast()
        daemon.process.send_signal(signal.SIGSTOP)
        process = subprocess.Popen([CONTOURCTL, "status", "--socket", daemon.socket_path], stdout=subprocess.PIPE)
        threading.Timer(0.2, daemon.process.send_signal, [signal.SIGCONT]).start()
        out, _ = process.communicate(timeout=DEADLINE_S)
        self.assertEqual(process.returncode, OK)
        self.assertIn(b"idle", out)


class Robustness(ControlTest):
    def test_a_spool_that_vanishes_does_not_end_the_daemon(self):
        # As if its disk were unmounted: the light must go off, and the user must be able to find out why nothing prints.
        daemon = self.printing()
        os.rename(daemon.spool, self.path("gone"))
        daemon.cancel("part")
        self.assertTrue(daemon.alive(), daemon.log())
        self.assertIn("result", daemon.rpc("plate_cleared") | daemon.rpc("status"))
        self.assertTrue(daemon.alive(), daemon.log())

    def test_an_idle_daemon_uses_almost_no_processor_time(self):
        daemon = self.fast()
        daemon.printed("part.stl", SLAB)

        def ticks():
            with open(f"/proc/{daemon.process.pid}/stat", encoding="ascii") as file:
                return sum(map(int, file.read().rsplit(")", 1)[1].split()[11:13]))

        before, start = ticks(), time.monotonic()
        wait_until(lambda: time.monotonic() > start + 1, "a second to pass")
        self.assertLess(ticks() - before, 5)  # of 100
