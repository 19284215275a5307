"""The spool: how files that are put into incoming/ arrive, wait, are printed or refused, and end in done/ or failed/."""

import json
import os
import socket
import time
import unittest

from harness import (
    CONTOURCTL, NIMBLE_RESIN, SANITIZED, SLAB, SLOWNESS, WAITS, SpoolTest, ascii_stl, binary_stl, box, contents, cube, run, source_json, wait_until,
)  # fmt: skip


class Arrival(SpoolTest):
    def test_missing_folders_are_created(self):
        daemon = self.daemon({"spool_folder": "deep/er/spool"})
        daemon.start()
        for name in ("incoming", "printing", "done", "failed"):
            self.assertTrue(os.path.isdir(self.path("deep", "er", "spool", name)), name)

    def test_a_file_moved_copied_or_linked_in_is_printed_and_ends_in_done(self):
        daemon = self.daemon().start()
        report = daemon.printed("part.stl", SLAB)
        self.assertEqual((report["outcome"], report["layers"], report["layers_exposed"]), ("done", 20, 20))
        self.assertEqual(daemon.names_in("done"), ["part.preview.png", "part.report.html", "part.report.json", "part.stl"])
        self.assertEqual(contents(daemon.file("done", "part.stl")), SLAB)
        self.write(daemon.file("incoming", "copied.stl"), SLAB)
        daemon.wait_done("copied")
        original = self.write("original.stl", SLAB)
        os.link(original, os.fsencode(daemon.file("incoming", "linked.stl")))
        daemon.wait_done("linked")
        self.assertEqual(contents(original), SLAB)
        # An extension in upper case is a model's, too.
        daemon.drop("LOUD.STL", SLAB, {"copies": 2})
        daemon.drop("mixed.StL", ascii_stl(cube(2)))
        self.assertEqual(daemon.wait_done("LOUD")["model"]["copies"], 2)
        self.assertEqual(daemon.wait_done("mixed")["model"]["format"], "ascii")
        for folder in ("incoming", "printing", "failed"):
            self.assertEqual(daemon.names_in(folder), [], folder)

    def test_a_file_is_read_once_it_is_complete_and_other_files_are_left_alone(self):
        daemon = self.daemon().start()
        later, touched = (daemon.file("incoming", name) for name in ("later.stl", "touched.stl"))
        self.write(later, b"")
        made = time.monotonic()
        others = [".hidden.stl", "notes.txt", "part.stl.part", "part.step", "stl", ".stl", "orphan.json"]
        for name in others:
            daemon.drop(name, SLAB)
        with open(daemon.file("incoming", "slow.stl"), "wb", buffering=0) as file:
            for start in range(0, len(SLAB), 200):
                file.write(SLAB[start : start + 200])
            # An empty file is refused after three seconds, three looks; this one is filled after two. The test is about time, so
            # there is no event to wait for.
            wait_until(lambda: time.monotonic() >= made + 2, "two looks")
            self.write(later, SLAB)
            self.assertEqual(daemon.wait_done("later")["layers"], 20)
            self.write(daemon.file("incoming", "empty.stl"), b"")
            self.assertIn("empty", daemon.wait_refused("empty"))
            # The server of a network share opens a file several times between its creation and its first byte.
            for _ in range(10):
                open(touched, "ab").close()
                daemon.status()  # once it answers, the daemon has seen the events
            # slow.stl has its full size now, but is still open, so it is not complete however often the daemon looks.
            self.assertEqual(daemon.names_in("incoming"), sorted([*others, "slow.stl", "touched.stl"]))
            self.assertEqual(daemon.status()["queued"], 0)
        self.assertEqual(daemon.wait_done("slow")["layers"], 20)
        self.write(touched, SLAB)
        self.assertEqual(daemon.wait_done("touched")["layers"], 20)
        self.assertEqual(daemon.names_in("incoming"), sorted(others))

    def test_files_from_before_the_start_are_printed_oldest_first(self):
        daemon = self.daemon()
        names = ["m", "z", "a", "k"]
        for name in names:
            daemon.drop(name + ".stl", SLAB)
        daemon.start()
        ended = daemon.wait_outcomes(dict.fromkeys(names, "done"))
        self.assertEqual(ended, names)

    def test_jobs_are_printed_in_order_of_arrival_and_refused_before_their_turn(self):
        daemon = self.printing_daemon()
        names = ["c", "a", "d", "b"]
        for name in names:
            daemon.drop(name + ".stl", SLAB)
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.status()["state"], "exposing")
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], [name + ".stl" for name in names])
        for following in names:
            daemon.rpc("cancel")
            daemon.wait_state("exposing")
            self.assertEqual(daemon.status()["job"]["name"], following)

    def test_a_queued_file_that_is_withdrawn_replaced_or_being_overwritten_is_printed_as_it_is_at_its_turn(self):
        larger = binary_stl(box((0, 0, 0), (10, 5, 2)))
        daemon = self.printing_daemon()
        for name in ("withdrawn.stl", "replaced.stl", "overwritten.stl"):
            daemon.drop(name, SLAB)
        daemon.wait_status("queued", 3)
        os.rename(daemon.file("incoming", "withdrawn.stl"), self.path("taken.stl"))
        daemon.wait_status("queued", 2)
        daemon.drop("replaced.stl", larger)
        daemon.rpc("cancel")
        daemon.wait_state("exposing")
        job = daemon.status()["job"]
        self.assertEqual((job["name"], job["layers"]), ("replaced", 40))
        with open(daemon.file("incoming", "overwritten.stl"), "wb", buffering=0) as file:
            file.write(larger[:300])
            daemon.cancel("replaced")
            self.looks_pass(daemon)
            self.assertEqual(daemon.names_in("incoming"), ["overwritten.stl"])
            self.assertFalse(daemon.has("failed", "overwritten.stl"))
            file.write(larger[300:])
        daemon.wait_state("exposing")
        job = daemon.status()["job"]
        self.assertEqual((job["name"], job["layers"]), ("overwritten", 40))

    def test_none_of_many_files_at_once_is_lost(self):
        daemon = self.daemon().start()
        tiny = binary_stl(box((0, 0, 0), (2, 2, 0.1)))
        names = [f"part{number}" for number in range(60)]
        for name in names:
            daemon.drop(name + ".stl", tiny if int(name[4:]) % 3 else b"no model, number " + name.encode())
        outcomes = {name: "done" if int(name[4:]) % 3 else "failed" for name in names}
        daemon.wait_outcomes(outcomes)
        for name, outcome in outcomes.items():
            self.assertTrue(daemon.has(outcome, name + ".stl"), name)



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
        self.printer.printed("good.stl", SLAB)


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
        self.printer.write_resin("clear", {})
        tickets = {
            "syntax": ("{",),
            "empty": ("",),
            "list": ("[]",),
            "type": ({"copies": "two"}, "/copies"),
            "fraction": ({"copies": 1.5}, "/copies"),
            "many": ({"copies": 0, "scale": -1, "colour": "red", "rotation_deg": {"x": 999}}, "/copies", "/scale", "colour", "/rotation_deg/x"),
            "both": ({"scale": 2, "fit": True},),
            "twice": ('{"copies": 1, "copies": 2}',),
            "nan": ('{"scale": NaN}',),
            "huge": ('{"scale": 1e999}',),
            "deep": ("[" * 100000,),
            "deep2": ('{"scale": ' + "[" * 100000 + "]" * 100000 + "}",),
            "notutf8": (b'{"resin": "\xff\xfe"}',),
            "large": (b'{"resin": "' + b"x" * (2 << 20) + b'"}',),
            "path": ({"resin": "../standard"},),
            "outside": ({"layer_height_um": 400},),
            "unknown": ({"resin": "gold"}, "gold", "standard", "clear"),
        }
        for name, (ticket, *words) in tickets.items():
            with self.subTest(name):
                reason = self.refused(name + ".stl", SLAB, ticket, *words)
                self.assertLess(len(reason), 2000)

    def test_a_model_as_large_as_the_machine_is_printed_and_unprintable_ones_are_refused_with_the_reason(self):
        self.printer.printed("full.stl", binary_stl(box((0, 0, 0), (96, 54, 1))))
        for name, data, ticket, *words in (
            ("wide", binary_stl(box((0, 0, 0), (97, 10, 10))), None, "97", "96"),
            ("deep", binary_stl(box((0, 0, 0), (10, 55, 10))), None, "55", "54"),
            ("tall", binary_stl(box((0, 0, 0), (10, 10, 157))), None, "157", "156.5"),
            ("beside", SLAB, {"position_mm": {"x": 44, "y": 0}}, "44"),
            ("many", binary_stl(box((0, 0, 0), (30, 30, 1))), {"copies": 100}, "100"),
            ("flat", binary_stl([((0, 0, 5), (9, 0, 5), (0, 9, 5))]), None, "flat"),
            ("none", binary_stl([]), None, "no facets"),
            ("thin", binary_stl(box((0, 0, 0), (9, 9, 1e-5))), None),
            ("cut", SLAB[:-20], None, "cut short"),
            ("junk", b"MZ" + bytes(1000), None),
            ("text", b"solid\nhello\n", None, "line 2"),
        ):
            with self.subTest(name):
                self.refused(name + ".stl", data, ticket, *words)

    def test_names_that_were_used_before_get_numbers(self):
        for folder, data, jobs in (("done", SLAB, ("part", "part-2", "part-3")), ("failed", b"no model", ("part-4", "part-5"))):
            for job in jobs:
                self.printer.drop("part.stl", data)
                self.assertEqual(self.printer.wait_ended(job)["outcome"], folder)
            for job in jobs:
                self.assertTrue(self.printer.has(folder, job + ".stl"))

    def test_a_job_named_like_another_job_s_report_overwrites_nothing(self):
        self.printer.printed("part.stl", SLAB)
        before = self.printer.read("done", "part.report.json")
        self.printer.drop("part.report.stl", SLAB, {"copies": 2})
        self.printer.wait_next_end()
        self.assertEqual(self.printer.read("done", "part.report.json"), before)

    def test_odd_names_are_printed_or_refused_like_any_other(self):
        names = ["two words", "new\nline", "percent %s {} {0}", "<img src=x onerror=alert(1)>", "Geräte-部品", "-dash", "--",
                 "'\"`$(x)", "a.b.c", "tab\there", "trailing ", "back\\slash"]  # fmt: skip
        for name in names:
            with self.subTest(name):
                self.printer.printed(name + ".stl", SLAB)
                self.assertNotIn("<img src=x", self.printer.read("done", name + ".report.html"))
                self.printer.drop(name + "x.stl", b"no model")
                self.printer.wait_refused(name + "x")

    def test_a_file_whose_name_is_not_utf_8_is_printed(self):
        path = os.path.join(os.fsencode(self.printer.file("incoming")), b"\xff\xfe\x80.stl")
        os.rename(self.write("staging", SLAB), path)
        end = self.printer.wait_next_end()
        self.assertEqual(end["outcome"], "done")
        self.assertIn(b"\xff\xfe\x80.stl", os.listdir(os.fsencode(self.printer.file("done"))))

    def test_names_about_as_long_as_possible_are_handled_like_any_other(self):
        # A name has at most 255 bytes, so the files of a job with such a name need shorter names.
        for length in (255, 250, 240):
            for data, folder, suffix in ((SLAB, "done", "report.json"), (b"no model", "failed", "reason.txt")):
                with self.subTest(length=length, folder=folder):
                    before = self.printer.names_in(folder)
                    self.printer.drop("n" * (length - 4) + ".stl", data)
                    self.assertEqual(self.printer.wait_next_end()["outcome"], folder)
                    self.assertEqual(self.printer.names_in("incoming") + self.printer.names_in("printing"), [])
                    names = [name for name in self.printer.names_in(folder) if name not in before]
                    for ending in (suffix, ".stl"):
                        self.assertEqual(len([name for name in names if name.endswith(ending)]), 1, names)



