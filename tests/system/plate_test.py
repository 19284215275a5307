"""Plates: a folder of several models that are printed together."""

import json
import os
import signal

from harness import NIMBLE_RESIN, OK, WAITS, Daemon, FolderTest, binary_stl, box, contourctl, read_png, realtime, wait_until

CUBE = binary_stl(box((0, 0, 0), (10, 10, 1)))  # 20 layers
POST = binary_stl(box((50, 50, 50), (54, 52, 52)))  # 40 layers
BOTH = {"models": [{"file": "cube.stl", "position_mm": {"x": -20}},
                   {"file": "post.stl", "position_mm": {"x": 15, "y": 10}}]}  # fmt: skip
CURVE = {"exposure_ms": None, "bottom_exposure_ms": None, "working_curve": {
    "penetration_depth_um": 150, "critical_energy_mj_cm2": 9, "overcure_um": 60, "bottom_overcure_um": 200}}  # fmt: skip


def text(ticket):
    return ticket if isinstance(ticket, (str, bytes)) else json.dumps(ticket)


class PlateTest(FolderTest):
    def daemon(self, config=None, resin=None, **options):
        return Daemon(self, config, resin, **options)

    def put(self, daemon, name, data):
        """Puts a complete file into incoming/ by a rename."""
        staging = self.write("staged", data)
        os.rename(staging, os.fsencode(daemon.file("incoming", name)))

    def drop_plate(self, daemon, name, ticket, files=None):
        daemon.drop_plate(name, ticket, files or {"cube.stl": CUBE, "post.stl": POST})

    def refused(self, daemon, name, ticket, *words, files=None):
        self.drop_plate(daemon, name, ticket, files)
        reason = daemon.wait_refused(name)
        self.assert_words(reason, *words)
        self.assertTrue(daemon.has("failed", name, "plate.json"))
        self.assertEqual(daemon.names_in("incoming") + daemon.names_in("printing"), [])


