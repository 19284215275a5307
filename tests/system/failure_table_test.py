"""docs/failure-table.md: every row names tests that exist, or gives a reason why there is none."""

import os
import pathlib
import re
import unittest

_SOURCE = pathlib.Path(os.environ["CONTOURD_SOURCE"])
_REASON = "No test: "


def _rows():
    for number, line in enumerate((_SOURCE / "docs/failure-table.md").read_text().splitlines(), 1):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| ") and cells[0] != "failure":
            yield number, cells


def _unit_tests():
    for path in (_SOURCE / "tests").rglob("*_test.cpp"):
        for literals in re.findall(r'TEST_CASE(?:_METHOD\(\s*[\w:]+,|\()\s*((?:"[^"]*"\s*)+)', path.read_text()):
            yield "".join(re.findall(r'"([^"]*)"', literals))


def _python_tests():
    for folder in ("system", "vm/tests"):
        for path in (_SOURCE / "tests" / folder).glob("*_test.py"):
            yield from re.findall(r"^ *def (\w+)\(", path.read_text(), re.MULTILINE)


class FailureTableTest(unittest.TestCase):
    def test_every_row_has_all_its_cells(self):
        for number, cells in _rows():
            self.assertEqual(len(cells), 5, f"line {number}: {cells}")

    def test_every_row_names_existing_tests_or_gives_a_reason(self):
        existing = {*_unit_tests(), *_python_tests()}
        self.assertGreater(len(existing), 500)
        rows = list(_rows())
        self.assertGreater(len(rows), 50)
        for number, cells in rows:
            with self.subTest(line=number, failure=cells[0]):
                named = re.findall("`([^`]+)`", cells[-1])
                reason = cells[-1].removeprefix(_REASON) if cells[-1].startswith(_REASON) else ""
                self.assertTrue(named or len(reason) > 20, "neither a test nor a reason")
                for name in named:
                    self.assertIn(name, existing)