class NotAFile(RefusingTest):
    """Entries of incoming/ that have a model's name, but are no regular files."""

    def test_a_folder_a_fifo_a_socket_or_a_link_to_nothing_does_not_stop_the_next_job(self):
        os.mkdir(self.printer.file("incoming", "folder.stl"))
        os.mkfifo(self.printer.file("incoming", "fifo.stl"))
        self.assertIn("regular file", self.printer.wait_refused("fifo"))
        os.symlink("nowhere", self.printer.file("incoming", "dangling.stl"))
        self.printer.wait_refused("dangling")
        self.assertTrue(os.path.islink(self.printer.file("failed", "dangling.stl")))
        with socket.socket(socket.AF_UNIX) as endpoint:
            endpoint.bind(self.path("s"))
            os.rename(self.path("s"), self.printer.file("incoming", "socket.stl"))
        self.printer.wait_refused("socket")

    def test_a_link_to_a_model_or_ticket_is_refused_and_its_target_is_not_read(self):
        original = self.write("original.stl", SLAB)
        ticket = self.write("original.json", b'{"secret": 1}')
        for name, target in (("absolute", os.fsdecode(original)), ("relative", "../../original.stl")):
            os.symlink(target, self.printer.file("incoming", name + ".stl"))
            self.assertIn("it is a symbolic link", self.printer.wait_refused(name))
        os.symlink(ticket, os.fsencode(self.printer.file("incoming", "ticket.json")))
        reason = self.printer.refused("ticket.stl", SLAB)
        self.assertIn("it is a symbolic link", reason)
        self.assertNotIn("secret", reason)
        self.assertEqual(contents(original), SLAB)

    def test_a_link_in_a_plate_is_refused(self):
        self.write("original.stl", SLAB)
        os.mkdir(self.path("linked"))
        os.symlink("../../../original.stl", self.path("linked", "part.stl"))
        self.write("linked/plate.json", json.dumps({"models": [{"file": "part.stl"}]}))
        os.rename(self.path("linked"), self.printer.file("incoming", "linked"))
        self.assertIn("it is a symbolic link", self.printer.wait_refused("linked"))

    def test_a_ticket_that_is_no_file_refuses_the_job(self):
        os.mkfifo(self.printer.file("incoming", "fifo.json"))
        self.printer.refused("fifo.stl", SLAB)
        os.mkdir(self.printer.file("incoming", "folder.json"))
        self.printer.refused("folder.stl", SLAB)
        os.symlink("nowhere", self.printer.file("incoming", "link.json"))
        self.printer.refused("link.stl", SLAB)

    @unittest.skipIf(os.geteuid() == 0, "permissions do not stop root")
    def test_a_file_that_cannot_be_read_is_refused(self):
        path = self.write("secret", SLAB)
        os.chmod(path, 0)
        os.rename(path, os.fsencode(self.printer.file("incoming", "secret.stl")))
        self.assertIn("ermission", self.printer.wait_refused("secret"))


