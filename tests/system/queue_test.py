"""contourctl queue: shows, removes and reorders waiting jobs."""

import json
import os

from harness import BAD_USAGE, FAILED, NIMBLE_RESIN, OK, REALTIME, SMALL, Daemon, FolderTest, text_of, wait_until


class Queue(FolderTest):
    def setUp(self):
        super().setUp()
        self.daemon = self.printing()

    def wait(self, *names, ticket=None):
        for name in names:
            self.daemon.drop(name + ".stl", SMALL, ticket)
            wait_until(lambda name=name: name + ".stl" in self.order(), name)

    def order(self):
        return self.daemon.rpc("queue")["result"]["queue"]

    def queue(self, *words, code=OK):
        result = self.daemon.ctl("queue", *words)
        self.assertEqual(result.returncode, code, result)
        return (result.stdout if code == OK else result.stderr).decode()

    def test_a_checked_job_shows_its_time_parts_and_layers(self):
        self.wait("one", ticket={"copies": 2, "layer_height_um": 25})
        wait_until(lambda: self.daemon.rpc("queue")["result"]["jobs"][0]["state"] == "ready", "the job to be checked")
        lines = self.queue().splitlines()
        self.assertEqual(lines[0], "  1  one.stl")
        self.assertRegex(lines[1], r"^     ready, \d+ min \d\d s, 2 parts, layers 8 of 25 um, standard, 0\.7 kB$")
        shown = dict(line.split(None, 1) for line in self.queue("show", "one").splitlines())
        self.assertEqual((shown["job"], shown["number"], shown["parts"], shown["layers"]), ("one", "1 of 1", "2", "8 of 25 um, 0.20 mm high"))
        self.assertEqual(json.loads(self.queue("show", "one", "--json"))["result"]["jobs"][0]["layers"], 8)

    def test_an_order_survives_a_restart_and_is_the_order_of_the_prints(self):
        self.wait("a", "b", "c", "d")
        self.assertEqual(self.queue("move", "d", "--first").splitlines()[0], "  1  d.stl")
        self.queue("move", "a", "--last")
        self.queue("move", "c.stl", "--to", "2")
        expected = ["d.stl", "c.stl", "b.stl", "a.stl"]
        self.assertEqual(self.order(), expected)
        record = self.path("spool.state", "queue-order")
        wait_until(lambda: self.read(record) == "".join(name + "\0" for name in expected), "the stored order")
        self.daemon.kill()
        self.daemon = Daemon(self, {**REALTIME, "wait_for_plate_cleared": True}, NIMBLE_RESIN).start()
        wait_until(lambda: len(self.order()) == 4, "the four jobs")
        self.assertEqual(self.order(), expected)
        self.wait("late")
        self.assertEqual(self.order(), [*expected, "late.stl"])
        self.daemon.rpc("plate_cleared")
        self.daemon.wait_done("d")
        wait_until(lambda: not self.read(record).startswith("d.stl"), "the stored order without the printed job")
        self.assertEqual(self.order(), [*expected[1:], "late.stl"])

    def read(self, path):
        return text_of(path)

    def test_a_removed_job_is_in_failed_with_its_ticket_and_who_removed_it(self):
        self.wait("one", "two", ticket={"copies": 2})
        self.assertIn("one: removed", self.queue("remove", "one"))
        ended = self.daemon.wait_ended("one")
        self.assertEqual(ended["outcome"], "cancelled")
        self.assertRegex(ended["reason"], r"^removed from the queue by user \S+ \(\d+\)$")
        self.assertEqual(sorted(os.listdir(self.daemon.file("failed", ""))), ["one.json", "one.reason.txt", "one.stl"])
        self.assertEqual(self.read(self.daemon.file("failed", "one.reason.txt")).strip(), ended["reason"])
        self.assertEqual(self.order(), ["two.stl"])
        self.assertIn("no job", self.queue("remove", "one", code=FAILED))
        # The print under way goes on.
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def test_wrong_commands_change_nothing(self):
        self.wait("a", "b")
        for words in (["move", "a"], ["move", "a", "--to", "0"], ["move", "a", "--to", "x"], ["move", "a", "--first", "--last"],
                      ["remove"], ["remove", ""], ["show"], ["drop", "a"]):  # fmt: skip
            self.queue(*words, code=BAD_USAGE)
        for words in (["move", "none", "--first"], ["remove", "none"], ["show", "none"]):
            self.assertEqual(self.queue(*words, code=FAILED), 'contourctl: no job "none" waits\n')
        self.assertIn("cancel ends it", self.queue("remove", "part", code=FAILED))
        self.assertEqual(self.order(), ["a.stl", "b.stl"])

    def test_hundreds_of_moves_at_once_end_in_the_last_order_without_disturbing_the_print(self):
        self.wait("a", "b", "c")
        client = self.daemon.client()
        for number in range(400):
            job = "abc"[number % 3]
            client.send(json.dumps({"jsonrpc": "2.0", "method": "queue_move", "params": {"job": job, "to": 1}, "id": number}).encode() + b"\n")
        last = client.wait_for(lambda m: m.get("id") == 399, "the last answer")["result"]["queue"]
        self.assertEqual(last, ["a.stl", "c.stl", "b.stl"])
        wait_until(lambda: self.read(self.path("spool.state", "queue-order")).split("\0")[:-1] == last, "the stored order")
        self.assertEqual(self.daemon.status()["state"], "exposing")
