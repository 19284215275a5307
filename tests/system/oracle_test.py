"""Compares sections of the shared models with those of an independent slicer: area, perimeter, contours and segments."""

import concurrent.futures
import csv
import json
import os
import subprocess
import unittest

from harness import OK, SHARED, contourctl, skip_file

ORACLE_PYTHON = "/usr/bin/python3"  # Debian's python, for which python3-numpy is installed
HEIGHTS = 50

# One process for each model, since reading a model takes longer than cutting it.
PROGRAM = """
import json, random, sys
sys.path.insert(0, sys.argv[1])
import section
facets, corners, heights = section.prep(sys.argv[2])
chosen = random.Random(sys.argv[3])
found = []
for _ in range(int(sys.argv[4])):
    z = chosen.uniform(heights[0], heights[-1])
    cut = section.section(facets, corners, z)
    found.append({"z": z, "segments": int(cut["segs"]), "contours": int(cut["comps"]), "open": int(cut["open"]),
                  "area": float(cut["area"]), "perimeter": float(cut["perim"])})
print(json.dumps(found))
"""


def find_models():
    table = os.path.join(SHARED, "models", "TABLE.tsv")
    if not os.path.exists(table):
        skip_file(f"{table} does not exist")
    if subprocess.run([ORACLE_PYTHON, "-c", "import numpy"], stderr=subprocess.DEVNULL, check=False).returncode != 0:
        skip_file("the oracle needs numpy: apt-get install python3-numpy")
    with open(table, newline="", encoding="utf-8") as file:
        return [row["file"] for row in csv.DictReader(file, delimiter="\t") if row["watertight"] == "yes"]


def truth_of(name):
    result = subprocess.run(
        [ORACLE_PYTHON, "-c", PROGRAM, os.path.join(SHARED, "oracle"), os.path.join(SHARED, "models", name), name, str(HEIGHTS)],
        stdout=subprocess.PIPE, check=True, timeout=240)  # fmt: skip
    return json.loads(result.stdout)


def section_of(name, z):
    result = contourctl("slice", os.path.join(SHARED, "models", name), "--z", repr(z), "--json")
    if result.returncode != OK:
        raise AssertionError(result.stderr)
    return json.loads(result.stdout)


class Sections(unittest.TestCase):
    def compare(self, name, truth, sections):
        cut = 0
        for expected, found in zip(truth, sections):
            with self.subTest(model=name, z=expected["z"]):
                self.assertEqual(expected["open"], 0)
                self.assertEqual((found["contours"], found["open_chains"]), (expected["contours"], 0))
                self.assertEqual(found["segments"], expected["segments"])
                # Both slicers compute in double from the same floats; they differ in the order of
                # additions, and by the grid on which overlaps are resolved.
                area = abs(expected["area"])
                self.assertAlmostEqual(found["area_mm2"], area, delta=area * 1e-5)
                self.assertAlmostEqual(found["perimeter_mm"], expected["perimeter"], delta=expected["perimeter"] * 1e-5)
                cut += found["segments"] > 0
        return cut

    def test_watertight_models_have_the_oracle_s_sections_at_seeded_random_heights(self):
        models = find_models()
        self.assertGreaterEqual(len(models), 10)
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for name, truth in zip(models, pool.map(truth_of, models)):
                self.assertEqual(len(truth), HEIGHTS)
                sections = list(pool.map(lambda expected, name=name: section_of(name, expected["z"]), truth))
                # Few random heights between the ends of a model miss all its facets.
                self.assertGreaterEqual(self.compare(name, truth, sections), HEIGHTS // 2, name)


find_models()
