"""What contourctl writes for slicers: sliced archives (slice --sl1) and PrusaSlicer's profiles (export prusaslicer)."""

import configparser
import os
import resource
import shutil
import struct
import subprocess
import zipfile

from harness import BAD_CONFIG, BAD_USAGE, CANNOT_CREATE, OK, SpoolTest, binary_stl, box, contents, contourctl, read_png, source_json, text_of, wedge

# An asymmetric part with grey edges.
PART = wedge(2.013, 1.007, 0.4) + box((-0.41, -0.31, 0), (0.117, 0.52, 0.2))
CURVE = {"penetration_depth_um": 150, "critical_energy_mj_cm2": 8, "overcure_um": 50, "bottom_overcure_um": 150}
DISPLAY = {"display": {"width_px": 96, "height_px": 64, "mirror_x": True, "gamma": 1.6, "threshold": 20}}


def ini_of(text):
    return dict(line.split(" = ", 1) if " = " in line else (line.split(" =")[0], "") for line in text.splitlines() if "=" in line)


class SlicedArchive(SpoolTest):
    def masks(self, *folder):
        names = sorted(name for name in os.listdir(self.path(*folder)) if name.endswith(".png"))
        return [read_png(self.path(*folder, name)).rows for name in names]

    def printer(self, **resin):
        return self.daemon(DISPLAY, {"growth_um": 40, **resin}, masks=True).start()

    def slice(self, model, daemon, out, *options, **expected):
        return contourctl("slice", model, "--printer", daemon.config_path, "--sl1", out, *options, **(expected or {"expect": OK}))

    def test_the_archive_printed_by_contourd_gives_the_masks_of_the_model_to_the_byte(self):
        daemon = self.printer()
        model = self.write("part.stl", binary_stl(PART))
        daemon.printed("part.stl", binary_stl(PART))
        result = self.slice(model, daemon, self.path("sliced.sl1"), "--masks", self.path("own"))
        self.assertIn(f"8 layers in {self.path('sliced.sl1')}", result.stdout.decode())
        daemon.printed("sliced.sl1", contents(self.path("sliced.sl1")))
        expected = self.masks("masks", "part")
        self.assertEqual(len(expected), 8)
        self.assertTrue(any(0 < pixel < 255 for row in expected[0] for pixel in row))
        self.assertEqual(self.masks("masks", "sliced"), expected)
        self.assertEqual(self.masks("own"), expected)

    def test_the_archive_has_the_files_and_settings_that_other_tools_read(self):
        daemon = self.printer()
        self.slice(self.write("my part.stl", binary_stl(PART)), daemon, self.path("a.sl1"))
        with zipfile.ZipFile(self.path("a.sl1")) as archive:
            self.assertIsNone(archive.testzip())
            names = archive.namelist()
            self.assertEqual(names, [f"my_part{n:05}.png" for n in range(8)] + ["thumbnail/thumbnail400x400.png", "thumbnail/thumbnail800x480.png", "prusaslicer.ini", "config.ini"])
            config, slicer = (ini_of(archive.read(name).decode()) for name in ("config.ini", "prusaslicer.ini"))
            for name, size in (("thumbnail/thumbnail400x400.png", (400, 400)), ("thumbnail/thumbnail800x480.png", (800, 480)), (names[0], (96, 64))):
                self.assertEqual(struct.unpack(">II", archive.read(name)[16:24]), size)
        self.assertEqual((config["jobDir"], config["layerHeight"], config["numFast"], config["numSlow"]), ("my_part", "0.05", "8", "0"))
        resin = source_json("resins", "standard.json")
        self.assertEqual((float(config["expTime"]), float(config["expTimeFirst"])), (resin["exposure_ms"] / 1000, resin["bottom_exposure_ms"] / 1000))
        self.assertGreater(float(config["usedMaterial"]), 0)
        self.assertGreater(float(config["printTime"]), float(config["expTimeFirst"]))
        self.assertEqual((slicer["display_pixels_x"], slicer["display_pixels_y"], slicer["display_width"], slicer["display_height"]), ("96", "64", "4.8", "3.2"))
        self.assertEqual((slicer["display_mirror_x"], slicer["display_mirror_y"], slicer["display_orientation"]), ("1", "0", "landscape"))
        self.assertEqual((slicer["layer_height"], slicer["exposure_time"], slicer["initial_exposure_time"]), (config["layerHeight"], config["expTime"], config["expTimeFirst"]))

    def test_a_disk_that_is_full_leaves_no_archive_and_keeps_an_earlier_one(self):
        daemon = self.printer()
        model = self.write("part.stl", binary_stl(PART))
        self.write("earlier.sl1", b"an earlier archive")

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

        before = sorted(os.listdir(self.folder))
        for name in ("earlier.sl1", "new.sl1"):
            with self.subTest(name):
                # SIGXFSZ stays ignored, as Python has it, so that a write beyond the limit fails as on a full disk.
                result = self.slice(model, daemon, self.path(name), expect=CANNOT_CREATE, preexec_fn=limit, restore_signals=False)
                self.assert_refusal(result, CANNOT_CREATE, "cannot write", name)
                self.assertEqual(sorted(os.listdir(self.folder)), before)
        self.assertEqual(contents(self.path("earlier.sl1")), b"an earlier archive")
        self.assert_refusal(self.slice(model, daemon, "/dev/full", expect=CANNOT_CREATE), CANNOT_CREATE, "/dev/full", "not a regular file")
        self.assert_refusal(self.slice(model, daemon, self.path("none", "a.sl1"), expect=CANNOT_CREATE), CANNOT_CREATE, "none/a.sl1")

    def test_what_an_archive_cannot_have_is_refused(self):
        daemon = self.printer()
        # Upright walls take thick layers, and a slope takes thin ones.
        slope = [tuple((x, y, z + 1) for x, y, z in facet) for facet in wedge(1, 1, 0.4)]
        model = self.write("part.stl", binary_stl(box((0, 0, 0), (1, 1, 1)) + slope))
        daemon.write_resin("curve", {"exposure_ms": None, "bottom_exposure_ms": None, "working_curve": CURVE})
        ticket = self.write("part.json", b'{"resin": "curve", "adaptive_layers": {"min_um": 25, "max_um": 100, "cusp_um": 5}}')
        self.assert_refusal(self.slice(model, daemon, self.path("a.sl1"), "--ticket", ticket, expect=BAD_USAGE), BAD_USAGE, "one thickness")
        self.assertEqual(contourctl("slice", model, "--layer-height-um", "50", "--sl1", self.path("a.sl1")).returncode, BAD_USAGE)
        self.assertFalse(os.path.exists(self.path("a.sl1")))


