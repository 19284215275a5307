"""The history in its database: its contents, and what happens when its file is damaged or the daemon is killed."""

import csv
import io
import json
import os
import random
import sqlite3
import time
import unittest

from harness import (
    BAD_USAGE, FAILED, NIMBLE_RESIN, OK, REALTIME, SANITIZED, SMALL, UNAVAILABLE, Daemon, FolderTest, contents, contourctl, on_terminal, wait_until,
)  # fmt: skip

HOSTILE = '=1+1,"x"\x1b[31m'


class HistoryTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.daemon = Daemon(self)

    @property
    def file(self):
        return os.path.join(self.daemon.state_folder, "history.sqlite")

    def print_one(self, name):
        self.daemon.printed(name + ".stl", SMALL)

    def ended(self, **parameters):
        result = self.daemon.rpc("history", **parameters)["result"]
        self.assertIsNone(result["trouble"])
        return [(job["job"], job["outcome"]) for job in result["ended"]]

    def ctl(self, *arguments, code=OK):
        result = self.daemon.ctl("history", *arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stdout.decode()

    def assert_sound(self):
        with sqlite3.connect(self.file) as database:
            self.assertEqual(database.execute("PRAGMA integrity_check").fetchall(), [("ok",)])


class Lines(HistoryTest):
    def test_on_a_narrow_terminal_lines_are_broken_between_words(self):
        self.daemon.start()
        self.print_one("a-part-with-a-name")
        self.daemon.rpc("pause")
        for command in ("history", "usage", "status", "queue"):
            whole = self.daemon.ctl(command).stdout.decode()
            for columns in (30, 40, 80):
                lines = on_terminal(columns, command, "--socket", self.daemon.socket_path)
                self.assertLessEqual(max(len(line) for line in lines), columns, lines)
                self.assertEqual(" ".join(lines).split(), whole.split())
        self.assertIn("1 job, 4 layers", self.daemon.ctl("usage").stdout.decode())


class Kept(HistoryTest):
    def test_the_history_outlives_the_daemon_and_can_be_filtered(self):
        self.daemon.start()
        self.print_one("first")
        self.daemon.drop("bad.stl", b"no model")
        self.daemon.wait_ended("bad")
        self.daemon.restart()
        self.print_one("second")
        self.assertEqual(self.ended(), [("first", "done"), ("bad", "failed"), ("second", "done")])
        self.assertEqual(self.ended(this_run=True), [("second", "done")])
        self.assertEqual(self.ended(outcome="failed"), [("bad", "failed")])
        for arguments, names in ((("--resin", "standard"), ["first", "second"]), (("--job", "ir"), ["first"]),
                                 (("--since", "1h"), ["first", "bad", "second"]), (("--since", "2199-12-31"), []),
                                 (("--outcome", "done", "--last", "1"), ["second"])):  # fmt: skip
            jobs = json.loads(self.ctl("--json", *arguments))["result"]["ended"]
            self.assertEqual([job["job"] for job in jobs], names, arguments)
        job = self.daemon.rpc("history", last=1)["result"]["ended"][0]
        report = self.daemon.report("second")
        self.assertEqual((job["layers"], job["layers_exposed"], job["resin"]), (4, 4, "standard"))
        self.assertAlmostEqual(job["lit_s"], sum(layer["exposure_most_ms"] for layer in report["layer_records"]) / 1000, 6)
        self.assertAlmostEqual(job["resin_ml"], report["exposed_volume_mm3"] / 1000, 9)
        self.assertIn("exposure 3000 ms", job["settings"])
        usage = self.daemon.rpc("usage")["result"]
        self.assertEqual((usage["layers"], usage["resins"][0]["jobs"]), (8, 2))
        self.assertAlmostEqual(usage["lamp_h"], 2 * job["lit_s"] / 3600, 9)
        self.assertIn(b"ml of standard: 2 jobs, 8 layers", self.daemon.ctl("usage").stdout)
        self.daemon.stop()
        self.assert_sound()

    def test_csv_can_be_parsed_and_a_name_cannot_become_a_formula(self):
        self.daemon.start()
        self.print_one("part")
        self.daemon.drop(HOSTILE + ".stl", b"no model")
        self.daemon.wait_ended(HOSTILE)
        text = self.ctl("--csv")
        self.assertNotIn("\x1b", text)
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual([row["job"] for row in rows], ["part", '\'=1+1,"x"?[31m'])
        self.assertEqual((rows[0]["layers"], rows[0]["resin"], rows[1]["layers"]), ("4", "standard", "0"))
        self.assertEqual(self.ctl("--csv", "--last", "1").splitlines()[0], text.splitlines()[0])
        self.assertNotIn("\x1b", self.ctl())

    def test_wrong_options_are_bad_usage(self):
        self.daemon.start()
        for wrong in (("--since", "yesterday"), ("--since", "2026-02-30x"), ("--since", "2026-02-30"), ("--since", "2999-01-01"),
                      ("--since", ""), ("--outcome", "good"), ("--last", "0"), ("--json", "--csv"), ("--job", "")):  # fmt: skip
            self.assertEqual(self.ctl(*wrong, code=BAD_USAGE), "", wrong)
        self.daemon.stop()
        for command in ("history", "usage"):
            result = contourctl(command, "--socket", self.daemon.socket_path)
            self.assert_refusal(result, UNAVAILABLE)

    def test_all_jobs_are_listed_in_order_even_if_one_answer_cannot_hold_them(self):
        self.daemon.start()
        self.daemon.stop()
        with sqlite3.connect(self.file) as database:
            database.executemany("INSERT INTO job(key,name,outcome,began_ms) VALUES(?,?,'done',0)",
                                 [(i, f"job {i}") for i in range(250)])  # fmt: skip
        database.close()
        self.daemon.start()
        jobs = json.loads(self.ctl("--json", "--last", "240"))["result"]["ended"]
        self.assertEqual([job["job"] for job in jobs], [f"job {i}" for i in range(10, 250)])
        self.assertEqual(len(self.ctl().splitlines()), 20)

    def test_watch_does_not_find_a_job_that_ended_in_an_earlier_run(self):
        self.daemon.start()
        self.print_one("part")
        self.daemon.restart()
        result = self.daemon.ctl("watch", "--job", "part", expect=FAILED)
        self.assertIn(b"there is no job part", result.stderr)


class Reminders(HistoryTest):
    """Parts that wear: their use since they were new, and reminders to replace them."""

    def remind(self, **limits):
        self.daemon.config["reminders"] = limits
        self.daemon.write_config()

    def parts(self):
        usage = self.daemon.rpc("usage")["result"]
        self.assertIsNone(usage["trouble"])
        return {part["part"]: part for part in usage["parts"]}

    def reminders_after(self, number):
        """Waits until the log has this number of reminders, and returns their lines."""
        def reminders():
            found = [line for line in self.daemon.log().splitlines() if "is due" in line]
            return found if len(found) >= number else None
        return wait_until(reminders, f"{number} reminders")

    def test_a_reminder_is_logged_after_each_print_and_at_the_start_until_the_part_is_replaced(self):
        self.remind(film={"prints": 2, "layers": 1000}, vat={"lamp_h": 1000})
        self.daemon.start()
        self.print_one("first")
        self.assertEqual(self.daemon.status()["reminders"], [])
        self.print_one("second")
        self.daemon.watcher.wait_for(lambda m: m.get("method") == "reminders", "the reminder")
        (sentence,) = self.daemon.status()["reminders"]
        self.assertEqual(sentence, "the film is due: 2 prints (limit 2) since the history began; when it is replaced: contourctl replaced film")
        for command in ("status", "usage"):
            self.assertIn(f"reminder  {sentence}\n", self.daemon.ctl(command).stdout.decode())
        self.assertEqual(len(self.reminders_after(1)), 1)
        self.daemon.restart()
        self.reminders_after(2)
        self.print_one("third")
        self.assertIn("3 prints (limit 2)", self.reminders_after(3)[2])
        replaced = self.daemon.ctl("replaced", "film")
        self.assertEqual((replaced.returncode, replaced.stderr), (OK, b""))
        self.assertNotIn(b"reminder", replaced.stdout)
        self.assertEqual(self.daemon.status()["reminders"], [])
        film, vat = self.parts()["film"], self.parts()["vat"]
        self.assertEqual((film["prints"], film["layers"], film["lamp_h"]), (0, 0, 0))
        self.assertEqual((vat["prints"], vat["layers"], vat["replaced"]), (3, 12, None))
        self.daemon.restart()
        self.print_one("fourth")
        self.assertEqual((self.parts()["film"]["prints"], self.parts()["film"]["layers"]), (1, 4))
        self.assertIsNotNone(self.parts()["film"]["replaced"])
        self.daemon.stop()
        self.assertEqual(len(self.reminders_after(3)), 3)
        self.assertIn("the film is new: its use counts from now on", self.daemon.log())

    def test_without_a_limit_use_is_counted_but_there_is_no_reminder(self):
        self.daemon.start()
        self.print_one("part")
        self.assertEqual(self.daemon.status()["reminders"], [])
        self.assertEqual([part["prints"] for part in self.parts().values()], [1, 1, 1])
        self.daemon.stop()
        self.assertNotIn("is due", self.daemon.log())

    def test_a_damaged_history_starts_again_empty_and_without_storage_no_part_can_be_replaced(self):
        self.remind(film={"prints": 1})
        self.daemon.start()
        self.print_one("part")
        self.reminders_after(1)
        self.daemon.stop()
        with open(self.file, "r+b") as file:
            file.write(b"noise" * 100)
        self.daemon.start()
        self.assertEqual(self.parts()["film"]["prints"], 0)
        self.assertIn("lamp, film and vat is counted from zero", self.daemon.log())
        self.daemon.stop()
        for ending in ("", "-wal", "-shm"):
            if os.path.exists(self.file + ending):
                os.remove(self.file + ending)
        os.mkdir(self.file)
        self.daemon.start()
        refused = self.daemon.ctl("replaced", "film")
        self.assert_refusal(refused, FAILED, "is a folder", "nothing is recorded")
        self.assertEqual(self.daemon.status()["reminders"], [])
        self.print_one("another")

    def test_replacing_an_unknown_part_is_refused(self):
        self.daemon.start()
        for wrong in (["lens"], [""], []):
            self.assertEqual(self.daemon.ctl("replaced", *wrong).returncode, BAD_USAGE)
        self.assertEqual(self.daemon.rpc("replaced", part="lens")["error"]["code"], -32602)


class Killed(HistoryTest):
    def test_a_killed_print_counts_the_light_it_had(self):
        self.daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, "bottom_exposure_ms": 5, "rest_ms": 60000})
        self.daemon.start()
        self.daemon.drop("part.stl", SMALL)
        self.daemon.watcher.wait_for(lambda m: m.get("method") == "layer", "the first layer")
        # This question is answered after the layer has been stored.
        self.assertGreater(self.daemon.rpc("usage")["result"]["lamp_h"], 0)
        self.daemon.kill()
        self.daemon.start()
        job = self.daemon.rpc("history")["result"]["ended"][0]
        self.assertEqual((job["job"], job["outcome"], job["layers_exposed"]), ("part", "failed", 1))
        self.assertIn("killed", job["reason"])
        self.assertGreaterEqual(job["lit_s"], 0.005)
        self.assertEqual(job["resin"], "standard")

    def test_a_daemon_that_is_killed_between_jobs_loses_no_job_and_stores_none_twice(self):
        chance = random.Random(int(os.environ.get("SEED", "1")))
        dropped = []
        jobs = iter(range(1000))
        for _ in range(8):
            self.daemon.start()
            for _ in range(6):
                name = f"job{next(jobs)}"
                dropped.append(name)
                self.daemon.drop(name + ".stl", SMALL)
            time.sleep(chance.uniform(0, 0.25))  # any moment will do
            self.daemon.kill()
            with sqlite3.connect(self.file) as database:
                self.assertEqual(database.execute("PRAGMA integrity_check").fetchall(), [("ok",)])
            database.close()
        self.daemon.start()

        def all_ended():
            status = self.daemon.status()
            if status["held"]:
                self.daemon.rpc("plate_cleared")
            left = self.daemon.names_in("printing") + [name for name in self.daemon.names_in("incoming") if name.endswith(".stl")]
            return status["job"] is None and status["queued"] == 0 and not left

        wait_until(all_ended, "the end of all jobs")
        names = [job for job, _ in self.ended()]
        self.assertEqual(sorted(names), sorted(dropped))
        self.daemon.stop()
        self.assert_sound()
        self.assertNotIn("damaged", self.daemon.log())


