"""Supports in tickets, in the printer's configuration, in the report and in contourctl."""

import json
import math
import os

from harness import BAD_DATA, BAD_USAGE, OK, Daemon, FolderTest, binary_stl, box, contents, contourctl, inside_out, read_png, text_of, wait_until

DISPLAY = ("--display", "1920x1080", "--pixel-pitch-um", "50")  # simulated.json


def ball(radius, steps=24):
    """Returns the facets of a ball around the origin."""
    def at(ring, turn):
        down, around = math.pi * ring / steps, 2 * math.pi * turn / steps
        return (radius * math.sin(down) * math.cos(around), radius * math.sin(down) * math.sin(around), radius * math.cos(down))

    facets = []
    for ring in range(steps):
        for turn in range(steps):
            a, b, c, d = at(ring, turn), at(ring + 1, turn), at(ring + 1, turn + 1), at(ring, turn + 1)
            if ring < steps - 1:
                facets.append((a, b, c))
            if ring > 0:
                facets.append((a, c, d))
    return facets


BALL = binary_stl(ball(4))
BOX = binary_stl(box((0, 0, 0), (10, 5, 1)))
# A bar in the air between two walls that are 1 mm apart: there is no room for a support below it.
CAGED = binary_stl([*box((0, 0, 0), (5.5, 12, 14)), *box((6.5, 0, 0), (12, 12, 14)), *box((5.9, 5, 8), (6.1, 7, 9))])
# A block with a cavity, whose ceiling hangs over its floor without a wall in reach.
HOLLOW = binary_stl([*box((0, 0, 0), (12, 12, 12)), *inside_out(box((2, 2, 3), (10, 10, 9)))])


