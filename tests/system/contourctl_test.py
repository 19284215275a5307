"""contourctl inspect and contourctl slice: figures, masks, measurements, and messages about bad input and bad usage."""

import csv
import json
import math
import os
import signal
import subprocess
import unittest

from harness import (
    BAD_DATA, BAD_USAGE, CANNOT_CREATE, CONTOURCTL, NO_INPUT, OK, SOURCE, FolderTest, ascii_stl, binary_stl, box, contents, contourctl, cube,
    inside_out, limit_memory, read_png, source_json, wedge,
)  # fmt: skip

RELEASED = b"CMAKE_BUILD_TYPE:STRING=Release" in contents(os.path.join(os.path.dirname(CONTOURCTL), "..", "CMakeCache.txt"))
# The daemon's log has the same sentence.
INSIDE_OUT = "the model is inside out: its facets were turned outwards"
# File names that users really have, or that a careless program mishandles.
ODD_NAMES = [
    b"two words.stl", b" leading blank.stl", b"line\nbreak.stl", b"carriage\rreturn.stl", b"not utf-8 \xff\xfe\x80.stl",
    "Geräte-čřšřěá-部品.stl".encode(), b"-dash.stl", b"--json", b"quote'\"`.stl", b"%s%n{}{0}.stl", b"no extension",
    b"esc\x1b[31m.stl", b"$(HOME).stl", b"a" * 255,
]  # fmt: skip


class Linking(unittest.TestCase):
    @unittest.skipUnless(RELEASED, "only release builds compile each source of hw by itself")
    def test_contourctl_needs_no_library_that_only_the_daemon_uses(self):
        found = subprocess.run(["readelf", "--dynamic", "--wide", CONTOURCTL], capture_output=True, text=True, check=True)
        needed = [line for line in found.stdout.splitlines() if "(NEEDED)" in line]
        self.assertTrue([line for line in needed if "libpng" in line], found.stdout)
        # contourctl needs libgpiod, since `diagnose` lists the chips.
        for library in ("libsystemd", "libdrm", "libserialport", "libsqlite3"):
            self.assertEqual([line for line in needed if library in line], [])


