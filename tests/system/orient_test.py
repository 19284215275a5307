"""contourctl orient, and jobs whose tickets let contourd choose the direction that points up."""

import json
import os
import re

from harness import (
    BAD_CONFIG, BAD_DATA, BAD_USAGE, CANNOT_CREATE, NO_INPUT, OK, SHARED, SOURCE, Daemon, FolderTest, binary_stl, box, contents, contourctl, read_png,
    text_of,
)  # fmt: skip

# A table: when it stands on its legs, its top overhangs; upside down nothing overhangs.
TABLE = binary_stl(
    box((0, 0, 6), (16, 16, 7)) + [f for x in (0, 14) for y in (0, 14) for f in box((x, y, 0), (x + 2, y + 2, 7))]
)
SIMULATED = os.path.join(SOURCE, "config", "simulated.json")


class Orient(FolderTest):
    def orient(self, *arguments):
        return contourctl("orient", self.write("table.stl", TABLE), *arguments)

    def test_a_table_is_best_upside_down(self):
        result = self.orient()
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        text = result.stdout.decode()
        self.assertTrue(text.startswith("0, 0, -1 points up (auto): no overhangs, 7.00 mm high"), text)
        self.assertIn('ticket  {"up":{"x":0.0,"y":0.0,"z":-1.0}}', text.replace("-0.0", "0.0"))
        self.assertIn("as drawn", text)

    def test_json_has_the_alternatives_and_is_the_same_every_time(self):
        found = [json.loads(self.orient("--json").stdout) for _ in range(2)]
        for each in found:
            self.assertGreater(each.pop("took_ms"), 0)
        self.assertEqual(found[0], found[1])
        best, drawn = found[0]["alternatives"][0], [a for a in found[0]["alternatives"] if a["up"] == [0, 0, 1]]
        self.assertEqual((best["up"], best["contacts"], best["stands"], best["size_mm"]), ([0, 0, -1], 0, True, [16, 16, 7]))
        self.assertTrue(all(a["score"] >= best["score"] for a in drawn))
        self.assertEqual(found[0]["preset"], "auto")

    def test_scale_and_preset_are_used(self):
        doubled = json.loads(self.orient("--json", "--scale", "2", "--preset", "fast").stdout)
        self.assertEqual(doubled["preset"], "fast")
        self.assertEqual(doubled["alternatives"][0]["size_mm"][2], 14)

    def test_an_orientation_that_does_not_fit_the_printer_is_not_chosen(self):
        model = self.write("rod.stl", binary_stl(box((0, 0, 0), (5, 5, 90))))
        alone = json.loads(contourctl("orient", model, "--json").stdout)
        self.assertTrue(alone["as_drawn"])
        printer = json.loads(contents(SIMULATED))
        printer["z_axis"]["travel_mm"] = 60
        printer["resins_folder"] = os.path.join(SOURCE, "config", "resins")
        low = json.loads(contourctl("orient", model, "--json", "--printer", self.write("low.json", json.dumps(printer).encode())).stdout)
        self.assertFalse(low["as_drawn"])
        self.assertTrue(low["alternatives"][0]["fits"])

    def test_the_page_and_the_pictures_show_each_orientation(self):
        page, folder = self.path("ways.html"), self.path("ways")
        self.assertEqual(self.orient("--html", page, "--pictures", folder).returncode, OK)
        html = text_of(page)
        self.assertEqual(len(re.findall(r'<img alt="[^"]*" width="360" height="360" src="data:image/png;base64,', html)), 8)
        self.assertEqual(html.count('class="chosen"'), 1)
        self.assertNotRegex(html, r'(?:src|href)="(?!data:)')
        files = sorted(os.listdir(folder))
        self.assertEqual(files, [f"{i:04}.png" for i in range(1, 9)])
        picture = read_png(os.path.join(folder, files[0]))
        self.assertEqual((picture.width, picture.height), (360, 360))
        self.assertEqual(self.orient("--pictures", folder).returncode, CANNOT_CREATE)
        self.assertEqual(self.orient("--pictures", folder, "--force").returncode, OK)

    def test_wrong_options_and_bad_files_are_errors(self):
        for arguments, code, word in (
            (["--scale", "0"], BAD_USAGE, "--scale"),
            (["--scale", "nan"], BAD_USAGE, "--scale"),
            (["--force"], BAD_USAGE, "--pictures"),
            (["--html", self.path("none", "x.html")], CANNOT_CREATE, "x.html"),
            (["--printer", self.path("none.json")], BAD_CONFIG, "none.json"),
            (["--profile", self.write("resin.json", b"{}")], BAD_CONFIG, "resin.json"),
        ):
            with self.subTest(arguments):
                result = self.orient(*arguments)
                self.assertEqual(result.returncode, code, result)
                self.assertIn(word, result.stderr.decode())
                self.assertEqual(result.stdout, b"")
        self.assertEqual(self.orient("--preset", "best").returncode, BAD_USAGE)
        self.assertEqual(contourctl("orient", self.path("none.stl")).returncode, NO_INPUT)
        self.assertEqual(contourctl("orient", self.write("bad.stl", b"x" * 99)).returncode, BAD_DATA)

    def test_slice_and_analyze_turn_the_model_first(self):
        model = self.write("table.stl", TABLE)
        lying = [json.loads(contourctl("slice", model, "--z", z, "--up", up, "--json").stdout)["area_mm2"]
                 for z, up in (("-0.5", "0,0,-1"), ("-6.5", "0,0,-1"))]
        # Upside down, z goes from -7 to 0: the legs are above the top.
        self.assertEqual([round(area, 6) for area in lying], [16, 256])
        result = contourctl("analyze", model, "--up", "auto", "--json")
        self.assertTrue(result.stderr.decode().startswith("contourctl: 0, 0, -1 points up (auto)"), result.stderr)
        self.assertEqual(json.loads(result.stdout)["islands"], 0)
        self.assertGreater(json.loads(contourctl("analyze", model, "--json").stdout)["largest_area_layer"], 100)
        self.assertEqual(contourctl("slice", model, "--z", "1", "--up", "1,2").returncode, BAD_USAGE)

    def test_real_models_are_rated_within_the_time_limit(self):
        model = os.path.join(SHARED, "models", "bunny-closed-70k.stl")
        if not os.path.exists(model):
            self.skipTest("no ../shared/models")
        found = json.loads(contourctl("orient", model, "--scale", "0.25", "--json").stdout)
        best, drawn = found["alternatives"][0], [a for a in found["alternatives"] if a["up"] == [0, 0, 1]]
        self.assertLess(best["contacts"], 60)  # 54 bear the moments of peel
        self.assertTrue(all(a["contacts"] > 1.5 * best["contacts"] for a in drawn))


class Jobs(FolderTest):
    def test_a_job_is_turned_and_its_report_lists_the_alternatives(self):
        daemon = Daemon(self).start()
        model = self.write("table.stl", TABLE)
        daemon.ctl("submit", model, "--up", "clean", "--wait", expect=OK)
        report = daemon.report("table")
        self.assertEqual(report["model"]["up"], [0, 0, -1])
        orientation = report["model"]["orientation"]
        self.assertEqual((orientation["preset"], orientation["as_drawn"]), ("clean", False))
        self.assertEqual(orientation["alternatives"][0]["contacts"], 0)
        self.assertIn("0, 0, -1 points up (clean): no overhangs", daemon.read("done", "table.report.html"))
        self.assertIn("table: 0, 0, -1 points up (clean)", daemon.log())
