"""contourctl offer: takes models from an untrusted folder, such as a USB stick."""

import json
import os
import shutil
import socket
import stat
import subprocess
import unittest

from harness import (
    BAD_DATA, BAD_USAGE, CANNOT_CREATE, CONTOURCTL, NO_INPUT, OK, SMALL, SOURCE, UNAVAILABLE, Daemon, FolderTest, contents, contourctl, limit_memory,
)  # fmt: skip

MOST = 20  # models in one run
UNIT = os.path.join(SOURCE, "systemd", "contourd-usb@.service")


class OfferTest(FolderTest):
    def setUp(self):
        super().setUp()
        for folder in ("incoming", "printing", "done", "failed"):
            os.makedirs(self.path("spool", folder))
        os.mkdir(self.path("stick"))

    def put(self, name, data=SMALL):
        path = os.path.join(os.fsencode(self.path("stick")), os.fsencode(name))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        self.write(path, data)
        return path

    def offer(self, *arguments, **options):
        return contourctl("offer", self.path("stick"), "--spool", self.path("spool"), *arguments, **options)

    def once(self, label="a"):
        return self.offer("--once", self.path("taken"), "--label", label)

    def taken(self, result, code=OK):
        self.assertEqual(result.returncode, code, result)
        return [line.split(": job ")[1] for line in result.stdout.decode().splitlines() if ": job " in line]

    def incoming(self):
        return sorted(os.listdir(self.path("spool", "incoming")))