class Inspect(FolderTest):
    def inspect(self, path):
        result = contourctl("inspect", "--json", "--", path, expect=OK)
        self.assertEqual(result.stderr, b"")
        return json.loads(result.stdout)

    def test_a_binary_cube_has_every_figure(self):
        found = self.inspect(self.write("cube.stl", binary_stl(box((-10, 5, 1), (10, 25, 21)))))
        self.assertAlmostEqual(found.pop("volume_mm3"), 8000, delta=8000 * 1e-12)  # double rounding
        self.assertEqual(found, {
            "format": "binary", "facets": 12, "bounds_mm": {"min": [-10, 5, 1], "max": [10, 25, 21]},
            "size_mm": [20, 20, 20], "watertight": True, "open_edges": 0, "non_manifold_edges": 0,
            "flipped_edges": 0, "degenerate_facets": 0, "zero_area_facets": 0, "duplicate_facets": 0,
            "repairs": {"turned_facets": 0, "doubled_facets": 0, "reversed_facets": 0, "inner_wall_facets": 0},
            "warnings": [],
        })  # fmt: skip

    def test_an_ascii_cube_has_the_same_figures_as_a_binary_one(self):
        binary = self.inspect(self.write("b.stl", binary_stl(cube(20))))
        ascii_ = self.inspect(self.write("a.stl", ascii_stl(cube(20))))
        self.assertEqual(ascii_.pop("format"), "ascii")
        self.assertEqual(binary.pop("format"), "binary")
        self.assertEqual(ascii_, binary)

    def test_without_json_it_prints_plain_text(self):
        result = contourctl("inspect", self.write("cube.stl", binary_stl(cube(20))), expect=OK)
        self.assert_words(result.stdout, b"binary", b"12", b"20 x 20 x 20 mm", "8000 mm³".encode(), b"watertight")
        self.assertNotIn(b"{", result.stdout)
        slab = "solid\n" + "".join("facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {'-0' if each == 0 else each} 1 2\n" for each in facet) + "endloop\nendfacet\n"
                                   for facet in ((0, 1, 2), (2, 0, 3))) + "endsolid\n"  # fmt: skip
        result = contourctl("inspect", self.write("zero.stl", slab), expect=OK)
        self.assert_words(result.stdout, b"x 0 to 3")

    def test_a_turned_facet_flips_three_edges(self):
        facets = cube(20)
        found = self.inspect(self.write("flip.stl", binary_stl(inside_out(facets[:1]) + facets[1:])))
        self.assertEqual((found["flipped_edges"], found["open_edges"], found["watertight"]), (3, 0, False))
        self.assertEqual(found["repairs"]["turned_facets"], 1)
        warning = "the model's facets disagree with each other: 1 facet turned round"
        self.assertEqual(found["warnings"], [warning])
        result = contourctl("slice", self.path("flip.stl"), "--z", "5")
        self.assertEqual(result.stderr.decode(), f"contourctl: warning: {warning}\n")
        self.assertIn("area         400 mm²".encode(), result.stdout)

    def test_degenerate_and_duplicate_facets_are_counted(self):
        facets = cube(20)
        line = ((0, 0, 0), (10, 0, 0), (20, 0, 0))
        point = ((0, 0, 0), (0, 0, 0), (20, 0, 0))
        found = self.inspect(self.write("bad.stl", binary_stl(facets + [point, line, facets[3]])))
        self.assertEqual((found["degenerate_facets"], found["zero_area_facets"], found["duplicate_facets"]), (1, 2, 1))

    def test_an_inside_out_cube_has_a_negative_volume(self):
        found = self.inspect(self.write("inverted.stl", binary_stl(inside_out(cube(20)))))
        self.assertAlmostEqual(found["volume_mm3"], -8000, delta=8000 * 1e-12)
        self.assertTrue(found["watertight"])
        self.assertEqual(found["warnings"], [INSIDE_OUT])
        result = contourctl("inspect", self.path("inverted.stl"))
        self.assertIn(f"warning      {INSIDE_OUT}\n".encode(), result.stdout)

    def test_an_unlikely_unit_and_a_coarse_place_are_told_and_the_unit_can_be_set(self):
        inches = self.write("inches.stl", binary_stl(box((0, 0, 0), (2, 1, 0.5)), b"UNITS=in"))
        self.assertRegex(self.inspect(inches)["warnings"][0], "names inches as its unit .* would measure 50.8 x 25.4 x 12.7 mm")
        found = json.loads(contourctl("inspect", "--json", "--unit", "inch", inches, expect=OK).stdout)
        self.assertEqual(found["warnings"], [])
        for size, expected in zip(found["size_mm"], (50.8, 25.4, 12.7)):
            self.assertAlmostEqual(size, expected, delta=1e-5)  # the rounding of a float
        metres = self.inspect(self.write("metres.stl", binary_stl(box((0, 0, 0), (0.04, 0.03, 0.06)))))
        self.assertIn("in metres, the model would measure 40 x 30 x 60 mm", metres["warnings"][0])
        far = self.inspect(self.write("far.stl", binary_stl(box((0, 4e6, 0), (10, 4e6 + 10, 10)))))
        self.assertIn("4000 m from the origin, where the file's numbers are 0.25 mm apart", far["warnings"][0])

    def test_the_unit_can_be_set_by_any_of_its_names_in_the_commands_that_read_a_model(self):
        model = self.write("inch.stl", binary_stl(box((0, 0, 0), (2, 1, 0.5))))
        for unit in ("inch", "inches", "In"):
            cut = json.loads(contourctl("slice", "--json", "--z", "1", "--unit", unit, model, expect=OK).stdout)
            self.assertAlmostEqual(cut["area_mm2"], 50.8 * 25.4, delta=1e-2)  # the rounding of a float
        scaled = json.loads(contourctl("slice", "--json", "--z", "1", "--unit", "inch", "--scale", "0.5", model, expect=OK).stdout)
        self.assertAlmostEqual(scaled["area_mm2"], 25.4 * 12.7, delta=1e-2)
        found = json.loads(contourctl("orient", "--json", "--unit", "inch", model, expect=OK).stdout)
        self.assertIn("12.7", json.dumps(found))
        self.assert_refusal(contourctl("inspect", "--unit", "furlong", model), BAD_USAGE, "--unit furlong: expected mm, cm, m, um, inch, foot")

    def test_shells_that_are_wound_against_their_place_are_told(self):
        block, relief, core = box((0, 0, 0), (20, 20, 5)), box((5, 5, 3), (10, 10, 7)), box((5, 5, 1), (10, 10, 4))
        self.assertIn("1 shell of the model is inside out", self.inspect(self.write("a.stl", binary_stl(block + inside_out(relief))))["warnings"][0])
        self.assertIn("faces outwards within a solid", self.inspect(self.write("b.stl", binary_stl(block + core)))["warnings"][0])
        for sound in (block + relief, block + inside_out(core)):
            self.assertEqual(self.inspect(self.write("c.stl", binary_stl(sound)))["warnings"], [])

    def test_a_file_without_facets_is_not_an_error(self):
        for data in (binary_stl([]), b"solid nothing\nendsolid nothing\n"):
            found = self.inspect(self.write("empty.stl", data))
            self.assertEqual((found["facets"], found["bounds_mm"], found["watertight"]), (0, None, False))

    def test_a_header_that_begins_with_solid_does_not_make_a_binary_file_ascii(self):
        found = self.inspect(self.write("solid.stl", binary_stl(cube(20), b"solid facet normal 0 0 0")))
        self.assertEqual((found["format"], found["facets"]), ("binary", 12))

    def test_bad_data_gives_65_and_one_line(self):
        nan = float("nan")
        bad = {
            "nothing": b"",
            "junk": b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 8,
            "cut short": binary_stl(cube(20))[:-7],
            "only a header": binary_stl(cube(20))[:90],
            "not a number": binary_stl([((nan, 0, 0), (1, 0, 0), (0, 1, 0))]),
            "not finite": binary_stl([((0, 0, float("inf")), (1, 0, 0), (0, 1, 0))]),
            "word for a number": ascii_stl(cube(20)).replace(b"vertex 20", b"vertex twenty", 1),
            "number too large": ascii_stl(cube(20)).replace(b"vertex 20", b"vertex 1e400", 1),
            "ends inside a facet": ascii_stl(cube(20))[:200],
            "page of a website": b"<!doctype html>\n<html><body>404 not found</body></html>\n" * 4,
        }
        for name, data in bad.items():
            with self.subTest(name):
                path = self.write("bad.stl", data)
                for command in (["inspect", path], ["inspect", "--json", path], ["slice", path, "--z", "1"]):
                    result = contourctl(*command)
                    self.assert_refusal(result, BAD_DATA, path)

    def test_the_facet_count_in_the_header_allocates_nothing(self):
        path = self.write("bomb.stl", binary_stl(cube(20), count=0xFFFFFFFF))
        # The facets claimed would take 200 GB.
        result = contourctl("inspect", "--json", path, preexec_fn=lambda: limit_memory(128 << 20))
        self.assertIn(result.returncode, (OK, BAD_DATA))
        self.assertNotIn(b"memory", result.stderr)

    def test_a_file_that_cannot_be_read_gives_66_and_one_line(self):
        fifo = self.path("fifo.stl")
        os.mkfifo(fifo)
        loop = self.path("loop.stl")
        os.symlink("loop.stl", loop)
        dangling = self.path("dangling.stl")
        os.symlink("nowhere", dangling)
        for path in (self.path("missing.stl"), self.folder, fifo, loop, dangling, "/dev/null", self.path("a" * 300), ""):
            with self.subTest(path):
                for command in (["inspect", "--", path], ["slice", "--z", "1", "--", path]):
                    result = contourctl(*command, timeout=10)
                    self.assert_refusal(result, NO_INPUT, path)

    @unittest.skipIf(os.geteuid() == 0, "permissions do not stop root")
    def test_a_file_without_permission_gives_66(self):
        path = self.write("secret.stl", binary_stl(cube(20)))
        os.chmod(path, 0)
        result = contourctl("inspect", path)
        self.assert_refusal(result, NO_INPUT, path)

    def test_odd_file_names_are_read(self):
        data = binary_stl(cube(20))
        for name in ODD_NAMES:
            with self.subTest(name):
                found = self.inspect(self.write(name, data))
                self.assertEqual(found["facets"], 12)

    def test_odd_file_names_in_an_error_stay_on_one_line(self):
        for name in ODD_NAMES:
            with self.subTest(name):
                path = self.write(name, b"no STL file")
                result = contourctl("inspect", "--", path)
                self.assert_refusal(result, BAD_DATA)
                os.unlink(path)
                result = contourctl("inspect", "--", path)
                self.assert_refusal(result, NO_INPUT)

    def test_a_relative_path_and_a_link_are_read(self):
        self.write("cube.stl", binary_stl(cube(20)))
        os.symlink("cube.stl", self.path("link.stl"))
        for path in ("cube.stl", "./cube.stl", "link.stl"):
            self.assertEqual(contourctl("inspect", path, cwd=self.folder).returncode, OK)