class Supports(FolderTest):
    def daemon(self, supports="auto", **config):
        return Daemon(self, {"supports": supports, **config}, masks=True).start()

    def printed(self, daemon, name, data, ticket=None):
        daemon.drop(f"{name}.stl", data, ticket)
        return daemon.wait_done(name)

    def masks(self, folder):
        return {name: read_png(os.path.join(folder, name)) for name in sorted(os.listdir(folder))}

    def sliced(self, data, *words):
        model, folder = self.write("model.stl", data), self.path("sliced" + "".join(words))
        contourctl("slice", model, "--layer-height-um", "50", "--masks", folder, *DISPLAY, *words, expect=OK)
        return self.masks(folder)

    def json_of(self, *words):
        result = contourctl(*words, "--json", expect=OK)
        return json.loads(result.stdout)

    # --- what is printed

    def test_a_ball_gets_supports_without_a_ticket_if_the_configuration_says_so(self):
        daemon = self.daemon()
        report = self.printed(daemon, "ball", BALL)
        supports = report["supports"]
        self.assertGreaterEqual(supports["islands"], 1)
        self.assertGreaterEqual(supports["feet"], 1)
        self.assertEqual(supports["unheld"], 0)
        self.assertEqual(len(supports["contact_list"]), supports["contacts"])
        self.assertEqual(report["analysis"]["islands"], 0)
        # The ball of 8 mm and 5 mm below it, in layers of 50 um.
        self.assertEqual(report["layers"], 260)
        self.assertEqual(report["settings"]["supports"]["tip_diameter_mm"], 0.4)
        self.assertRegex(daemon.log(), r"ball: supports: \d+ contacts? \(\d+ at islands, \d+ at overhangs, \d+ against peel\), \d+ branch(es)?, \d+ f(oo|ee)t")
        self.assertRegex(text_of(self.path("spool", "done", "ball.report.html")), r"<th>Supports</th><td>\d+ contact")
        self.assertEqual(self.masks(self.path("masks", "ball")), self.sliced(BALL, "--supports", "auto"))

    def test_off_prints_the_model_without_supports(self):
        daemon = self.daemon("off")
        report = self.printed(daemon, "ball", BALL)
        self.assertIsNone(report["supports"])
        self.assertEqual(report["layers"], 160)
        bare = self.sliced(BALL)
        self.assertEqual(self.masks(self.path("masks", "ball")), bare)
        self.assertEqual(self.sliced(BALL, "--supports", "off"), bare)
        self.assertIsNotNone(self.printed(daemon, "held", BALL, {"supports": "auto"})["supports"])

    def test_a_model_that_needs_no_supports_is_printed_unchanged(self):
        daemon = self.daemon()
        report = self.printed(daemon, "box", BOX, {"copies": 2})
        self.assertEqual((report["supports"]["contacts"], report["supports"]["unheld"]), (0, 0))
        self.assertIn("box: supports: none needed", daemon.log())
        self.assertIsNone(self.printed(daemon, "bare", BOX, {"copies": 2, "supports": "off"})["supports"])
        self.assertEqual(self.masks(self.path("masks", "box")), self.masks(self.path("masks", "bare")))

    def test_support_settings_of_a_ticket_are_used_and_reported(self):
        daemon = self.daemon("off")
        report = self.printed(daemon, "ball", BALL, {"supports": {"lift_mm": 7, "foot_diameter_mm": 3}})
        self.assertEqual(report["layers"], 300)
        self.assertEqual(report["overrides"], [{"setting": "supports.foot_diameter_mm", "asked": 3, "profile": 4},
                                               {"setting": "supports.lift_mm", "asked": 7, "profile": 5}])  # fmt: skip
        self.assertIn("by its ticket: supports.foot_diameter_mm 3 instead of 4, supports.lift_mm 7 instead of 5", daemon.log())
        self.assertIn("/supports/tip_diameter_mm: 2 mm is more than pillar_diameter_mm, 1 mm", daemon.refused("wrong.stl", BALL, {"supports": {"tip_diameter_mm": 2}}))

    def test_a_model_that_is_too_high_on_its_supports_is_refused(self):
        daemon = self.daemon(z_axis={"travel_mm": 15.5}, simulation={"start_height_mm": 0})
        self.assert_one_line(daemon.refused("ball.stl", BALL).encode(), "the model is 8.00 mm high and stands 5.00 mm above the plate, on supports: "
                             "13.00 mm, and the machine can print 12.00 mm")  # fmt: skip
        self.printed(daemon, "bare", BALL, {"supports": "off"})

    # --- what cannot be held

    def test_a_model_with_unheld_places_waits_to_be_accepted(self):
        daemon = self.daemon()
        daemon.drop("caged.stl", CAGED)
        job = wait_until(lambda: next((job for job in daemon.rpc("queue")["result"]["jobs"] if job["state"] == "unaccepted"), None), "caged to wait to be accepted")
        self.assertEqual(job["asks"], ["unheld_places"])
        self.assertGreaterEqual(job["supports"]["unheld"], 1)
        self.assertRegex(" ".join(job["warnings"]), r"places? cannot be held: at -?\d+\.\d\d, -?\d+\.\d\d mm from the plate's centre, \d+\.\d\d mm above the plate \(")
        self.assertIn('caged.stl waits: unheld places; run "contourctl accept caged" to print it anyway', daemon.log())
        shown = daemon.ctl("queue", "show", "caged").stdout.decode()
        self.assertRegex(shown, r"(?m)^supports  .*[1-9]\d* places? not held")
        self.assertRegex(shown, r"(?m)^warning   .*places? cannot be held: at ")
        self.printed(daemon, "box", BOX)
        daemon.ctl("accept", "caged", expect=OK)
        report = daemon.wait_done("caged")
        self.assertGreaterEqual(report["supports"]["unheld"], 1)
        self.assertTrue(any("cannot be held" in warning for warning in report["model"]["warnings"]))

    def test_supports_in_a_sealed_hollow_are_named_before_the_print_and_in_its_report(self):
        said = r"\d+ supports? stands? in (a )?sealed hollows? and cannot be taken out: (the lowest )?at -?\d+\.\d\d, -?\d+\.\d\d mm from the plate's centre, 9\.00 mm above the plate"
        daemon = self.daemon()
        report = self.printed(daemon, "hollow", HOLLOW)
        self.assertRegex(" ".join(report["model"]["warnings"]), said)
        self.assertRegex(daemon.log(), said)
        path = self.write("hollow.stl", HOLLOW)
        for command in (["support"], ["slice", "--layer-height-um", "50", "--supports", "auto"], ["analyze", "--supports", "auto"]):
            ran = contourctl(*command, path)
            self.assertRegex((ran.stdout + ran.stderr).decode(), said, command)

    def test_a_job_that_waits_to_be_accepted_is_checked_again_when_its_ticket_changes(self):
        daemon = self.daemon()

        def waits():
            return next((job for job in daemon.rpc("queue")["result"]["jobs"] if job["state"] == "unaccepted"), None)

        daemon.drop("caged.stl", CAGED)
        wait_until(waits, "caged to wait to be accepted")
        self.write("spool/incoming/caged.json", json.dumps({"supports": "off"}))
        self.assertIsNone(daemon.wait_done("caged")["supports"])
        daemon.drop("again.stl", CAGED)
        wait_until(waits, "again to wait to be accepted")
        self.write("spool/incoming/again.json", '{"supports": ')
        self.assertIn("again.json", daemon.wait_refused("again"))

    def test_a_tiny_tip_depth_prints_the_same_as_a_tip_depth_of_zero(self):
        daemon = self.daemon()
        for name, depth in (("none", 0), ("hardly", 1e-170)):
            self.printed(daemon, name, BALL, {"supports": {"tip_depth_mm": depth}})
        self.assertEqual(self.masks(self.path("masks", "hardly")), self.masks(self.path("masks", "none")))

    # --- contourctl

    def test_support_lists_contacts_and_writes_supports_as_a_model(self):
        model = self.write("ball.stl", BALL)
        result = contourctl("support", model, "--scale", "1000")
        self.assert_refusal(result, BAD_DATA, "the model is 8005 mm high: supports are possible up to 3000 mm")
        result = contourctl("support", model, expect=OK)
        self.assertRegex(result.stdout.decode(), r"(?m)^supports   \d+ contacts?.*\nlift       5 mm$")
        self.assertRegex(result.stdout.decode(), r"(?m)^island     at -?\d+\.\d\d, -?\d+\.\d\d mm, \d+\.\d\d mm above the plate, holds ")
        supports = self.json_of("support", model)
        self.assertEqual(supports["lift_mm"], 5)
        self.assertEqual({each["cause"] for each in supports["contact_list"]} - {"island", "overhang", "peel"}, set())
        alone, together = self.path("alone.stl"), self.path("together.stl")
        self.assertEqual(contourctl("support", model, "--stl", alone).returncode, OK)
        self.assertEqual(contourctl("support", model, "--stl", together, "--with-model").returncode, OK)
        inspected, both = self.json_of("inspect", alone), self.json_of("inspect", together)
        self.assertGreater(inspected["facets"], 100)
        self.assertEqual(both["facets"], inspected["facets"] + len(ball(4)))
        self.assertEqual((inspected["bounds_mm"]["min"][2], both["bounds_mm"]["min"][2]), (0, 0))
        half = self.json_of("support", model, "--scale", "0.5")
        self.assertLess(max(each["plate_mm"][2] for each in half["contact_list"]), 5 + 4)

    def test_a_model_that_carries_supports_is_printed_as_it_is(self):
        model, held = self.write("ball.stl", binary_stl(ball(8))), self.path("held.stl")
        contourctl("support", model, "--stl", held, "--with-model", expect=OK)
        data = contents(held)
        self.assertEqual(self.sliced(data, "--supports", "auto"), self.sliced(data))
        result = contourctl("support", held, expect=OK)
        self.assertEqual(result.stdout.decode(), "supports   none added: 1 model carries its own in its file\nlift       0 mm\n")
        self.assertIs(self.json_of("support", held)["carries_supports"], True)
        self.assertIs(self.json_of("support", model)["carries_supports"], False)
        told = b"the model carries supports in its file, so contourctl adds none"
        self.assertIn(told, contourctl("slice", held, "--layer-height-um", "50", "--supports", "auto", expect=OK).stderr)
        overruled = contourctl("support", held, "--supports", "on", expect=OK)
        self.assertEqual(overruled.stdout.decode(), "supports   none needed\nlift       0 mm\n")
        told = b"the model carries supports in its file, but contourctl supports it like any other model, as asked"
        for command in ("support", "slice"):
            layers = ("--layer-height-um", "50")
            self.assertIn(told, contourctl(command, held, *layers, "--supports", "on", expect=OK).stderr)
        daemon = self.daemon(wait_for_plate_cleared=True)
        own = "1 model carries its own in its file"
        self.printed(daemon, "box", BOX)
        daemon.drop("held.stl", data)
        waiting = wait_until(lambda: next((job for job in daemon.rpc("queue")["result"]["jobs"] if job["supports"]), None), "held to be checked")
        self.assertEqual((waiting["supports"]["carriers"], waiting["supports"]["contacts"]), (1, 0))
        self.assertIn(f"supports  none added: {own}\n", daemon.ctl("queue", "show", "held").stdout.decode())
        daemon.rpc("plate_cleared")
        wait_until(lambda: (daemon.rpc("status")["result"]["job"] or {}).get("supports"), "held to be printed")
        self.assertIn(f"supports  {own}\n", daemon.ctl("status").stdout.decode())
        self.assertIn("  as drawn, on its own supports", contourctl("orient", held, expect=OK).stdout.decode())
        report = daemon.wait_done("held")
        self.assertEqual((report["supports"]["contacts"], report["supports"]["carriers"], report["layers"]), (0, 1, 420))
        self.assertIn("the model carries supports in its file, so contourd adds none", report["model"]["warnings"])

    def test_analyze_counts_supports_and_shows_them(self):
        model, page = self.write("ball.stl", BALL), self.path("ball.html")
        bare = self.json_of("analyze", model)
        held = self.json_of("analyze", model, "--supports", "auto", "--html", page)
        self.assertIsNone(bare["supports"])
        self.assertEqual(bare["islands"], 0)  # the ball's lowest point on the plate is no island
        self.assertEqual((held["islands"], held["layers"]), (0, 260))
        self.assertGreater(held["resin_ml"], bare["resin_ml"])
        text = text_of(page)
        for cause in ("island", "overhang", "peel"):
            expected = sum(each["cause"] == cause for each in held["supports"]["contact_list"])
            self.assertEqual(text.count(f'<circle class="{cause}"'), expected)
        printer = Daemon(self, {"supports": "auto"}).config_path
        self.assertEqual(self.json_of("analyze", model, "--printer", printer)["layers"], 260)
        self.assertEqual(self.json_of("analyze", model, "--printer", printer, "--supports", "off")["layers"], 160)
        self.assertEqual(self.json_of("analyze", model, "--printer", printer, "--scale", "0.5")["layers"], 180)

    def test_submit_writes_supports_into_the_ticket_and_prints_the_outlook(self):
        daemon = self.daemon("off")
        model = self.write("ball.stl", BALL)
        result = daemon.ctl("submit", "--yes", "--supports", "auto", "--printer", daemon.config_path, model, expect=OK)
        self.assertIn("260 layers", result.stdout.decode())
        self.assertRegex(result.stdout.decode(), r"(?m)^  supports: \d+ contact")
        self.assertEqual(daemon.wait_done("ball")["layers"], 260)

    def link(self, model):
        link = os.path.join(self.folder, "same.html")
        os.link(model, link)
        return link

    def test_wrong_options_are_refused_with_a_reason(self):
        model = self.write("ball.stl", BALL)
        name = os.fsdecode(model)
        for words, code, part in (
            (["slice", model, "--z", "1", "--supports", "yes"], BAD_USAGE, "--supports"),
            (["slice", model, "--layer-height-um", "50", "--supports", "auto", "--fit"], BAD_USAGE, "--supports auto excludes --fit"),
            (["slice", model, "--z", "1", "--scale", "0"], BAD_USAGE, "--scale 0: expected 0.001 to 1000"),
            (["support", model, "--with-model"], BAD_USAGE, "--with-model needs --stl"),
            (["support", self.write("none.stl", b"no model")], BAD_DATA, "none.stl"),
            (["support", model, "--stl", model], BAD_USAGE, f"--stl {name}: this file is the model"),
            (["analyze", model, "--html", model], BAD_USAGE, f"--html {name}: this file is the model"),
            (["orient", model, "--html", self.link(model)], BAD_USAGE, "same.html: this file is the model"),
            (["slice", model, "--z", "1", "--mask", model], BAD_USAGE, f"--mask {name}: this file is the model"),
            (["slice", model, "--layer-height-um", "50", "--csv", model], BAD_USAGE, f"--csv {name}: this file is the model"),
        ):
            result = contourctl(*words)
            self.assertEqual(result.returncode, code, words)
            self.assertIn(part, result.stderr.decode())
        self.assertEqual(contents(model), BALL)
