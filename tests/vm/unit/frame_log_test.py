import unittest

from bed.frame_log import FrameLog, Picture

TEXT = """\
100 0 ON 1920x1080 00000000 0
200 1 FLIP 1920x1080 0000aaaa 0
300 2 FLIP 1920x1080 0000bbbb 17
400 3 UNPLUG 0x0 00000000 0
500 3 OFF 0x0 00000000 0
"""


class FrameLogTest(unittest.TestCase):
    def test_a_picture_lasts_until_the_next_or_until_the_output_is_off(self):
        pictures = FrameLog(TEXT).pictures()
        self.assertEqual(pictures, [Picture(200, 300, 0xAAAA, 0), Picture(300, 500, 0xBBBB, 17)])

    def test_the_last_picture_has_no_end(self):
        self.assertIsNone(FrameLog("200 1 FLIP 1920x1080 0000aaaa 9\n").lit_pictures()[0].end_ns)

    def test_a_malformed_line_is_refused(self):
        with self.assertRaises(ValueError):
            FrameLog("no frame log\n")


if __name__ == "__main__":
    unittest.main()
