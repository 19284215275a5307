"""The spool: how files that are put into incoming/ arrive, wait, are printed or refused, and end in done/ or failed/."""

import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
import time
import unittest

from harness import (
    CONTOURCTL, CONTOURD, ENDLESS, MAKE_MODEL, NIMBLE_RESIN, REALTIME, SANITIZED, SLOWNESS, SOURCE, Daemon, FolderTest, ascii_stl, binary_stl, box,
    contents, cube, merge, realtime, run, source_json, text_of, wait_until,
)  # fmt: skip

SMALL = binary_stl(box((0, 0, 0), (10, 5, 1)))  # 20 layers
WAITS = {"wait_for_plate_cleared": True}


class SpoolTest(FolderTest):
    def daemon(self, config=None, resin=None, **options):
        return Daemon(self, config, resin, **options)

    def printing_daemon(self, **config):
        return self.printing("first.stl", SMALL, **config)

    def second_daemon(self, name, config):
        """Returns another daemon in the same folder, with its own configuration, socket and log."""
        second = Daemon(self)
        second.config_path, second.log_path = self.path(name + ".json"), self.path(name + ".log")
        second.spool, second.socket_path = self.path(config["spool_folder"]), self.path(name + ".sock")
        merge(second.config, {"control_socket": name + ".sock", **config})
        second.write_config()
        return second

    def looks_pass(self, daemon, name):
        """Waits until the daemon refuses an empty file; meanwhile it looks at all incomplete files several times."""
        daemon.refused(name + ".stl", b"")


class Arrival(SpoolTest):
    def test_missing_folders_are_created(self):
        daemon = self.daemon({"spool_folder": "deep/er/spool"})
        daemon.start()
        for name in ("incoming", "printing", "done", "failed"):
            self.assertTrue(os.path.isdir(self.path("deep", "er", "spool", name)), name)

    def test_a_file_moved_in_is_printed_and_ends_in_done(self):
        daemon = self.daemon().start()
        report = daemon.printed("part.stl", SMALL)
        self.assertEqual((report["outcome"], report["layers"], report["layers_exposed"]), ("done", 20, 20))
        self.assertEqual(daemon.names_in("done"), ["part.preview.png", "part.report.html", "part.report.json", "part.stl"])
        for folder in ("incoming", "printing", "failed"):
            self.assertEqual(daemon.names_in(folder), [], folder)
        self.assertEqual(contents(daemon.file("done", "part.stl")), SMALL)

    def test_a_copy_that_still_grows_is_not_read_yet(self):
        daemon = self.daemon().start()
        with open(daemon.file("incoming", "slow.stl"), "wb", buffering=0) as file:
            for start in range(0, len(SMALL), 200):
                file.write(SMALL[start : start + 200])
            # The file has its full size now, but is still open, so it is not complete however often the daemon looks.
            self.looks_pass(daemon, "empty")
            self.assertEqual(daemon.names_in("incoming"), ["slow.stl"])
            self.assertEqual(daemon.status()["queued"], 0)
        self.assertEqual(daemon.wait_done("slow")["layers"], 20)

    def test_a_file_that_is_created_empty_and_filled_later_is_printed(self):
        daemon = self.daemon().start()
        path = daemon.file("incoming", "later.stl")
        made = time.monotonic()
        self.write(path, b"")
        # The file is filled after two seconds, two looks; an empty file is refused after three.
        self.looks_pass_seconds(made + 2)
        self.write(path, SMALL)
        self.assertEqual(daemon.wait_done("later")["layers"], 20)

    def test_opening_an_empty_file_repeatedly_does_not_make_it_complete(self):
        # The server of a network share does so between a file's creation and its first byte.
        daemon = self.daemon().start()
        path = daemon.file("incoming", "touched.stl")
        for _ in range(10):
            open(path, "ab").close()
            daemon.status()  # once it answers, the daemon has seen the events
        self.assertEqual(daemon.names_in("incoming"), ["touched.stl"])
        self.write(path, SMALL)
        self.assertEqual(daemon.wait_done("touched")["layers"], 20)

    def looks_pass_seconds(self, until):
        """Waits until this time. The test is about time, so there is no event to wait for."""
        wait_until(lambda: time.monotonic() >= until, "this time")

    def test_a_file_that_stays_empty_is_refused(self):
        daemon = self.daemon().start()
        self.write(daemon.file("incoming", "empty.stl"), b"")
        self.assertIn("empty", daemon.wait_refused("empty"))

    def test_a_hard_link_is_printed(self):
        daemon = self.daemon().start()
        original = self.write("original.stl", SMALL)
        os.link(original, os.fsencode(daemon.file("incoming", "linked.stl")))
        daemon.wait_done("linked")
        self.assertEqual(contents(original), SMALL)

    def test_a_file_copied_in_at_once_is_printed(self):
        daemon = self.daemon().start()
        self.write(daemon.file("incoming", "copied.stl"), SMALL)
        daemon.wait_done("copied")

    def test_files_from_before_the_start_are_printed_oldest_first(self):
        daemon = self.daemon()
        names = ["m", "z", "a", "k"]
        for name in names:
            daemon.drop(name + ".stl", SMALL)
        daemon.start()
        started = []
        for _ in names:
            end = daemon.wait_next_end()
            self.assertEqual(end["outcome"], "done")
            started.append(end["job"])
        self.assertEqual(started, names)

    def test_jobs_are_printed_in_order_of_arrival(self):
        daemon = self.printing_daemon()
        names = ["c", "a", "d", "b"]
        for name in names:
            daemon.drop(name + ".stl", SMALL)
        daemon.wait_status("queued", 4)
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], [name + ".stl" for name in names])
        for following in names:
            daemon.rpc("cancel")
            daemon.wait_state("exposing")
            self.assertEqual(daemon.status()["job"]["name"], following)

    def test_an_upper_case_extension_is_a_model_too(self):
        daemon = self.daemon().start()
        daemon.drop("LOUD.STL", SMALL, {"copies": 2})
        daemon.drop("mixed.StL", ascii_stl(cube(1)))
        self.assertEqual(daemon.wait_done("LOUD")["model"]["copies"], 2)
        self.assertEqual(daemon.wait_done("mixed")["model"]["format"], "ascii")
        self.assertEqual(daemon.names_in("incoming"), [])

    def test_other_files_are_left_alone(self):
        daemon = self.daemon().start()
        others = [".hidden.stl", "notes.txt", "part.stl.part", "part.obj", "stl", ".stl", "orphan.json"]
        for name in others:
            daemon.drop(name, SMALL)
        daemon.printed("real.stl", SMALL)
        self.looks_pass(daemon, "empty")
        self.assertEqual(daemon.names_in("incoming"), sorted(others))

    def test_a_file_withdrawn_from_the_queue_is_not_printed(self):
        daemon = self.printing_daemon()
        daemon.drop("second.stl", SMALL)
        daemon.drop("third.stl", SMALL)
        daemon.wait_status("queued", 2)
        os.rename(daemon.file("incoming", "second.stl"), self.path("taken.stl"))
        daemon.wait_status("queued", 1)
        daemon.rpc("cancel")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "third")

    def test_a_queued_file_that_is_being_overwritten_waits_until_it_is_complete(self):
        daemon = self.printing_daemon()
        daemon.drop("second.stl", SMALL)
        daemon.wait_status("queued", 1)
        larger = binary_stl(box((0, 0, 0), (10, 5, 2)))
        with open(daemon.file("incoming", "second.stl"), "wb", buffering=0) as file:
            file.write(larger[:300])
            daemon.cancel("first")
            self.looks_pass(daemon, "empty")
            self.assertEqual(daemon.names_in("incoming"), ["second.stl"])
            self.assertFalse(daemon.has("failed", "second.stl"))
            file.write(larger[300:])
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["layers"], 40)

    def test_a_queued_file_that_was_replaced_is_printed_with_its_new_contents(self):
        daemon = self.printing_daemon()
        daemon.drop("second.stl", SMALL)
        daemon.drop("second.stl", binary_stl(box((0, 0, 0), (10, 5, 2))))
        daemon.rpc("cancel")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["layers"], 40)

    def test_none_of_many_files_at_once_is_lost(self):
        daemon = self.daemon().start()
        tiny = binary_stl(box((0, 0, 0), (2, 2, 0.1)))
        names = [f"part{number}" for number in range(60)]
        for name in names:
            daemon.drop(name + ".stl", tiny if int(name[4:]) % 3 else b"no model, number " + name.encode())
        ends = {}
        while len(ends) < len(names):
            end = daemon.wait_next_end()
            ends[end["job"]] = end["outcome"]
        self.assertEqual(ends, {name: "done" if int(name[4:]) % 3 else "failed" for name in names})
        for name, outcome in ends.items():
            self.assertTrue(daemon.has(outcome, name + ".stl"), name)

    def test_a_waiting_job_is_refused_before_its_turn(self):
        daemon = self.printing_daemon()
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.status()["state"], "exposing")


class Ticket(SpoolTest):
    def setUp(self):
        super().setUp()
        self.printer = self.daemon()
        self.printer.write_resin("thick", {"layer_height_um": 100, "exposure_ms": 2000, "bottom_layers": 1, "fade_layers": 0})
        self.printer.start()

    def printed(self, ticket, data=None):
        report = self.printer.printed("part.stl", data or binary_stl(box((0, 0, 0), (10, 20, 2))), ticket)
        self.assertTrue(self.printer.has("done", "part.json"))
        self.printer.stop()
        return report

    def test_an_empty_ticket_uses_the_resin_s_layer_height_and_the_model_s_size(self):
        report = self.printed({})
        self.assertEqual((report["layers"], report["layer_height_um"], report["resin"]), (40, 50, "standard"))
        self.assertEqual(report["model"]["size_mm"], [10, 20, 2])

    def test_fit_fills_the_display(self):
        # 1080 pixels of 50 um less one (equation 3.8) for the 20 mm along y.
        report = self.printed({"fit": True})
        factor = 1079 * 0.05 / 20
        for found, expected in zip(report["model"]["size_mm"], (10 * factor, 20 * factor, 2 * factor)):
            self.assertAlmostEqual(found, expected, delta=1e-5)  # float coordinates

    def test_all_settings_of_a_ticket_together(self):
        report = self.printed({"resin": "thick", "layer_height_um": 50, "scale": 0.5, "copies": 2,
                               "rotation_deg": {"x": 0, "y": 90, "z": 90}, "position_mm": {"x": -3.5, "y": 4}})  # fmt: skip
        self.assertEqual(report["model"]["position_mm"], [-3.5, 4])
        self.assertEqual(report["model"]["rotation_deg"], [0, 90, 90])
        self.assertEqual(report["model"]["size_mm"], [10, 1, 5])
        self.assertEqual((report["layers"], report["layer_height_um"], report["resin"]), (100, 50, "thick"))
        self.assertEqual(report["layer_records"][1]["exposure_asked_ms"], 2000)
        for layer in report["layer_records"]:
            self.assertAlmostEqual(layer["area_mm2"], 20, delta=1e-6)