class Printing(PlateTest):
    def test_a_plate_is_printed_like_its_models_alone(self):
        daemon = self.daemon(masks=True).start()
        self.drop_plate(daemon, "both", BOTH)
        report = daemon.wait_done("both")
        self.assertEqual((report["outcome"], report["layers"], report["layers_exposed"]), ("done", 40, 40))
        self.assertEqual([model["file"] for model in report["models"]], ["cube.stl", "post.stl"])
        self.assertEqual(report["models"][1]["positions_mm"], [[15, 10]])
        self.assertEqual(daemon.names_in("done"), ["both", "both.preview.png", "both.report.html", "both.report.json"])
        self.assertEqual(sorted(os.listdir(daemon.file("done", "both"))), ["cube.stl", "plate.json", "post.stl"])
        self.assertEqual(daemon.names_in("incoming") + daemon.names_in("printing") + daemon.names_in("failed"), [])
        masks = report["masks_folder"]
        pictures = {name: read_png(os.path.join(masks, name)) for name in sorted(os.listdir(masks)) if name.endswith(".png")}
        self.assertEqual(len(pictures), 40)
        # The cube is 200 x 200 pixels, 400 left of the middle; the post is 80 x 40, 300 right of the middle and 200 above.
        cube, post = self.alone("cube", CUBE, -400, 0), self.alone("post", POST, 300, 200)
        for number, picture in enumerate(pictures.values()):
            rows = [bytearray(row) for row in post[number]]
            if number < 20:
                for row, other in zip(rows, cube[number]):
                    for x in range(460, 660):
                        row[x] |= other[x]
            self.assertEqual([bytes(row) for row in rows], list(picture.rows), f"layer {number + 1}")

    def alone(self, name, data, right, up):
        """Returns the rows of each mask of `contourctl slice`, moved by whole pixels."""
        model = self.write(name + ".stl", data)
        folder = self.path("masks-" + name)
        done = contourctl("slice", model, "--layer-height-um", "50", "--display", "1920x1080", "--pixel-pitch-um", "50",
                          "--masks", folder)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        layers = []
        for mask in sorted(os.listdir(folder)):
            rows = read_png(os.path.join(folder, mask)).rows
            sideways = [row[-right:] + bytes(-right) if right < 0 else bytes(right) + row[: len(row) - right] for row in rows]
            layers.append(sideways[up:] + [bytes(1920)] * up)
        return layers

    def test_models_without_a_position_are_arranged_with_their_copies(self):
        daemon = self.daemon().start()
        self.drop_plate(daemon, "many", {"models": [{"file": "cube.stl", "copies": 3}, {"file": "post.stl", "copies": 5},
                                                    {"file": "cube.stl", "scale": {"x": 2, "z": 2}}]})  # fmt: skip
        report = daemon.wait_done("many")
        self.assertEqual([model["copies"] for model in report["models"]], [3, 5, 1])
        self.assertAlmostEqual(report["layer_records"][0]["area_mm2"], 3 * 100 + 5 * 8 + 200, delta=1e-6)
        self.assertAlmostEqual(report["layer_records"][-1]["area_mm2"], 5 * 8 + 200, delta=1e-6)

    def test_adaptive_layers_are_exposed_according_to_their_thickness(self):
        daemon = self.daemon(resin=CURVE).start()
        # A roof, 10 mm wide and 2 mm high, on walls of 1 mm. Its slope is 2 in 5.
        roof = [((0, 0, 1), (10, 0, 1), (5, 0, 3)), ((0, 10, 1), (5, 10, 3), (10, 10, 1)),
                ((0, 0, 1), (5, 0, 3), (5, 10, 3)), ((0, 0, 1), (5, 10, 3), (0, 10, 1)),
                ((10, 0, 1), (10, 10, 1), (5, 10, 3)), ((10, 0, 1), (5, 10, 3), (5, 0, 3))]  # fmt: skip
        walls = [facet for facet in box((0, 0, 0), (10, 10, 1)) if not all(vertex[2] == 1 for vertex in facet)]
        self.drop_plate(daemon, "roof", {"adaptive_layers": {"cusp_um": 28}, "models": [{"file": "roof.stl"}]},
                        {"roof.stl": binary_stl(roof + walls)})  # fmt: skip
        report = daemon.wait_done("roof")
        records = report["layer_records"]
        # On the slope 28 um / cos(atan(2 / 5)) = 30.2 um.
        self.assertEqual([record["thickness_um"] for record in records[:11]], [100] * 10 + [30])
        self.assertAlmostEqual(sum(record["thickness_um"] for record in records), 3000, delta=1e-6)
        self.assertEqual(report["layers"], len(records))
        self.assertEqual(report["adaptive_layers"], {"cusp_um": 28, "min_um": 25, "max_um": 100})
        # After the fade, Jacobs' working curve applies: exp((thickness + overcure) / Dp) Ec / irradiance.
        self.assertAlmostEqual(records[-20]["exposure_asked_ms"], 9 / 5 * 2.718281828459045 ** ((30 + 60) / 150) * 1000, delta=0.01)


