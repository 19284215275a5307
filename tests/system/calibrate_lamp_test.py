"""The lamp's calibration, with a simulated owner who measures a hidden lamp's light on the pictures that the display really showed."""

import json
import os
import pty
import random
import re
import struct
import subprocess
import unittest
import zlib

from calibrate_test import PRINTER, CalibrationTest
from harness import BAD_CONFIG, BAD_DATA, BAD_USAGE, OK, contourctl, read_png, text_of

COLUMNS, ROWS = 5, 3
SIDE = 36  # pixels of a field: three fifths of 60
DISPLAY = {"width_px": 320, "height_px": 180, "pixel_pitch_um": 50}
PITCH_MM = DISPLAY["pixel_pitch_um"] / 1000


def hidden_light(x, y):
    """Returns a lamp's light that is 22 to 34 percent lower in the corners than at its brightest place, off the middle. x and y are 0 to 1."""
    return 40 * (1 - 0.185 * ((2 * x - 1.12) ** 2 + 0.5 * (2 * y - 0.92) ** 2))


def exact_readings(digits=3):
    """Returns the light in the middle of each field, row by row."""
    return [f"{hidden_light((column * (320 - SIDE) / 4 + SIDE / 2) / 320, (row * (180 - SIDE) / 2 + SIDE / 2) / 180):.{digits}f}" for row in range(ROWS) for column in range(COLUMNS)]


def light_of(picture):
    """Returns the lit pixels' mean light, as a meter shows it."""
    lit = [(x, y) for y, row in enumerate(picture.rows) for x, grey in enumerate(row) if grey]
    return sum(hidden_light((x + 0.5) / picture.width, (y + 0.5) / picture.height) * picture.rows[y][x] / 255 for x, y in lit) / len(lit)


def spread_percent(mask):
    light = [hidden_light((x + 0.5) / mask.width, (y + 0.5) / mask.height) * grey / 255 for y, row in enumerate(mask.rows) for x, grey in enumerate(row)]
    return 100 * (max(light) / min(light) - 1)