class RefusingTest(SpoolTest):
    """The next job is printed after each of these tests."""

    def setUp(self):
        super().setUp()
        self.printer = self.daemon().start()

    def tearDown(self):
        self.printer.printed("good.stl", SMALL)


class Refusal(RefusingTest):
    def refused(self, name, data, ticket=None, *words):
        """Drops a file that must be refused, and returns the reason, which must contain the words."""
        self.printer.drop(name, data, ticket)
        stem = os.path.splitext(name)[0]
        reason = self.printer.wait_refused(stem)
        self.assert_words(reason, *words)
        self.assertTrue(self.printer.has("failed", stem + ".stl"))
        if ticket is not None:
            self.assertTrue(self.printer.has("failed", stem + ".json"))
        self.assertEqual(self.printer.names_in("incoming") + self.printer.names_in("printing"), [])
        return reason

    def test_a_malformed_ticket_refuses_only_its_job(self):
        tickets = {
            "syntax": "{",
            "empty": "",
            "list": "[]",
            "unknown": {"colour": "red"},
            "type": {"copies": "two"},
            "range": {"scale": 0},
            "fraction": {"copies": 1.5},
            "both": {"scale": 2, "fit": True},
            "twice": '{"copies": 1, "copies": 2}',
            "nan": '{"scale": NaN}',
            "huge": '{"scale": 1e999}',
            "deep": "[" * 100000,
            "deep2": '{"scale": ' + "[" * 100000 + "]" * 100000 + "}",
            "notutf8": b'{"resin": "\xff\xfe"}',
            "large": b'{"resin": "' + b"x" * (2 << 20) + b'"}',
            "path": {"resin": "../standard"},
            "outside": {"layer_height_um": 400},
        }
        for name, ticket in tickets.items():
            with self.subTest(name):
                reason = self.refused(name + ".stl", SMALL, ticket)
                self.assertLess(len(reason), 2000)

    def test_the_reason_names_every_mistake_of_a_ticket(self):
        reason = self.refused("part.stl", SMALL, {"copies": 0, "scale": -1, "colour": "red", "rotation_deg": {"x": 999}})
        self.assert_words(reason, "/copies", "/scale", "colour", "/rotation_deg/x")

    def test_the_reason_about_an_unknown_resin_lists_the_known_ones(self):
        self.printer.write_resin("clear", {})
        self.refused("part.stl", SMALL, {"resin": "gold"}, "gold", "standard", "clear")

    def test_a_model_too_large_is_refused_with_both_sizes(self):
        self.refused("wide.stl", binary_stl(box((0, 0, 0), (97, 10, 10))), None, "97", "96")
        self.refused("deep.stl", binary_stl(box((0, 0, 0), (10, 55, 10))), None, "55", "54")
        self.refused("tall.stl", binary_stl(box((0, 0, 0), (10, 10, 155))), None, "155", "154")
        self.refused("beside.stl", SMALL, {"position_mm": {"x": 44, "y": 0}}, "44")
        self.refused("many.stl", binary_stl(box((0, 0, 0), (30, 30, 1))), {"copies": 100}, "100")

    def test_a_model_as_large_as_the_machine_is_printed(self):
        self.printer.printed("full.stl", binary_stl(box((0, 0, 0), (96, 54, 1))))

    def test_a_model_without_height_or_facets_is_refused(self):
        self.refused("flat.stl", binary_stl([((0, 0, 5), (9, 0, 5), (0, 9, 5))]), None, "flat")
        self.refused("none.stl", binary_stl([]), None, "no facets")
        self.refused("thin.stl", binary_stl(box((0, 0, 0), (9, 9, 1e-5))), None)

    def test_damaged_files_are_refused(self):
        self.refused("cut.stl", SMALL[:-20], None, "cut short")
        self.refused("junk.stl", b"MZ" + bytes(1000), None)
        self.refused("text.stl", b"solid\nhello\n", None, "line 2")

    def test_names_that_were_used_before_get_numbers(self):
        for number in range(3):
            self.printer.drop("part.stl", SMALL)
            self.printer.wait_done("part" if number == 0 else f"part-{number + 1}")
        self.printer.drop("part.stl", b"no model")
        self.printer.wait_refused("part-4")
        self.printer.drop("part.stl", b"no model")
        self.printer.wait_refused("part-5")
        for name in ("part.stl", "part-2.stl", "part-3.stl"):
            self.assertTrue(self.printer.has("done", name))
        for name in ("part-4.stl", "part-5.stl"):
            self.assertTrue(self.printer.has("failed", name))

    def test_a_job_named_like_another_job_s_report_overwrites_nothing(self):
        self.printer.printed("part.stl", SMALL)
        before = self.printer.read("done", "part.report.json")
        self.printer.drop("part.report.stl", SMALL, {"copies": 2})
        self.printer.wait_next_end()
        self.assertEqual(self.printer.read("done", "part.report.json"), before)

    def test_odd_names_are_printed_or_refused_like_any_other(self):
        names = ["two words", "new\nline", "percent %s {} {0}", "<img src=x onerror=alert(1)>", "Geräte-部品", "-dash", "--",
                 "'\"`$(x)", "a.b.c", "tab\there", "trailing ", "back\\slash"]  # fmt: skip
        for name in names:
            with self.subTest(name):
                self.printer.printed(name + ".stl", SMALL)
                self.assertNotIn("<img src=x", self.printer.read("done", name + ".report.html"))
                self.printer.drop(name + "x.stl", b"no model")
                self.printer.wait_refused(name + "x")

    def test_a_file_whose_name_is_not_utf_8_is_printed(self):
        path = os.path.join(os.fsencode(self.printer.file("incoming")), b"\xff\xfe\x80.stl")
        os.rename(self.write("staging", SMALL), path)
        end = self.printer.wait_next_end()
        self.assertEqual(end["outcome"], "done")
        self.assertIn(b"\xff\xfe\x80.stl", os.listdir(os.fsencode(self.printer.file("done"))))

    def long_name_ends(self, length):
        # A name has at most 255 bytes, so the files of a job with such a name need shorter names.
        for data, folder, suffix in ((SMALL, "done", "report.json"), (b"no model", "failed", "reason.txt")):
            self.printer.drop("n" * (length - 4) + ".stl", data)
            end = self.printer.wait_next_end()
            self.assertEqual(end["outcome"], folder)
            self.assertEqual(self.printer.names_in("incoming") + self.printer.names_in("printing"), [])
            names = self.printer.names_in(folder)
            self.assertEqual(len([name for name in names if name.endswith(suffix)]), 1, names)
            self.assertEqual(len([name for name in names if name.endswith(".stl")]), 1, names)

    def test_the_longest_name_is_handled_like_any_other(self):
        self.long_name_ends(255)

    def test_a_name_too_long_for_its_report_is_handled_like_any_other(self):
        self.long_name_ends(250)

    def test_a_name_just_short_enough_is_handled_like_any_other(self):
        self.long_name_ends(240)


class NotAFile(RefusingTest):
    """Entries of incoming/ that have a model's name, but are no regular files."""

    def test_a_folder_does_not_stop_the_next_job(self):
        os.mkdir(self.printer.file("incoming", "folder.stl"))

    def test_a_fifo_is_refused(self):
        os.mkfifo(self.printer.file("incoming", "fifo.stl"))
        self.assertIn("regular file", self.printer.wait_refused("fifo"))

    def test_a_link_to_nothing_is_refused(self):
        os.symlink("nowhere", self.printer.file("incoming", "dangling.stl"))
        self.printer.wait_refused("dangling")
        self.assertTrue(os.path.islink(self.printer.file("failed", "dangling.stl")))

    def test_a_link_to_a_model_or_ticket_is_refused_and_its_target_is_not_read(self):
        original = self.write("original.stl", SMALL)
        ticket = self.write("original.json", b'{"secret": 1}')
        for name, target in (("absolute", os.fsdecode(original)), ("relative", "../../original.stl")):
            os.symlink(target, self.printer.file("incoming", name + ".stl"))
            self.assertIn("it is a symbolic link", self.printer.wait_refused(name))
        os.symlink(ticket, os.fsencode(self.printer.file("incoming", "ticket.json")))
        reason = self.printer.refused("ticket.stl", SMALL)
        self.assertIn("it is a symbolic link", reason)
        self.assertNotIn("secret", reason)
        self.assertEqual(contents(original), SMALL)

    def test_a_link_in_a_plate_is_refused(self):
        self.write("original.stl", SMALL)
        os.mkdir(self.path("linked"))
        os.symlink("../../../original.stl", self.path("linked", "part.stl"))
        self.write("linked/plate.json", json.dumps({"models": [{"file": "part.stl"}]}))
        os.rename(self.path("linked"), self.printer.file("incoming", "linked"))
        self.assertIn("it is a symbolic link", self.printer.wait_refused("linked"))

    def test_a_socket_is_refused(self):
        with socket.socket(socket.AF_UNIX) as endpoint:
            endpoint.bind(self.path("s"))
            os.rename(self.path("s"), self.printer.file("incoming", "socket.stl"))
        self.printer.wait_refused("socket")

    def test_a_ticket_that_is_no_file_refuses_the_job(self):
        os.mkfifo(self.printer.file("incoming", "fifo.json"))
        self.printer.refused("fifo.stl", SMALL)
        os.mkdir(self.printer.file("incoming", "folder.json"))
        self.printer.refused("folder.stl", SMALL)
        os.symlink("nowhere", self.printer.file("incoming", "link.json"))
        self.printer.refused("link.stl", SMALL)

    @unittest.skipIf(os.geteuid() == 0, "permissions do not stop root")
    def test_a_file_that_cannot_be_read_is_refused(self):
        path = self.write("secret", SMALL)
        os.chmod(path, 0)
        os.rename(path, os.fsencode(self.printer.file("incoming", "secret.stl")))
        self.assertIn("ermission", self.printer.wait_refused("secret"))