class Exclusion(PlateTest):
    def masks_of(self, report):
        folder = report["masks_folder"]
        return [read_png(os.path.join(folder, name)).rows for name in sorted(os.listdir(folder)) if name.endswith(".png")]

    def test_an_excluded_copy_goes_dark_with_its_supports_and_the_others_keep_every_pixel(self):
        table = binary_stl(box((1, 1, 0), (3, 3, 1)) + box((0, 0, 1), (6, 6, 2)))  # needs supports
        # Two copies, and the same copies from a print in which none is excluded.
        ticket = {"supports": "on", "models": [{"file": "table.stl", "position_mm": {"x": -12}}, {"file": "post.stl", "position_mm": {"x": 12}}]}
        files = {"table.stl": table, "post.stl": POST}
        plain = self.daemon(masks=True).start()
        self.drop_plate(plain, "both", ticket, files)
        report = plain.wait_done("both")
        self.assertGreater(report["supports"]["contacts"], 0)
        whole = self.masks_of(report)
        plain.stop()
        config = realtime(simulation={"start_height_mm": 10})
        daemon = self.daemon(config, {**NIMBLE_RESIN, "exposure_ms": 1}, masks=True).start()
        self.drop_plate(daemon, "again", ticket, files)
        daemon.wait_state("exposing")
        daemon.rpc("pause", at_layer=9)
        layer = daemon.wait_state("paused")["job"]["layer"] + 1
        self.assertEqual(layer, 9)
        listed = daemon.ctl("exclude").stdout.decode()
        self.assert_words(listed, "  1  table.stl, at -12.0, 0.0 mm", "  2  post.stl, at 12.0, 0.0 mm")
        self.assertEqual(daemon.ctl("exclude", "table.stl").returncode, OK)
        self.assertEqual(daemon.status()["job"]["excluded"], ["table.stl"])
        self.assertIn(b"dark from layer 9 on already", daemon.ctl("exclude", "1").stderr)
        self.assertIn(b"post.stl is the last copy that is printed", daemon.ctl("exclude", "2").stderr)
        daemon.rpc("resume")
        report = daemon.wait_done("again")
        self.assertEqual(report["excluded"], [{"copy": "table.stl", "number": 1, "from_layer": 9}])
        self.assertIn("table.stl dark from layer 9 on", daemon.read("done", "again.report.html"))
        self.assertIn("table.stl dark from layer 9 on", daemon.rpc("history")["result"]["ended"][-1]["settings"])
        masks = self.masks_of(report)
        self.assertEqual(len(masks), len(whole))
        middle = len(whole[0][0]) // 2
        for number, (mask, before) in enumerate(zip(masks, whole)):
            self.assertEqual([row[middle:] for row in mask], [row[middle:] for row in before])
            left = [row[:middle] for row in mask]
            if number < 8:
                self.assertTrue(any(any(row) for row in left))
                self.assertEqual(left, [row[:middle] for row in before])
            else:
                self.assertFalse(any(any(row) for row in left), f"layer {number + 1}")


class Arrival(PlateTest):
    def test_a_plate_that_is_copied_file_by_file_waits_until_all_files_are_there(self):
        daemon = self.daemon().start()
        os.mkdir(daemon.file("incoming", "slow"))
        # The daemon may see the folder before its plate.json; then the folder waits for plate.json.
        self.put(daemon, "slow/plate.json", text(BOTH))
        wait_until(lambda: daemon.status()["incomplete"].get("slow") == ["cube.stl", "post.stl"], "the plate to wait for both files")
        self.put(daemon, "slow/cube.stl", CUBE)
        wait_until(lambda: daemon.status()["incomplete"].get("slow") == ["post.stl"], "the plate to wait for the last file")
        with open(daemon.file("incoming", "slow", "post.stl"), "wb", buffering=0) as file:
            file.write(POST[:100])
            # All files exist, but one is still being written.
            wait_until(lambda: not daemon.status()["incomplete"], "the file to be seen")
            daemon.refused("empty.stl", b"")
            self.assertEqual(daemon.names_in("incoming"), ["slow"])
            file.write(POST[100:])
        self.assertEqual(daemon.wait_done("slow")["layers"], 40)
        self.assertIn("waits for cube.stl, post.stl", daemon.log())

    def test_a_status_stays_small_however_many_plates_wait(self):
        daemon = self.daemon().start()
        plate = {"models": [{"file": f"{'m' * 180}{number}.stl"} for number in range(60)]}
        for number in range(40):
            folder = self.path(f"plate{number}")
            os.mkdir(folder)
            self.write(f"plate{number}/plate.json", json.dumps(plate))
            os.rename(folder, daemon.file("incoming", f"plate{number}"))
        wait_until(lambda: daemon.log().count(" waits for ") == 40, "all plates to be looked at")
        self.assertEqual(len(daemon.status()["incomplete"]), 10)

    def test_a_folder_is_ignored_until_it_contains_a_plate_json(self):
        daemon = self.daemon()
        os.makedirs(daemon.file("incoming", "later"))
        os.makedirs(daemon.file("incoming", ".hidden"))
        daemon.start()
        self.put(daemon, "later/cube.stl", CUBE)
        daemon.printed("real.stl", CUBE)
        self.assertEqual(daemon.names_in("incoming"), [".hidden", "later"])
        self.put(daemon, "later/plate.json", '{"models": [{"file": "cube.stl"}]}')
        daemon.wait_done("later")

    def test_plates_that_were_there_before_the_start_are_printed(self):
        daemon = self.daemon()
        self.drop_plate(daemon, "early", BOTH)
        daemon.start()
        daemon.wait_done("early")

    def test_a_plate_and_a_model_of_the_same_name_do_not_overwrite_each_other(self):
        daemon = self.daemon().start()
        daemon.printed("part.stl", CUBE)
        self.drop_plate(daemon, "part", BOTH)
        daemon.wait_done("part-2")
        daemon.drop("part.stl", CUBE)
        daemon.wait_done("part-3")
        self.assertTrue(daemon.has("done", "part.stl") and daemon.has("done", "part-2", "cube.stl"))

    def test_a_waiting_plate_that_loses_a_file_waits_for_it_again(self):
        daemon = self.printing("first.stl", CUBE)
        self.drop_plate(daemon, "second", BOTH)
        daemon.wait_status("queued", 1)
        os.rename(daemon.file("incoming", "second", "post.stl"), self.path("taken.stl"))
        daemon.wait_status("queued", 0)
        self.assertEqual(daemon.status()["incomplete"], {"second": ["post.stl"]})
        os.rename(self.path("taken.stl"), daemon.file("incoming", "second", "post.stl"))
        daemon.wait_status("queued", 1)
        os.rename(daemon.file("incoming", "second"), self.path("withdrawn"))
        daemon.wait_status("queued", 0)
        self.assertEqual(daemon.status()["incomplete"], {})


