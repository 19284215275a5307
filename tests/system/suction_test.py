"""Suction cups and resin traps: found, reported, and a reason to wait for acceptance; and the drain holes of a ticket."""

import json
import math

from harness import BAD_USAGE, OK, Daemon, FolderTest, binary_stl, box, contourctl, inside_out, text_of

BLOCK = box((0, 0, 0), (10, 10, 1))


def hollow(low, high):
    return binary_stl([*BLOCK, *inside_out(box((2, 2, low), (8, 8, high)))])


# 20 layers. The cup's mouth is at the film.
CUP = hollow(0.2, 1)
CLOSED = hollow(0.2, 0.8)
TUBE = hollow(0, 1)
# A hole from the left side into the hollow, starting at the first layer of the hollow.
SIDE_HOLE = {"position_mm": {"x": 0, "y": 5, "z": 0.3}, "direction": {"x": 3}, "diameter_mm": 0.4, "depth_mm": 2.5}
ASKS = {"ask_before": ["suction_cups", "resin_traps"]}


class Suction(FolderTest):
    def analyze(self, model, *options):
        result = contourctl("analyze", self.write("part.stl", model), "--json", *options, expect=OK)
        return json.loads(result.stdout)

    def test_a_cup_is_reported_with_layers_place_area_and_volume(self):
        found = self.analyze(CUP)
        self.assertEqual((found["suction_cups"], found["resin_traps"]), (1, 0))
        cup = found["suction_cup_list"][0]
        self.assertEqual((cup["first_layer"], cup["last_layer"], cup["widest_layer"], cup["on_plate"]), (5, 20, 5, False))
        self.assertAlmostEqual(cup["area_mm2"], 36, delta=1e-6)
        self.assertAlmostEqual(cup["volume_mm3"], 36 * 0.8, delta=1e-6)
        for value in cup["plate_mm"]:
            self.assertAlmostEqual(value, 0, delta=1e-6)
        self.assertIn("1 suction cup pulls on the film until it opens or is closed: layers 5 to 20", found["warnings"][0])

    def test_a_tube_on_the_plate_is_closed_by_the_plate(self):
        found = self.analyze(TUBE)
        self.assertTrue(found["suction_cup_list"][0]["on_plate"])
        self.assertIn("closed by the plate", found["warnings"][0])

    def test_the_page_lists_cups_and_traps(self):
        page = self.path("part.html")
        self.analyze(CLOSED, "--html", page)
        text = text_of(page)
        self.assert_words(text, 'id="cups"', 'id="traps"', 'href="#mark-0"', 'href="#mark-1"', 'id="mark-0"', 'id="mark-1"')

    def test_a_cup_that_is_dropped_waits_to_be_accepted(self):
        daemon = Daemon(self, ASKS).start()
        daemon.drop("cup.stl", CUP)
        self.assertEqual(daemon.wait_job("cup")["asks"], ["suction_cups"])
        shown = daemon.ctl("queue", "show", "cup").stdout.decode()
        self.assertRegex(shown, r"(?m)^warning   1 suction cup pulls on the film until it opens or is closed: layers 5 to 20, ")
        self.assertEqual(daemon.ctl("accept", "cup").returncode, OK)
        analysis = daemon.wait_done("cup")["analysis"]
        self.assertEqual((analysis["suction_cups"], analysis["resin_traps"]), (1, 0))
        page = daemon.read("done", "cup.report.html")
        self.assertIn("Suction cups and resin traps that are widest here", page)

    def test_a_closed_hollow_is_both_a_cup_and_a_trap(self):
        daemon = Daemon(self, ASKS).start()
        daemon.drop("ball.stl", CLOSED)
        self.assertEqual(daemon.wait_job("ball")["asks"], ["suction_cups", "resin_traps"])

    # --- models that contourd makes hollow

    def test_a_hollow_model_takes_less_resin_and_sucks_nowhere(self):
        daemon = Daemon(self).start()
        solid = binary_stl(box((0, 0, 0), (12, 12, 9)))
        report = daemon.printed("part.stl", solid, {"hollow": {"wall_mm": 1.5}})
        hollow = report["model"]["hollow"]
        self.assertEqual((hollow["cavities"], hollow["holes_added"]), (1, 1))
        self.assertAlmostEqual(hollow["volume_ml"], 9 * 9 * 6 / 1000, delta=1e-6)
        analysis = report["analysis"]
        self.assertEqual((analysis["suction_cups"], analysis["resin_traps"]), (0, 0))
        # The hole takes at most its cylinder through the wall.
        whole, removed = 12 * 12 * 9 / 1000, hollow["volume_ml"]
        self.assertLess(analysis["resin_ml"], whole - removed)
        self.assertGreater(analysis["resin_ml"], whole - removed - math.pi * 1.25**2 * 1.5 / 1000 - 0.005)
        self.assertIn("1 cavity of 0.49 ml, walls of 1.5 mm, 1 hole added", daemon.read("done", "part.report.html"))
        closed = daemon.printed("closed.stl", solid, {"hollow": {"wall_mm": 1.5, "hole_mm": 0}})["analysis"]
        self.assertEqual((closed["suction_cups"], closed["resin_traps"]), (1, 1))

    def test_submit_makes_a_model_hollow(self):
        daemon = Daemon(self).start()
        part = self.write("part.stl", binary_stl(box((0, 0, 0), (12, 12, 9))))
        self.assertEqual(daemon.ctl("submit", part, "--hollow", "1.5", "--yes", "--wait").returncode, OK)
        self.assertEqual(daemon.wait_done("part")["model"]["hollow"]["wall_mm"], 1.5)

    def test_models_are_hollowed_before_they_are_printed(self):
        part = self.write("part.stl", binary_stl(box((0, 0, 0), (12, 12, 9))))
        printer = ("--printer", Daemon(self).config_path)
        ticket = self.write("closed.json", json.dumps({"hollow": {"wall_mm": 3, "hole_mm": 0}}).encode())

        def resin_ml(*options):
            return json.loads(contourctl("analyze", part, *printer, *options, "--json", expect=OK).stdout)["resin_ml"]

        whole, removed = resin_ml(), 9 * 9 * 6 / 1000
        self.assertAlmostEqual(whole - resin_ml("--hollow", "1.5", "--ticket", ticket), removed, delta=1e-4)
        self.assertGreater(whole - resin_ml("--hollow", "1.5"), removed)
        for wrong in ("0.1", "31", "nan"):
            result = contourctl("slice", part, *printer, "--hollow", wrong, "--masks", self.path("masks"))
            self.assert_refusal(result, BAD_USAGE, f"--hollow {wrong}", "0.2 to 30")
        # The command line is checked before a file is read.
        self.assert_refusal(contourctl("slice", self.path("none.stl"), *printer, "--hollow", "31"), BAD_USAGE, "--hollow 31")

    # --- drain holes

    def new_name(self):
        """Returns an unused name, since the daemons of a test share their spool."""
        self.dropped = getattr(self, "dropped", 0) + 1
        return f"part{self.dropped}"

    def refused(self, model, drain, *words, **ticket):
        daemon = Daemon(self).start()
        name = self.new_name()
        reason = daemon.refused(name + ".stl", model, {"drain": drain, **ticket})
        self.assert_words(reason, *words)
        daemon.stop()

    def drained(self, model, drain, **ticket):
        daemon = Daemon(self, {"wait_for_plate_cleared": False}).start()
        name = self.new_name()
        report = daemon.printed(name + ".stl", model, {"drain": drain, **ticket})
        daemon.stop()
        return report

    def test_a_hollow_with_a_hole_in_its_side_is_neither_cup_nor_trap(self):
        daemon = Daemon(self, ASKS).start()
        report = daemon.printed("bottle.stl", CLOSED, {"drain": [SIDE_HOLE]})
        self.assertEqual((report["analysis"]["suction_cups"], report["analysis"]["resin_traps"]), (0, 0))
        self.assertEqual(report["model"]["drain_holes"], 1)

    def test_a_hole_in_the_floor_leaves_a_cup_on_the_plate_and_no_trap(self):
        report = self.drained(CLOSED, [{"position_mm": {"x": 5, "y": 5}, "direction": {"z": 1}, "diameter_mm": 2, "depth_mm": 0.5}])
        self.assertEqual((report["analysis"]["suction_cups"], report["analysis"]["resin_traps"]), (1, 0))
        self.assertTrue(report["analysis"]["suction_cup_list"][0]["on_plate"])

    def test_a_hole_removes_its_volume_and_is_turned_and_scaled_with_the_model(self):
        whole = self.drained(binary_stl(BLOCK), [])["analysis"]["resin_ml"] * 1000
        through = {"position_mm": {"x": 5, "y": 5}, "direction": {"z": 1}, "diameter_mm": 3, "depth_mm": 2}
        area = math.pi * 1.5**2
        # A pixel counts fully or not at all, by its centre: 0.05 mm in the radius would be 7 %, but its mean is far less.
        taken = whole - self.drained(binary_stl(BLOCK), [through])["analysis"]["resin_ml"] * 1000
        self.assertAlmostEqual(taken, area * 1, delta=0.01 * area)
        turned = whole - self.drained(binary_stl(BLOCK), [through], up={"x": 1})["analysis"]["resin_ml"] * 1000
        self.assertAlmostEqual(turned, area * 1, delta=0.02 * area)
        larger = 8 * whole - self.drained(binary_stl(BLOCK), [through], scale=2)["analysis"]["resin_ml"] * 1000
        self.assertAlmostEqual(larger, 8 * area, delta=0.01 * 8 * area)

    def test_each_copy_and_each_model_of_a_plate_has_its_own_holes(self):
        found = self.drained(CLOSED, [SIDE_HOLE], copies=3)["analysis"]
        self.assertEqual((found["suction_cups"], found["resin_traps"]), (0, 0))
        daemon = Daemon(self).start()
        daemon.drop_plate("both", {"models": [{"file": "a.stl", "drain": [SIDE_HOLE]}, {"file": "a.stl"}]}, {"a.stl": CLOSED})
        report = daemon.wait_done("both")
        self.assertEqual((report["analysis"]["suction_cups"], report["analysis"]["resin_traps"]), (1, 1))

    def test_a_hole_beside_the_model_is_refused_with_its_place(self):
        beside = {**SIDE_HOLE, "position_mm": {"x": -20, "y": 5, "z": 0.3}}
        self.refused(CLOSED, [SIDE_HOLE, beside], "drain hole 2 of the model misses it: the hole starts at -20, 5, 0.3 mm, is 0.4 mm wide")
        self.refused(CLOSED, [{**SIDE_HOLE, "direction": {}}], "/drain/0/direction: a direction must not be zero")