class Offer(OfferTest):
    def test_models_are_taken_with_the_tickets_beside_them(self):
        self.put("part.stl")
        self.put("part.json", b'{"copies":  2}')
        self.put("below/and below/Deep.STL")
        self.put("note.txt", b"no model")
        self.put("lonely.json", b"{}")
        result = self.offer()
        self.assertEqual(self.taken(result), ["Deep", "part"])
        self.assertEqual(result.stderr, b"")
        self.assertEqual(self.incoming(), ["Deep.stl", "part.json", "part.stl"])
        self.assertEqual(contents(self.path("spool", "incoming", "part.json")), b'{"copies":  2}')
        self.assertTrue(os.stat(self.path("spool", "incoming", "Deep.stl")).st_mode & stat.S_IRGRP)

    def test_contourd_prints_an_offered_model(self):
        daemon = Daemon(self).start()
        self.put("part.stl")
        result = daemon.ctl("offer", self.path("stick"), "--json")
        self.assertEqual(json.loads(result.stdout), {"file": "part.stl", "job": "part"})
        daemon.wait_done("part")

    def test_a_taken_file_is_not_taken_again_unless_it_has_changed(self):
        first, second = self.put("first.stl"), self.put("second.stl")
        self.assertEqual(self.taken(self.once()), ["first", "second"])
        result = self.once()
        self.assertEqual(self.taken(result), [])
        self.assertEqual(result.stdout, b"nothing to take; 2 were taken before\n")
        os.utime(first, (1, 1))
        os.rename(second, os.path.join(os.path.dirname(second), b"third.stl"))
        self.assertEqual(self.taken(self.once()), ["first-2", "third"])
        self.put("third.json", b'{"copies": 2}')
        self.assertEqual(self.taken(self.once()), ["third-2"])
        # Files on another stick count as other files.
        self.assertEqual(len(self.taken(self.once("b"))), 2)
        self.assertEqual(self.taken(self.once("b")), [])

    def test_a_file_that_was_not_taken_is_tried_again(self):
        self.put("part.stl", b"no model")
        self.assertEqual(self.taken(self.once(), BAD_DATA), [])
        self.put("part.stl")
        self.assertEqual(self.taken(self.once()), ["part"])

    def test_at_most_20_models_are_taken_at_a_time(self):
        for number in range(MOST + 5):
            self.put(f"part{number:02}.stl")
        result = self.once()
        self.assertEqual(self.taken(result, BAD_DATA), [f"part{number:02}" for number in range(MOST)])
        self.assert_one_line(result.stderr, "20 models are taken at a time")
        self.assertEqual(self.taken(self.once()), [f"part{number:02}" for number in range(MOST, MOST + 5)])

    def test_hidden_and_deleted_files_are_ignored(self):
        for name in (".hidden.stl", "._part.stl", ".Trash-1000/part.stl", "$RECYCLE.BIN/part.stl", "a/b/c/too deep.stl"):
            self.put(name)
        result = self.offer()
        self.assertEqual((self.taken(result), result.stderr), ([], b""))

    def test_links_are_not_followed_and_special_files_do_not_block(self):
        stick = self.path("stick")
        os.symlink("/etc/shadow", f"{stick}/shadow.stl")
        self.put("secret", SMALL)
        os.symlink("secret", f"{stick}/inside.stl")
        os.symlink("/etc", f"{stick}/etc")
        os.makedirs(self.path("outside"))
        self.write("outside/part.stl", SMALL)
        os.symlink("../outside", f"{stick}/folder")
        os.symlink("/proc/self/fd/0", f"{stick}/magic.stl")
        os.mkfifo(f"{stick}/fifo.stl")
        os.mkdir(f"{stick}/folder.stl")
        listening = socket.socket(socket.AF_UNIX)
        self.addCleanup(listening.close)
        listening.bind(f"{stick}/socket.stl")
        self.put("good.stl")
        os.symlink("/etc/passwd", f"{stick}/good.json")
        self.put("other.stl")
        result = self.offer()
        self.assertEqual(self.taken(result, BAD_DATA), ["other"])
        errors = result.stderr.decode().splitlines()
        for name in ("shadow", "inside", "magic"):
            self.assertIn(f'contourctl: "{name}.stl" is not taken: it is a symbolic link', errors)
        for name in ("fifo", "socket", "good"):
            self.assertEqual(sum(f'"{name}.stl" is not taken' in line for line in errors), 1, errors)
        self.assertEqual(len(errors), 6)
        self.assertEqual(self.incoming(), ["other.stl"])

    def test_job_names_get_no_control_characters(self):
        names = [b"new\nline.stl", b"\x1b[2Jescape.stl", b"-o option.stl", b"bytes \xff.stl", b"a" * 251 + b".stl", "Bär.stl".encode()]
        for name in names:
            self.put(name)
        result = self.offer()
        jobs = self.taken(result)
        self.assertEqual(sorted(jobs), sorted(["new_line", "_[2Jescape", "_o option", "bytes \ufffd", "a" * 200, "Bär"]))
        self.assertEqual(len(self.incoming()), len(names))
        self.assertNotIn(b"\x1b", result.stdout)
        self.assertEqual(len(result.stdout.splitlines()), len(names))

    def test_a_file_that_is_no_model_is_an_error_and_the_others_are_taken(self):
        self.put("a.stl", b"no model")
        self.put("b.stl", b"")
        self.put("c.stl")
        self.put("d.stl")
        self.put("d.json", b" " * (1 << 20) + b"{}")
        result = self.offer()
        self.assertEqual(self.taken(result, BAD_DATA), ["c"])
        self.assertEqual(len(result.stderr.splitlines()), 3)
        self.assertEqual(self.incoming(), ["c.stl"])

    def test_models_of_other_formats_are_reported_and_the_others_are_taken(self):
        for name in ("part.stl", "cat.PLY", "below/dog.step", "old.ctb", "all.7z", "photo.jpg", ".hidden.obj"):
            self.put(name)
        result = self.offer()
        self.assertEqual(self.taken(result, BAD_DATA), ["part"])
        lines = result.stderr.decode().splitlines()
        self.assertEqual(len(lines), 4, lines)
        for name, advice in (("all.7z", "extract"), ("below/dog.step", "export"), ("cat.PLY", "export"), ("old.ctb", "the model itself")):
            self.assertTrue(any(name in line and advice in line for line in lines), (name, lines))

    def test_a_huge_file_is_not_read(self):
        with open(self.put("sparse.stl", SMALL[:84]), "r+b") as file:
            file.truncate(200 << 30)
        result = self.offer()
        self.assertEqual(self.taken(result, BAD_DATA), [])
        self.assert_one_line(result.stderr, '"sparse.stl" is not taken', "214748364800")

    def test_only_some_of_a_hundred_thousand_files_are_looked_at(self):
        model = self.put("0.stl")
        for number in range(1, 100_000):
            os.link(model, self.path("stick", f"{number}.stl")) if number < 60_000 else os.mkfifo(self.path("stick", f"{number}.stl"))
        result = subprocess.run([CONTOURCTL, "offer", self.path("stick"), "--spool", self.path("spool")], capture_output=True,
                                check=False, preexec_fn=lambda: limit_memory(200 << 20))  # fmt: skip
        self.assertLessEqual(len(self.taken(result, BAD_DATA)), MOST)
        self.assertLess(len(result.stderr.splitlines()), 40)
        self.assertIn(b"20000 names", result.stderr)

    def test_a_missing_spool_or_folder_is_an_error(self):
        self.put("part.stl")
        for arguments, code, word in (
            (["offer", self.path("none"), "--spool", self.path("spool")], NO_INPUT, "none"),
            (["offer", self.path("stick", "part.stl"), "--spool", self.path("spool")], NO_INPUT, "part.stl"),
            (["offer", self.path("stick"), "--spool", self.path("none")], CANNOT_CREATE, "none/incoming"),
            (["offer", self.path("stick"), "--socket", self.path("none")], UNAVAILABLE, "cannot reach contourd"),
        ):
            with self.subTest(arguments):
                self.assert_refusal(contourctl(*arguments), code, word)
        # The model is submitted before the record is written.
        result = contourctl("offer", self.path("stick"), "--spool", self.path("spool"), "--once", self.path("none", "taken"), expect=CANNOT_CREATE)
        self.assert_one_line(result.stderr, "none/taken")
        self.assertEqual(contourctl("offer", self.path("stick"), "--label", "x").returncode, BAD_USAGE)

    def test_a_damaged_record_is_started_again(self):
        self.put("part.stl")
        for record in (b"", b"\0\xff" * 5000, b"\n" * 100_000, b"x" * 1_000_000):
            self.write("taken", record)
            self.assertEqual(len(self.taken(self.once())), 1)
            self.assertEqual(self.taken(self.once()), [])
        self.assertLess(os.path.getsize(self.path("taken")), 2_000_000)