@unittest.skipUnless(os.geteuid() == 0, "only root can run a daemon and a member of its group as users of their own")
class Members(SpoolTest):
    """The service runs as its own user, with the permissions that its folders have on a printer. Another user of its group, with
    the usual umask, drops files."""

    GROUP, SERVICE, MEMBER = 64000, 64001, 64002  # ids of no other user or group

    def setUp(self):
        super().setUp()
        self.printer = self.daemon({"wait_for_plate_cleared": False})
        os.chmod(self.folder, 0o755)
        for name in ("home", "state", "run"):
            os.mkdir(self.path(name))
        os.chown(self.path("home"), self.MEMBER, self.MEMBER)
        for name in ("state", "run"):
            os.chown(self.path(name), self.SERVICE, self.GROUP)
        with open(os.path.join(SOURCE, "systemd", "contourd.tmpfiles"), encoding="utf-8") as file:
            folders = [line.split() for line in file if line.startswith("d /var/spool")]
        for _, path, mode, *_ in folders:
            folder = path.replace("/var/spool/contourd", self.printer.spool)
            os.mkdir(folder)
            os.chown(folder, self.SERVICE, self.GROUP)
            os.chmod(folder, int(mode, 8))
        self.printer.config["control_socket"] = self.printer.socket_path = self.path("run", "control.sock")
        self.printer.write_config()
        self.printer.environment["STATE_DIRECTORY"] = self.path("state")
        self.printer.program = self.reachable(CONTOURD)
        self.contourctl = self.reachable(CONTOURCTL)
        self.printer.rights = {"user": self.SERVICE, "group": self.GROUP, "extra_groups": [], "umask": 0o002}
        os.chmod(self.path(), 0o777)  # for the notify socket of the test
        self.printer.start()

    def member(self, command, umask="022"):
        """Runs a shell command as the member, in the member's home; $incoming is the spool's folder incoming/."""
        subprocess.run(
            ["sh", "-ec", f"umask {umask}; {command}"], cwd=self.path("home"), check=True, user=self.MEMBER,
            group=self.MEMBER, extra_groups=[self.GROUP], env={**os.environ, "incoming": self.printer.file("incoming")})  # fmt: skip

    def plate_at_home(self, name, ticket=None):
        self.member(f"mkdir {name}")
        for file, data in (("part.stl", SMALL), ("plate.json", json.dumps(ticket or {"models": [{"file": "part.stl"}]}))):
            path = self.write(f"home/{name}/{file}", data)
            os.chown(path, self.MEMBER, self.MEMBER)

    def is_not_printed_again(self, *jobs):
        """Asserts that the jobs are neither printed nor refused again, now or after a restart."""
        wait_until(lambda: self.printer.status()["deletable"] == list(jobs), "the jobs to be deletable")
        self.printer.restart()
        self.printer.printed("another.stl", SMALL)
        wait_until(lambda: self.printer.status()["deletable"] == list(jobs), "the jobs to be deletable")
        for job in jobs:
            self.assertFalse(any(name.startswith(job + "-2") for folder in ("done", "failed") for name in self.printer.names_in(folder)))

    def test_a_plate_copied_in_is_printed_once_and_may_be_deleted(self):
        self.plate_at_home("plate")
        self.member("cp -r plate $incoming/")
        self.printer.wait_done("plate")
        self.assertTrue(self.printer.has("done", "plate", "part.stl"))
        self.assertTrue(self.printer.has("incoming", "plate", "part.stl"))
        self.assertIn("plate: printing a copy", self.printer.log())
        self.assertIn(b"deletable plate", self.printer.ctl("status").stdout)
        # With other permissions and another name, it is still the same plate.
        self.member("chmod -R a+r $incoming/plate; mv $incoming/plate $incoming/renamed")
        wait_until(lambda: self.printer.status()["deletable"] == ["renamed"], "the plate's new name")
        self.is_not_printed_again("renamed")

    def test_a_plate_made_in_place_and_a_plate_moved_in_are_printed(self):
        self.plate_at_home("moved")
        self.member("mv moved $incoming/")
        self.printer.wait_done("moved")
        self.plate_at_home("made")
        self.member("mkdir $incoming/made; cp made/part.stl made/plate.json $incoming/made/")
        self.printer.wait_done("made")
        self.is_not_printed_again("made", "moved")

    def test_a_changed_plate_is_printed_again_and_a_removed_one_is_forgotten(self):
        self.plate_at_home("plate")
        self.member("cp -r plate $incoming/")
        self.printer.wait_done("plate")
        self.member("""echo '{"models": [{"file": "part.stl", "copies": 2}]}' > $incoming/plate/plate.json""")
        self.printer.wait_done("plate-2")
        self.member("rm -r $incoming/plate")
        wait_until(lambda: self.printer.status()["deletable"] == [], "the plate to be forgotten")

    def cut_off_copy(self):
        """Puts the copy of a printed plate into printing/ again. Returns its inode, and the mark of its original."""
        self.plate_at_home("plate")
        self.member("cp -r plate $incoming/")
        self.printer.wait_done("plate")
        self.printer.kill()
        os.rename(self.printer.file("done", "plate"), self.printer.file("printing", "plate"))
        for name in self.printer.names_in("done"):
            os.remove(self.printer.file("done", name))
        return os.stat(self.printer.file("printing", "plate")).st_ino, text_of(self.path("state", "copied-originals"))

    def test_a_plate_is_not_printed_again_after_a_power_cut_that_followed_its_copy(self):
        inode, mark = self.cut_off_copy()
        self.write("state/copied-originals", f"copying {inode} {mark}")
        self.printer.start()
        self.assertEqual(self.printer.names_in("failed"), ["plate", "plate.reason.txt"])
        self.printer.rpc("resume")
        self.is_not_printed_again("plate")

    def test_a_power_cut_before_the_copy_is_complete_loses_no_plate(self):
        inode, mark = self.cut_off_copy()
        self.write("state/copied-originals", f"copying {inode} {mark}")
        os.rename(self.printer.file("printing", "plate"), self.path("home", "gone"))
        self.printer.start()
        self.printer.wait_done("plate")
        self.is_not_printed_again("plate")

    def test_models_of_any_owner_are_moved(self):
        self.write("home/model.stl", SMALL)
        self.member("cp model.stl $incoming/copied.stl")
        self.printer.wait_done("copied")
        self.member("cp model.stl mine.stl; mv mine.stl $incoming/moved.stl")
        self.printer.wait_done("moved")
        self.assertEqual(self.printer.names_in("incoming"), [])

    def test_a_bad_plate_is_refused_once(self):
        self.plate_at_home("bad", {"models": [{"file": "part.stl", "colour": "red"}]})
        self.member("cp -r bad $incoming/")
        self.assertIn("colour", self.printer.wait_refused("bad"))
        self.is_not_printed_again("bad")

    def test_unreadable_files_are_refused_once(self):
        self.plate_at_home("closed")
        self.member("cp -r closed $incoming/", umask="077")
        self.assertIn("Permission denied", self.printer.wait_refused("closed"))
        self.write("home/model.stl", SMALL)
        self.member("cp model.stl $incoming/secret.stl", umask="077")
        self.assertIn("Permission denied", self.printer.wait_refused("secret"))
        self.member("mkdir $incoming/folder.stl")
        self.assertIn("folder", self.printer.wait_refused("folder"))
        self.is_not_printed_again("closed", "folder.stl")

    def test_the_name_of_an_unreadable_plate_is_harmless(self):
        self.plate_at_home("closed")
        self.member('chmod 0 closed/part.stl; mv closed "$incoming/line\nbreak"')
        reason = self.printer.wait_refused("line\nbreak")
        self.assertIn("Permission denied", reason)
        self.assertEqual(reason.count("\n"), 1, reason)

    def test_a_bad_plate_is_refused_while_another_job_waits(self):
        # The jobs are checked while they wait in the queue for the plate to be cleared.
        self.printer.stop()
        merge(self.printer.config, WAITS)
        self.printer.write_config()
        self.printer.start()
        self.printer.printed("first.stl", SMALL)
        self.plate_at_home("bad", {"models": [{"file": "part.stl", "colour": "red"}]})
        self.plate_at_home("good")
        self.member("cp -r bad good $incoming/")
        self.assertIn("colour", self.printer.wait_refused("bad"))
        self.printer.rpc("plate_cleared")
        self.printer.wait_done("good")

    def flood(self, request=b""):
        """Opens 200 connections of the member, which each send a request and then stay idle."""
        script = (
            "import os, socket, sys, time\n"
            f"os.setgroups([{self.GROUP}])\n"
            f"os.setresgid({self.MEMBER}, {self.MEMBER}, {self.MEMBER})\n"
            f"os.setresuid({self.MEMBER}, {self.MEMBER}, {self.MEMBER})\n"
            "held = []\n"
            "for _ in range(200):\n"
            "    held.append(socket.socket(socket.AF_UNIX))\n"
            "    held[-1].connect(sys.argv[1])\n"
            "    held[-1].send(sys.argv[2].encode())\n"
            "print('held', flush=True)\n"
            "time.sleep(600)\n")  # fmt: skip
        flood = subprocess.Popen(
            [sys.executable, "-c", script, self.printer.socket_path, request.decode()], stdout=subprocess.PIPE)
        self.addCleanup(flood.wait)
        self.addCleanup(flood.kill)
        self.addCleanup(flood.stdout.close)
        flood.stdout.readline()

    def test_idle_connections_and_watchers_of_one_user_do_not_block_others(self):
        for request in (b"", b'{"jsonrpc":"2.0","method":"watch","id":1}\n'):
            self.flood(request)
            for _ in range(3):
                self.assertEqual(self.printer.status()["state"], "idle")
        # The daemon's first watcher, which is root's, is still connected.
        self.printer.printed("part.stl", SMALL)

    def test_a_command_is_logged_with_its_user_and_a_query_is_not_logged(self):
        call = [self.contourctl, "cancel", "--socket", self.printer.socket_path]
        result = subprocess.run(call, user=self.MEMBER, group=self.MEMBER, extra_groups=[self.GROUP], capture_output=True, check=False)
        self.assertIn(b"no print to cancel", result.stderr)
        self.assertIn(f"cancel requested by user {self.MEMBER} (process ", self.printer.log())
        self.printer.rpc("pause")
        self.assertIn("pause requested by user root (0) (process ", self.printer.log())
        self.printer.status()
        self.assertNotIn("status requested", self.printer.log())

    def test_a_member_can_neither_replace_nor_remove_the_spools_folders(self):
        for folder in ("incoming", "printing", "done", "failed"):
            with self.assertRaises(subprocess.CalledProcessError):
                self.member(f"mv $incoming/../{folder} $incoming/../elsewhere 2>/dev/null")
        with self.assertRaises(subprocess.CalledProcessError):
            self.member("ls $incoming/../../state 2>/dev/null")