class SliceAtOneHeight(FolderTest):
    def slice(self, facets, z, *arguments, warning=b""):
        path = self.write("model.stl", binary_stl(facets))
        result = contourctl("slice", path, "--z", str(z), "--json", *arguments, expect=OK)
        self.assertEqual(result.stderr, warning)
        return json.loads(result.stdout)

    def test_a_cube_has_every_figure(self):
        found = self.slice(cube(20), 7.5)
        for key, value in {"z_mm": 7.5, "segments": 8, "contours": 1, "open_chains": 0, "gaps_closed": 0}.items():
            self.assertEqual(found[key], value, key)
        # Corners at whole millimetres are exact in a float; only the rounding of doubles remains.
        self.assertAlmostEqual(found["area_mm2"], 400, delta=1e-9)
        self.assertAlmostEqual(found["perimeter_mm"], 80, delta=1e-9)

    def test_without_json_it_prints_plain_text(self):
        result = contourctl("slice", self.write("cube.stl", binary_stl(cube(20))), "--z", "5", expect=OK)
        self.assertIn("400 mm²".encode(), result.stdout)
        self.assertNotIn(b"{", result.stdout)

    def test_the_height_is_in_the_files_coordinates(self):
        facets = box((0, 0, -30), (10, 10, -20))
        self.assertAlmostEqual(self.slice(facets, -25)["area_mm2"], 100, delta=1e-9)
        warning = b"contourctl: warning: z is 5 mm, but the model is from -30 to -20 mm: nothing is cut\n"
        self.assertEqual(self.slice(facets, 5, warning=warning)["contours"], 0)

    def test_a_height_outside_the_model_cuts_nothing(self):
        for z in (-1, 20.001, 1e9, -1e300):
            warning = f"contourctl: warning: z is {z:.6g} mm, but the model is from 0 to 20 mm: nothing is cut\n"
            found = self.slice(cube(20), z, warning=warning.encode())
            self.assertEqual((found["segments"], found["contours"], found["area_mm2"]), (0, 0, 0))

    def test_an_inside_out_cube_has_its_full_area_and_gives_a_warning(self):
        found = self.slice(inside_out(cube(20)), 10, warning=f"contourctl: warning: {INSIDE_OUT}\n".encode())
        self.assertAlmostEqual(found["area_mm2"], 400, delta=1e-9)

    def test_a_hole_is_closed_and_counted(self):
        # Both facets of the side x = 20 are missing.
        facets = [f for f in cube(20) if not all(vertex[0] == 20 for vertex in f)]
        self.assertEqual(len(facets), 10)
        found = self.slice(facets, 10)
        self.assertEqual(found["open_chains"], 1)
        self.assertAlmostEqual(found["area_mm2"], 400, delta=1e-9)
        self.assertAlmostEqual(found["widest_gap_mm"], 20, delta=1e-9)

    def test_a_crack_narrower_than_a_pixel_is_joined(self):
        facets = cube(20)
        moved = [tuple((x + 0.001, y, z) if x == 20 else (x, y, z) for x, y, z in f)
                 if all(vertex[0] == 20 for vertex in f) else f for f in facets]  # fmt: skip
        found = self.slice(moved, 10)
        self.assertEqual((found["open_chains"], found["contours"]), (0, 1))
        self.assertGreater(found["gaps_closed"], 0)
        self.assertAlmostEqual(found["area_mm2"], 400, delta=0.02)  # 20 mm of side, moved by 1 um

    def test_a_model_without_facets_has_no_contours_and_a_dark_mask(self):
        mask = self.path("mask.png")
        self.assertEqual(self.slice([], 1, "--mask", mask)["contours"], 0)
        self.assertEqual(read_png(mask).values(), {0})

    def test_the_mask_at_a_height_is_that_of_the_layer(self):
        path = self.write("model.stl", binary_stl(wedge(20, 10, 10)))
        contourctl("slice", path, "--layer-height-um", "1000", "--masks", self.path("masks"))
        self.slice(wedge(20, 10, 10), 2.5, "--mask", self.path("mask.png"))
        self.assertEqual(read_png(self.path("mask.png")), read_png(self.path("masks", "0003.png")))