class UnitTest(unittest.TestCase):
    def test_the_unit_may_write_only_to_the_spool_and_its_record_and_has_limits(self):
        with open(UNIT, encoding="utf-8") as file:
            lines = [line.strip() for line in file]
        for line in ("ProtectSystem=strict", "ReadWritePaths=/var/spool/contourd/incoming /var/lib/contourd-usb", "PrivateMounts=yes",
                     "DevicePolicy=closed", "DeviceAllow=/dev/%I r", "BindsTo=dev-%i.device", "NoNewPrivileges=yes"):  # fmt: skip
            self.assertIn(line, lines)
        # RestrictSUIDSGID would block openat2(2).
        self.assertFalse(any(line.startswith("RestrictSUIDSGID=") for line in lines))
        for limit in ("TimeoutStartSec", "MemoryMax", "TasksMax", "LimitFSIZE"):
            self.assertTrue(any(line.startswith(limit + "=") for line in lines), limit)

    def test_the_rule_names_the_alias_of_the_enabled_unit(self):
        with open(os.path.join(SOURCE, "systemd/70-contourd-usb.rules"), encoding="utf-8") as rules, open(UNIT, encoding="utf-8") as unit:
            [alias] = [line.strip().removeprefix("Alias=") for line in unit if line.startswith("Alias=")]
            self.assertIn(alias.replace("@", "@%k"), rules.read())

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed")
    def test_systemd_accepts_the_unit(self):
        checked = subprocess.run(["systemd-analyze", "verify", "--man=no", UNIT], capture_output=True, text=True, check=False)
        complaints = [line for line in checked.stderr.splitlines() if "contourd" in line and "not executable" not in line]
        self.assertEqual(complaints, [])
