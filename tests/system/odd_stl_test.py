"""The shared collection of strange and broken STL files, through contourctl and through the spool."""

import concurrent.futures
import csv
import hashlib
import json
import os
import re
import unittest

from harness import BAD_DATA, OK, SHARED, Daemon, FolderTest, binary_stl, box, contents, contourctl, cube, limit_memory, skip_file

FOLDER = os.path.join(SHARED, "odd-stl")
TIME_LIMIT_S = 10

# The table's formats and figures come from a lenient reader. This project refuses these files on purpose:
REFUSED = {
    "openscad-empty.stl": "no bytes at all",
    "openscad-toomanyvertices.stl": "a facet with four vertices",
    "openscad-unparseable.stl": "garbage for a coordinate",
    "synth-asc-just-solid.stl": "ends after the first word",
    "synth-asc-nan-vertex.stl": "not a number",
    "synth-asc-no-endsolid.stl": "cut short: no endsolid",
    "synth-asc-trunc-midvertex.stl": "cut short",
    "synth-bin-79.stl": "76 bytes of '#'",
    "synth-bin-attr-bytecount.stl": "52 bytes a facet",
    "synth-bin-inf-vertex.stl": "infinite coordinates",
    "synth-bin-nan-vertex.stl": "not a number",
}
# Files that are read with a number of facets other than the table's.
OTHER_FACETS = {
    "numpystl-bin-HalfDonut.stl": 288,  # binary with one byte too many; the table's reader took it for ASCII
    "synth-bin-count-2.stl": 2,  # the header's count, with a warning
}
# Single facets, walls without a thickness, a needle: these files are read, but contain nothing to print.
DARK = {
    "miraclegrue-OneTriangle.stl", "online3d-two_triangles.stl", "openscad-single-triangle.stl", "pyntcloud-diamond.stl",
    "synth-geo-tall-sliver.stl",
}  # fmt: skip
# File, height in mm, and the area in mm2 that the table states for the section at that height.
AREAS = [
    ("synth-geo-far-from-origin.stl", 5, 100), ("synth-geo-gap-1um.stl", 5, 100),
    ("synth-geo-nested-same-winding.stl", 10, 400), ("synth-geo-nested3.stl", 15, 600),
    ("synth-geo-open-tube.stl", 5, 100), ("synth-geo-overlap-boxes.stl", 5, 175), ("synth-geo-shared-face.stl", 5, 200),
    ("synth-geo-stacked.stl", 5, 100), ("synth-geo-t-junction.stl", 2, 100), ("synth-geo-t-junction.stl", 5, 100),
    ("synth-geo-t-junction.stl", 7, 100), ("mayo-cube-binary.stl", 5, 100), ("prusa-20mmbox-CR.stl", 10, 400),
    ("prusa-20mmbox-umlaut.stl", 10, 400), ("bitpit-cubeAscii_MultiSolid.stl", 0, 2), ("trimesh-shared.stl", 0, 2),
    ("openscad-cubes-touching.stl", 0.5, 2), ("trimesh-7_8ths_cube.stl", -10, 1600), ("trimesh-7_8ths_cube.stl", 10, 1200),
]  # fmt: skip


def table():
    path = os.path.join(FOLDER, "TABLE.tsv")
    if not os.path.exists(path):
        skip_file(f"{path} does not exist")
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def path_of(name):
    return os.path.join(FOLDER, name)


def inspect(name):
    # A facet takes 36 bytes, and about 150 more while edges are counted: 50 bytes of a binary file become about 200.
    # ASCII is less dense. The constant is for the program, its libraries and its thread's stack.
    limit = (96 << 20) + 12 * os.path.getsize(path_of(name))
    return contourctl("inspect", "--json", path_of(name), timeout=TIME_LIMIT_S,
                      preexec_fn=lambda: limit_memory(limit))  # fmt: skip


