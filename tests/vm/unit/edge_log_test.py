import unittest

from bed.edge_log import MOVED, EdgeLog, Lines

LINES = Lines()


class EdgeLogTest(unittest.TestCase):
    def test_the_position_at_a_time_is_that_of_the_last_event_before_it(self):
        log = EdgeLog(EdgeLog.pack([(100, 5, MOVED, LINES.step, 1), (110, 5, 0, LINES.step, 0), (200, 6, MOVED, LINES.step, 1)]))
        self.assertIsNone(log.position_at(99))
        self.assertEqual([log.position_at(t) for t in (100, 199, 200, 10_000)], [5, 5, 6, 6])

    def test_active_returns_the_intervals_in_which_a_line_is_high(self):
        log = EdgeLog(EdgeLog.pack([(1, 0, 0, 24, 1), (5, 0, 0, 24, 0), (9, 0, 0, 24, 1)]))
        self.assertEqual(log.active(24), [(1, 5), (9, None)])

    def test_a_truncated_log_and_one_with_decreasing_times_are_refused(self):
        whole = EdgeLog.pack([(1, 0, 0, 24, 1)])
        with self.assertRaises(ValueError):
            EdgeLog(whole[:-1])
        with self.assertRaises(ValueError):
            EdgeLog(EdgeLog.pack([(2, 0, 0, 24, 1), (1, 0, 0, 24, 0)]))


if __name__ == "__main__":
    unittest.main()