class Profiles(SpoolTest):
    """The bundle of profiles, read as PrusaSlicer's INI files are."""

    SHRINKAGE = {"shrinkage_percent": {"x": 0.5, "y": 1, "z": 2}}

    def bundle(self, path):
        parser = configparser.ConfigParser(delimiters=("=",), interpolation=None, strict=True)
        parser.read_string(text_of(path))
        return parser

    def export(self, daemon, *options):
        contourctl("export", "prusaslicer", daemon.config_path, "-o", self.path("bundle.ini"), *options, expect=OK)
        return self.bundle(self.path("bundle.ini"))

    def test_the_bundle_has_the_display_and_a_material_for_each_resin(self):
        daemon = self.daemon({"name": "my [printer]", "display": {"width_px": 800, "height_px": 600, "pixel_pitch_um": 47.5, "mirror_y": True}})
        daemon.write_resin("grey", {"layer_height_um": 25, "exposure_ms": 2200, "bottom_exposure_ms": 25500, "fade_layers": 7, **self.SHRINKAGE})
        daemon.write_resin("broken", {"exposure_ms": -1})
        result = contourctl("export", "prusaslicer", daemon.config_path, expect=OK)
        self.assert_words(result.stderr.decode(), "broken", "is left out", "exposure_ms")
        bundle = configparser.ConfigParser(delimiters=("=",), interpolation=None)
        bundle.read_string(result.stdout.decode())
        self.assertEqual([name for name in bundle.sections() if name.startswith("printer:")], ["printer:my _printer_"])
        printer = bundle["printer:my _printer_"]
        self.assertEqual([printer[f"display_{key}"] for key in ("pixels_x", "pixels_y", "width", "height", "mirror_x", "mirror_y")], ["800", "600", "38", "28.5", "0", "1"])
        self.assertEqual((printer["sla_archive_format"], printer["gamma_correction"], printer["elefant_foot_compensation"]), ("SL1SVG", "1", "0"))
        materials = {name.split(":")[1]: bundle[name] for name in bundle.sections() if name.startswith("sla_material:")}
        self.assertEqual(sorted(materials), ["grey", "standard"])
        self.assertEqual([materials["grey"][key] for key in ("exposure_time", "initial_exposure_time", "initial_layer_height")], ["2.2", "25.5", "0.025"])
        print_profile = bundle["sla_print:" + materials["grey"]["compatible_prints"].strip('"')]
        self.assertEqual((print_profile["layer_height"], print_profile["faded_layers"]), ("0.025", "7"))
        factors = [float(materials["grey"][f"material_correction_{axis}"]) for axis in "xyz"]
        for factor, percent in zip(factors, self.SHRINKAGE["shrinkage_percent"].values()):
            self.assertAlmostEqual(factor, 1 / (1 - percent / 100), places=6)
        self.assertEqual(bundle["presets"]["sla_material"], "standard")
        self.assertFalse(any(name.startswith("physical_printer:") for name in bundle.sections()))

    def test_resins_whose_names_differ_only_in_characters_that_are_replaced_get_profiles_of_their_own(self):
        daemon = self.daemon()
        for number, name in enumerate(("a:b", "a;b", "a_b")):
            daemon.write_resin(name, {"exposure_ms": 4000 + number})
        bundle = self.export(daemon)  # strict: no section twice
        materials = {name: bundle[name] for name in bundle.sections() if name.startswith("sla_material:a")}
        self.assertEqual(sorted(material["exposure_time"] for material in materials.values()), ["4", "4.001", "4.002"])
        for material in materials.values():
            self.assertIn("sla_print:" + material["compatible_prints"].strip('"'), bundle.sections())

    def test_a_host_makes_a_physical_printer_and_mistakes_are_one_line(self):
        daemon = self.daemon()
        bundle = self.export(daemon, "--host", "192.168.1.20:8080")
        physical = bundle[next(name for name in bundle.sections() if name.startswith("physical_printer:"))]
        self.assertEqual(physical["print_host"], "192.168.1.20:8080")
        self.assertIn(f"printer:{physical['preset_names'].strip(chr(34))}", bundle.sections())
        self.assertEqual(contourctl("export", "prusaslicer", daemon.config_path, "--host", "a\nb").returncode, BAD_USAGE)
        self.assertEqual(contourctl("export", "prusaslicer", self.write("bad.json", b"{}")).returncode, BAD_CONFIG)
        self.assert_refusal(contourctl("export", "prusaslicer", daemon.config_path, "-o", "/dev/full"), CANNOT_CREATE, "/dev/full")

    def test_a_file_that_the_real_prusaslicer_slices_with_the_profiles_is_printed_as_the_model_itself(self):
        if not shutil.which("prusa-slicer"):
            self.skipTest("there is no prusa-slicer")
        daemon = self.daemon({"display": {"mirror_x": True, "mirror_y": True}}, masks=True)
        bundle = self.export(daemon)
        daemon.start()
        # Its command line takes one profile: the three of the bundle in one.
        settings = {"supports_enable": "0", "pad_enable": "0"}
        for section in bundle.sections():
            if section != "presets":
                settings |= bundle[section]
        flat = self.write("flat.ini", "".join(f"{key} = {value}\n" for key, value in settings.items()).encode())
        model = self.write("part.stl", binary_stl(box((0, 0, 0), (20, 4, 2)) + box((0, 4, 0), (4, 10, 1))))
        result = subprocess.run(["prusa-slicer", "--export-sla", "--load", flat, "--output", self.path("part.sl1"), model],
                                capture_output=True, text=True, timeout=300, check=False, env={**os.environ, "HOME": self.folder})  # fmt: skip
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        report = daemon.printed("part.sl1", contents(self.path("part.sl1")))
        self.assertEqual(report["layer_height_um"], source_json("resins", "standard.json")["layer_height_um"])
        self.assertFalse([warning for warning in report["model"]["warnings"] if "first layer" in warning or "display" in warning])
        contourctl("slice", model, "--printer", daemon.config_path, "--masks", self.path("own"), expect=OK)
        names = sorted(os.listdir(self.path("own")))
        self.assertEqual(sorted(os.listdir(self.path("masks", "part"))), names)
        for name in names:
            own, sliced = read_png(self.path("own", name)).rows, read_png(self.path("masks", "part", name)).rows
            # PrusaSlicer centres the part on the plate to a micrometre.
            self.assertLessEqual(max(abs(a - b) for row, other in zip(own, sliced) for a, b in zip(row, other)), 6, name)