class Masks(FolderTest):
    def masks(self, facets, layer_height_um, *arguments):
        path = self.write("model.stl", binary_stl(facets))
        result = contourctl("slice", path, "--layer-height-um", str(layer_height_um), "--masks", self.path("masks"),
                            "--force", *arguments)  # fmt: skip
        self.assertEqual(result.returncode, OK, result.stderr)
        self.warnings = result.stderr
        names = sorted(os.listdir(self.path("masks")))
        return {name: read_png(self.path("masks", name)) for name in names}

    def test_a_cube_of_20_mm_at_50_um_is_400_pixels_square_in_the_middle(self):
        masks = self.masks(box((3, -70, 11), (23, -50, 31)), 5000)
        self.assertEqual(list(masks), ["0001.png", "0002.png", "0003.png", "0004.png"])
        dark, lit = bytes(1920), bytes(760) + b"\xff" * 400 + bytes(760)
        for picture in masks.values():
            self.assertEqual((picture.width, picture.height), (1920, 1080))
            self.assertEqual(picture.rows, [dark] * 340 + [lit] * 400 + [dark] * 340)

    def test_row_0_is_the_largest_y_and_x_grows_to_the_right(self):
        floor = box((0, 0, 0), (10, 2, 1))
        post = box((0, 8, 0), (2, 10, 1))
        picture = self.masks(floor + post, 1000, "--display", "100x100", "--pixel-pitch-um", "100")["0001.png"]
        self.assertEqual(picture.lit_box(), (0, 0, 100, 100))
        self.assertEqual(picture.rows[10], b"\xff" * 20 + bytes(80))
        self.assertEqual(picture.rows[50], bytes(100))
        self.assertEqual(picture.rows[90], b"\xff" * 100)

    def test_each_layer_is_cut_at_its_middle(self):
        # 20 mm wide at the bottom, 0 at 10 mm: the middles of ten layers are 380, 340 ... 20 pixels wide.
        masks = self.masks(wedge(20, 10, 10), 1000)
        self.assertEqual(len(masks), 10)
        for number, picture in enumerate(masks.values()):
            left, top, right, bottom = picture.lit_box()
            self.assertEqual((right - left, bottom - top), (380 - 40 * number, 200), number)
            self.assertEqual(left, 760)  # the upright side does not move

    def test_the_last_layer_is_the_last_one_that_is_cut_below_the_top(self):
        for height, layers in ((10.2, 10), (10.6, 11)):
            self.assertEqual(len(self.masks(box((0, 0, 0), (5, 5, height)), 1000, "--display", "128x128")), layers)

    def test_a_pixel_that_is_covered_partly_is_grey(self):
        # 20.025 mm are 400.5 pixels: a quarter of a pixel on each side.
        picture = self.masks(box((0, 0, 0), (20.025, 20.025, 1)), 1000)["0001.png"]
        self.assertEqual(picture.lit_box(), (759, 339, 1161, 741))
        edge, inner = picture.rows[339], picture.rows[500]
        for found, expected in ((inner[759], 0.25), (inner[1160], 0.25), (edge[1000], 0.25), (edge[759], 0.0625)):
            self.assertAlmostEqual(found, 255 * expected, delta=1)  # rounding to whole grey values
        self.assertEqual(set(inner[760:1160]), {255})

    def test_without_anti_aliasing_a_pixel_is_black_or_white_by_its_centre(self):
        picture = self.masks(box((0, 0, 0), (20.025, 20.075, 1)), 1000, "--aa", "off")["0001.png"]
        self.assertEqual(picture.values(), {0, 255})
        # Along x, 0.25 of a pixel on each side does not reach the pixel's centre; along y, 0.75 of a pixel does.
        self.assertEqual(picture.lit_box(), (760, 339, 1160, 741))
        slanted = self.masks(wedge(20, 20, 20), 70, "--aa", "off", "--display", "500x500")
        self.assertEqual(set().union(*(picture.values() for picture in slanted.values())), {0, 255})

    def test_a_correction_that_erases_a_wall_or_a_pin_gives_a_warning(self):
        for thin in (box((30, 0, 0), (30.1, 20, 20)), box((30, 9, 0), (30.1, 9.1, 20))):
            path = self.write("thin.stl", binary_stl(cube(20) + thin))
            layers, cut = ("--layer-height-um", "1000", "--masks", self.path("masks"), "--force"), ("--z", "5", "--mask", self.path("one.png"))
            for words in (layers, cut):
                self.assertEqual(contourctl("slice", path, *words, expect=OK).stderr, b"")
                warned = contourctl("slice", path, *words, "--grow-um", "-60", expect=OK).stderr.decode()
                self.assertRegex(warned, r"^contourctl: warning: the compensation moves outlines by -60 um in layer 1 and erases walls and pins .* nothing is left at 15\.0\d, -?[01]\.\d\d mm from the plate's centre")
            self.assertEqual(contourctl("slice", path, *cut, "--grow-um", "60", expect=OK).stderr, b"")

    def test_contours_grow_and_the_elephant_foot_is_removed(self):
        # 20 mm plus 2 x 100 um; at a height of 0.5 mm half of the 200 um for the elephant foot are still taken off.
        masks = self.masks(cube(20), 1000, "--grow-um", "100", "--elephant-foot-um", "200",
                           "--elephant-foot-height-um", "1000")  # fmt: skip
        widths = [picture.lit_box()[2] - picture.lit_box()[0] for picture in masks.values()]
        self.assertEqual(widths, [400] + [404] * 19)
        self.assertEqual(self.masks(cube(20), 5000, "--grow-um", "-150")["0004.png"].lit_box(), (763, 343, 1157, 737))

    def test_uniformity_mask_gamma_and_threshold_change_the_grey(self):
        # A uniformity mask made from a mask: 255 over the model, 0 beside it.
        self.masks(cube(20), 20000)
        os.rename(self.path("masks", "0001.png"), self.path("even.png"))
        picture = self.masks(cube(30), 30000, "--uniformity-mask", self.path("even.png"))["0001.png"]
        self.assertEqual(picture.lit_box(), (760, 340, 1160, 740))
        # A quarter of a pixel is grey 64, 255 (64 / 255) ^ (1 / 2.2) = 136.
        facets = box((0, 0, 0), (20.025, 20, 1))
        self.assertEqual(self.masks(facets, 1000, "--gamma", "2.2")["0001.png"].values(), {0, 136, 255})
        self.assertEqual(self.masks(facets, 1000, "--threshold", "64")["0001.png"].values(), {0, 64, 255})
        self.assertEqual(self.masks(facets, 1000, "--threshold", "65")["0001.png"].values(), {0, 255})

    def test_display_and_pitch_are_honoured(self):
        picture = self.masks(cube(2), 1000, "--display", "70x50", "--pixel-pitch-um", "200")["0001.png"]
        self.assertEqual((picture.width, picture.height), (70, 50))
        self.assertEqual(picture.lit_box(), (30, 20, 40, 30))

    def test_fit_fills_the_display_and_keeps_the_shape(self):
        # Equations 3.8 and 3.16 to 3.19: 99 pixels for the 20 mm along y, starting at the corner.
        tall = self.masks(box((5, 5, 0), (15, 25, 1)), 1000, "--fit", "--display", "200x100", "--aa", "off")["0001.png"]
        self.assertEqual(tall.lit_box(), (0, 0, 49, 99))  # 10 mm are 49.5 pixels; the centre of the 50th lies on the edge
        wide = self.masks(box((5, 5, 0), (65, 15, 1)), 1000, "--fit", "--display", "200x100", "--aa", "off")["0001.png"]
        self.assertEqual(wide.lit_box(), (0, 0, 199, 33))  # 199 pixels for 60 mm: 10 mm are 33.2

    def test_a_model_larger_than_the_display_is_cut_off_with_a_warning(self):
        picture = self.masks(cube(20), 10000, "--display", "100x50")["0001.png"]
        self.assertEqual(picture.values(), {255})
        self.assert_one_line(self.warnings, "larger than the display")

    def test_the_same_model_gives_the_same_bytes(self):
        def written():
            return {name: contents(self.path("masks", name)) for name in os.listdir(self.path("masks"))}

        self.masks(wedge(20, 10, 10), 500, "--display", "500x300")
        first = written()
        self.masks(wedge(20, 10, 10), 500, "--display", "500x300")
        self.assertEqual(written(), first)

    def test_adaptive_layers_are_cut_at_their_own_middles(self):
        # A box of 2 mm has no slopes, so it gets 20 layers of the largest height, 100 um.
        path = self.write("box.stl", binary_stl(box((0, 0, 1), (10, 10, 3))))
        csv = self.path("layers.csv")
        contourctl("slice", path, "--cusp-um", "28", "--csv", csv, expect=0)
        with open(csv, encoding="utf-8") as file:
            heights = [float(line.split(",")[1]) for line in file.readlines()[1:]]
        self.assertEqual(len(heights), 20)
        for number, height in enumerate(heights):
            self.assertAlmostEqual(height, 1.05 + 0.1 * number, delta=1e-6)
        for arguments in (["--cusp-um", "0"], ["--cusp-um", "5", "--layer-height-um", "50"], ["--cusp-um", "5", "--mask", "m"],
                          ["--cusp-um", "5", "--min-layer-um", "50", "--max-layer-um", "40"]):  # fmt: skip
            self.assertEqual(contourctl("slice", path, *arguments).returncode, 64, arguments)

    def test_more_than_9999_layers_have_longer_names(self):
        masks = self.masks(box((0, 0, 0), (1, 1, 10.001)), 1, "--display", "8x8", "--pixel-pitch-um", "500")
        self.assertEqual(len(masks), 10001)
        self.assertIn("9999.png", masks)
        self.assertIn("10001.png", masks)

    def test_a_mask_that_cannot_be_written_gives_73_and_one_line(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        taken = self.write("file", b"")
        # A link instead of the device itself, which a program would remove if it cleaned up after a failed write.
        full = self.path("full")
        os.symlink("/dev/full", full)
        for arguments in (["--z", "5", "--mask", self.path("missing", "mask.png")],
                          ["--z", "5", "--mask", self.folder],
                          ["--z", "5", "--mask", full],
                          ["--layer-height-um", "5000", "--masks", taken],
                          ["--layer-height-um", "5000", "--masks", "/proc/no"],
                          ["--layer-height-um", "5000", "--contours", taken],
                          ["--layer-height-um", "5000", "--csv", self.path("missing", "layers.csv")],
                          ["--layer-height-um", "5000", "--csv", full]):  # fmt: skip
            with self.subTest(arguments):
                result = contourctl("slice", model, *arguments, expect=CANNOT_CREATE)
                self.assert_one_line(result.stderr, arguments[-1])
                if not os.path.lexists(full):
                    os.symlink("/dev/full", full)

    def test_the_error_names_the_lowest_of_several_masks_that_cannot_be_written(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        for name in ("0004.png", "0005.png", "0006.png", "0017.png"):
            os.makedirs(self.path("masks", name))
        for _ in range(3):
            result = contourctl("slice", model, "--layer-height-um", "10", "--masks", self.path("masks"), "--force", expect=CANNOT_CREATE)
            self.assert_one_line(result.stderr, self.path("masks", "0004.png"))
            written = os.listdir(self.path("masks"))
            self.assertTrue({"0001.png", "0002.png", "0003.png"}.issubset(written), written)
            self.assertNotIn("2000.png", written)

    def test_a_failed_write_removes_no_existing_file(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        full = self.path("full")
        os.symlink("/dev/full", full)
        for arguments in (["--z", "5", "--mask", full], ["--layer-height-um", "5000", "--csv", full]):
            contourctl("slice", model, *arguments)
            self.assertTrue(os.path.islink(full), arguments)


class Measurements(FolderTest):
    COLUMNS = ["layer", "z_mm", "slicing_ms", "contour_ms", "total_ms", "intersecting_facets", "loop_count"]

    def measure(self, facets, layer_height_um, *arguments):
        path = self.write("model.stl", binary_stl(facets))
        result = contourctl("slice", path, "--layer-height-um", str(layer_height_um), "--csv", self.path("out.csv"),
                            "--json", *arguments)  # fmt: skip
        self.assertEqual(result.returncode, OK, result.stderr)
        with open(self.path("out.csv"), newline="", encoding="ascii") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0], self.COLUMNS)
        return [dict(zip(self.COLUMNS, map(float, row))) for row in rows[1:]], json.loads(result.stdout)

    def test_each_layer_has_a_row(self):
        facets = box((0, 0, 2), (20, 20, 7)) + box((5, 5, 7), (15, 15, 12)) + box((30, 0, 2), (40, 10, 12))
        rows, _ = self.measure(facets, 1000)
        self.assertEqual([row["layer"] for row in rows], list(range(1, 11)))
        for row in rows:
            self.assertAlmostEqual(row["z_mm"], 2 + row["layer"] - 0.5, delta=1e-6)  # six decimals
            self.assertAlmostEqual(row["total_ms"], row["slicing_ms"] + row["contour_ms"], delta=2e-6)
            self.assertGreater(row["total_ms"], 0)
            self.assertEqual((row["intersecting_facets"], row["loop_count"]), (16, 2))

    def test_the_summary_holds_mean_deviation_and_correlation_of_the_rows(self):
        facets = cube(20) + [v for i in range(8) for v in box((30 * i, 30, 0), (30 * i + 9, 39, 2 + 2 * i))]
        rows, printed = self.measure(facets, 100)
        with open(self.path("out-summary.csv"), newline="", encoding="ascii") as file:
            summary = {row[0]: row[1:] for row in csv.reader(file)}
        self.assertEqual(summary.pop("measurement"), ["mean", "standard_deviation"])

        def column(name):
            return [row[name] for row in rows]

        for name in ("slicing_ms", "contour_ms", "total_ms", "intersecting_facets", "loop_count"):
            values = column(name)
            mean = sum(values) / len(values)
            deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
            found = [float(value) for value in summary.pop(name)]
            # The files have six decimals; the errors of the rows average out.
            self.assertAlmostEqual(found[0], mean, delta=2e-6, msg=name)
            self.assertAlmostEqual(found[1], deviation, delta=2e-6, msg=name)
            self.assertAlmostEqual(printed[name]["mean"], mean, delta=2e-6, msg=name)
            self.assertAlmostEqual(printed[name]["sd"], deviation, delta=2e-6, msg=name)
        for other in ("loop_count", "intersecting_facets"):
            x, y = column("contour_ms"), column(other)
            expected = sum(a * b for a, b in zip(x, y)) / math.sqrt(sum(a * a for a in x) * sum(b * b for b in y))
            found = float(summary.pop(f"normalized_correlation_contour_time_vs_{other}")[0])
            # A contour time of some hundred nanoseconds has three digits at six decimals.
            self.assertAlmostEqual(found, expected, delta=0.01, msg=other)
        self.assertEqual(summary, {})
        self.assertEqual((printed["layers"], printed["facets"]), (200, len(facets)))

    def test_contours_are_one_file_per_layer_with_the_points_of_every_loop(self):
        facets = box((0, 0, 0), (20, 10, 3)) + inside_out(box((5, 2, 0), (15, 8, 3)))
        self.measure(facets, 1000, "--contours", self.path("contours"), "--display", "800x600", "--pixel-pitch-um", "100")
        self.assertEqual(sorted(os.listdir(self.path("contours"))), ["0001.csv", "0002.csv", "0003.csv"])
        with open(self.path("contours", "0002.csv"), newline="", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        areas = {}
        for loop in {row["loop"] for row in rows}:
            points = [(float(row["x_mm"]), float(row["y_mm"])) for row in rows if row["loop"] == loop]
            areas[loop] = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points[:1])) / 2
        self.assertEqual(sorted(round(area, 6) for area in areas.values()), [-60, 200])  # the hole runs clockwise
        for row in rows:
            self.assertAlmostEqual(float(row["x_pixel"]), 400 + (float(row["x_mm"]) - 10) * 10, delta=2e-3)
            self.assertAlmostEqual(float(row["y_pixel"]), 300 - (float(row["y_mm"]) - 5) * 10, delta=2e-3)

    def test_masks_contours_and_measurements_can_be_written_in_one_run(self):
        self.measure(cube(5), 1000, "--masks", self.path("masks"), "--contours", self.path("contours"))
        self.assertEqual(len(os.listdir(self.path("masks"))), 5)
        self.assertEqual(len(os.listdir(self.path("contours"))), 5)

    def test_json_is_printed_in_addition_to_masks(self):
        model = self.write("model.stl", binary_stl(cube(5)))
        result = contourctl("slice", model, "--layer-height-um", "1000", "--masks", self.path("masks"), "--json")
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        self.assertEqual(json.loads(result.stdout)["layers"], 5)
        self.assertEqual(len(os.listdir(self.path("masks"))), 5)

    def test_cracks_give_a_warning_whatever_output_is_requested(self):
        # A side is missing above 3 mm.
        facets = [f for f in box((0, 0, 3), (20, 20, 5)) if not all(vertex[0] == 20 for vertex in f)]
        model = self.write("model.stl", binary_stl(box((0, 0, 0), (20, 20, 3)) + facets))
        warning = (b"contourctl: warning: the model is cracked in 2 of 5 layers: 2 open chains, 0 turned, 0 gaps "
                   b"closed, the widest 20 mm\n")  # fmt: skip
        figures = {"open_chains": 1, "turned_chains": 0, "gaps_closed": 0, "widest_gap_mm": 20}
        for arguments in ([], ["--csv", self.path("out.csv")], ["--masks", self.path("masks")], ["--json"],
                          ["--json", "--masks", self.path("others")]):  # fmt: skip
            with self.subTest(arguments=arguments):
                result = contourctl("slice", model, "--layer-height-um", "1000", *arguments)
                self.assertEqual((result.returncode, result.stderr), (OK, warning))
                if "--json" in arguments:
                    found = json.loads(result.stdout)
                    self.assertEqual({name: found[name] for name in figures}, {**figures, "open_chains": 2})
                    self.assertEqual(found["cracked_layer_list"], [{"layer": 4, **figures}, {"layer": 5, **figures}])