class TicketOfTwoModels(SpoolTest):
    """NAME.json together with NAME.stl and NAME.STL."""

    TICKET = b'{"layer_height_um": 100}'  # 10 layers

    def test_both_models_are_printed_with_the_ticket(self):
        daemon = self.daemon()
        for name in ("part.json", "part.stl", "part.STL"):
            daemon.drop(name, self.TICKET if name.endswith("json") else SLAB)
        daemon.start()
        self.assertEqual([daemon.wait_done(job)["layers"] for job in ("part", "part-2")], [10, 10])
        for job in ("part", "part-2"):
            self.assertEqual(daemon.read("done", job + ".json"), self.TICKET.decode())
        self.assertEqual(daemon.names_in("incoming"), [])

    def test_the_ticket_is_kept_for_the_second_model_if_the_first_is_refused(self):
        daemon = self.printing_daemon()
        for name, data in (("part.json", self.TICKET), ("part.STL", b"no model"), ("part.stl", SLAB)):
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
            daemon.drop(name, SLAB)
        os.mkfifo(daemon.file("incoming", "part.json"))
        daemon.start()
        daemon.wait_refused("part")
        daemon.printed("next.stl", SLAB)


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
            daemon.printed(f"good{odd}.stl", SLAB)
            daemon.drop(f"bad{odd}.stl", f"solid {odd}\nfacet {odd}\n{odd}".encode())
            daemon.wait_ended(f"bad{odd}")
            self.assert_harmless(daemon.ctl("status").stdout, "status")
            self.assert_harmless(daemon.ctl("status", "--json").stdout, "status as JSON")
            daemon.drop_plate(f"plate{odd}", {"models": [{"file": f"{odd}.stl"}], odd: 1}, {f"{odd}.stl": SLAB})
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
            daemon.drop(f"good{odd}.stl", SLAB)
            self.assertEqual(daemon.wait_ended(f"good{odd}")["outcome"], "failed")
            self.assert_harmless(daemon.read("failed", f"good{odd}.reason.txt"), "reason")
        self.assert_harmless(daemon.log(), "log")


