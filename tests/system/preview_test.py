"""contourctl preview: pictures of models, jobs and layers, as PNG files and on terminals."""

import contextlib
import fcntl
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import termios
import time
import unittest

from harness import (
    BAD_CONFIG, BAD_DATA, BAD_USAGE, BIN, CANNOT_CREATE, CONTOURCTL, DEADLINE_S, NO_INPUT, OK, SANITIZED, UNAVAILABLE, Daemon, FolderTest, Picture,
    ascii_stl, binary_stl, box, contents, contourctl, read_png, text_of, wait_until, wedge,
)  # fmt: skip

INSTALLED = "/etc/contourd/contourd.json"
SMALL = binary_stl(box((0, 0, 0), (4, 2, 1)))  # 20 layers
WEDGE = binary_stl(wedge(8, 4, 2))
COLORLESS = {"NO_COLOR": None, "COLORTERM": None, "TERM": "xterm"}
SGR = re.compile(rb"\x1b\[[0-9;]*m")
# A display whose whole mask fits on a terminal.
DISPLAY = {"display": {"width_px": 192, "height_px": 108, "pixel_pitch_um": 100}}


def decode_half_blocks(data):
    """Returns the picture that lines of half blocks with true colours show."""
    rows = []
    for line in data.decode().splitlines():
        upper, lower, colors = bytearray(), bytearray(), {}
        for ground, red, green, blue, character in re.findall("\x1b\\[([34]8);2;(\\d+);(\\d+);(\\d+)m|([ \u2580])", line):
            if ground:
                assert red == green == blue, line
                colors[ground] = int(red)
            else:
                lower.append(colors.get("48", 0))
                upper.append(colors["38"] if character == "\u2580" else lower[-1])
        rows += [bytes(upper), bytes(lower)] if "48" in colors else [bytes(upper)]
    return Picture(len(rows[0]), len(rows), rows)


def light(grey):
    value = grey / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def grey_of(light_):
    return 255 * (light_ * 12.92 if light_ <= 0.0031308 else 1.055 * light_ ** (1 / 2.4) - 0.055)


def resized(picture, left, top, right, bottom, width, height):
    """Returns the rows of a part of the picture, resized to width x height; each pixel has the mean light of the area it covers."""
    def weights(size, count):
        for i in range(count):
            begin, end = i * size / count, (i + 1) * size / count
            yield [(each, min(end, each + 1) - max(begin, each)) for each in range(int(begin), min(size, int(end) + 1))]
    columns, rows = list(weights(right - left, width)), list(weights(bottom - top, height))
    area = (right - left) / width * (bottom - top) / height
    return [[grey_of(sum(light(picture.rows[top + y][left + x]) * wy * wx for y, wy in ys for x, wx in xs) / area)
             for xs in columns] for ys in rows]  # fmt: skip


class PreviewTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.home = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, self.home)

    def printer(self, **config):
        """Returns the path of a printer's configuration without a running daemon."""
        return Daemon(self, {**DISPLAY, **config}).config_path

    def spool(self, **jobs):
        """Makes a spool. `jobs` is a dictionary from folder to {job: (model, ticket or None)}."""
        for folder in ("incoming", "printing", "done", "failed"):
            os.makedirs(self.path("spool", folder), exist_ok=True)
            for name, (model, ticket) in jobs.get(folder, {}).items():
                self.write(os.path.join(b"spool", folder.encode(), os.fsencode(name) + b".stl"), model)
                if ticket is not None:
                    self.write(os.path.join(b"spool", folder.encode(), os.fsencode(name) + b".json"), ticket)
        return self.path("spool")

    def png(self, *arguments, **options):
        """Returns the picture that contourctl preview writes."""
        output = self.path("out.png")
        result = contourctl("preview", *arguments, "-o", output, **options)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (OK, b"", b""), result)
        return read_png(output)

    def drawn(self, *arguments):
        """Returns the lines that contourctl preview writes into a pipe."""
        result = contourctl("preview", *arguments)
        self.assertEqual((result.returncode, result.stderr), (OK, b""), result)
        self.assertNotIn(b"\x1b", result.stdout)
        lines = result.stdout.decode().splitlines()
        self.assertTrue(all(len(line) <= 80 for line in lines), lines)
        return lines