class EarlierLayers(FolderTest):
    """A folder that already holds the layers of another model."""

    def slice(self, height, *arguments):
        model = self.write("model.stl", binary_stl(box((0, 0, 0), (5, 5, height))))
        return contourctl("slice", model, "--layer-height-um", "1000", *arguments)

    def test_a_folder_with_an_earlier_models_layers_is_refused_and_stays_as_it_is(self):
        for option, extension in (("--masks", ".png"), ("--contours", ".csv")):
            with self.subTest(option):
                folder = self.path(extension)
                self.assertEqual(self.slice(30, option, folder).returncode, OK)
                result = self.slice(20, option, folder)
                self.assert_refusal(result, CANNOT_CREATE, folder, "30", "0001" + extension, "0030" + extension, "--force")
                self.assertEqual(len(os.listdir(folder)), 30)
                # Even a single old layer could be taken for one of this model's.
                for number in range(1, 31):
                    if number != 25:
                        os.unlink(os.path.join(folder, f"{number:04}{extension}"))
                self.assertEqual(self.slice(20, option, folder).returncode, CANNOT_CREATE)
                self.assertEqual(os.listdir(folder), [f"0025{extension}"])

    def test_with_force_earlier_layers_are_replaced_and_nothing_else_is_touched(self):
        folder, outside = self.path("masks"), self.path("outside.png")
        self.assertEqual(self.slice(30, "--masks", folder).returncode, OK)
        self.write(outside, b"outside")
        others = ["notes.txt", "1.png", "0001.png.txt", "00001.png", "layer0001.png", "0001.csv", "0001.PNG", ".0001.png", "00a1.png"]
        for name in others:
            self.write(os.path.join(folder, name), b"mine")
        os.symlink(outside, os.path.join(folder, "0100.png"))
        os.mkdir(os.path.join(folder, "0200.png"))
        self.write(os.path.join(folder, "10000.png"), b"")
        self.assertEqual(self.slice(20, "--masks", folder, "--force").returncode, OK)
        new = [f"{number:04}.png" for number in range(1, 21)]
        self.assertEqual(sorted(os.listdir(folder)), sorted([*new, *others, "0200.png"]))
        self.assertEqual(contents(outside), b"outside")

    def test_an_empty_folder_and_one_with_other_files_need_no_force(self):
        os.mkdir(self.path("masks"))
        self.write("masks/notes.txt", b"mine")
        self.assertEqual(self.slice(20, "--masks", self.path("masks"), "--contours", self.path("masks")).returncode, OK)
        self.assertEqual(len(os.listdir(self.path("masks"))), 41)

    def test_force_alone_is_bad_usage(self):
        for arguments in ([], ["--csv", self.path("layers.csv")]):
            self.assertEqual(self.slice(20, "--force", *arguments).returncode, BAD_USAGE)