class OddNames(SpoolTest):
    """Names that could control a terminal, or look like other names."""

    ODD = ("\x1b[31m", "line\nbreak", "\x9b2J", "\u202egnp", "\u2066isolate", "\u2028separator", "\x07bell\r")

    def assert_harmless(self, text, what):
        text = text.decode("utf-8") if isinstance(text, bytes) else text
        for char in "\x1b\x07\r\x9b\u202e\u2066\u2028":
            self.assertNotIn(char, text, what)
        self.assertNotIn("line\nbreak", text, what)

    def test_odd_names_reach_terminal_log_and_report_without_control_characters(self):
        daemon = self.daemon().start()
        for odd in self.ODD:
            daemon.printed(f"good{odd}.stl", SMALL)
            daemon.drop(f"bad{odd}.stl", f"solid {odd}\nfacet {odd}\n{odd}".encode())
            daemon.wait_ended(f"bad{odd}")
            self.assert_harmless(daemon.ctl("status").stdout, "status")
            self.assert_harmless(daemon.ctl("status", "--json").stdout, "status as JSON")
            os.mkdir(self.path("plate"))
            self.write("plate/plate.json", json.dumps({"models": [{"file": f"{odd}.stl"}], odd: 1}))
            self.write(f"plate/{odd}.stl", SMALL)
            os.rename(self.path("plate"), daemon.file("incoming", f"plate{odd}"))
            daemon.wait_ended(f"plate{odd}")
        self.assert_harmless(daemon.log(), "log")
        for folder in ("done", "failed"):
            for name in daemon.names_in(folder):
                if name.endswith((".html", ".json", ".txt")):
                    self.assert_harmless(daemon.read(folder, name), name)
        daemon.drop("pause.stl", b"no model")
        daemon.wait_ended("pause")

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_an_odd_name_in_an_error_of_the_kernel_is_harmless(self):
        daemon = self.daemon()
        slow = daemon.put_on_slow_disk()
        daemon.start()
        for odd in self.ODD:
            os.symlink("nowhere", daemon.file("incoming", f"link{odd}.stl"))
            daemon.wait_ended(f"link{odd}")
            self.assert_harmless(daemon.read("failed", f"link{odd}.reason.txt"), "reason")
        self.write(os.path.join(slow, "full"), b"")
        for odd in self.ODD:
            daemon.drop(f"bad{odd}.stl", b"no model")
            daemon.wait_ended(f"bad{odd}")
        self.assert_harmless(daemon.log(), "log")

    def test_an_odd_name_of_a_job_that_the_machine_cannot_begin_is_harmless(self):
        daemon = self.daemon(masks=True)
        self.write("masks", b"no folder")
        daemon.start()
        for odd in self.ODD:
            daemon.drop(f"good{odd}.stl", SMALL)
            self.assertEqual(daemon.wait_ended(f"good{odd}")["outcome"], "failed")
            self.assert_harmless(daemon.read("failed", f"good{odd}.reason.txt"), "reason")
        self.assert_harmless(daemon.log(), "log")


class Profiles(SpoolTest):
    """The resin's profile is read when a job is claimed, whether a ticket or the configuration names it."""

    def break_resin(self, name="standard", text=None):
        broken = {**source_json("resins", "standard.json"), "lift_mm": "high", "settle_ms": True}
        self.write(f"resins/{name}.json", json.dumps(broken) if text is None else text)

    def waits_for(self, daemon, *words):
        status = daemon.wait_status("waiting_for")
        self.assert_words(status["waiting_for"], *words)
        self.assertNotIn("\n", status["waiting_for"])
        self.assertIn(words[0].encode(), daemon.ctl("status").stdout)
        return status

    def exposure(self, report):
        return report["settings"]["exposure_ms"], report["layer_records"][-1]["exposure_asked_ms"]

    def analyzed_s(self, daemon, model, *ticket):
        arguments = ["--ticket", *ticket] if ticket else []
        result = run(CONTOURCTL, "analyze", "--json", model, "--printer", daemon.config_path, *arguments, expect=0)
        return json.loads(result.stdout)["layer_time_s"]

    def cpu_s(self, daemon):
        with open(f"/proc/{daemon.process.pid}/stat", encoding="ascii") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def test_an_edited_profile_applies_to_every_job_that_is_claimed_afterwards(self):
        daemon = self.daemon().start()
        tall = binary_stl(box((0, 0, 0), (10, 5, 2)))  # 40 layers, more than bottom and fade have
        self.assertEqual(self.exposure(daemon.printed("before.stl", tall)), (3000, 3000))
        daemon.write_resin("standard", {"exposure_ms": 3500})
        daemon.drop("none.stl", tall)
        daemon.drop("empty.stl", tall, {})
        daemon.drop("named.stl", tall, {"resin": "standard"})
        os.mkdir(self.path("plate"))
        self.write("plate/part.stl", tall)
        self.write("plate/plate.json", json.dumps({"models": [{"file": "part.stl"}]}))
        os.rename(self.path("plate"), daemon.file("incoming", "plate"))
        for job in ("none", "empty", "named", "plate"):
            self.assertEqual(self.exposure(daemon.wait_done(job)), (3500, 3500), job)
            self.assertIn(f"{job}: standard: exposure 3500 ms", daemon.log())
            self.assertIn("exposure 3500 ms", daemon.read("done", job + ".report.html"))
        model, ticket = self.write("same.stl", tall), self.write("ticket.json", '{"resin": "standard"}')
        edited = self.analyzed_s(daemon, model)
        self.assertEqual(self.analyzed_s(daemon, model, ticket), edited)
        daemon.write_resin("standard", {"exposure_ms": 4500})
        # The 25 layers after bottom and fade get the whole additional second, the 10 of the fade half of it on average.
        self.assertAlmostEqual(self.analyzed_s(daemon, model) - edited, 25 + 10 / 2, delta=0.01)

    def test_a_profile_edited_during_a_print_applies_from_the_next_job_on(self):
        daemon = self.printing_daemon()
        daemon.drop("next.stl", SMALL)
        daemon.wait_status("queued", 1)
        daemon.write_resin("standard", {**NIMBLE_RESIN, "exposure_ms": 2, "bottom_exposure_ms": 2})
        self.assertEqual(daemon.cancel("first")["outcome"], "cancelled")
        self.assertEqual(daemon.report("first", "failed")["settings"]["exposure_ms"], 120000)
        self.assertEqual(self.exposure(daemon.wait_done("next")), (2, 2))

    def test_a_broken_profile_makes_the_queue_wait_until_it_is_corrected(self):
        daemon = self.daemon().start()
        for text, words in ((None, ("standard.json", "/lift_mm", "1 more")), ("{", ("standard.json",)), ("gone", ("standard",))):
            with self.subTest(text):
                self.break_resin("standard", text)
                if text == "gone":
                    os.unlink(self.path("resins", "standard.json"))
                daemon.drop("one.stl", SMALL)
                daemon.drop("two.stl", SMALL, {"resin": "standard"})
                self.waits_for(daemon, "standard", *words, "fixed")
                daemon.wait_status("queued", 2)
                self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), ([], []))
                daemon.write_resin("standard", {})
                daemon.wait_done("one")
                daemon.wait_done("two")
                self.assertIsNone(daemon.status()["waiting_for"])
                self.assertEqual(daemon.log().count("one.stl waits: the resin profile"), 1)
                for name in daemon.names_in("done"):
                    os.unlink(daemon.file("done", name))
                daemon.stop()
                os.truncate(daemon.log_path, 0)
                daemon.start()

    def test_a_broken_profile_that_only_a_ticket_names_also_makes_the_queue_wait(self):
        daemon = self.daemon()
        self.break_resin("tough")
        daemon.start()
        daemon.drop("part.stl", SMALL, {"resin": "tough"})
        self.waits_for(daemon, "tough", "tough.json", "/lift_mm")
        # Once the file is removed, the other jobs continue.
        os.unlink(daemon.file("incoming", "part.stl"))
        daemon.printed("other.stl", SMALL)
        self.assertEqual(daemon.names_in("failed"), [])

    def test_a_ticket_with_an_unknown_profile_is_refused(self):
        daemon = self.daemon().start()
        reason = daemon.refused("part.stl", SMALL, {"resin": "gold"})
        self.assert_words(reason, "gold", "standard")
        daemon.printed("good.stl", SMALL)

    def test_a_profile_that_breaks_or_vanishes_while_jobs_wait_gives_a_warning_and_refuses_none(self):
        daemon = self.printing_daemon()
        daemon.write_resin("tough", NIMBLE_RESIN)
        daemon.drop("checked.stl", SMALL, {"resin": "tough"})
        daemon.refused("bad.stl", b"no model")  # by then the job before it has been checked
        os.unlink(self.path("resins", "tough.json"))
        self.break_resin("standard")
        daemon.drop("late.stl", SMALL)
        wait_until(lambda: "late.stl: the resin profile" in daemon.log(), "the warning")
        self.assertIsNone(daemon.status()["waiting_for"])  # a print is under way
        daemon.cancel("first")
        self.waits_for(daemon, "tough")
        daemon.write_resin("tough", NIMBLE_RESIN)
        daemon.wait_done("checked")
        self.waits_for(daemon, "standard.json")
        daemon.write_resin("standard", NIMBLE_RESIN)
        daemon.wait_done("late")
        self.assertEqual([name for name in daemon.names_in("failed") if name.endswith(".stl")], ["bad.stl", "first.stl"])

    def test_waiting_for_a_profile_takes_almost_no_processor_time(self):
        daemon = self.daemon().start()
        self.break_resin()
        daemon.drop("part.stl", SMALL)
        self.waits_for(daemon, "standard")
        used = self.cpu_s(daemon)
        end = time.monotonic() + 3
        wait_until(lambda: time.monotonic() >= end, "three seconds to pass")
        # A busy loop would take 3 s; reading a small file once takes far less.
        self.assertLess(self.cpu_s(daemon) - used, 0.3 * SLOWNESS)

    def test_the_configuration_is_read_only_at_the_start(self):
        daemon = self.daemon().start()
        daemon.config["display"]["pixel_pitch_um"] = 100
        daemon.config["resin"] = "tough"
        daemon.write_resin("tough", {"exposure_ms": 4000})
        daemon.write_config()
        report = daemon.printed("part.stl", SMALL)
        self.assertEqual((report["resin"], report["settings"]["exposure_ms"]), ("standard", 3000))
        daemon.restart()
        self.assertEqual(daemon.printed("again.stl", SMALL)["resin"], "tough")