class Refusal(PlateTest):
    def test_the_reason_names_what_is_wrong_with_a_plate(self):
        daemon = self.daemon().start()
        self.refused(daemon, "syntax", "{", "plate.json")
        self.refused(daemon, "unknown", {"models": [{"file": "cube.stl", "colour": 1}]}, "/models/0/colour")
        self.refused(daemon, "none", {"models": []}, "/models")
        self.refused(daemon, "outside", {"models": [{"file": "../cube.stl"}]}, "/models/0/file")
        self.refused(daemon, "over", {"models": [{"file": "cube.stl", "position_mm": {"x": 45}}]},
                     "cube.stl", "2.00 mm over the right edge")  # fmt: skip
        self.refused(daemon, "clash", {"models": [{"file": "cube.stl", "position_mm": {}},
                                                  {"file": "post.stl", "position_mm": {"x": 6}}]},
                     "cube.stl and post.stl", "height of 0.025 mm")  # fmt: skip
        self.refused(daemon, "broken", BOTH, "post.stl", "STL", files={"cube.stl": CUBE, "post.stl": b"no model"})
        self.refused(daemon, "times", {"adaptive_layers": {"cusp_um": 10}, "models": [{"file": "cube.stl"}]}, "working curve")
        self.drop_plate(daemon, "good", BOTH)
        daemon.wait_done("good")


class Interruption(PlateTest):
    def test_a_killed_plate_waits_as_a_whole_until_the_plate_is_cleared(self):
        daemon = self.printing("first.stl", CUBE, **WAITS)
        daemon.cancel("first")
        daemon.rpc("plate_cleared")
        self.drop_plate(daemon, "plate.of.two", BOTH)
        daemon.wait_state("exposing")
        self.assertEqual(daemon.names_in("printing"), ["plate.of.two"])
        daemon.kill()
        daemon.start()
        self.assertEqual(daemon.names_in("printing"), ["plate.of.two"])
        status = daemon.status()
        self.assertEqual((status["plate_job"], status["interrupted"]["job"]), ("plate.of.two", "plate.of.two"))
        daemon.rpc("plate_cleared")
        wait_until(lambda: daemon.has("failed", "plate.of.two", "post.stl"), "the plate in failed")
        self.assertIn("interrupted", daemon.read("failed", "plate.of.two.reason.txt"))
        # The plate is printed again when it is put back unchanged.
        os.rename(daemon.file("failed", "plate.of.two"), daemon.file("incoming", "again"))
        daemon.wait_state("exposing")
        daemon.process.send_signal(signal.SIGTERM)
        self.assertEqual(daemon.process.wait(30), 0)
        self.assertTrue(daemon.has("failed", "again", "plate.json"))
        self.assertIn("stopped", daemon.read("failed", "again.reason.txt"))