class Pictures(PreviewTest):
    def test_a_job_looks_like_its_file_turned_by_its_ticket_and_a_layer_is_the_mask_that_was_shown(self):
        daemon = Daemon(self, masks=True).start()
        shaded = {}
        for name, ticket in (("plain", None), ("turned", b'{"rotation_deg": {"x": 30}, "scale": 2}')):
            with self.subTest(name):
                daemon.printed(name + ".stl", WEDGE, ticket)
                as_printed = ["--socket", daemon.socket_path, "--printer", daemon.config_path]
                shaded[name] = self.png(name, *as_printed)
                self.assertGreaterEqual(len(shaded[name].values()), 3)  # black, and two faces in different light
                for number in (1, 17, daemon.report(name)["layers"]):
                    shown = read_png(self.path("masks", name, f"{number:04}.png"))
                    self.assertEqual(self.png(name, "--layer", str(number), *as_printed), shown)
        daemon.stop()
        # A file needs neither a daemon nor a printer.
        self.write("w.stl", WEDGE)
        self.assertEqual(self.png("w.stl"), shaded["plain"])
        self.assertNotEqual(shaded["turned"], shaded["plain"])

    def test_a_job_is_found_in_every_folder_of_the_spool(self):
        spool = self.spool(incoming={"a": (SMALL, None)}, printing={"b": (WEDGE, None)}, done={"c": (SMALL, None)},
                           failed={"d": (WEDGE, None)})  # fmt: skip
        for name, folder in (("a", "incoming"), ("b", "printing"), ("c", "done"), ("d", "failed"), ("a.stl", "incoming")):
            lines = self.drawn(name, "--spool", spool)
            size = "4 x 2 x 1" if name[0] in "ac" else "8 x 4 x 2"
            self.assertEqual(lines[0].split(" facets")[0].rsplit(" ", 1)[0], f"{name[0]}, in {folder}: {size} mm,")
            self.assertTrue(any("\u2592" in line for line in lines))
        self.assert_refusal(contourctl("preview", "e", "--spool", spool), NO_INPUT, 'neither a file nor a job', '"e"')
        for hostile in ("..", ".", "", "x" * 300, "a\n"):
            self.assertNotEqual(contourctl("preview", hostile, "--spool", spool).returncode, OK)

    def test_a_waiting_job_is_preferred_and_others_of_its_name_are_mentioned(self):
        spool = self.spool(incoming={"a": (SMALL, None)}, done={"a": (WEDGE, None)}, failed={"a": (WEDGE, None)})
        self.assertIn("a, in incoming (there is another in done and in failed): 4 x 2 x 1 mm", self.drawn("a", "--spool", spool)[0])
        # The path of a job's model is that of a file.
        self.assertIn("a.stl: 8 x 4 x 2 mm", self.drawn("spool/done/a.stl")[0])

    def test_two_files_of_one_job_name_are_distinguished_by_their_file_names(self):
        spool = self.spool(incoming={"a": (SMALL, None)})
        self.write("spool/incoming/a.STL", WEDGE)
        self.assert_refusal(contourctl("preview", "a", "--spool", spool), BAD_USAGE, 'more than one job in incoming is called "a"', '"a.STL", "a.stl"')
        self.assertIn("8 x 4 x 2 mm", self.drawn("a.STL", "--spool", spool)[0])

    def test_a_file_is_preferred_to_a_job_and_a_folder_is_not(self):
        spool = self.spool(incoming={"part": (SMALL, None), "other": (SMALL, None)})
        self.write("part", WEDGE)
        os.mkdir("other")
        self.assertIn("part: 8 x 4 x 2 mm", self.drawn("part", "--spool", spool)[0])
        self.assertIn("other, in incoming: 4 x 2 x 1 mm", self.drawn("other", "--spool", spool)[0])

    def test_control_characters_in_names_are_replaced(self):
        spool = self.spool(incoming={"b\x1b[31m": (SMALL, None), "B\u00e4r-\u90e8\u54c1" * 9: (SMALL, None)})
        self.assertIn("b?[31m, in incoming", self.drawn("b?[31m", "--spool", spool)[0])
        self.drawn("B\u00e4r-\u90e8\u54c1" * 9, "--spool", spool)
        self.write(b"c\x1b[31m\xff.stl", SMALL)
        self.assertIn("c?[31m", self.drawn(b"c\x1b[31m\xff.stl")[0])

    def test_a_job_is_shown_according_to_its_ticket(self):
        ticket = b'{"copies": 3, "scale": 2, "up": {"x": 1}, "layer_height_um": 100}'
        spool = self.spool(incoming={"a": (SMALL, ticket)})
        as_printed = ["--spool", spool, "--printer", self.printer()]
        self.assertIn("a, in incoming: 3 of 2 x 4 x 8 mm, layers 80 of 100 um", self.drawn("a", *as_printed)[0])
        # Three copies are wider than one.
        three = self.png("a", *as_printed).lit_box()
        alone = self.png(self.write("one.stl", SMALL), "--ticket", self.write("one", ticket.replace(b"3", b"1", 1)), *as_printed[2:]).lit_box()
        self.assertGreater(three[2] - three[0], 1.5 * (alone[2] - alone[0]))
        mask = self.png("a", "--layer", "80", *as_printed)
        middle = mask.rows[mask.lit_box()[1] + 1]
        self.assertEqual(len(re.findall(rb"[^\0]+", middle)), 3)
        self.assertEqual(sum(map(bool, middle)), 3 * 20)  # 2 mm at 0.1 mm
        # A file with the same ticket has the same mask.
        file, given = self.write("a.stl", SMALL), self.write("t", ticket)
        self.assertEqual(self.png(file, "--layer", "80", "--ticket", given, *as_printed[2:]), mask)
        self.assert_refusal(contourctl("preview", "a", "--ticket", given, *as_printed), BAD_USAGE, "--ticket needs a model")
        self.assert_refusal(contourctl("preview", file, "--ticket", self.write("bad", b"{"), *as_printed[2:]), BAD_DATA, "ticket")

    def test_a_plate_is_shown_with_all_its_models(self):
        spool = self.spool()
        os.makedirs(self.path("spool", "incoming", "two"))
        self.write("spool/incoming/two/a.stl", SMALL)
        self.write("spool/incoming/two/b.stl", WEDGE)
        self.write("spool/incoming/two/plate.json", '{"models": [{"file": "a.stl", "copies": 2}, {"file": "b.stl"}]}')
        as_printed = ["--spool", spool, "--printer", self.printer()]
        self.assertIn("two, in incoming: 3 models, 2 mm high, layers 40 of 50 um", self.drawn("two", *as_printed)[0])
        self.assertGreater(self.png("two", "--layer", "1", *as_printed).lit_box()[2], 0)

    def test_the_error_about_a_missing_layer_names_the_number_of_layers(self):
        model = self.write("a.stl", SMALL)
        for number in ("21", "10000000"):
            self.assert_refusal(contourctl("preview", model, "--layer", number, "--printer", self.printer()), BAD_USAGE,
                         f"there is no layer {number} of a.stl: it has 20")  # fmt: skip
        for number in ("0", "-1", "1.5", "x", "", "99999999999999999999"):
            self.assertEqual(contourctl("preview", model, "--layer", number, "--printer", self.printer()).returncode, BAD_USAGE)

    @unittest.skipIf(os.path.exists(INSTALLED), "contourd is installed")
    def test_without_a_configuration_the_error_names_the_option_that_needs_one(self):
        model, ticket = self.write("a.stl", SMALL), self.write("a.json", "{}")
        self.assert_refusal(contourctl("preview", model, "--layer", "1"), BAD_USAGE, "--layer needs a printer's configuration", INSTALLED)
        self.assert_refusal(contourctl("preview", model, "--ticket", ticket), BAD_USAGE, "a ticket needs a printer's configuration")
        self.assert_refusal(contourctl("preview", model, "--layer", "1", "--printer", self.path("none")), BAD_CONFIG, "none")
        self.drawn(model)
        self.drawn("a", "--spool", self.spool(incoming={"a": (SMALL, None)}))

    def test_a_refused_job_is_shown_like_its_file_with_the_reason_as_a_warning(self):
        high = binary_stl(box((0, 0, 0), (4, 2, 500)))
        spool = self.spool(failed={"high": (high, b"{}"), "odd": (SMALL, b'{"copis": 2}')})
        for name, why in (("high", "500.00 mm high"), ("odd", "copis")):
            result = contourctl("preview", name, "--spool", spool, "--printer", self.printer())
            self.assertEqual(result.returncode, OK, result)
            self.assert_one_line(result.stderr, "contourctl: warning: the model is drawn as in its file: ", why)
            self.assertIn("facets", result.stdout.decode().splitlines()[0])
            self.assert_refusal(contourctl("preview", name, "--layer", "1", "--spool", spool, "--printer", self.printer()), BAD_DATA, why)

    def test_without_a_daemon_the_error_says_how_to_find_a_job(self):
        self.assert_refusal(contourctl("preview", "part", "--socket", self.path("none")), UNAVAILABLE,
                     'there is no file "part"', "cannot reach contourd", "--spool")  # fmt: skip
        self.assert_refusal(contourctl("preview", "./part.stl", "--socket", self.path("none")), NO_INPUT, "./part.stl")
        self.assert_refusal(contourctl("preview", "part", "--spool", self.path("none")), NO_INPUT, "none/incoming")

    def test_a_daemon_that_does_not_name_its_spool_is_an_error(self):
        path = self.path("s")
        for answer in (b'{"id":1,"result":{"spool":""}}\n', b'{"id":1,"error":{}}\n', b""):
            with self.subTest(answer), socket.socket(socket.AF_UNIX) as server:
                server.bind(path)
                server.listen()
                with subprocess.Popen([CONTOURCTL, "preview", "part", "--socket", path], stdout=subprocess.PIPE,
                                      stderr=subprocess.PIPE) as asking:  # fmt: skip
                    connection, _ = server.accept()
                    with connection:
                        connection.recv(4096)
                        connection.sendall(answer)
                    out, why = asking.communicate(timeout=DEADLINE_S)
                os.unlink(path)
                self.assertEqual((asking.returncode, out), (UNAVAILABLE, b""), why)
                self.assert_one_line(why, 'there is no file "part"', "--spool")

    def test_a_file_that_is_no_model_is_refused_as_by_the_other_commands(self):
        os.mkfifo("fifo.stl")
        os.mkdir("folder.stl")
        self.write("empty.stl", b"")
        self.write("text.stl", b"hello\n" * 100)
        self.write("nothing.stl", ascii_stl([]))
        self.assert_refusal(contourctl("preview", "nothing.stl"), BAD_DATA, "nothing.stl: the file holds no facets")
        self.write("nan.stl", ascii_stl(box((0, 0, 0), (1, 1, 1))).replace(b"vertex 1", b"vertex nan"))
        for name in ("fifo.stl", "folder.stl", "/dev/zero", "/dev/null", "none.stl", "empty.stl", "text.stl", "nan.stl"):
            with self.subTest(name):
                name = name if name.startswith("/") else "./" + name
                mine, other = contourctl("preview", name), contourctl("inspect", name)
                self.assert_refusal(mine, other.returncode, name)
                self.assertIn(mine.returncode, (BAD_DATA, NO_INPUT))

    def test_it_says_so_if_there_is_nothing_to_see(self):
        self.write("point.stl", binary_stl(box((1, 1, 1), (1, 1, 1))))
        self.assertEqual(self.drawn("point.stl"), ["point.stl: 0 x 0 x 0 mm, 12 facets", "nothing is visible"])
        self.png("point.stl")
        # A layer between two parts, one above the other.
        self.write("gap.stl", binary_stl(box((0, 0, 0), (4, 4, 0.5)) + box((0, 0, 1), (4, 4, 2))))
        self.assertEqual(self.drawn("gap.stl", "--layer", "15", "--printer", self.printer()),
                         ["gap.stl: layer 15 of 40, 0.700 to 0.750 mm, 0.00 mm²", "nothing is lit"])  # fmt: skip

    @unittest.skipIf(SANITIZED, "AddressSanitizer must be loaded first")
    def test_a_job_that_is_moved_meanwhile_is_found_in_its_new_folder(self):
        spool = self.spool(incoming={"a": (SMALL, None)})
        os.mkdir("slow")
        self.write("slow/models", b"")  # opening a model waits while this file exists (slow_disk.cpp)
        slow = {**os.environ, "LD_PRELOAD": os.path.join(BIN, "libslow-disk.so"), "SLOW_DISK": self.path("slow")}
        with subprocess.Popen([CONTOURCTL, "preview", "a", "--spool", spool], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              env=slow) as process:  # fmt: skip
            wait_until(lambda: os.path.exists("slow/waiting"), "the model to be opened")
            os.rename(self.path("spool", "incoming", "a.stl"), self.path("spool", "done", "a.stl"))
            os.unlink("slow/models")
            out, why = process.communicate(timeout=DEADLINE_S)
        self.assertEqual((process.returncode, why), (OK, b""))
        self.assertIn(b"a, in done: 4 x 2 x 1 mm", out)

    def test_a_model_that_does_not_fit_into_memory_is_not_read(self):
        with open("large.stl", "wb") as file:
            file.write(b"\0" * 80 + struct.pack("<I", 2_000_000_000))
            file.truncate(84 + 50 * 2_000_000_000)
        self.assert_refusal(contourctl("preview", "large.stl"), BAD_DATA, "large.stl", "memory")
        self.spool()
        os.rename("large.stl", "spool/incoming/large.stl")
        self.assert_refusal(contourctl("preview", "large", "--spool", "spool"), BAD_DATA, "large.stl", "memory")

    def test_a_link_in_the_spool_is_refused(self):
        self.spool()
        os.symlink(self.write("secret.stl", SMALL), self.path("spool", "incoming", "a.stl"))
        self.assert_refusal(contourctl("preview", "a", "--spool", "spool"), BAD_DATA, "symbolic link")


