"""The shipped profiles: they are valid with every Raspberry Pi, screw, microstep setting and projector, and the figures in
docs/first-print.md are right."""

import fractions
import json
import os
import re

from harness import BAD_CONFIG, OK, SOURCE, Daemon, FolderTest, binary_stl, box, check_config, merge, source_json, text_of

MODELS = ("3", "4", "5")
# Source: the kernel's drivers drivers/pinctrl/bcm/pinctrl-bcm2835.c and drivers/pinctrl/pinctrl-rp1.c.
CHIPS = {"3": "pinctrl-bcm2835", "4": "pinctrl-bcm2711", "5": "pinctrl-rp1"}
PITCHES_MM, MICROSTEPS, FULL_STEPS = (2, 4, 8), (16, 32), 200
TABLES = sorted(name[:-len(".json")] for name in os.listdir(os.path.join(SOURCE, "config", "projectors")))
# Steps per second (docs/printer-setup.md): the limit of any axis, and the rate that every Raspberry Pi reaches easily.
MOST_RATE, SURE_RATE = 20000, 5000
GUIDE = os.path.join(SOURCE, "docs", "first-print.md")


def per_mm(pitch_mm, microsteps):
    return fractions.Fraction(FULL_STEPS * microsteps, pitch_mm)


def guide_table(first_column):
    """Returns the rows of the guide's table whose first column has this name, as lists of cells."""
    text = text_of(GUIDE)
    (table,) = re.findall(rf"(?m)^\| {re.escape(first_column)} \|.*\n\|[-| ]+\|\n((?:\|.*\n)+)", text)
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()]


class Profiles(FolderTest):
    def setUp(self):
        super().setUp()
        for name in ("resins", "projectors"):
            os.symlink(os.path.join(SOURCE, "config", name), self.path(name))

    def check(self, profile):
        return check_config(self.write("contourd.json", json.dumps(profile)))

    def profile(self, model, **of_axis):
        return merge(source_json(f"raspberry-pi-{model}.json"), {"z_axis": of_axis})

    def machines(self):
        for model in MODELS:
            for pitch in PITCHES_MM:
                for microsteps in MICROSTEPS:
                    yield model, pitch, microsteps

    def with_speed(self, model, steps_per_mm, rate):
        speed = float(rate / steps_per_mm)
        slower = min(5, speed)
        return self.profile(model, microsteps_per_mm=float(steps_per_mm), top_speed_mm_s=speed, travel_speed_mm_s=slower,
                            homing_speed_mm_s=slower)  # fmt: skip

    def test_every_machine_with_every_projector_is_valid(self):
        self.assertEqual(len(TABLES), 6)
        for model, pitch, microsteps in self.machines():
            for table in TABLES:
                with self.subTest(model=model, pitch=pitch, microsteps=microsteps, table=table):
                    profile = self.with_speed(model, per_mm(pitch, microsteps), SURE_RATE)
                    profile["projector"]["table"] = table
                    if "light_on" not in source_json("projectors", table + ".json")["commands"]:
                        code, _, last = self.check(profile)
                        self.assertEqual(code, BAD_CONFIG)
                        self.assertIn('give a "light" line too', last)
                        profile["projector"]["light"] = {"chip": CHIPS[model], "line": 24}
                    code, warnings, last = self.check(profile)
                    self.assertEqual((code, last), (OK, f"{self.path('contourd.json')}: good"))
                    # BenQ's replies may take longer than the resin's exposure, as the guide says.
                    self.assertEqual([table for warning in warnings if "the reply to light_on may take" in warning],
                                     ["benq"] if table == "benq" else [])  # fmt: skip
                    self.assertEqual(len(warnings), int(table == "benq"), warnings)

    def test_the_highest_speed_follows_from_the_step_rate(self):
        for model, pitch, microsteps in self.machines():
            with self.subTest(model=model, pitch=pitch, microsteps=microsteps):
                steps = per_mm(pitch, microsteps)
                self.assertEqual(self.check(self.with_speed(model, steps, MOST_RATE))[0], OK)
                code, _, last = self.check(self.with_speed(model, steps, MOST_RATE * 1.01))
                self.assertEqual(code, BAD_CONFIG)
                most = f"{float(MOST_RATE / steps):g} mm/s"
                self.assertIn(f"more than the limit, {most}" if steps == 400 else  # the schema's limit
                              f"are 20200 steps a second; the limit is {MOST_RATE}, that is {most}", last)  # fmt: skip

    def test_the_guide_has_the_same_figures(self):
        rows = {}
        for pitch, microsteps, steps, height, sure, most in guide_table("pitch"):
            rows[int(pitch.split()[0]), int(microsteps.split("/")[1])] = [float(word.split()[0]) for word in (steps, height, sure, most)]
        self.assertEqual(sorted(rows), sorted((pitch, microsteps) for pitch in PITCHES_MM for microsteps in MICROSTEPS))
        for (pitch, microsteps), figures in rows.items():
            steps = per_mm(pitch, microsteps)
            expected = [steps, 1000 / steps, SURE_RATE / steps, MOST_RATE / steps]
            # The figures are rounded to two places, limits always down.
            for figure, value, most_above in zip(figures, expected, (0, 0.005, 0, 0), strict=True):
                self.assertLessEqual(figure, value + most_above)
                self.assertGreater(figure, value - fractions.Fraction(1, 100))

    def test_the_guide_names_each_model_s_profile_and_chip(self):
        rows = {row[0].split()[-1]: row for row in guide_table("computer")}
        self.assertEqual(sorted(rows), list(MODELS))
        for model, row in rows.items():
            profile = self.profile(model)
            self.assertIn(f"`raspberry-pi-{model}.json`", row)
            self.assertIn(f"`{CHIPS[model]}`", row)
            for line in ("step", "direction", "enable", "limit_switch"):
                self.assertEqual(profile["z_axis"][line]["chip"], CHIPS[model])

    def test_profiles_differ_only_in_their_chip_and_name(self):
        texts = set()
        for model in MODELS:
            text = json.dumps(self.profile(model)).replace(CHIPS[model], "chip")
            texts.add(text.replace(f"Raspberry Pi {model}", "Raspberry Pi"))
        self.assertEqual(len(texts), 1)

    def test_the_wiring_of_the_guide_uses_no_line_twice(self):
        for model in MODELS:
            contact = {"chip": CHIPS[model], "active_low": True, "bias": "pull_up", "contact": "normally_closed"}
            profile = self.profile(model, emergency_stop={**contact, "line": 5}, lid={**contact, "line": 6})
            profile["projector"]["light"] = {"chip": CHIPS[model], "line": 24}
            self.assertEqual(self.check(profile), (OK, [], f"{self.path('contourd.json')}: good"))


class Prints(FolderTest):
    def test_a_profile_prints_when_its_hardware_is_simulated(self):
        for model in MODELS:
            with self.subTest(model=model):
                daemon = Daemon(self)
                daemon.config = merge(source_json(f"raspberry-pi-{model}.json"), {
                    "spool_folder": "spool", "control_socket": "control.sock", "job_ended_socket": "job-ended.socket",
                    "projectors_folder": os.path.join(SOURCE, "config", "projectors"), "min_free_disk_mb": 0,
                    "wait_for_plate_cleared": False, "hardware": "simulated", "simulation": {"pace": "fast"},
                })  # fmt: skip
                daemon.write_config()
                daemon.start()
                model_file = self.write(f"part{model}.stl", binary_stl(box((0, 0, 0), (5, 5, 0.2))))
                daemon.ctl("submit", model_file, "--wait", expect=OK)
                daemon.stop()
