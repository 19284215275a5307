"""Cracked models under both policies: repaired with warnings, or refused before anything is exposed."""

from harness import NIMBLE_RESIN, Daemon, FolderTest, binary_stl, box


def without_front(facets, y):
    return [facet for facet in facets if any(vertex[1] != y for vertex in facet)]


# A slab of 1 mm and a tower of 1 mm whose front is missing: 10 + 10 layers of 100 um.
CRACKED = binary_stl(box((0, 0, 0), (10, 10, 1)) + without_front(box((2, 2, 1), (6, 6, 2)), 2))
SOUND = binary_stl(box((0, 0, 0), (10, 10, 1)) + box((2, 2, 1), (6, 6, 2)))


# A slab with one facet turned round.
_walls = box((0, 0, 0), (10, 10, 1))
_at = next(i for i, facet in enumerate(_walls) if len({vertex[2] for vertex in facet}) > 1)
_walls[_at] = [_walls[_at][1], _walls[_at][0], _walls[_at][2]]
TURNED = binary_stl(_walls)


class Policies(FolderTest):
    def daemon(self):
        return Daemon(self, None, NIMBLE_RESIN, False).start()

    def test_a_cracked_model_whose_ticket_asks_for_the_repair_is_repaired_with_warnings(self):
        daemon = self.daemon()
        report = daemon.printed("part.stl", CRACKED, {"layer_height_um": 100, "cracks": "repair"})
        self.assertIn("not watertight", " ".join(report["model"]["warnings"]))
        layers = report["layer_records"]
        self.assertEqual([layer["open_chains"] for layer in layers], [0] * 10 + [1] * 10)
        self.assertEqual({layer["widest_gap_mm"] for layer in layers[10:]}, {4.0})
        # The contour is closed by a straight line across the missing front, so its area is that of the sound model.
        self.assertEqual({round(layer["area_mm2"], 6) for layer in layers[10:]}, {16.0})
        [line] = [line for line in daemon.log().splitlines() if " did not close" in line and "part: 10 of " in line]
        self.assertIn("10 of 20 layers, from layer 11 to 20: contours did not close; the widest gap bridged is 4.000 mm", line)
        self.assertNotIn("layer 12: ", daemon.log())

    def test_a_ticket_that_refuses_cracks_refuses_the_model_before_its_first_layer(self):
        daemon = self.daemon()
        reason = daemon.refused("part.stl", CRACKED, {"layer_height_um": 100, "cracks": "refuse"})
        self.assert_one_line(reason.encode(), "10 of 20 layers", "layer 11 at 1.050 mm", "widest gap is 4.000 mm")
        self.assertNotIn("layer 1 of", daemon.log())
        # The plate is still clear: the next job begins by itself.
        self.assertEqual(daemon.printed("sound.stl", SOUND, {"layer_height_um": 100, "cracks": "refuse"})["layers"], 20)

    def test_turned_facets_are_turned_back_with_a_warning_unless_the_ticket_refuses_cracks(self):
        daemon = self.daemon()
        report = daemon.printed("turned.stl", TURNED, {"layer_height_um": 100})
        layers = report["layer_records"]
        self.assertEqual([(layer["turned_chains"], layer["open_chains"]) for layer in layers], [(0, 0)] * 10)
        self.assertEqual(report["model"]["repairs"]["turned_facets"], 1)
        self.assertIn("1 facet turned round", " ".join(report["model"]["warnings"]))
        self.assertEqual({round(layer["area_mm2"], 6) for layer in layers}, {100.0})
        daemon.stop()
        daemon = self.daemon()
        reason = daemon.refused("part.stl", TURNED, {"layer_height_um": 100, "cracks": "refuse"})
        self.assert_one_line(reason.encode(), "its facets disagree with each other (repair: 1 facet turned round)")