class IgnoredFiles(SpoolTest):
    """Files in incoming/ that will never be printed."""

    def listed(self, daemon, *names):
        return wait_until(lambda: (lambda s: s if set(s["ignored"]) == set(names) else None)(daemon.status()), names)

    def test_unprintable_files_are_logged_once_and_listed_until_they_are_removed(self):
        daemon = self.daemon()
        os.makedirs(daemon.file("incoming"))
        self.write("spool/incoming/before.step", b"there before the start")
        daemon.start()
        files = {"before.step": "STL", "part.ply": "STL", "part.glb": "STL", "sliced.gcode": "sliced", "part.ctb": "sliced", "notes": "NAME.stl"}
        for name in files:
            if name != "before.step":
                daemon.drop(name, b"something")
        os.mkdir(daemon.file("incoming", "folder"))
        self.write("spool/incoming/folder/part.stl", SLAB)
        os.symlink("part.ply", daemon.file("incoming", "link"))
        # These files may be part of a job, so they are not listed.
        for name in ("ticket.json", ".hidden.ply", "part.stl.part", "other.3mf.crdownload"):
            daemon.drop(name, b"{}")
        # A file that soon gets its right name is not listed either.
        daemon.drop("upload", SLAB)
        os.rename(daemon.file("incoming", "upload"), daemon.file("incoming", "renamed.stl"))
        daemon.wait_done("renamed")
        status = self.listed(daemon, *files, "folder", "link")
        for name, word in files.items():
            self.assertIn(word, status["ignored"][name])
        self.assertIn("plate.json", status["ignored"]["folder"])
        self.assertEqual((status["ignored_more"], status["queued"]), (0, 0))
        shown = daemon.ctl("status").stdout.decode()
        for name in (*files, "folder", "link"):
            self.assertIn(f"ignored   {name} in incoming: ", shown)
            self.assertEqual(daemon.log().count(f"{name}: is ignored"), 1)
        self.assertEqual(len(daemon.names_in("incoming")), 12)
        # Each file is logged once, even if others change.
        daemon.printed("good.stl", SLAB)
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
            self.write(f"spool/incoming/{number}\x1b\n.ply", b"something")
        status = wait_until(lambda: (lambda s: s if s["ignored_more"] == 990 else None)(daemon.status()), "all files to be counted")
        self.assertEqual(len(status["ignored"]), 10)
        wait_until(lambda: "more in incoming are ignored" in daemon.log(), "the summary in the log")
        self.assertLess(daemon.log().count("ignored"), 40)
        self.assertNotIn(b"\x1b", daemon.ctl("status").stdout)
        daemon.printed("good.stl", SLAB)