class NoSuchLayers(FolderTest):
    def test_too_many_layers_are_bad_data_and_are_reported_at_once(self):
        counted = "the model has 2000000000 layers, at most 10000000 can be printed"
        uncounted = "the model has more than 10000000 layers"
        for height, arguments, sentence in (
            (1e8, ["slice", "--layer-height-um", "50"], counted), (1e8, ["analyze"], counted),
            (3e38, ["slice", "--layer-height-um", "50"], uncounted), (3e38, ["analyze"], uncounted),
            (3e38, ["slice", "--cusp-um", "15"], uncounted),
        ):  # fmt: skip
            with self.subTest(height=height, arguments=arguments):
                path = self.write("tall.stl", binary_stl(box((0, 0, 0), (5, 5, height))))
                # A list of all layers would take 16 GB, or would never end.
                result = contourctl(*arguments, path, timeout=20, preexec_fn=lambda: limit_memory(256 << 20))
                self.assertEqual((result.returncode, result.stdout), (BAD_DATA, b""))
                self.assertEqual(result.stderr, f"contourctl: {sentence}\n".encode())


    def test_a_model_too_thin_for_a_layer_is_bad_data(self):
        flat = [((0, 0, 3), (9, 0, 3), (0, 9, 3))]
        for facets, layers, height in (
            (flat, ["--layer-height-um", "50"], "0"), (flat, ["--cusp-um", "15"], "0"), ([], ["--layer-height-um", "50"], "0"),
            (cube(2), ["--layer-height-um", "1e6"], "2"),
        ):  # fmt: skip
            for more in ([], ["--json"], ["--masks", self.path("masks")], ["--csv", self.path("out.csv")]):
                with self.subTest(facets=len(facets), arguments=layers + more):
                    path = self.write("model.stl", binary_stl(facets))
                    result = contourctl("slice", path, *layers, *more)
                    self.assertEqual((result.returncode, result.stdout), (BAD_DATA, b""))
                    sentence = f"contourctl: {os.fsdecode(path)}: the model is {height} mm high, too thin for a layer\n"
                    self.assertEqual(result.stderr.decode(), sentence)
        self.assertEqual(os.listdir(self.folder), ["model.stl"])