class IgnoredFiles(SpoolTest):
    """Files in incoming/ that will never be printed."""

    def listed(self, daemon, *names):
        return wait_until(lambda: (lambda s: s if set(s["ignored"]) == set(names) else None)(daemon.status()), names)

    def test_unprintable_files_are_logged_once_and_listed_until_they_are_removed(self):
        daemon = self.daemon()
        os.makedirs(daemon.file("incoming"))
        self.write("spool/incoming/before.obj", b"there before the start")
        daemon.start()
        files = {"before.obj": "STL", "part.3mf": "STL", "part.obj": "STL", "sliced.gcode": "sliced", "part.sl1": "sliced", "notes": "NAME.stl"}
        for name in files:
            if name != "before.obj":
                daemon.drop(name, b"something")
        os.mkdir(daemon.file("incoming", "folder"))
        self.write("spool/incoming/folder/part.stl", SMALL)
        os.symlink("part.3mf", daemon.file("incoming", "link"))
        # These files may be part of a job, so they are not listed.
        for name in ("ticket.json", ".hidden.3mf", "part.stl.part", "other.3mf.crdownload"):
            daemon.drop(name, b"{}")
        # A file that soon gets its right name is not listed either.
        daemon.drop("upload", SMALL)
        os.rename(daemon.file("incoming", "upload"), daemon.file("incoming", "renamed.stl"))
        daemon.wait_done("renamed")
        status = self.listed(daemon, *files, "folder", "link")
        for name, word in files.items():
            self.assertIn(word, status["ignored"][name])
        self.assertIn("plate.json", status["ignored"]["folder"])
        self.assertEqual((status["ignored_more"], status["queued"]), (0, 0))
        shown = daemon.ctl("status").stdout.decode()
        for name in (*files, "folder", "link"):
            self.assertIn(f"unprinted {name} in incoming: ", shown)
            self.assertEqual(daemon.log().count(f"{name}: is ignored"), 1)
        self.assertEqual(len(daemon.names_in("incoming")), 12)
        # Each file is logged once, even if others change.
        daemon.printed("good.stl", SMALL)
        for name in (*files, "link"):
            os.unlink(daemon.file("incoming", name))
        self.listed(daemon, "folder")
        self.write("spool/incoming/folder/plate.json", json.dumps({"models": [{"file": "part.stl"}]}))
        daemon.wait_done("folder")
        self.listed(daemon)
        self.assertEqual(daemon.log().count("is ignored"), 8)
        self.assertNotIn("upload", daemon.log())

    def test_a_few_of_very_many_unprintable_files_are_listed_and_the_rest_is_counted(self):
        daemon = self.daemon().start()
        for number in range(1000):
            self.write(f"spool/incoming/{number}\x1b\n.3mf", b"something")
        status = wait_until(lambda: (lambda s: s if s["ignored_more"] == 990 else None)(daemon.status()), "all files to be counted")
        self.assertEqual(len(status["ignored"]), 10)
        wait_until(lambda: "more in incoming are ignored" in daemon.log(), "the summary in the log")
        self.assertLess(daemon.log().count("ignored"), 40)
        self.assertNotIn(b"\x1b", daemon.ctl("status").stdout)
        daemon.printed("good.stl", SMALL)