class ManyAndLong(SpoolTest):
    def test_a_ticket_with_tens_of_thousands_of_mistakes_has_a_short_reason(self):
        daemon = self.daemon().start()
        reason = daemon.refused("long.stl", SLAB, "{" + ",".join(f'"{number}":1' for number in range(80000)) + "}")
        self.assertLess(len(reason), 10000)
        self.assertRegex(reason, r"; and at least 9[89]\d more\n$")
        # Sixty nested objects with keys of a thousand bytes.
        nested = "".join('{"' + "k" * 1000 + '":' for _ in range(60)) + "1" + "}" * 60
        self.assertLess(len(daemon.refused("deep.stl", SLAB, nested)), 10000)
        self.assertLess(len(daemon.log()), 50000)

    def test_answers_list_the_first_of_many_names_and_count_the_rest(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("first.stl", SLAB)
        for number in range(60):
            os.mkdir(daemon.file("incoming", f"folder{number}"))
        for number in range(1060):
            daemon.drop(f"part{number}.stl", SLAB)
        status = wait_until(lambda: (lambda s: s if s["queued"] == 1060 and s["incomplete_more"] == 50 else None)(daemon.status()), "all files to be counted")
        self.assertEqual(len(status["incomplete"]), 10)
        queue = daemon.rpc("queue")["result"]
        self.assertEqual((len(queue["queue"]), queue["more"]), (1000, 60))
        self.assertIn(b"and 60 more", daemon.ctl("queue").stdout)


class Plate(SpoolTest):
    def test_the_next_job_waits_until_the_plate_is_cleared(self):
        daemon = self.daemon(WAITS).start()
        daemon.refused("bad.stl", b"no model")
        self.assertEqual(daemon.status()["plate"], "clear")  # nothing was printed
        daemon.drop("one.stl", SLAB)
        daemon.drop("two.stl", SLAB)
        daemon.wait_done("one")
        status = daemon.wait_status("waiting_for")
        self.assertEqual((status["plate"], status["plate_job"], status["queued"]), ("occupied", "one", 1))
        self.assertIn("plate-cleared", status["waiting_for"])
        self.assertEqual(daemon.names_in("incoming"), ["two.stl"])
        # With an empty queue the status shows no wait.
        os.rename(daemon.file("incoming", "two.stl"), self.path("two.stl"))
        self.assertIsNone(daemon.wait_status("queued", 0)["waiting_for"])
        os.rename(self.path("two.stl"), daemon.file("incoming", "two.stl"))
        daemon.wait_status("waiting_for")
        self.assertNotIn("error", daemon.rpc("plate_cleared"))
        daemon.wait_done("two")
        self.assertIsNone(daemon.status()["waiting_for"])
        # A cleared plate stays clear after a restart.
        daemon.rpc("plate_cleared")
        self.assertIsNone(daemon.status()["waiting_for"])
        daemon.kill()
        daemon.start()
        self.assertEqual(daemon.status()["plate"], "clear")
        daemon.printed("three.stl", SLAB)

    def test_a_restart_does_not_clear_the_plate(self):
        daemon = self.daemon(WAITS).start()
        daemon.printed("one.stl", SLAB)
        for end in (daemon.stop, daemon.kill):
            end()
            daemon.drop("two.stl", SLAB)
            daemon.start()
            status = daemon.wait_status("waiting_for")
            self.assertEqual((status["plate_job"], status["queued"]), ("one", 1))
            self.assertEqual(daemon.names_in("incoming"), ["two.stl"])
        daemon.rpc("plate_cleared")
        daemon.wait_done("two")
        daemon.restart()
        self.assertEqual(daemon.status()["plate_job"], "two")



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
        daemon.drop_plate("plate", {"models": [{"file": "part.stl"}]}, {"part.stl": tall})
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
        daemon.drop("next.stl", SLAB)
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
                daemon.drop("one.stl", SLAB)
                daemon.drop("two.stl", SLAB, {"resin": "standard"})
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
        daemon.drop("part.stl", SLAB, {"resin": "tough"})
        self.waits_for(daemon, "tough", "tough.json", "/lift_mm")
        # Once the file is removed, the other jobs continue.
        os.unlink(daemon.file("incoming", "part.stl"))
        daemon.printed("other.stl", SLAB)
        self.assertEqual(daemon.names_in("failed"), [])

    def test_a_profile_that_breaks_or_vanishes_while_jobs_wait_gives_a_warning_and_refuses_none(self):
        daemon = self.printing_daemon()
        daemon.write_resin("tough", NIMBLE_RESIN)
        daemon.drop("checked.stl", SLAB, {"resin": "tough"})
        daemon.refused("bad.stl", b"no model")  # by then the job before it has been checked
        os.unlink(self.path("resins", "tough.json"))
        self.break_resin("standard")
        daemon.drop("late.stl", SLAB)
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
        daemon.drop("part.stl", SLAB)
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
        report = daemon.printed("part.stl", SLAB)
        self.assertEqual((report["resin"], report["settings"]["exposure_ms"]), ("standard", 3000))
        daemon.restart()
        self.assertEqual(daemon.printed("again.stl", SLAB)["resin"], "tough")
