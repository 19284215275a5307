import unittest
from dataclasses import replace

from bed import exposure_checks
from bed.edge_log import MOVED
from bed.frame_log import FrameLog
from unit.made_up_logs import LINES, SECOND, print_of


def logs_of(recorder):
    return recorder.frame_log(), recorder.edge_log()


class ExposureChecksTest(unittest.TestCase):
    def setUp(self):
        self.recorder, self.layers = print_of()

    def test_a_faultless_print_breaks_no_rule(self):
        self.assertEqual(exposure_checks.all_checks(*logs_of(self.recorder), self.layers), [])

    def test_a_mask_that_differs_from_the_cores_is_found(self):
        self.layers[1] = replace(self.layers[1], mask_crc=0xDEAD)
        self.assertEqual(len(exposure_checks.masks(*logs_of(self.recorder), self.layers)), 1)

    def test_a_plate_that_is_off_by_one_step_is_found(self):
        self.layers[2] = replace(self.layers[2], position=self.layers[2].position + 1)
        self.assertEqual(len(exposure_checks.masks(*logs_of(self.recorder), self.layers)), 1)

    def test_an_additional_or_missing_layer_is_found(self):
        self.assertTrue(exposure_checks.masks(*logs_of(self.recorder), self.layers[:2]))
        self.assertTrue(exposure_checks.exposures(*logs_of(self.recorder), self.layers[:2]))

    def test_an_exposure_that_is_too_long_or_too_short_is_found(self):
        for asked in (2 * SECOND - 2_000_000, 2 * SECOND + 30_000):
            layers = [replace(layer, exposure_ns=asked) for layer in self.layers]
            broken = exposure_checks.exposures(*logs_of(self.recorder), layers)
            self.assertEqual(len([sentence for sentence in broken if "had light" in sentence]), 3)

    def test_a_mask_that_stays_on_the_screen_too_long_is_found(self):
        lines = self.recorder.frames
        time, rest = lines[2].split(" ", 1)
        lines[2] = f"{int(time) + 20_000_000} {rest}"
        self.assertEqual(len(exposure_checks.exposures(*logs_of(self.recorder), self.layers)), 1)

    def test_light_before_the_mask_is_found(self):
        index = next(i for i, edge in enumerate(self.recorder.edges) if edge[3] == LINES.light)
        time, *rest = self.recorder.edges[index]
        self.recorder.edges[index] = (time - 200_000, *rest)
        self.assertEqual(len(exposure_checks.light_only_on_masks(*logs_of(self.recorder))), 1)

    def test_light_on_a_mask_that_changes_is_found(self):
        frames = sorted([*self.recorder.frames, self._within_the_first_exposure()], key=lambda line: int(line.split()[0]))
        self.assertEqual(len(exposure_checks.light_only_on_masks(FrameLog("\n".join(frames)), self.recorder.edge_log())), 1)

    def _within_the_first_exposure(self):
        on, _ = self.recorder.edge_log().active(LINES.light)[0]
        return f"{on + SECOND} 0 FLIP 1920x1080 00001234 5"

    def test_a_step_during_an_exposure_is_found(self):
        on, _ = self.recorder.edge_log().active(LINES.light)[0]
        self.recorder.edges.append((on + 1000, 41, MOVED, LINES.step, 1))
        self.recorder.edges.sort(key=lambda edge: edge[0])
        self.assertEqual(len(exposure_checks.light_only_on_masks(*logs_of(self.recorder))), 1)

    def test_light_that_never_goes_off_is_found(self):
        last = max(i for i, edge in enumerate(self.recorder.edges) if edge[3] == LINES.light)
        del self.recorder.edges[last]
        logs = logs_of(self.recorder)
        self.assertTrue(exposure_checks.light_only_on_masks(*logs))
        self.assertTrue(exposure_checks.dark_at_the_end(*logs))
        self.assertTrue(exposure_checks.exposures(*logs, self.layers))

    def test_a_mask_left_on_the_screen_is_found(self):
        self.recorder.frames.pop()
        self.assertTrue(exposure_checks.dark_at_the_end(*logs_of(self.recorder)))
        self.assertTrue(exposure_checks.exposures(*logs_of(self.recorder), self.layers))


if __name__ == "__main__":
    unittest.main()