class Output(PreviewTest):
    def test_standard_output_gets_the_same_picture(self):
        model = self.write("a.stl", SMALL)
        result = contourctl("preview", model, "-o", "-")
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        self.png(model)
        self.assertEqual(result.stdout, contents("out.png"))
        with open("/dev/full", "wb") as full:
            self.assertEqual(contourctl("preview", model, "-o", "-", stdout=full).returncode, CANNOT_CREATE)
            self.assertEqual(contourctl("preview", model, stdout=full).returncode, CANNOT_CREATE)

    def test_an_existing_file_is_replaced_completely_or_kept(self):
        model = self.write("a.stl", SMALL)
        self.write("old.png", b"old")
        os.link("old.png", "kept")
        os.symlink("old.png", "link.png")
        contourctl("preview", model, "-o", "link.png")
        self.assertTrue(os.path.islink("link.png"))
        self.assertEqual(read_png("old.png").width, 720)
        self.assertEqual(contents("kept"), b"old")  # the old file has been replaced, not written into
        before = sorted(os.listdir())
        os.mkfifo("fifo")
        os.mkdir("folder")
        os.symlink("nothing", "dangling")
        for output in ("fifo", "folder", "folder/", "dangling", "/dev/null", "/dev/stdout", "no/where.png", "old.png/x"):
            self.assert_refusal(contourctl("preview", model, "-o", output), CANNOT_CREATE, output)
        self.assertTrue(os.path.exists("/dev/null") and not os.path.isfile("/dev/null"))
        self.assertEqual(sorted(set(os.listdir()) - {"fifo", "folder", "dangling"}), before)
        self.assert_refusal(contourctl("preview", self.write("bad.stl", b"x"), "-o", "old.png"), BAD_DATA)
        self.assertEqual(read_png("old.png").width, 720)

    def test_the_model_is_not_overwritten(self):
        model, ticket = self.write("a.stl", SMALL), self.write("t.json", b"{}")
        os.link("a.stl", "same.png")
        spool = self.spool(incoming={"j": (SMALL, None)})
        for arguments in (["a.stl", "-o", "a.stl"], ["a.stl", "-o", "./same.png"], ["a.stl", "--ticket", ticket, "-o", "t.json"],
                          ["j", "--spool", spool, "-o", "spool/incoming/j.stl"]):  # fmt: skip
            self.assert_refusal(contourctl("preview", *arguments), BAD_USAGE, "the output would replace the model or its ticket")
        self.assertEqual(contents(model), SMALL)

    def test_an_interrupted_preview_leaves_no_file(self):
        # Interrupts a little later each time, from the start of the program to its end.
        model = self.write("a.stl", binary_stl(wedge(8, 4, 2) * 500))
        before, begin = sorted(os.listdir()), time.monotonic()
        self.png(model)
        whole, steps = time.monotonic() - begin, 25
        for delay in [whole * step / steps for step in range(steps)]:
            with contextlib.suppress(FileNotFoundError):
                os.unlink("out.png")
            with subprocess.Popen([CONTOURCTL, "preview", model, "-o", "out.png"]) as process:
                time.sleep(delay)
                process.send_signal(signal.SIGINT)
                code = process.wait(DEADLINE_S)
            self.assertIn(code, (OK, -signal.SIGINT))
            there = sorted(set(os.listdir()) - {"out.png"})
            self.assertEqual(there, before)
            if os.path.exists("out.png"):
                self.assertEqual(read_png("out.png").width, 720)
            self.assertTrue(code != OK or os.path.exists("out.png"))