class ManyAndLong(SpoolTest):
    def test_a_ticket_with_tens_of_thousands_of_mistakes_has_a_short_reason(self):
        daemon = self.daemon().start()
        reason = daemon.refused("long.stl", SMALL, "{" + ",".join(f'"{number}":1' for number in range(80000)) + "}")
        self.assertLess(len(reason), 10000)
        self.assertIn("and at least 980 more", reason)
        # Sixty nested objects with keys of a thousand bytes.
        nested = "".join('{"' + "k" * 1000 + '":' for _ in range(60)) + "1" + "}" * 60
        self.assertLess(len(daemon.refused("deep.stl", SMALL, nested)), 10000)
        self.assertLess(len(daemon.log()), 50000)

    def test_answers_list_the_first_of_many_names_and_count_the_rest(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("first.stl", SMALL)
        for number in range(60):
            os.mkdir(daemon.file("incoming", f"folder{number}"))
        for number in range(1060):
            daemon.drop(f"part{number}.stl", SMALL)
        status = wait_until(lambda: (lambda s: s if s["queued"] == 1060 and s["incomplete_more"] == 50 else None)(daemon.status()), "all files to be counted")
        self.assertEqual(len(status["incomplete"]), 10)
        queue = daemon.rpc("queue")["result"]
        self.assertEqual((len(queue["queue"]), queue["more"]), (1000, 60))
        self.assertIn(b"and 60 more", daemon.ctl("queue").stdout)


class Outcome(SpoolTest):
    def test_a_print_whose_done_folder_was_removed_is_done(self):
        daemon = self.daemon().start()
        os.rmdir(daemon.file("done"))
        daemon.printed("part.stl", SMALL)
        self.assertTrue(daemon.has("done", "part.stl"))

    def test_a_print_that_cannot_be_filed_is_filed_at_the_next_start_with_its_outcome(self):
        daemon = self.daemon().start()
        os.rmdir(daemon.file("done"))
        self.write(daemon.file("done"), b"")
        daemon.drop("part.stl", SMALL)
        self.assertEqual(daemon.wait_ended("part")["outcome"], "done")
        self.assertEqual(daemon.names_in("printing"), ["part.stl"])
        daemon.drop("next.stl", SMALL)
        status = daemon.wait_status("waiting_for")
        self.assertIn("part is not filed yet", status["waiting_for"])
        # Files are read one after the other. A file that is being read when the daemon is killed would not be read again.
        daemon.refused("last.stl", b"no model")
        daemon.kill()
        os.unlink(daemon.file("done"))
        daemon.start()
        self.assertIn("contourd did not file this print, which was done", daemon.log())
        self.assertTrue(daemon.has("done", "part.stl"))
        daemon.wait_done("next")
        self.assertEqual(daemon.names_in("failed"), ["last.reason.txt", "last.stl"])

    def test_partly_written_files_of_a_killed_daemon_are_removed_at_the_start(self):
        daemon = self.daemon().start()
        daemon.kill()
        left = [daemon.file(folder, ".contourd-0123456789abcdef.new") for folder in ("printing", "done", "failed")]
        left.append(os.path.join(daemon.spool + ".state", ".contourd-0123456789abcdef.new"))
        for path in left:
            self.write(path, b"")
        os.mkdir(daemon.file("printing", ".copies"))
        self.write(daemon.file("printing", ".copies", "half.stl"), b"")
        daemon.start()
        self.assertEqual([path for path in left if os.path.lexists(path)], [])
        self.assertEqual(daemon.names_in("printing"), [])


class PlantedFiles(SpoolTest):
    """Files other than models that a member of the group may put into the spool."""

    def test_fifos_of_any_name_block_neither_a_print_nor_a_refusal_nor_a_restart(self):
        daemon = self.daemon({"wait_for_plate_cleared": True}).start()
        for suffix in ("report.json", "report.html", "preview.png", "reason.txt"):
            for folder in ("done", "failed"):
                for name in (f"part.{suffix}", f".part.{suffix}.new", f"bad.{suffix}", f".bad.{suffix}.new"):
                    os.mkfifo(daemon.file(folder, name))
        for name in ("plate-occupied", ".plate-occupied.new", "queue-held", ".queue-held.new"):
            os.mkfifo(daemon.file(name))
        daemon.drop("bad.stl", b"no model")
        # If a name is taken, a job that ends gets a number.
        end = daemon.wait_next_end()
        self.assertEqual(end["outcome"], "failed")
        daemon.drop("part.stl", SMALL)
        end = daemon.wait_next_end()
        self.assertEqual(end["outcome"], "done")
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], end["job"])

    def test_files_named_like_the_daemon_s_own_change_neither_queue_nor_plate(self):
        daemon = self.daemon({"wait_for_plate_cleared": True})
        os.makedirs(daemon.spool)
        for name in ("plate-occupied", "queue-held"):
            self.write(daemon.file(name), "something\n")
        daemon.start()
        status = daemon.status()
        self.assertEqual((status["held"], status["plate"]), (None, "clear"))
        daemon.printed("part.stl", SMALL)
        for name in ("plate-occupied", "queue-held"):
            os.unlink(daemon.file(name))
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], "part")

    def test_only_the_daemon_can_access_its_own_files(self):
        daemon = self.daemon({"wait_for_plate_cleared": True}).start()
        daemon.printed("part.stl", SMALL)
        self.assertEqual(os.stat(daemon.spool + ".state").st_mode & 0o777, 0o700)
        # A user who can read the lock file could hold the lock.
        self.assertEqual(os.stat(daemon.file(".lock")).st_mode & 0o777, 0o600)

    def test_the_state_folder_of_the_service_manager_is_used_if_there_is_one(self):
        daemon = self.daemon({"wait_for_plate_cleared": True})
        os.mkdir(self.path("own"))
        os.chmod(self.path("own"), 0o2775)
        daemon.environment["STATE_DIRECTORY"] = self.path("own")
        daemon.start()
        daemon.printed("part.stl", SMALL)
        daemon.stop()
        self.assertIn("plate-occupied", os.listdir(self.path("own")))
        self.assertEqual(os.stat(self.path("own")).st_mode & 0o777, 0o700)
        self.assertFalse(os.path.exists(daemon.spool + ".state"))

    def test_a_spool_with_a_link_in_place_of_a_folder_is_refused(self):
        daemon = self.daemon()
        os.makedirs(daemon.spool)
        os.mkdir(self.path("elsewhere"))
        os.symlink(self.path("elsewhere"), daemon.file("done"))
        daemon.launch()
        self.assertGreater(daemon.process.wait(30), 0)
        self.assertIn("done is a symbolic link", daemon.log())


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class SlowDisk(SpoolTest):
    """A print goes on while the disk does not answer, as slow cards do for seconds."""

    def printing_on_slow_disk(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, "exposure_ms": 150, "bottom_exposure_ms": 150})
        slow = daemon.put_on_slow_disk()
        daemon.start()
        daemon.begin("part.stl", SMALL)
        return daemon, slow

    def goes_on(self, daemon, slow, gate):
        """Asserts that layers are printed while the daemon waits for the disk; then lets the disk answer again."""
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "a thread to wait for the disk")
        done = daemon.status()["job"]["layers_done"]
        daemon.watcher.wait_for(
            lambda m: m.get("method") == "layer" and m["params"]["job"]["layers_done"] >= done + 3, "three layers")
        self.assertTrue(os.path.exists(os.path.join(slow, gate)))
        os.unlink(os.path.join(slow, gate))

    def test_a_refusal_that_waits_for_the_disk_does_not_delay_a_print(self):
        daemon, slow = self.printing_on_slow_disk()
        self.write(os.path.join(slow, "writes"), b"")
        daemon.drop("bad.stl", b"no model")
        self.goes_on(daemon, slow, "writes")
        self.assertIn("bad.stl", "".join(daemon.names_in("failed") + daemon.names_in("incoming")))
        daemon.wait_refused("bad")
        self.assertTrue(daemon.has("failed", "bad.stl"))
        self.assertEqual(daemon.wait_done("part")["layers_exposed"], 20)
        self.assertNotIn("removed from incoming", daemon.log())

    def test_a_file_that_is_removed_while_it_is_refused_leaves_the_queue(self):
        daemon = self.daemon(WAITS)
        slow = daemon.put_on_slow_disk()
        daemon.environment["STATE_DIRECTORY"] = self.path("state")  # on another disk, which answers
        daemon.start()
        daemon.printed("first.stl", SMALL)
        self.write(os.path.join(slow, "writes"), b"")
        daemon.drop("bad.stl", b"no model")
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the reason file to wait for the disk")
        os.rename(daemon.file("incoming", "bad.stl"), self.path("bad.stl"))
        for _ in range(2):
            daemon.status()  # once it answers, the daemon has seen the events
        self.assertEqual(daemon.status()["queued"], 1)
        os.unlink(os.path.join(slow, "writes"))
        wait_until(lambda: daemon.status()["queued"] == 0, "the queue to be empty", 10)
        self.assertIn("bad.stl: removed from incoming by a user", daemon.log())
        self.assertFalse(daemon.has("failed", "bad.reason.txt"))

    def arrives(self, name):
        daemon, slow = self.printing_on_slow_disk()
        self.write(os.path.join(slow, "reads"), b"")
        os.rename(self.path(name), daemon.file("incoming", name))
        self.goes_on(daemon, slow, "reads")
        daemon.wait_done("part")
        daemon.wait_done("next")
        daemon.stop()

    def test_a_look_at_a_model_that_waits_for_the_disk_does_not_delay_a_print(self):
        self.write("next.stl", SMALL)
        self.arrives("next.stl")

    def test_a_look_at_a_plate_that_waits_for_the_disk_does_not_delay_a_print(self):
        os.mkdir(self.path("next"))
        self.write("next/next.stl", SMALL)
        self.write("next/plate.json", json.dumps({"models": [{"file": "next.stl"}]}))
        self.arrives("next")


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class SlowFiling(SpoolTest):
    """A print is over, but its report or picture waits for the disk."""

    def finishing_daemon(self, gate="pictures", end="cancel", resin=None):
        daemon = self.daemon(REALTIME, resin or {**NIMBLE_RESIN, **ENDLESS})
        slow = daemon.put_on_slow_disk()
        self.gate = os.path.join(slow, gate)
        daemon.start()
        daemon.begin("first.stl", SMALL)
        self.write(self.gate, b"")
        if end:
            daemon.rpc(end)
        daemon.wait_status("state", "finishing")
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the archivist to wait for the disk")
        return daemon

    def test_while_a_print_is_filed_the_daemon_answers_and_the_next_job_waits(self):
        daemon = self.finishing_daemon()
        daemon.drop("next.stl", SMALL)
        self.assertIn("no print", daemon.rpc("cancel")["error"]["message"])
        status = daemon.wait_status("queued")
        self.assertEqual((status["state"], status["job"]["name"], status["last"]), ("finishing", "first", None))
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("incoming")), (["first.stl"], ["next.stl"]))
        self.assertEqual(daemon.rpc("plate_cleared")["result"]["plate"], "clear")
        os.unlink(self.gate)
        self.assertEqual(daemon.wait_ended("first")["outcome"], "cancelled")
        self.assertTrue(daemon.has("failed", "first.stl"))
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "next")

    def test_a_stop_waits_until_the_print_is_filed(self):
        daemon = self.finishing_daemon()
        daemon.process.send_signal(signal.SIGTERM)
        daemon.wait_status("state", "finishing")
        os.unlink(self.gate)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertTrue(daemon.has("failed", "first.preview.png"))

    def test_a_stop_waits_only_some_seconds_for_a_disk_that_does_not_answer(self):
        daemon = self.finishing_daemon()
        daemon.process.send_signal(signal.SIGTERM)
        # The daemon waits 15 s for the disk, and there is no other event to wait for.
        wait_until(lambda: "not filed after 15 s" in daemon.log(), "the daemon to give up")
        wait_until(lambda: "contourd has stopped" in daemon.log(), "the daemon to stop")
        os.unlink(self.gate)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertEqual((daemon.names_in("printing"), daemon.has("failed", "first.stl")), ([], True))

    def restarted_after_kill(self, daemon):
        daemon.kill()
        os.unlink(self.gate)
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.start()
        self.assertEqual(daemon.names_in("printing"), [])
        return daemon

    def test_a_done_print_that_was_killed_before_it_was_filed_is_done(self):
        daemon = self.finishing_daemon(end=None, resin={**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 20})
        self.restarted_after_kill(daemon)
        self.assertIn("first.stl", daemon.names_in("done"))
        self.assertEqual(daemon.names_in("failed"), [])
        self.assertEqual(daemon.report("first")["outcome"], "done")
        self.assertIn("was done", daemon.log())
        status = daemon.status()
        self.assertEqual((status["plate_job"], status["held"]), ("first", None))

    def test_a_cancelled_print_that_was_killed_before_it_was_filed_does_not_hold_the_queue(self):
        daemon = self.restarted_after_kill(self.finishing_daemon())
        self.assertIn("Cancelled", daemon.read("failed", "first.reason.txt"))
        self.assertIsNone(daemon.status()["held"])

    def test_a_failed_print_that_was_killed_before_it_was_filed_holds_the_queue_with_its_reason(self):
        # Homing fails, since the limit switch never closes.
        daemon = self.daemon(realtime(simulation={"limit_switch": "stuck_open"}), NIMBLE_RESIN)
        slow = daemon.put_on_slow_disk()
        self.gate = os.path.join(slow, "pictures")
        self.write(self.gate, b"")
        daemon.start()
        daemon.drop("first.stl", SMALL)
        wait_until(lambda: os.path.exists(os.path.join(slow, "waiting")), "the archivist to wait for the disk")
        self.restarted_after_kill(daemon)
        self.assertIn("homing failed", daemon.read("failed", "first.reason.txt"))
        self.assertIn("homing failed", daemon.status()["held"])

    def test_a_print_that_was_killed_before_its_outcome_was_stored_counts_as_interrupted(self):
        daemon = self.restarted_after_kill(self.finishing_daemon("writes"))
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        self.assertIn("first", daemon.status()["held"])


@unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
class DiskThatTakesNothing(SpoolTest):
    def printing_daemon(self, **config):
        daemon = self.daemon(realtime(**config), {**NIMBLE_RESIN, **ENDLESS})
        self.slow = daemon.put_on_slow_disk()
        daemon.start()
        daemon.begin("first.stl", SMALL)
        return daemon

    def becomes(self, state):
        self.write(os.path.join(self.slow, state), b"")

    def is_repaired(self, state):
        os.unlink(os.path.join(self.slow, state))

    def test_a_print_cancelled_on_a_full_disk_is_filed_without_its_reason(self):
        daemon = self.printing_daemon()
        self.becomes("full")
        daemon.cancel("first")
        self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), ([], ["first.stl"]))
        self.assertIn("cannot write its reason file", daemon.log())
        self.assertIn("no report", daemon.log())

    def restarts_on_a_disk_that_is(self, state):
        """Kills a daemon during a print and restarts it on this disk, twice. No job begins and nothing is lost; once the disk is
        repaired, the interrupted print is filed. Returns the log up to the repair."""
        daemon = self.printing_daemon()
        daemon.drop("next.stl", SMALL)
        # A file that is being read when the daemon is killed would not be read again.
        daemon.refused("bad.stl", b"no model")
        for name in ("bad.stl", "bad.reason.txt"):
            os.unlink(daemon.file("failed", name))
        self.becomes(state)
        for _ in range(2):
            daemon.kill()
            daemon.start()
            status = daemon.wait_status("waiting_for")
            self.assertEqual((status["plate_job"], status["queued"]), ("first", 1))
            self.assertIn("first", status["held"])
            self.assertEqual((daemon.names_in("printing"), daemon.names_in("failed")), (["first.stl"], []))
        log = daemon.log()
        self.assertNotIn("moved to failed", log)
        self.assertEqual(state == "read-only", "ReadWritePaths" in log)
        self.assertEqual(log.count("cannot save the state for the next start"), 2, log)
        self.assertEqual(log.count("first: stays in printing"), 2, log)
        self.is_repaired(state)
        daemon.drop("more.stl", SMALL)
        wait_until(lambda: daemon.has("failed", "first.stl"), "first in failed")
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        self.assertIn("first", daemon.state("queue-held"))
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertEqual(daemon.rpc("resume")["result"]["held"], None)
        daemon.wait_state("exposing")
        daemon.stop()
        return log

    def test_the_error_about_a_spool_that_cannot_be_made_names_the_unit_s_setting(self):
        daemon = self.daemon(REALTIME)
        self.slow = daemon.put_on_slow_disk()
        self.becomes("read-only")
        daemon.launch()
        self.assertGreater(daemon.process.wait(30), 0)
        self.assertIn("ReadWritePaths", daemon.log())

    def test_the_daemon_starts_on_a_full_disk_after_a_kill(self):
        self.assertIn("No space left", self.restarts_on_a_disk_that_is("full"))

    def test_the_daemon_starts_on_a_read_only_disk_after_a_kill(self):
        self.assertIn("Read-only file system", self.restarts_on_a_disk_that_is("read-only"))

    def test_a_job_that_cannot_be_claimed_stays_in_the_queue_and_is_tried_again(self):
        daemon = self.printing_daemon()
        self.becomes("printing-read-only")
        for name in ("one", "two"):
            daemon.drop(name + ".stl", SMALL)
        daemon.wait_status("queued", 2)
        daemon.cancel("first")
        status = daemon.wait_status("waiting_for")
        self.assertEqual(status["queued"], 2)
        self.assertIn("one.stl cannot be claimed", status["waiting_for"])
        for name in ("three", "four"):  # each arrival makes the daemon try the first job again
            daemon.drop(name + ".stl", SMALL)
        daemon.wait_status("queued", 4)
        self.assertEqual(daemon.log().count("cannot be claimed"), 1, daemon.log())
        self.is_repaired("printing-read-only")
        daemon.begin("five.stl", SMALL)
        self.assertEqual(daemon.status()["job"]["name"], "one")
        self.assertIsNone(daemon.status()["waiting_for"])
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], ["two.stl", "three.stl", "four.stl", "five.stl"])

    def test_a_print_goes_on_if_incoming_is_removed_and_cannot_be_made_again(self):
        daemon = self.printing_daemon()
        self.becomes("read-only")
        os.rmdir(daemon.file("incoming"))
        wait_until(lambda: "incoming folder" in daemon.log(), "the warning")
        self.assertEqual(daemon.status()["state"], "exposing")
        self.is_repaired("read-only")
        wait_until(lambda: daemon.has("incoming"), "the new incoming folder")
        daemon.drop("next.stl", SMALL)
        daemon.wait_status("queued", 1)
        self.assertEqual(daemon.log().count("incoming folder"), 1)