class Inspect(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rows = table()
        cls.results = {row["file"]: inspect(row["file"]) for row in cls.rows}

    def read(self):
        for row in self.rows:
            result = self.results[row["file"]]
            if result.returncode == OK and row["file"] not in REFUSED:
                yield row, json.loads(result.stdout)

    def test_the_collection_is_complete(self):
        self.assertEqual(len(self.rows), 141)

    def test_each_file_is_read_or_refused_with_one_line(self):
        for row in self.rows:
            with self.subTest(row["file"]):
                result = self.results[row["file"]]
                self.assertIn(result.returncode, (OK, BAD_DATA), result)
                if result.returncode == OK:
                    self.assertEqual(result.stderr, b"")
                    continue
                self.assertEqual(result.stdout, b"")
                text = result.stderr.decode()
                self.assertEqual(text.count("\n"), 1, text)
                self.assertTrue(text.startswith(f"contourctl: {path_of(row['file'])}: "), text)
                self.assertNotIn("memory", text)
                self.assertGreater(len(text.split(": ", 2)[2].split()), 3, text)
                self.assertTrue(text.isprintable() or text[:-1].isprintable(), text)

    def test_exactly_the_untrustworthy_files_are_refused(self):
        refused = {name for name, result in self.results.items() if result.returncode == BAD_DATA}
        self.assertEqual(refused, set(REFUSED))

    def test_format_and_facet_count_are_as_in_the_table(self):
        for row, found in self.read():
            name = row["file"]
            with self.subTest(name):
                self.assertEqual(found["facets"], OTHER_FACETS.get(name, int(row["facets"])))
                expected = "binary" if name in OTHER_FACETS else row["format"].split("(")[0]
                self.assertEqual(found["format"], expected)

    def test_bounds_are_as_in_the_table(self):
        for row, found in self.read():
            if row["file"] in OTHER_FACETS or not row["bbox"].strip("-"):
                continue
            with self.subTest(row["file"]):
                low, high = ([float(x) for x in end.split(",")] for end in row["bbox"].split(".."))
                for found_end, expected_end in ((found["bounds_mm"]["min"], low), (found["bounds_mm"]["max"], high)):
                    for a, b in zip(found_end, expected_end):
                        self.assertAlmostEqual(a, b, delta=abs(b) * 6e-4)  # the table has four digits

    def test_edges_and_facets_are_counted_as_in_the_table(self):
        keys = {"open": "open_edges", "nonman": "non_manifold_edges", "flip": "flipped_edges",
                "degen": "degenerate_facets", "zero": "zero_area_facets", "dup": "duplicate_facets"}  # fmt: skip
        compared = 0
        for row, found in self.read():
            figures = dict(item.split("=") for item in row["edges"].split())
            if figures["open"] == "-" or row["file"] in OTHER_FACETS:
                continue
            compared += 1
            with self.subTest(row["file"]):
                self.assertEqual({key: str(found[name]) for key, name in keys.items()},
                                 {key: figures[key] for key in keys})  # fmt: skip
                self.assertEqual(found["watertight"], row["watertight"] == "yes")
        self.assertGreater(compared, 110)

    def test_volumes_are_as_in_the_table(self):
        stated = 0
        for row, found in self.read():
            match = re.search(r"volume ([\d.]+)", row["expected_by_project"])
            if match:
                stated += 1
                digits = len(match[1].split(".")[1])
                self.assertAlmostEqual(found["volume_mm3"], float(match[1]), delta=0.6 * 10**-digits)
        self.assertGreaterEqual(stated, 3)

    def test_the_same_model_in_two_formats_has_the_same_figures(self):
        for one, other in (("mayo-cube-ascii.stl", "mayo-cube-binary.stl"),
                           ("numpystl-ascii-Moon.stl", "numpystl-bin-Moon.stl"),
                           ("openscad-import_bin.stl", "openscad-import_bin_solid.stl"),
                           ("prusa-20mmbox-LF.stl", "prusa-20mmbox-CRLF.stl"),
                           ("prusa-20mmbox-LF.stl", "prusa-20mmbox-CR.stl")):  # fmt: skip
            found = [json.loads(self.results[name].stdout) for name in (one, other)]
            for each in found:
                del each["format"]
                each["volume_mm3"] = round(each["volume_mm3"], 9)
            self.assertEqual(*found)

    def test_oddities_that_do_not_change_the_shape_give_a_warning(self):
        for name in ("synth-bin-count-2.stl", "synth-bin-count-66.stl", "synth-bin-count-ffffffff.stl",
                     "synth-bin-trailing-1k.stl", "synth-bin-trailing-lf.stl", "numpystl-bin-HalfDonut.stl"):  # fmt: skip
            # Some of the models are so small that their unit is doubted.
            warnings = [each for each in json.loads(self.results[name].stdout)["warnings"] if "is drawn in" not in each]
            self.assertEqual(len(warnings), 1, name)


class Slice(unittest.TestCase):
    def slice(self, name, z):
        result = contourctl("slice", path_of(name), "--z", str(z), "--json", timeout=TIME_LIMIT_S, expect=OK)
        return json.loads(result.stdout)

    def test_areas_are_as_in_the_table(self):
        table()
        for name, z, area in AREAS:
            with self.subTest(name, z=z):
                # A crack of 1 um along 10 mm is 0.01 mm2; all other areas are exact except for rounding.
                tolerance = 0.011 if "gap" in name else area * 1e-6
                self.assertAlmostEqual(self.slice(name, z)["area_mm2"], area, delta=tolerance)

    def test_the_section_where_two_boxes_touch_is_that_of_one_box(self):
        area = self.slice("synth-geo-spiral-touch.stl", 10)["area_mm2"]
        self.assertTrue(abs(area - 100) < 1e-6 or abs(area - 16) < 1e-6, area)

    def test_added_bad_facets_do_not_change_a_section(self):
        for z in (0.1, 0.5, 0.9):
            whole = self.slice("synth-asc-lf.stl", z)
            for name in ("synth-bin-degenerate.stl", "synth-bin-dup-facet.stl"):
                with self.subTest(name, z=z):
                    found = self.slice(name, z)
                    self.assertAlmostEqual(found["area_mm2"], whole["area_mm2"], delta=1e-9)
                    self.assertEqual(found["open_chains"], 0)

    def test_one_turned_facet_still_gives_the_area(self):
        for z in (0.1, 0.5, 0.9):
            with self.subTest(z):
                whole, turned = self.slice("synth-asc-lf.stl", z), self.slice("synth-bin-flipped-one.stl", z)
                self.assertAlmostEqual(turned["area_mm2"], whole["area_mm2"], delta=1e-6)

    def test_a_sliver_has_one_contour_at_every_height(self):
        for z in (0.001, 1, 33.3, 50, 99, 99.99):
            self.assertEqual(self.slice("synth-geo-tall-sliver.stl", z)["contours"], 1, z)

    def test_every_file_is_cut_in_the_middle_within_the_time_limit(self):
        def cut(row):
            result = contourctl("inspect", "--json", path_of(row["file"]), timeout=TIME_LIMIT_S)
            if result.returncode != OK:
                return None
            bounds = json.loads(result.stdout)["bounds_mm"]
            z = (bounds["min"][2] + bounds["max"][2]) / 2 if bounds else 0
            arguments = ("slice", path_of(row["file"]), "--z", repr(z), "--json")
            return row, contourctl(*arguments, timeout=TIME_LIMIT_S)

        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for found in filter(None, pool.map(cut, table())):
                row, result = found
                with self.subTest(row["file"]):
                    self.assertEqual(result.returncode, OK, result.stderr)
                    section = json.loads(result.stdout)
                    self.assertGreaterEqual(section["area_mm2"], 0)
                    if row["watertight"] == "yes":
                        self.assertEqual(section["open_chains"], 0)


class Spool(FolderTest):
    # The plate of the simulated printer with pixels ten times as coarse, and layers of 0.5 mm.
    PLATE = {"width_px": 192, "height_px": 108, "pixel_pitch_um": 500}
    RESIN = {"layer_height_um": 500, "layer_height_max_um": 500}

    def ticket_for(self, figures):
        """Returns a ticket that accepts gaps and small models, and that scales a model to fit unless it fits and is high enough for some layers."""
        size = figures["size_mm"] if figures else (1, 1, 1)
        fits = size[0] <= 96 and size[1] <= 54 and 1 <= size[2] <= 154
        return {"cracks": "repair", "unit": "mm", **({} if fits else {"fit": True})}

    def test_all_files_are_printed_or_refused_and_the_printer_goes_on(self):
        rows = table()
        daemon = Daemon(self, {"display": self.PLATE}, self.RESIN).start()
        printable, content = {}, {}
        for row in rows:
            name = row["file"]
            result = inspect(name)
            figures = json.loads(result.stdout) if result.returncode == OK else None
            printable[name] = bool(figures and figures["facets"] and figures["size_mm"][2] > 0 and name not in DARK)
            data = contents(path_of(name))
            content[name] = hashlib.sha256(data).digest()
            daemon.drop(name, data, self.ticket_for(figures))
        ends = {}
        while len(ends) < len(rows):
            end = daemon.wait_next_end()
            ends[end["job"] + ".stl"] = end
        self.assertEqual(set(ends), set(printable))
        for name, end in ends.items():
            with self.subTest(name):
                stem = name.removesuffix(".stl")
                folder = end["outcome"]
                self.assertEqual(folder, "done" if printable[name] else "failed", end)
                self.assertEqual(hashlib.sha256(contents(daemon.file(folder, name))).digest(), content[name])
                if folder == "done":
                    report = daemon.report(stem)
                    self.assertEqual(report["layers_exposed"], report["layers"])
                    self.assertTrue(daemon.has("done", stem + ".report.html"))
                    self.assertFalse(daemon.has("failed", name))
                else:
                    reason = daemon.read("failed", stem + ".reason.txt")
                    self.assertEqual(reason.count("\n"), 1, reason)
                    self.assertGreater(len(reason.split()), 4, reason)
                    self.assertTrue(reason[:-1].isprintable(), reason)
        self.assertEqual(daemon.names_in("incoming") + daemon.names_in("printing"), [])
        report = daemon.printed("good.stl", binary_stl(cube(20)))
        self.assertAlmostEqual(report["layer_records"][20]["area_mm2"], 400, delta=1e-9)

    def test_the_reason_names_what_is_wrong_with_the_file(self):
        rows = {row["file"] for row in table()}
        daemon = Daemon(self, {"display": self.PLATE}, self.RESIN).start()
        for name, word in (("openscad-empty2.stl", "no facets"), ("synth-bin-84-zero.stl", "no facets"),
                           ("synth-geo-plane-only.stl", "flat"), ("synth-bin-nan-vertex.stl", "finite"),
                           ("synth-asc-trunc-midvertex.stl", "cut short"), ("photonic3d-lager_houder.stl", "machine")):  # fmt: skip
            self.assertIn(name, rows)
            daemon.drop(name, contents(path_of(name)))
            with self.subTest(name):
                self.assertIn(word, daemon.wait_refused(name.removesuffix(".stl")))
        daemon.printed("good.stl", binary_stl(box((0, 0, 0), (5, 5, 5))))


table()
