"""Tests of the soak's checks: checks that never find anything prove nothing."""

import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.environ["CONTOURD_SOURCE"], "tests/system"))

from good_jobs import light_trouble, masks_trouble, report_trouble  # noqa: E402
from process_figures import Waits  # noqa: E402


def layer(number, **changes):
    return {"layer": number, "complete": True, "area_mm2": 5.0, "exposure_asked_ms": 20, "exposure_least_ms": 20, "exposure_most_ms": 20,
            "exposure_parts": 1, "shown_at_s": 1.5, "mask_ms": 0.3, **changes}  # fmt: skip


def report(**changes):
    return {"job": "a", "outcome": "done", "print_time_s": 3, "analysis": {"islands": 0}, "layers": 2,
            "layer_records": [layer(1), layer(2)], **changes}  # fmt: skip


class Masks(unittest.TestCase):
    ALONE = ["a", "b", "b", "c"]

    def test_equal_masks_are_good(self):
        self.assertIsNone(masks_trouble(self.ALONE, self.ALONE, 0))

    def test_missing_wrong_additional_and_exchanged_masks_are_found(self):
        for masks in (["a", "b", "b"], ["a", "b", "c"], ["a", "b", "b", "d"], ["a", "b", "b", "c", "c"], ["a", "b", "b", "c", "a"],
                      ["b", "a", "b", "c"], []):  # fmt: skip
            with self.subTest(masks):
                self.assertIsNotNone(masks_trouble(masks, self.ALONE, 0))

    def test_a_layer_may_be_shown_again_as_often_as_it_was_interrupted(self):
        self.assertIsNone(masks_trouble(["a", "a", "b", "b", "c"], self.ALONE, 1))
        self.assertIsNotNone(masks_trouble(["a", "a", "b", "b", "c", "c"], self.ALONE, 1))
        self.assertIsNotNone(masks_trouble(["a", "a", "b", "c"], self.ALONE, 1))


class Report(unittest.TestCase):
    def test_figures_that_depend_on_time_may_differ(self):
        self.assertIsNone(report_trouble(report(job="b", print_time_s=9, layer_records=[layer(1, shown_at_s=7), layer(2, mask_ms=2)]), report()))

    def test_different_figures_keys_and_layers_are_found(self):
        for changes in ({"layers": 3}, {"new": 1}, {"layer_records": [layer(1)]}, {"layer_records": [layer(1), layer(2, area_mm2=4)]},
                        {"analysis": {"islands": 1}}):  # fmt: skip
            with self.subTest(changes):
                self.assertIsNotNone(report_trouble(report(**changes), report()))

    def test_an_analysis_that_a_stop_cut_off_may_be_missing(self):
        self.assertIsNone(report_trouble(report(analysis=None), report()))

    def test_too_much_and_too_little_light_and_an_unfinished_layer_are_found(self):
        self.assertIsNone(light_trouble(report(), 1e-6))
        for changes in ({"exposure_most_ms": 20.1}, {"exposure_least_ms": 19.9}, {"complete": False}):
            with self.subTest(changes):
                self.assertIsNotNone(light_trouble(report(layer_records=[layer(1), layer(2, **changes)]), 1e-6))
        self.assertIsNone(light_trouble(report(layer_records=[layer(1, exposure_most_ms=25)]), 5))


class Waiting(unittest.TestCase):
    def test_the_longest_wait_within_a_time_is_found(self):
        waits = Waits()
        waits.close()
        waits._times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
        waits._waited = [0.0, 0.0, 0.5, 0.6, 0.6, 0.6, 0.6]
        self.assertAlmostEqual(waits.most_within(0.8, 0, 10), 0.5)  # sampling adds a period at both ends
        self.assertAlmostEqual(waits.most_within(1.8, 0, 10), 0.6)
        self.assertEqual(waits.most_within(0.1, 5, 10), 0.0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