class BadUsage(FolderTest):
    def test_bad_usage_gives_64_and_a_message(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        layers = ["slice", model, "--layer-height-um", "50"]
        at = ["slice", model, "--z", "5"]
        for arguments in (
            [], ["bake"], ["--no-such-option"], ["inspect"], ["inspect", model, "--no-such-option"],
            ["inspect", model, model], ["slice"], ["slice", model], ["slice", "--z", "5"], ["slice", model, "--z"],
            at + ["--layer-height-um", "50"], ["slice", model, "--z", "five"], ["slice", model, "--z", "5mm"],
            ["slice", model, "--z", "nan"], ["slice", model, "--z", "inf"], ["slice", model, "--z", ""],
            ["slice", model, "--z", "5,5"],
            ["slice", model, "--layer-height-um", "0"], ["slice", model, "--layer-height-um", "-50"],
            ["slice", model, "--layer-height-um", "nan"], ["slice", model, "--layer-height-um", "inf"],
            ["slice", model, "--layer-height-um", "1e300"], ["slice", model, "--layer-height-um", "thin"],
            at + ["--masks", "d"], at + ["--csv", "f"], at + ["--contours", "d"], layers + ["--mask", "f"],
            at + ["--display", "0x100"], at + ["--display", "1920"], at + ["--display", "1920x"],
            at + ["--display", "1920x1080x3"], at + ["--display", "-5x5"], at + ["--display", "99999x1"],
            at + ["--display", "99999999999999999999x1"], at + ["--display", " 5x5 "], at + ["--display", ""],
            at + ["--pixel-pitch-um", "0"], at + ["--pixel-pitch-um", "-1"], at + ["--pixel-pitch-um", "nan"],
            at + ["--pixel-pitch-um", "inf"], at + ["--aa", "maybe"], at + ["--aa"], at + ["--z", "6"],
            at + ["--grow-um", "50"], at + ["--gamma", "2.2"], at + ["--threshold", "9"], layers + ["--uniformity-mask", "l"],
            layers + ["--csv", "f", "--grow-um", "5"], at + ["--mask", "f", "--grow-um", "501"],
            at + ["--mask", "f", "--grow-um", "nan"], at + ["--mask", "f", "--elephant-foot-um", "50"],
            at + ["--mask", "f", "--elephant-foot-height-um", "50"], at + ["--mask", "f", "--gamma", "0"],
            at + ["--mask", "f", "--gamma", "nan"], at + ["--mask", "f", "--threshold", "256"],
            at + ["--mask", "f", "--threshold", "1.5"], at + ["--mask", "f", "--grow-um", "5", "--fit"],
            at + ["--mask", "f", "--uniformity-mask", model], at + ["--mask", "f", "--uniformity-mask", ""],
        ):  # fmt: skip
            with self.subTest(arguments):
                result = contourctl(*arguments, cwd=self.folder, expect=BAD_USAGE)
                self.assertEqual(result.stdout, b"")
                self.assertGreater(len(result.stderr.strip()), 10)
        self.assertEqual(os.listdir(self.folder), ["model.stl"])

    def test_the_error_about_a_length_names_both_limits(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        for arguments, sentence in (
            (["--cusp-um", "15", "--min-layer-um", "1e30"], "--min-layer-um 1e+30: expected 1 to 1000000"),
            (["--layer-height-um", "1000001"], "--layer-height-um 1000001: expected 1 to 1000000"),
            (["--cusp-um", "0"], "--cusp-um 0: expected 0.1 to 1000000"),
        ):  # fmt: skip
            result = contourctl("slice", model, *arguments)
            self.assertEqual((result.returncode, result.stderr), (BAD_USAGE, f"contourctl: {sentence}\n".encode()))

    def test_an_empty_output_path_is_an_error(self):
        # An unset shell variable gives an empty path.
        model = self.write("model.stl", binary_stl(cube(20)))
        for arguments in (["--z", "5", "--mask", ""], ["--layer-height-um", "5000", "--masks", ""],
                          ["--layer-height-um", "5000", "--csv", ""],
                          ["--layer-height-um", "5000", "--contours", ""]):  # fmt: skip
            with self.subTest(arguments):
                self.assertIn(contourctl("slice", model, *arguments).returncode, (BAD_USAGE, CANNOT_CREATE))

    def test_a_negative_height_is_a_number_not_an_option(self):
        model = self.write("model.stl", binary_stl(box((0, 0, -5), (1, 1, 5))))
        result = contourctl("slice", model, "--z", "-1.5", "--json", expect=OK)
        self.assertEqual(json.loads(result.stdout)["z_mm"], -1.5)

    def test_help_and_version_succeed(self):
        for arguments in (["--help"], ["--version"], ["slice", "--help"], ["inspect", "--help"]):
            result = contourctl(*arguments)
            self.assertEqual((result.returncode, result.stderr), (OK, b""))
            self.assertGreater(len(result.stdout), 4)


class Output(FolderTest):
    def test_a_pipe_that_closes_early_ends_contourctl_without_a_crash(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        for arguments in (["inspect", "--json", model], ["slice", model, "--z", "5", "--json"], ["--help"]):
            reader, writer = os.pipe()
            os.close(reader)
            result = contourctl(*arguments, stdout=writer, timeout=10)
            os.close(writer)
            self.assertIn(result.returncode, (-signal.SIGPIPE, CANNOT_CREATE), result)

    def test_a_full_standard_output_is_an_error(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        layers = ["slice", model, "--layer-height-um", "50", "--json"]
        for arguments in (["inspect", model], ["inspect", "--json", model], ["slice", model, "--z", "5", "--json"], layers,
                          ["analyze", model], ["--help"], ["slice", "--help"], ["--version"]):  # fmt: skip
            with open("/dev/full", "wb") as full:
                result = contourctl(*arguments, stdout=full)
            self.assert_refusal(result, CANNOT_CREATE)

    def test_a_closed_standard_output_is_an_error(self):
        model = self.write("model.stl", binary_stl(cube(20)))
        result = subprocess.run(["sh", "-c", f"exec {CONTOURCTL} inspect {os.fsdecode(model)} >&-"],
                                stderr=subprocess.PIPE, check=False)  # fmt: skip
        self.assert_refusal(result, CANNOT_CREATE)

    def test_messages_contain_no_control_characters(self):
        odd = "\x1b[31m\x9b2J\u202e\u2066\u2028\x07\r"
        model = self.write(f"{odd}.stl", f"solid {odd}\nfacet {odd}\n".encode())
        good = self.write(f"good{odd}.stl", binary_stl(cube(5)))
        ticket = self.write(f"{odd}.json", json.dumps({odd: 1, "resin": odd}))
        printer = self.write("printer.json", json.dumps({**source_json("simulated.json"), odd: odd}))
        for arguments in (["inspect", model], ["analyze", model], ["slice", model, "--z", odd], [odd],
                          ["slice", good, "--layer-height-um", "1000", "--masks", good],
                          ["analyze", good, "--printer", ticket], ["analyze", good, "--printer", printer],
                          ["analyze", good, "--printer", os.path.join(SOURCE, "config", "simulated.json"), "--ticket", ticket],
                          ["status", "--socket", self.path(odd)], ["inspect", self.path(odd)]):  # fmt: skip
            with self.subTest(arguments=arguments):
                result = contourctl(*arguments)
                self.assertNotEqual(result.returncode, OK)
                output = (result.stdout + result.stderr).decode("utf-8")
                self.assertTrue(output)
                for char in "\x1b\x9b\u202e\u2066\u2028\x07\r":
                    self.assertNotIn(char, output)

    def test_it_reads_a_model_from_a_redirected_file(self):
        with open(self.write("model.stl", binary_stl(cube(20))), "rb") as file:
            result = contourctl("inspect", "--json", "/dev/stdin", stdin=file)
        self.assertEqual(result.returncode, OK, result.stderr)
        self.assertEqual(json.loads(result.stdout)["facets"], 12)

    def test_numbers_do_not_depend_on_the_locale(self):
        locales = subprocess.run(["locale", "-a"], stdout=subprocess.PIPE, check=False).stdout.decode().split()
        comma = [name for name in locales if name.startswith(("de_", "fr_"))]
        model = self.write("model.stl", ascii_stl(box((0, 0, 0), (1.5, 2.5, 3.5))))
        for name in comma[:1] + ["C", "tr_TR.UTF-8"]:
            result = contourctl("inspect", "--json", model, env={**os.environ, "LC_ALL": name})
            self.assertEqual(json.loads(result.stdout)["size_mm"], [1.5, 2.5, 3.5])