class InTrouble(HistoryTest):
    def assert_prints_with_one_warning(self, *words):
        """Asserts that two jobs are printed, that the history lists them from memory, and that the log has one warning."""
        for name in ("one", "two"):
            self.print_one(name)
        result = self.daemon.rpc("history")["result"]
        self.assertEqual([job["job"] for job in result["ended"]], ["one", "two"])
        for word in words:
            self.assertIn(word, result["trouble"])
        warnings = [line for line in self.daemon.log().splitlines() if "the history in" in line]
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("printing continues", warnings[0])
        listed = self.daemon.ctl("history")
        self.assertEqual(len(listed.stdout.splitlines()), 2)
        self.assert_one_line(listed.stderr, "since contourd started")

    def make_state_folder(self):
        os.mkdir(self.daemon.state_folder, 0o700)

    def test_a_damaged_history_is_put_aside_and_the_printer_prints(self):
        self.make_state_folder()
        self.write(self.file, random.Random(1).randbytes(20000))
        self.daemon.start()
        self.print_one("part")
        self.assertEqual(self.ended(), [("part", "done")])
        self.assertEqual(self.daemon.log().count("the history was damaged"), 1)
        self.assertEqual(os.path.getsize(self.file + ".damaged-1"), 20000)

    def test_a_history_that_is_a_folder_gives_one_warning_and_the_printer_prints(self):
        self.make_state_folder()
        os.mkdir(self.file)
        self.daemon.start()
        self.assert_prints_with_one_warning("is a folder")
        self.assertEqual(os.listdir(self.file), [])

    def test_a_history_that_is_a_link_is_not_followed(self):
        self.make_state_folder()
        os.symlink(self.path("elsewhere"), self.file)
        self.daemon.start()
        self.assert_prints_with_one_warning("is a link")
        self.assertFalse(os.path.exists(self.path("elsewhere")))

    def test_a_history_of_a_later_version_is_left_as_it_is(self):
        self.daemon.start()
        self.daemon.stop()
        with sqlite3.connect(self.file) as database:
            database.execute("PRAGMA user_version=7")
        database.close()
        before = contents(self.file)
        self.daemon.start()
        self.assert_prints_with_one_warning("its version is 7")
        self.assertEqual(contents(self.file), before)

    def test_a_history_that_is_locked_is_completed_when_the_lock_is_gone(self):
        self.daemon.start()
        shell = sqlite3.connect(self.file, isolation_level=None)
        shell.execute("BEGIN IMMEDIATE")
        for name in ("one", "two"):
            self.print_one(name)
        wait_until(lambda: "has locked it" in self.daemon.log(), "the warning in the log")
        shell.execute("ROLLBACK")
        shell.close()
        self.assertEqual(self.ended(), [("one", "done"), ("two", "done")])

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_a_full_disk_delays_only_the_history(self):
        slow = self.daemon.put_on_slow_disk()
        self.daemon.start()
        self.print_one("before")
        gate = os.path.join(slow, "history-full")
        with open(gate, "w", encoding="utf-8"):
            pass
        for name in ("one", "two"):
            self.print_one(name)
        wait_until(lambda: "the history in" in self.daemon.log(), "the warning in the log")
        os.unlink(gate)
        self.assertEqual(self.ended(), [("before", "done"), ("one", "done"), ("two", "done")])
        self.assertEqual(self.daemon.log().count("printing continues"), 1)

    def assert_one_print(self, name, outcome, layers):
        """Asserts that the history has this print alone, with the figures of its layers and their light."""
        jobs = self.daemon.rpc("history")["result"]["ended"]
        self.assertEqual([(job["job"], job["outcome"], job["layers_exposed"], job["layers"]) for job in jobs], [(name, outcome, layers, 4)])
        self.assertGreater(jobs[0]["lit_s"], 0)
        self.assertGreater(jobs[0]["resin_ml"], 0)
        self.assertEqual(jobs[0]["resin"], "standard")

    def lock(self):
        shell = sqlite3.connect(self.file, isolation_level=None)
        shell.execute("BEGIN IMMEDIATE")
        return shell

    def test_the_figures_of_a_print_survive_a_lock_over_the_print_and_the_stop(self):
        self.daemon.start()
        shell = self.lock()
        self.print_one("one")
        self.daemon.stop()
        shell.close()
        self.daemon.start()
        self.assert_one_print("one", "done", 4)

    def test_the_light_of_a_print_survives_a_lock_over_the_print_and_a_kill(self):
        self.daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, "exposure_ms": 2000, "bottom_exposure_ms": 2000})
        self.daemon.start()
        shell = self.lock()
        self.daemon.begin("one.stl", SMALL)
        wait_until(lambda: os.path.exists(os.path.join(self.daemon.state_folder, "ended-jobs")), "the record of the light")
        self.daemon.kill()
        shell.close()
        self.daemon.start()
        self.assert_one_print("one", "failed", 1)
        self.assertIn("one was interrupted", self.daemon.status()["held"])

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_a_read_only_disk_delays_only_the_history(self):
        slow = self.daemon.put_on_slow_disk()
        gate = os.path.join(slow, "history-read-only")
        with open(gate, "w", encoding="utf-8"):
            pass
        self.daemon.start()
        self.assert_prints_with_one_warning()
        os.unlink(gate)
        self.assertEqual(self.ended(), [("one", "done"), ("two", "done")])

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_neither_the_start_nor_a_print_waits_for_the_history(self):
        slow = self.daemon.put_on_slow_disk()
        gate = os.path.join(slow, "history")
        with open(gate, "w", encoding="utf-8"):
            pass
        self.daemon.start()
        self.print_one("one")
        self.assertEqual(self.ended(this_run=True), [("one", "done")])
        client = self.daemon.client()
        client.send(b'{"jsonrpc":"2.0","method":"history","id":"later"}\n')
        self.assertEqual(self.daemon.status()["state"], "idle")
        os.unlink(gate)
        answer = client.wait_for(lambda m: m.get("id") == "later", "the answer")
        self.assertEqual([job["job"] for job in answer["result"]["ended"]], ["one"])