class TicketOfTwoModels(SpoolTest):
    """NAME.json together with NAME.stl and NAME.STL."""

    TICKET = b'{"layer_height_um": 100}'  # 10 layers

    def test_both_models_are_printed_with_the_ticket(self):
        daemon = self.daemon()
        for name in ("part.json", "part.stl", "part.STL"):
            daemon.drop(name, self.TICKET if name.endswith("json") else SMALL)
        daemon.start()
        self.assertEqual([daemon.wait_done(job)["layers"] for job in ("part", "part-2")], [10, 10])
        for job in ("part", "part-2"):
            self.assertEqual(daemon.read("done", job + ".json"), self.TICKET.decode())
        self.assertEqual(daemon.names_in("incoming"), [])

    def test_the_ticket_is_kept_for_the_second_model_if_the_first_is_refused(self):
        daemon = self.printing_daemon()
        for name, data in (("part.json", self.TICKET), ("part.STL", b"no model"), ("part.stl", SMALL)):
            daemon.drop(name, data)
        daemon.wait_refused("part")
        self.assertTrue(daemon.has("failed", "part.json"))
        daemon.rpc("cancel")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["layers"], 10)
        daemon.cancel("part-2")

    def test_a_ticket_that_is_a_fifo_refuses_a_model_and_the_next_job_is_printed(self):
        daemon = self.daemon()
        for name in ("part.stl", "part.STL"):
            daemon.drop(name, SMALL)
        os.mkfifo(daemon.file("incoming", "part.json"))
        daemon.start()
        daemon.wait_refused("part")
        daemon.printed("next.stl", SMALL)


