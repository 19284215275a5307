import unittest

from bed import motion_checks
from bed.edge_log import LOST_STOP, MOVED, EdgeLog
from bed.motion_checks import MotionLimits
from unit.made_up_logs import LINES, Recorder

LIMITS = MotionLimits()


def moved(**options):
    recorder = Recorder()
    recorder.move(1000, **options)
    recorder.move(-600, **options)
    return recorder


class MotionChecksTest(unittest.TestCase):
    def test_faultless_moves_break_no_rule(self):
        self.assertEqual(motion_checks.all_checks(moved().edge_log(), LIMITS), [])

    def test_a_lost_step_is_found(self):
        recorder = moved()
        index = next(i for i, edge in enumerate(recorder.edges) if edge[3] == LINES.step)
        time, position, _, line, value = recorder.edges[index]
        recorder.edges[index] = (time, position - 1, LOST_STOP, line, value)
        self.assertEqual(len(motion_checks.lost_steps(recorder.edge_log())), 1)

    def test_a_short_pulse_and_a_short_pause_are_found(self):
        events = [(0, 1, MOVED, LINES.step, 1), (1_999, 1, 0, LINES.step, 0), (3_998, 2, MOVED, LINES.step, 1)]
        broken = motion_checks.pulse_widths(EdgeLog(EdgeLog.pack(events)), LIMITS)
        self.assertEqual([sentence.split(" for ")[0] for sentence in broken], ["the step line was high", "the step line was low"])

    def test_a_step_too_soon_after_a_change_of_direction_is_found(self):
        events = [(0, 0, 0, LINES.direction, 1), (4_999, 1, MOVED, LINES.step, 1), (9_000, 1, 0, LINES.step, 0)]
        self.assertEqual(len(motion_checks.direction_setups(EdgeLog(EdgeLog.pack(events)), LIMITS)), 1)

    def test_a_change_of_direction_during_a_pulse_is_found(self):
        events = [(0, 1, MOVED, LINES.step, 1), (1_000, 1, 0, LINES.direction, 1), (9_000, 1, 0, LINES.step, 0)]
        self.assertEqual(len(motion_checks.direction_setups(EdgeLog(EdgeLog.pack(events)), LIMITS)), 1)

    def test_a_move_beyond_the_top_speed_is_found(self):
        # 25 mm/s instead of 10: a step takes 50 us, 75 us less than the minimum.
        log = moved(speed=25.0, acceleration=800.0).edge_log()
        self.assertTrue(motion_checks.speeds(log, LIMITS))
        self.assertFalse(motion_checks.speeds(moved().edge_log(), LIMITS))

    def test_a_burst_of_steps_after_a_late_one_is_found(self):
        recorder = moved()
        steps = [i for i, edge in enumerate(recorder.edges) if edge[3] == LINES.step]
        late = recorder.edges[steps[1000]][0] - 5_000
        for i in steps[998:1000]:
            recorder.edges[i] = (late, *recorder.edges[i][1:])
        self.assertTrue(motion_checks.speeds(recorder.edge_log(), LIMITS))

    def test_twice_the_acceleration_is_found_and_the_right_one_is_not(self):
        self.assertTrue(motion_checks.accelerations(moved(acceleration=50.0).edge_log(), LIMITS))
        self.assertFalse(motion_checks.accelerations(moved(acceleration=25.0).edge_log(), LIMITS))

    def test_a_start_without_a_ramp_is_found(self):
        self.assertTrue(motion_checks.accelerations(moved(acceleration=1e6).edge_log(), LIMITS))

    def test_a_dead_stop_is_found_unless_the_limit_switch_caused_it(self):
        recorder = Recorder()
        recorder.move(-1000)
        # The log is cut in the middle of the move, at full speed.
        recorder.edges = recorder.edges[:1000]
        last = [edge for edge in recorder.edges if edge[3] == LINES.step and edge[4]][-1]
        self.assertTrue(motion_checks.accelerations(recorder.edge_log(), LIMITS))
        recorder.edges.append((recorder.edges[-1][0], last[1], 0, LINES.limit, 0))
        self.assertFalse(motion_checks.accelerations(recorder.edge_log(), LIMITS))

    def test_moves_end_at_pauses_and_changes_of_direction(self):
        self.assertEqual([len(times) for times, _ in motion_checks.moves(moved().edge_log())], [1000, 600])


if __name__ == "__main__":
    unittest.main()
