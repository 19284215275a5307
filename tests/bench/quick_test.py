#!/usr/bin/env python3
"""Checks that contourd-bench --quick ends with a figure, or a reason for none, in every row. Judges no figures."""

import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

BENCH = os.path.join(os.environ["CONTOURD_BIN"], "contourd-bench")

MADE = {  # rows of models that the benchmark generates: never skipped
    "mask-random-gyroid-p50", "mask-random-gyroid-p99", "mask-rising-gyroid-p99", "mask-4k-gyroid-p99", "mask-crossing",
    "first-mask", "ascii", "memory-gyroid", "allocations-gyroid", "growth-facets", "growth-segments-mask",
    "growth-segments-contours", "display-1", "display-10", "display-100", "supports-mask", "hollow-mask",
    "dimming-ahead-gyroid-p50", "dimming-ahead-gyroid-p99", "dimming-mask-gyroid-p99", "dimming-memory-gyroid",
    "cure-ball-memory-1", "cure-ball-memory-0.9",
}
SHARED = {  # rows of models that must be available as files
    "contours-liver", "contours-liver-without-reading", "contours-femur", "contours-femur-without-reading",
    "contours-bunny", "contours-bunny-without-reading", "masks-liver", "png-liver", "mask-random-plate-p50",
    "mask-random-plate-p99", "mask-rising-plate-p99", "mask-4k-plate-p99", "memory-plate", "allocations-plate",
    "dimming-ahead-plate-p50", "dimming-ahead-plate-p99", "dimming-mask-plate-p99", "dimming-memory-plate",
}


def run(*arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "bench.json")
        result = subprocess.run([BENCH, "--quick", "--json", path, "--models", folder, *arguments], check=True,
                                stdout=subprocess.PIPE, text=True)
        return result.stdout, json.loads(path.read_text())


class QuickRun(unittest.TestCase):
    def check_figure(self, row):
        self.assertTrue(math.isfinite(row["figure"]), row)
        if row["id"].startswith("allocations"):
            self.assertGreaterEqual(row["figure"], 0, row)
        else:
            self.assertGreater(row["figure"], 0, row)
        for peer in row["peers"]:
            self.assertGreater(peer["figure"], 0, row)

    def test_every_row_has_a_figure_or_a_reason_for_none(self):
        table, results = run()
        self.assertTrue(results["quick"])
        rows = {row["id"]: row for row in results["rows"]}
        self.assertEqual(set(rows), MADE | SHARED)
        self.assertEqual(len(rows), len(results["rows"]), "an id occurs twice")
        for row in rows.values():
            self.assertIn(row["what"], table)
            if "skipped" in row:
                self.assertIn(row["id"], SHARED)
                self.assertIn("no model", row["skipped"])
            else:
                self.check_figure(row)

    def test_rows_whose_models_are_absent_say_so(self):
        table, results = run("--shared", "/nowhere")
        skipped = {row["id"] for row in results["rows"] if "skipped" in row}
        self.assertEqual(skipped, SHARED)
        self.assertIn("SKIPPED: no model minetto-liver.stl", table)


if __name__ == "__main__":
    unittest.main(verbosity=2)