class ReplacedFolders(SpoolTest):
    WATCHED = "the new folder is watched"

    def put(self, daemon, name, data=SMALL, folder="incoming"):
        self.write(daemon.file(folder, name), data)

    def printed(self, daemon, name):
        self.put(daemon, name + ".stl")
        return daemon.wait_done(name)

    def mount_over_incoming(self, daemon):
        os.makedirs(daemon.file("incoming"), exist_ok=True)
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "none", daemon.file("incoming")], check=False).returncode != 0:
            self.skipTest("nothing can be mounted here")
        self.addCleanup(subprocess.run, ["umount", "-q", daemon.file("incoming")], check=False)

    def stopped_while_it_reads(self, daemon, meanwhile=lambda: None):
        """Stops the daemon while it prepares big.stl, which has a ticket."""
        large = self.path("large.stl")
        self.assertEqual(run(MAKE_MODEL, "gyroid-sphere", large, "120").returncode, 0)
        daemon.start()
        data = contents(large)
        self.put(daemon, "big.json", b"{}")
        self.put(daemon, "big.stl", data)
        daemon.wait_status("state", "preparing")
        meanwhile()
        self.assertEqual(daemon.status()["state"], "preparing", "the model is read too fast for this test")
        daemon.stop()

    def test_an_incoming_folder_that_was_replaced_by_a_rename_is_watched(self):
        daemon = self.daemon().start()
        os.mkdir(daemon.file("other"))
        os.rename(daemon.file("incoming"), daemon.file("old"))
        os.rename(daemon.file("other"), daemon.file("incoming"))
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")
        self.put(daemon, "late.stl", folder="old")
        self.printed(daemon, "next")
        self.assertTrue(daemon.has("old", "late.stl"))

    def test_jobs_of_the_old_folder_leave_the_queue_and_jobs_of_the_new_one_arrive(self):
        daemon = self.printing_daemon()
        daemon.drop("old.stl", SMALL)
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["old.stl"], "the job in the queue")
        os.mkdir(daemon.file("other"))
        self.put(daemon, "new.stl", folder="other")
        os.rename(daemon.file("incoming"), daemon.file("before"))
        os.rename(daemon.file("other"), daemon.file("incoming"))
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["new.stl"], "only the new folder's job in the queue")
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_jobs_that_were_removed_while_events_were_lost_leave_the_queue(self):
        daemon = self.printing_daemon()
        daemon.drop("waits.stl", SMALL)
        os.mkdir(daemon.file("incoming", "plate"))
        self.put(daemon, "plate.json", json.dumps({"models": [{"file": "part.stl"}]}).encode(), "incoming/plate")
        wait_until(lambda: "plate" in daemon.status()["incomplete"] and daemon.status()["queued"] == 1, "the job and the plate to wait")
        with open("/proc/sys/fs/inotify/max_queued_events", encoding="ascii") as file:
            most = int(file.read())
        os.kill(daemon.process.pid, signal.SIGSTOP)
        for _ in range(most // 3 + 1):  # one event each for creation, closing and removal
            self.put(daemon, "noise", b"")
            os.unlink(daemon.file("incoming", "noise"))
        os.unlink(daemon.file("incoming", "waits.stl"))
        os.rename(daemon.file("incoming", "plate"), daemon.file("plate"))
        self.put(daemon, "new.stl")
        os.kill(daemon.process.pid, signal.SIGCONT)
        wait_until(lambda: daemon.rpc("queue")["result"]["queue"] == ["new.stl"], "only the new job in the queue")
        wait_until(lambda: not daemon.status()["incomplete"], "the plate to be removed")

    def test_a_spool_that_was_replaced_is_locked_and_watched(self):
        daemon = self.daemon().start()
        os.rename(daemon.spool, daemon.spool + ".old")
        os.mkdir(daemon.spool)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")
        second = self.second_daemon("second", {"spool_folder": "spool"})
        second.launch()
        self.assertNotEqual(second.process.wait(), 0)
        self.assertIn("another contourd uses the spool", second.log())

    def test_a_print_whose_spool_was_replaced_ends_and_the_queue_goes_on(self):
        daemon = self.printing_daemon()
        os.rename(daemon.spool, daemon.spool + ".old")
        os.mkdir(daemon.spool)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.assertEqual(daemon.status()["state"], "exposing")
        daemon.cancel("first")
        self.put(daemon, "next.stl")
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "next")
        self.assertTrue(os.path.exists(os.path.join(daemon.spool + ".old", "printing", "first.stl")))

    def test_a_spool_of_another_daemon_is_left_to_it(self):
        daemon = self.daemon().start()
        os.mkdir(self.path("others"))
        with open(self.path("others", ".lock"), "wb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            os.rename(daemon.spool, daemon.spool + ".old")
            os.rename(self.path("others"), daemon.spool)
            wait_until(lambda: "another contourd uses the spool" in daemon.log(), "the warning")
            self.assertEqual(daemon.log().count("nothing arrives"), 1)
            self.assertNotIn(self.WATCHED, daemon.log())
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.printed(daemon, "part")

    def test_a_mount_over_incoming_is_watched_and_after_unmounting_the_folder_below_it(self):
        daemon = self.daemon().start()
        self.mount_over_incoming(daemon)
        wait_until(lambda: self.WATCHED in daemon.log(), "the new folder to be watched")
        self.assertEqual(self.printed(daemon, "part")["layers"], 20)
        self.assertEqual(daemon.names_in("incoming"), [])  # even though nothing can be moved to another file system
        self.put(daemon, "bad.stl", b"no model")
        daemon.wait_refused("bad")
        subprocess.run(["umount", daemon.file("incoming")], check=True)
        wait_until(lambda: daemon.log().count(self.WATCHED) == 2, "the old folder to be watched again")
        self.printed(daemon, "under")

    def test_a_job_that_has_not_begun_returns_to_a_mounted_incoming_folder(self):
        daemon = self.daemon()
        self.mount_over_incoming(daemon)
        self.stopped_while_it_reads(daemon)
        self.assertEqual(daemon.names_in("incoming"), ["big.json", "big.stl"])
        self.assertEqual(daemon.names_in("printing"), [])

    def test_a_job_that_returns_to_incoming_does_not_overwrite_another_job(self):
        daemon = self.daemon()
        self.stopped_while_it_reads(daemon, lambda: self.put(daemon, "big.stl"))
        self.assertEqual(daemon.names_in("incoming"), ["big-2.json", "big-2.stl", "big.stl"])


class Plate(SpoolTest):
    def test_the_next_job_waits_until_the_plate_is_cleared(self):
        daemon = self.daemon(WAITS).start()
        daemon.drop("one.stl", SMALL)
        daemon.drop("two.stl", SMALL)
        daemon.wait_done("one")
        status = daemon.wait_status("waiting_for")
        self.assertEqual((status["plate"], status["plate_job"], status["queued"]), ("occupied", "one", 1))
        self.assertIn("plate-cleared", status["waiting_for"])
        self.assertEqual(daemon.names_in("incoming"), ["two.stl"])
        self.assertNotIn("error", daemon.rpc("plate_cleared"))
        daemon.wait_done("two")
        self.assertIsNone(daemon.status()["waiting_for"])

    def test_a_restart_does_not_clear_the_plate(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("one.stl", SMALL)
        for end in (daemon.stop, daemon.kill):
            end()
            daemon.drop("two.stl", SMALL)
            daemon.start()
            status = daemon.wait_status("waiting_for")
            self.assertEqual((status["plate_job"], status["queued"]), ("one", 1))
            self.assertEqual(daemon.names_in("incoming"), ["two.stl"])
        daemon.rpc("plate_cleared")
        daemon.wait_done("two")
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], "two")

    def test_a_cleared_plate_stays_clear_after_a_restart(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("one.stl", SMALL)
        daemon.rpc("plate_cleared")
        daemon.kill()
        daemon.start()
        self.assertEqual(daemon.status()["plate"], "clear")
        daemon.printed("two.stl", SMALL)

    def test_a_refused_job_leaves_the_plate_clear(self):
        daemon = self.daemon(WAITS).start()
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.status()["plate"], "clear")
        daemon.printed("good.stl", SMALL)

    def test_with_an_empty_queue_the_status_shows_no_wait(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("one.stl", SMALL)
        daemon.drop("two.stl", SMALL)
        daemon.wait_status("waiting_for")
        os.unlink(daemon.file("incoming", "two.stl"))
        daemon.wait_status("queued", 0)
        self.assertIsNone(daemon.status()["waiting_for"])
        daemon.rpc("plate_cleared")
        self.assertIsNone(daemon.status()["waiting_for"])


class Interruption(SpoolTest):
    def test_a_killed_print_is_found_in_failed_at_the_next_start(self):
        daemon = self.printing_daemon(**WAITS)
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.kill()
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        daemon.start()
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertIn("first.stl", daemon.names_in("failed"))
        self.assertIn("interrupted", daemon.read("failed", "first.reason.txt"))
        status = daemon.status()
        self.assertEqual((status["state"], status["plate"], status["plate_job"]), ("idle", "occupied", "first"))
        daemon.drop("next.stl", SMALL)
        daemon.wait_status("waiting_for")
        daemon.rpc("plate_cleared")
        daemon.wait_state("exposing")

    def next_waits_after(self, end):
        """Asserts that the next job does not begin after a restart until the user resumes, even if no plate must be cleared."""
        daemon = self.printing_daemon()
        daemon.drop("next.stl", SMALL)
        # Waits until the job has been read, since a kill during the reading would have it refused.
        wait_until(lambda: [job["state"] for job in daemon.rpc("queue")["result"]["jobs"]] == ["ready"], "a job in the queue")
        end(daemon)
        for _ in range(2):
            daemon.start()
            status = wait_until(lambda: (lambda s: s if s["queued"] or s["job"] else None)(daemon.status()), "the next job")
            self.looks_pass(daemon, "empty")
            self.assertEqual((status["state"], status["plate_job"]), ("idle", "first"))
            self.assertIn("first", status["held"])
            self.assertEqual(daemon.names_in("incoming"), ["next.stl"])
            for name in daemon.names_in("failed"):
                if name.startswith("empty"):
                    os.unlink(daemon.file("failed", name))
            daemon.stop()
        daemon.start()
        self.assertNotIn("error", daemon.rpc("resume"))
        daemon.wait_state("exposing")
        self.assertEqual(daemon.status()["job"]["name"], "next")
        daemon.stop()

    def test_after_a_killed_print_the_next_job_waits_until_the_user_resumes(self):
        self.next_waits_after(lambda daemon: daemon.kill())

    def test_after_a_print_that_ended_with_the_daemon_s_stop_the_next_job_waits_until_the_user_resumes(self):
        self.next_waits_after(lambda daemon: daemon.stop())

    def test_a_killed_print_keeps_its_ticket(self):
        daemon = self.printing_daemon()
        daemon.rpc("cancel")
        daemon.begin("second.stl", SMALL, {"copies": 2})
        daemon.kill()
        daemon.start()
        self.assertTrue(daemon.has("failed", "second.stl"))
        self.assertEqual(json.loads(daemon.read("failed", "second.json")), {"copies": 2})

    def end_by_signal(self, number):
        daemon = self.printing_daemon(**WAITS)
        daemon.process.send_signal(number)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertIn("light off", daemon.log().splitlines()[-1])
        self.assertFalse(os.path.exists(daemon.socket_path))
        self.assertEqual(daemon.names_in("printing"), [])
        self.assertIn("stopped", daemon.read("failed", "first.reason.txt"))
        report = daemon.report("first", "failed")
        self.assertEqual(report["outcome"], "failed")
        self.assertIn("stopped", report["reason"])
        daemon.start()
        return daemon

    def test_sigterm_ends_a_print_with_the_light_off_and_a_restart_works(self):
        daemon = self.end_by_signal(signal.SIGTERM)
        daemon.rpc("plate_cleared")
        daemon.begin("next.stl", SMALL)
        self.assertEqual(daemon.status()["job"]["name"], "next")

    def test_sigint_ends_a_print_with_the_light_off(self):
        self.end_by_signal(signal.SIGINT).stop()

    def test_a_print_stopped_in_its_first_exposure_leaves_the_plate_occupied(self):
        # The layer was exposed in part, so something may stick to the plate.
        daemon = self.end_by_signal(signal.SIGTERM)
        self.assertEqual(daemon.status()["plate"], "occupied")

    def test_a_print_cancelled_in_its_first_exposure_leaves_the_plate_occupied(self):
        daemon = self.printing_daemon(**WAITS)
        daemon.cancel("first")
        self.assertEqual(daemon.status()["plate"], "occupied")

    def test_a_job_that_fails_before_its_first_exposure_does_not_clear_the_plate(self):
        daemon = self.daemon().start()
        daemon.printed("one.stl", SMALL)
        daemon.stop()
        daemon.config["simulation"]["limit_switch"] = "stuck_open"
        daemon.write_config()
        daemon.start()
        daemon.refused("two.stl", SMALL)
        status = daemon.status()
        self.assertEqual((status["plate"], status["plate_job"]), ("occupied", "one"))

    def test_a_job_that_is_being_read_at_sigterm_is_printed_at_the_next_start(self):
        large = self.path("large.stl")
        self.assertEqual(run(MAKE_MODEL, "gyroid-sphere", large, "120").returncode, 0)
        daemon = self.daemon(WAITS).start()
        os.rename(large, daemon.file("incoming", "large.stl"))
        wait_until(lambda: daemon.has("printing", "large.stl"), "the job to be claimed")
        self.assertEqual(daemon.status()["state"], "preparing", "the model is read too fast for this test")
        daemon.stop()
        os.replace(self.write("small", SMALL), os.fsencode(daemon.file(
            "incoming" if daemon.has("incoming", "large.stl") else "printing", "large.stl")))  # fmt: skip
        daemon.start()
        self.assertFalse(daemon.has("failed", "large.stl"), "nothing was printed, yet it counts as interrupted")
        daemon.wait_done("large")

    def test_a_job_whose_ticket_alone_was_claimed_before_a_power_cut_keeps_its_ticket(self):
        # A claim renames two files. The power was cut in between.
        daemon = self.daemon()
        daemon.drop("part.stl", SMALL, {"copies": 3})
        os.makedirs(daemon.file("printing"))
        os.rename(daemon.file("incoming", "part.json"), daemon.file("printing", "part.json"))
        daemon.start()
        end = daemon.wait_next_end()
        if end["outcome"] == "done":
            self.assertEqual(daemon.report(end["job"])["model"]["copies"], 3)

    def test_a_job_whose_ticket_was_not_claimed_yet_keeps_its_ticket(self):
        # The model was claimed before its ticket. A ticket that is younger than the claim belongs to another job.
        daemon = self.daemon()
        for name in ("part", "other"):
            daemon.drop(name + ".stl", SMALL, {"copies": 3} if name == "part" else None)
            os.makedirs(daemon.file("printing"), exist_ok=True)
            os.rename(daemon.file("incoming", name + ".stl"), daemon.file("printing", name + ".stl"))
        self.write(os.path.relpath(daemon.file("incoming", "other.json"), self.path()), b"{}")
        daemon.start()
        self.assertTrue(daemon.has("failed", "part.json"))
        self.assertFalse(daemon.has("failed", "other.json"))
        self.assertEqual(daemon.names_in("incoming"), ["other.json"])

    def test_a_filed_job_gets_its_ticket_that_was_not_filed_yet(self):
        daemon = self.daemon()
        for folder in ("done", "failed"):
            daemon.drop(folder + ".stl", SMALL, {"copies": 3})
            os.makedirs(daemon.file(folder), exist_ok=True)
            os.makedirs(daemon.file("printing"), exist_ok=True)
            os.rename(daemon.file("incoming", folder + ".stl"), daemon.file(folder, folder + ".stl"))
            os.rename(daemon.file("incoming", folder + ".json"), daemon.file("printing", folder + ".json"))
        daemon.start()
        for folder in ("done", "failed"):
            self.assertEqual(daemon.names_in(folder), [folder + ".json", folder + ".stl"])

    def test_a_refused_job_is_filed_with_a_reason_that_was_written_earlier(self):
        daemon = self.daemon().start()
        self.write(os.path.relpath(daemon.file("failed", "bad.reason.txt"), self.path()), b"not a usable model")
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.names_in("failed"), ["bad.reason.txt", "bad.stl"])

    def test_a_second_daemon_does_not_touch_the_print_of_the_first(self):
        daemon = self.printing_daemon()
        second = run(CONTOURD, "--config", daemon.config_path)
        self.assertNotEqual(second.returncode, 0)
        self.assert_one_line(second.stderr.splitlines(keepends=True)[-1], "another contourd")
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        self.assertEqual(daemon.names_in("failed"), [])
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_a_second_daemon_with_another_socket_does_not_touch_the_spool_of_the_first(self):
        daemon = self.printing_daemon()
        other = self.path("other.json")
        self.write(other, json.dumps({**daemon.config, "control_socket": "other.sock"}))
        second = Daemon(self)
        second.config_path = other
        second.socket_path = self.path("other.sock")
        second.log_path = self.path("other.log")
        second.launch()
        # The second daemon must end because the spool is in use, without touching the print.
        wait_until(lambda: second.process.poll() is not None or os.path.exists(second.socket_path), "the second daemon to end or answer")
        self.assertEqual(daemon.names_in("printing"), ["first.stl"])
        self.assertNotEqual(second.process.poll() or 0, 0)