def photo_png(width, height, sample, bits=16):
    """Returns a PNG file of grey samples, each a share of white."""
    most = 2**bits - 1
    rows = b"".join(b"\0" + b"".join(round(most * sample(x, y)).to_bytes(bits // 8, "big") for x in range(width)) for y in range(height))
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks)


class Lamp(CalibrationTest):
    def setUp(self):
        super().setUp()
        self.rig = self.daemon({**PRINTER, "display": DISPLAY})
        self.before = text_of(self.rig.config_path)

    def ctl(self, *words):
        return self.run_ctl(self.rig, *words)

    def config(self):
        return self.read(self.rig.config_path)

    def masks(self):
        return sorted(name for name in os.listdir(self.rig.folder) if name.startswith("uniformity"))

    def assert_unchanged(self):
        self.assertEqual(text_of(self.rig.config_path), self.before)
        self.assertEqual(self.masks(), [])

    def shown(self):
        """Returns the picture that was shown last."""
        return read_png(os.path.join(self.rig.folder, "masks", "test pattern picture", "0001.png"))

    def measure(self, answer, *words):
        """Runs `calibrate lamp` and types answer(picture) after each field. Returns the readings of the command that it prints."""
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        command = [os.environ["CONTOURD_BIN"] + "/contourctl", "calibrate", "lamp", "--seconds", "0.01", "--in-resin", *words, "--printer", self.rig.config_path, "--socket", self.rig.socket_path]
        with subprocess.Popen(command, stdin=slave, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as program:
            os.close(slave)
            output, at = b"", 0
            while chunk := os.read(program.stdout.fileno(), 65536):
                output += chunk
                while found := re.compile(rb"Press\s+Enter|Enter\s+lights\s+it|The\s+reading").search(output, at):
                    at = found.end()
                    os.write(master, (answer(self.shown()) if found[0].startswith(b"The") else "").encode() + b"\n")
            self.assertEqual((program.wait(), program.stderr.read()), (OK, b""), output)
        self.said = " ".join(output.decode().split())
        return re.search(r"--grid [0-9x]+ ((?:[0-9.?]+ ?)+)", self.said)[1].split()

    def readings(self, seed=1, error=0.02):
        noise = random.Random(seed)
        return self.measure(lambda field: f"{light_of(field) * noise.gauss(1, error):.2f}")

    def test_a_hidden_lamp_is_evened_out_and_the_exposures_follow(self):
        readings = self.readings()
        command = ("fit", "lamp", *readings)
        self.well(self.ctl(*command), "the light differs by", "Nothing was written: --accept")
        self.assert_unchanged()

        self.well(self.ctl(*command, "--html", self.path("lamp.html")))
        self.assert_page(self.path("lamp.html"), 15, "<th>figure</th><th>value</th><th>+-</th><th>now</th>", "display/uniformity_mask", "data:image/png;base64,",
                         ".shot circle { fill: #fff; stroke: #000;")
        output = self.well(self.ctl(*command, "--lamp-hours", "120", "--accept"), "Written to ", "multiply exposure_ms and bottom_exposure_ms by", "profiles with fixed exposures: standard")
        expected = float(re.search(r"expected to differ by less than ([0-9.]+) %", output)[1])
        config = self.config()
        name = config["display"]["uniformity_mask"]
        self.assertEqual(self.masks(), [name])
        mask = read_png(os.path.join(self.rig.folder, name))
        self.assertEqual((mask.width, mask.height), (320, 180))
        self.assertGreater(spread_percent(type(mask)(320, 180, [bytes([255]) * 320] * 180)), 50)
        self.assertLess(spread_percent(mask), min(expected, 10))
        # The middle keeps the share of its light that the darkest place has.
        kept = mask.rows[90][160] / 255
        self.assertAlmostEqual(config["projector"]["irradiance_mw_cm2"], 400 * kept, delta=400 * 0.003)
        self.assertEqual((config["calibrations"][0]["kind"], config["calibrations"][0]["lamp_hours"]), ("lamp", 120))
        self.well(contourctl("config", "check", self.rig.config_path))

        self.well(self.ctl("fit", "undo"), "the calibration lamp of ")
        self.assertEqual(self.config(), json.loads(self.before))

    def test_a_second_calibration_keeps_the_first_mask_for_undo(self):
        self.well(self.ctl("fit", "lamp", *self.readings(1), "--accept"))
        first = self.config()
        self.rig.restart()  # with the mask
        # Fields are shown without the mask: the second result does not depend on the first.
        output = self.well(self.ctl("fit", "lamp", *self.readings(2), "--accept"), "as without the present mask")
        self.assertIn("shown without the printer's uniformity mask", self.said)
        second = self.config()
        self.assertEqual(len(self.masks()), 2)
        self.assertNotEqual(first["display"]["uniformity_mask"], second["display"]["uniformity_mask"])
        self.assertLess(spread_percent(read_png(os.path.join(self.rig.folder, second["display"]["uniformity_mask"]))), 10)
        # The middle has the light of the darkest place already.
        self.assertAlmostEqual(float(re.search(r"in the middle, this is ([0-9.]+) times", output)[1]), 1, delta=0.04)
        self.well(self.ctl("fit", "undo"))
        self.assertEqual(self.config(), first)

    def test_readings_through_the_mask_are_told_apart(self):
        exact = self.readings(error=0)
        self.assert_refusal(self.ctl("fit", "lamp", *exact, "--through-mask"), BAD_USAGE, "has no display.uniformity_mask")
        self.well(self.ctl("fit", "lamp", *exact, "--accept"))
        mask = read_png(os.path.join(self.rig.folder, self.masks()[0]))
        through = []
        for i, raw in enumerate(exact_readings(6)):
            x, y = round(i % COLUMNS * (320 - SIDE) / 4 + SIDE / 2), i // COLUMNS * (180 - SIDE) // 2 + SIDE // 2
            through.append(f"{float(raw) * mask.rows[y][x] / 255:.4f}")
        self.well(self.ctl("fit", "lamp", *through, "--through-mask", "--accept"), "whose effect was divided out")
        again = read_png(os.path.join(self.rig.folder, self.config()["display"]["uniformity_mask"]))
        self.assertLess(max(abs(a - b) for old, new in zip(mask.rows, again.rows) for a, b in zip(old, new)), 4)

    def test_a_photo_gives_the_readings(self):
        self.well(self.ctl("calibrate", "lamp", "--photo", "--seconds", "0.01", "--confirm", "--in-resin"), "white picture: 0.01 s", "\n\nUse a raw photo", "--corners ?,?,?,?,?,?,?,?")
        picture = self.shown()
        noise = random.Random(4)
        # The picture is 400 x 225 pixels in the photo, which was taken upside down.
        def sample(x, y):
            u, v = 1 - (x + 0.5 - 30) / 400, 1 - (y + 0.5 - 20) / 225
            if not (0 <= u < 1 and 0 <= v < 1):
                return 0.01
            light = hidden_light(u, v) * picture.rows[int(v * 180)][int(u * 320)] / 255
            return min(1, max(0, light / 60 * noise.gauss(1, 0.1)))

        corners = "430,245,30,245,30,20,430,20"
        for bits, encoding in ((16, "linear"), (8, "srgb")):
            curve = (lambda light: light) if encoding == "linear" else (lambda light: 1.055 * light ** (1 / 2.4) - 0.055 if light > 0.0031 else 12.92 * light)
            self.write("photo.png", photo_png(460, 265, lambda x, y: curve(sample(x, y)), bits))
            with self.subTest(encoding):
                self.well(self.ctl("fit", "lamp", "--photo", self.path("photo.png"), "--corners", corners, "--encoding", encoding, "--accept"))
                self.assertLess(spread_percent(read_png(os.path.join(self.rig.folder, self.config()["display"]["uniformity_mask"]))), 3)
        # With the wrong encoding, the fall-off is another one.
        wrong = self.ctl("fit", "lamp", "--photo", self.path("photo.png"), "--corners", corners, "--encoding", "linear")
        self.assertLess(float(re.search(r"the light differs by ([0-9.]+) %", wrong.stdout.decode())[1]), 35)
        self.assert_words(self.ctl("fit", "lamp", "--photo", self.path("photo.png"), "--corners", corners).stderr.decode(), "--photo requires --encoding")
        self.assert_refusal(self.ctl("fit", "lamp", "--photo", self.path("photo.png"), "--corners", "1,2", "--encoding", "srgb"), BAD_USAGE, "--corners 1,2: give x,y")

    def test_a_table_gives_the_readings(self):
        lines = ["x_mm,y_mm,reading", "# by hand", ""]
        for x in (0.5, 4, 8, 12, 15.5):
            for y in (0.5, 4.5, 8.5):
                lines.append(f"{x}, {y}, {hidden_light(x / 16, y / 9):.3f}")
        self.write("lamp.csv", b"\xef\xbb\xbf" + "\r\n".join(lines).encode())
        self.well(self.ctl("fit", "lamp", "--table", self.path("lamp.csv"), "--accept"), "0.5, 0.5 ", "15.5, 8.5 ")
        self.assertLess(spread_percent(read_png(os.path.join(self.rig.folder, self.masks()[0]))), 1)

    def test_the_command_has_the_readings_that_were_typed_and_a_question_mark_for_others(self):
        answers = iter("31.5 32 33 34 x nan -1".split() + [""] + "36 37 38 39".split())
        self.assertEqual(self.measure(lambda field: next(answers), "--grid", "3x3"), "31.5 32 33 34 ? 36 37 38 39".split())
        output = self.well(self.ctl("calibrate", "lamp", "--seconds", "0.01", "--confirm", "--in-resin"), "field 15 of 15, column 5, row 3: 15.1 mm to the right, 8.1 mm down", "\n\nThen type the readings")
        self.assertIn("--grid 5x3" + " ?" * 15, " ".join(output.split()))

    def test_what_does_not_determine_the_light_is_refused_and_nothing_is_written(self):
        exact = exact_readings()
        self.write("big.csv", b"1,1,1\n" * 20000)
        self.write("beside.csv", b"1,1,1\n17,1,1\n")
        self.write("words.csv", b"1,1,1\n1;2;3\n")
        self.write("first.csv", b"1;1;1\n1,1,1\n")
        self.write("nul.csv", b"1,1,1\n\0\xff\x1b[2J,1\n")
        self.write("empty.csv", b"")
        self.write("no.png", b"GIF89a")
        os.mkfifo(self.path("pipe"))
        corners = ("--corners", "0,0,9,0,9,9,0,9", "--encoding", "linear")
        for code, words, why in (
            (BAD_USAGE, [], "READING"),
            (BAD_USAGE, [*exact[:14]], "there are 14 readings, and a grid of 5x3 has 15 fields"),
            (BAD_USAGE, [*exact[:14], "x"], '"x" is not a number'),
            (BAD_USAGE, [*exact[:14], "nan"], '"nan" is not a number'),
            (BAD_DATA, [*exact[:14], "0"], "reading 15 is 0: a reading is more than 0 and at most 1e+09"),
            (BAD_DATA, [*exact[:14], "1e308"], "reading 15 is 1e+308"),
            (BAD_DATA, [*exact[:14], "-1"], "reading 15 is -1: a reading is more than 0"),
            (BAD_DATA, [*exact[:5], *["?"] * 10], "5 readings do not determine a lamp's light"),
            (BAD_DATA, [*reversed(exact[:8]), *exact[8:]], "the readings scatter by"),
            *((BAD_USAGE, ["--grid", grid, *exact], f"--grid {grid}: give columns and rows, each 3 to 9") for grid in ("2x9", "10x3", "5x", "5", "3x3x3", "1e9x3", "nanx3", "5.5x3", "99999999999999999999x3")),
            (BAD_USAGE, ["--table", self.path("big.csv")], "more than 64 KiB"),
            (BAD_USAGE, ["--table", self.path("beside.csv")], "line 2: \"17,1,1\" is beside the picture of 16 x 9 mm"),
            (BAD_USAGE, ["--table", self.path("words.csv")], "line 2: \"1;2;3\" is not x, y and reading"),
            (BAD_USAGE, ["--table", self.path("first.csv")], "line 1: \"1;1;1\" is not x, y and reading"),
            (BAD_USAGE, ["--table", self.path("nul.csv")], "line 2"),
            (BAD_DATA, ["--table", self.path("empty.csv")], "0 readings"),
            (BAD_USAGE, ["--table", self.path("pipe")], "--table"),
            (BAD_USAGE, ["--table", self.path("missing")], "--table"),
            (BAD_DATA, ["--photo", self.path("no.png"), *corners], "the file is not a PNG file"),
            (BAD_DATA, ["--photo", self.path("pipe"), *corners], "it is not a regular file"),
        ):
            with self.subTest(words):
                result = self.ctl("fit", "lamp", *words, "--accept")
                self.assertEqual((result.returncode, result.stdout), (code, b""), result)
                self.assert_words(result.stderr.decode(), why)
                self.assertNotIn("\x1b", result.stderr.decode())
                self.assert_unchanged()

    def test_a_folder_that_cannot_be_written_changes_nothing(self):
        exact = exact_readings()
        # A name that is taken by a folder stands for a file that cannot be written: also root is refused.
        os.mkdir(self.rig.config_path + ".new")
        result = self.ctl("fit", "lamp", *exact, "--accept")
        self.assertNotEqual(result.returncode, OK)
        self.assert_words(result.stderr.decode(), "cannot write")
        self.assert_unchanged()
        os.rmdir(self.rig.config_path + ".new")
        self.well(self.ctl("fit", "lamp", *exact, "--accept"))
        self.well(self.ctl("fit", "undo"))
        # The same readings use the mask that is there.
        self.well(self.ctl("fit", "lamp", *exact, "--accept"))
        self.assertEqual(len(self.masks()), 1)

    def test_light_and_grid_are_refused_as_by_hand(self):
        self.assert_words(self.ctl("calibrate", "lamp", "--confirm").stderr.decode(), "it may be in the resin; add --in-resin")
        self.assert_refusal(self.ctl("calibrate", "lamp", "--confirm", "--seconds", "1.1"), BAD_USAGE, "manual.light_limit_s allows more than 0 and at most 1 s")
        self.assert_refusal(self.ctl("calibrate", "lamp", "--confirm", "--grid", "99x99"), BAD_USAGE, "each 3 to 9")
        self.assertEqual(contourctl("calibrate", "lamp", "--confirm", "--printer", self.path("none.json"), "--socket", self.rig.socket_path).returncode, BAD_CONFIG)


if __name__ == "__main__":
    unittest.main()