class OnTerminal(PreviewTest):
    def start(self, *arguments, size=(80, 24), typed=b"", controlling=True, **environment):
        columns, rows = size
        self.ours, self.its = pty.openpty()
        for end in (self.ours, self.its):
            self.addCleanup(os.close, end)
        fcntl.ioctl(self.ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.modes = termios.tcgetattr(self.its)
        os.write(self.ours, typed)
        variables = {**os.environ, **COLORLESS, **environment}
        # By default the program is in the foreground of a new session on this terminal. A program that is to be stopped needs
        # a process group that is not orphaned.
        group = {"start_new_session": True, "preexec_fn": lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0)}
        self.process = subprocess.Popen(
            [CONTOURCTL, "preview", *map(os.fspath, arguments)], stdin=self.its, stdout=self.its, stderr=self.its,
            env={k: v for k, v in variables.items() if v is not None}, **(group if controlling else {"process_group": 0}))  # fmt: skip
        self.addCleanup(self.process.wait)
        self.addCleanup(self.process.kill)

    def read(self, until=None):
        """Returns the program's output until it ends, or until `until` has been received."""
        data = b""
        while True:
            if select.select([self.ours], [], [], 0.02)[0]:
                data += os.read(self.ours, 65536)
            elif self.process.poll() is not None:
                return data
            if until and until in data:
                return data

    def shown(self, *arguments, code=OK, **options):
        """Returns the text on the terminal, and asserts that the terminal's modes have been restored."""
        self.start(*arguments, **options)
        data = self.read()
        self.assertEqual(self.process.returncode, code, data)
        self.assertEqual(termios.tcgetattr(self.its), self.modes)
        return data.replace(b"\r\n", b"\n")

    def left_to_read(self):
        """Returns the input that the next program on this terminal would read."""
        modes = termios.tcgetattr(self.its)
        modes[3] &= ~(termios.ICANON | termios.ECHO)
        termios.tcsetattr(self.its, termios.TCSANOW, modes)
        return os.read(self.its, 4096) if select.select([self.its], [], [], 0)[0] else b""

    def layer(self, model=WEDGE):
        return [self.write("w.stl", model), "--layer", "5", "--printer", self.printer()]

    def test_a_terminal_shows_the_pixels_of_the_png(self):
        large = binary_stl(wedge(18, 10, 2))
        # The whole mask: unchanged and reduced. The lit part alone: enlarged by a whole factor, and reduced.
        for size, model, whole in (((192, 57), large, True), ((80, 24), large, True), ((30, 12), large, True),
                                   ((190, 80), WEDGE, False), ((60, 24), WEDGE, False)):  # fmt: skip
            with self.subTest(size=size, whole=whole):
                arguments = self.layer(model)
                png = self.png(*arguments)
                note, start, picture = self.shown(*arguments, size=size, COLORTERM="truecolor").partition(b"\x1b")
                note = b" ".join(note.split()).decode()
                self.assertIn("w.stl: layer 5 of 40, 0.200 to 0.250 mm", note)
                picture = decode_half_blocks(start + picture)
                self.assertLessEqual(picture.width, size[0])
                self.assertLessEqual(picture.height, 2 * (size[1] - 2))
                self.assertGreater(picture.width, 20)
                area = re.search(r"columns (\d+) to (\d+) and rows (\d+) to (\d+) of 192x108 pixels; the others are dark", note)
                self.assertEqual((area is None, "all 192x108 pixels" in note), (whole, whole))
                left, right, top, bottom = map(int, area.groups()) if area else (1, 192, 1, 108)
                expected = resized(png, left - 1, top - 1, right, bottom, picture.width, picture.height)
                # Rounding to whole grey values, with room for floating-point sums in another order.
                worst = max(abs(a - b) for mine, theirs in zip(picture.rows, expected, strict=True) for a, b in zip(mine, theirs, strict=True))
                self.assertLessEqual(worst, 0.501)
                self.assertGreater(len(picture.values()), 1)

    def test_a_terminal_shows_half_blocks(self):
        arguments = self.layer()
        true_color = self.shown(*arguments, COLORTERM="truecolor")
        greys = self.shown(*arguments)
        self.assertIn(b"\x1b[48;2;255;255;255m", true_color)
        self.assertIn(b"\x1b[48;5;231m", greys)
        for data in (true_color, greys):
            lines = SGR.sub(b"", data).decode().splitlines()
            self.assertTrue(all(set(line) <= {"\u2580", " "} for line in lines[2:]))
            self.assertTrue(all(len(line) <= 80 for line in lines))
            self.assertLessEqual(len(lines), 23)
            self.assertTrue(data.endswith(b"\x1b[0m\n"))

    def test_the_picture_fits_every_terminal(self):
        arguments = self.layer()
        for size in ((40, 24), (80, 24), (200, 60), (20, 8), (1, 1), (1000, 3)):
            with self.subTest(size):
                lines = SGR.sub(b"", self.shown(*arguments, size=size)).decode().splitlines()
                self.assertTrue(all(len(line) <= size[0] for line in lines), lines)
                if size[1] >= 24:
                    self.assertLess(len(lines), size[1])
        self.assertIn(b"\xe2\x96\x80", self.shown(*arguments, size=(0, 0)))

    def test_without_colours_characters_are_drawn(self):
        arguments = self.layer()
        piped = contourctl("preview", *arguments).stdout
        for environment in ({"NO_COLOR": "1"}, {"TERM": "dumb"}, {"TERM": None}, {"TERM": ""}):
            with self.subTest(environment):
                data = self.shown(*arguments, size=(80, 42), **environment)
                self.assertNotIn(b"\x1b", data)
                self.assertEqual(data.count(b"\n"), piped.count(b"\n"))
        self.assertIn("\u2588", piped.decode())
        self.assertIn(b"\x1b[48", self.shown(*arguments, NO_COLOR=""))

    def test_typed_text_is_left_to_the_shell(self):
        self.shown(*self.layer(), typed=b"ls\n")
        self.assertEqual(self.left_to_read(), b"ls\n")

    def test_in_the_background_the_picture_is_drawn_and_the_program_is_not_stopped(self):
        model = self.write("s.stl", WEDGE)
        self.start("--help")  # only for its terminal
        self.read()
        job = subprocess.Popen(["bash", "-mc", f"{CONTOURCTL} preview {os.fsdecode(model)} & wait $!"], stdin=self.its, stdout=self.its,
                               stderr=self.its, env={**os.environ, "TERM": "xterm", "NO_COLOR": ""}, start_new_session=True,
                               preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))  # fmt: skip
        self.process = job
        self.addCleanup(job.kill)
        data = self.read()
        self.assertEqual(job.returncode, OK, data)
        self.assertIn(b"\xe2\x96\x80", data)
        self.assertEqual(termios.tcgetattr(self.its), self.modes)

    def test_a_signal_in_the_middle_of_a_picture_leaves_the_terminal_usable(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            with self.subTest(number):
                # The picture is larger than the buffer of a terminal that is not read.
                self.start(self.write("s.stl", WEDGE), size=(900, 400), COLORTERM="truecolor")
                data = self.read(until=b"\x1b[48")
                self.wait_full()
                self.process.send_signal(number)
                data += self.read()
                self.assertEqual(self.process.returncode, -number)
                self.assertTrue(data.endswith(b"\x1b[0m\r\n"), data[-50:])
                self.assertEqual(termios.tcgetattr(self.its), self.modes)

    def wait_full(self):
        """Waits until the program sleeps, because the terminal is full."""
        def waits():
            return text_of(f"/proc/{self.process.pid}/stat").rsplit(") ", 1)[1].startswith("S")
        wait_until(waits, "the program to wait")

    def test_a_program_that_is_stopped_in_the_middle_draws_the_picture_again(self):
        self.start(self.write("s.stl", WEDGE), size=(900, 400), controlling=False, COLORTERM="truecolor")
        before = self.read(until=b"\x1b[48")
        self.wait_full()
        self.process.send_signal(signal.SIGTSTP)
        data = b""
        while not os.WIFSTOPPED(os.waitpid(self.process.pid, os.WUNTRACED | os.WNOHANG)[1]):
            if select.select([self.ours], [], [], 0.02)[0]:
                data += os.read(self.ours, 65536)
        self.assertEqual(termios.tcgetattr(self.its), self.modes)
        self.process.send_signal(signal.SIGCONT)
        data += self.read()
        self.assertEqual(self.process.returncode, OK)
        lines = (before + data).replace(b"\r\n", b"\n").split(b"\n")
        whole = self.shown("s.stl", size=(900, 400), COLORTERM="truecolor").split(b"\n")
        self.assertEqual(lines[-len(whole) + 1 :], whole[1:])  # the first line is the note

    def test_a_png_is_not_written_to_a_terminal(self):
        data = self.shown(self.write("a.stl", SMALL), "-o", "-", code=BAD_USAGE)
        self.assertIn(b"standard output is a terminal", data)
        self.assertNotIn(b"PNG", data)

    def test_for_a_bad_model_the_terminal_gets_one_line_without_sequences(self):
        data = self.shown(self.write("a.stl", b"x"), code=BAD_DATA)
        self.assertNotIn(b"\x1b", data)
