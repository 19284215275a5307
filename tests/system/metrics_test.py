"""The metrics file (metrics_file), parsed by the rules of OpenMetrics 1.0 and of node-exporter's collector."""

import os
import re
import stat

from harness import CONTOURD, ENDLESS, REALTIME, SOURCE, Daemon, FolderTest, binary_stl, cube, run, text_of, wait_until

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
LABEL = r'[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\["\\n])*"'
SAMPLE = re.compile(rf"({NAME})(?:\{{((?:{LABEL}(?:,{LABEL})*)?)\}})? (-?[0-9]+(?:\.[0-9]+)?)")
PRINTER = 'odd "name" \\ 50 µm'


def parse(text):
    """Returns {(sample, labels): value}; raises AssertionError if the text breaks a rule of the format."""
    assert text.endswith("\n"), "the last line does not end in a newline"
    *lines, end = text[:-1].split("\n")
    assert end == "# EOF", end
    values, families, family, kind = {}, set(), None, None
    for line in lines:
        if line.startswith("#"):
            word, name, rest = re.fullmatch(rf"# (TYPE|UNIT|HELP) ({NAME}) (.*)", line).groups()
            if word == "TYPE":
                assert name not in families, f"{name} occurs twice"
                families.add(name)
                family, kind = name, rest
                # The types that node-exporter's parser knows, too.
                assert kind in ("gauge", "counter"), line
            assert name == family, line
            assert word != "UNIT" or name.endswith("_" + rest), line
            assert word != "HELP" or not re.search(r'\\(?![\\n"])', rest), line
            continue
        found = SAMPLE.fullmatch(line)
        assert found, line
        name, labels, value = found.groups()
        assert name == family + ("_total" if kind == "counter" else ""), line
        pairs = tuple(sorted(re.findall(LABEL, labels or "")))
        assert len({pair.split("=")[0] for pair in pairs}) == len(pairs), line
        assert (name, pairs) not in values, f"{line} occurs twice"
        assert kind != "counter" or float(value) >= 0, line
        values[name, pairs] = float(value)
    return values


class MetricsTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.metrics = self.path("metrics", "contourd.prom")

    def daemon(self, config=None, **options):
        return Daemon(self, config={"metrics_file": "metrics/contourd.prom", "name": PRINTER, **(config or {})}, **options)

    def values(self):
        return parse(text_of(self.metrics))

    def wait_for(self, name, value, *labels):
        """Waits until this sample has this value, and returns all samples."""
        def samples():
            if not os.path.exists(self.metrics):
                return None
            values = self.values()
            return values if values.get((name, labels)) == value else None
        return wait_until(samples, f"{name}{labels} = {value}")

    def test_the_metrics_file_exists_from_the_start_to_the_stop(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon().start()
        values = self.wait_for("contourd_state", 1, 'state="idle"')
        self.assertEqual(sum(value for (name, _), value in values.items() if name == "contourd_state"), 1)
        version = run(CONTOURD, "--version").stdout.decode().split()[-1]
        self.assertEqual(values["contourd_build_info", ('printer="odd \\"name\\" \\\\ 50 µm"', f'version="{version}"')], 1)
        self.assertEqual(values["contourd_jobs_total", ('outcome="done"',)], 0)
        self.assertNotIn(("contourd_layer", ()), values)
        self.assertEqual(stat.S_IMODE(os.stat(self.metrics).st_mode) & 0o444, 0o444)
        report = daemon.printed("gear.stl", binary_stl(cube(2)))
        daemon.refused("bad.stl", b"no model")
        values = self.wait_for("contourd_jobs_total", 1, 'outcome="failed"')
        self.assertEqual(values["contourd_jobs_total", ('outcome="done"',)], 1)
        lit = sum(layer["exposure_most_ms"] for layer in report["layer_records"]) / 1000
        self.assertAlmostEqual(values["contourd_light_seconds_total", ()], lit, delta=0.01)  # the report is rounded
        self.assertEqual(os.listdir(self.path("metrics")), ["contourd.prom"])
        daemon.stop()
        self.assertEqual(os.listdir(self.path("metrics")), [])

    def test_the_metrics_show_a_running_print(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.begin("gear.stl", binary_stl(cube(2)))
        daemon.drop("next.stl", binary_stl(cube(2)))
        values = self.wait_for("contourd_queued_jobs", 1)
        self.assertEqual(values["contourd_state", ('state="exposing"',)], 1)
        self.assertEqual((values["contourd_layer", ()], values["contourd_layers", ()]), (1, 40))
        self.assertEqual(values["contourd_light_may_be_on", ()], 1)
        self.assertEqual(values["contourd_plate_occupied", ()], 1)
        daemon.kill()
        daemon.start()
        values = self.wait_for("contourd_queue_held", 1)
        self.assertNotIn(("contourd_layer", ()), values)

    def test_a_missing_metrics_folder_gives_one_warning_and_prints_go_on(self):
        daemon = self.daemon().start()
        wait_until(lambda: "contourd.prom cannot be written" in daemon.log(), "the warning")
        daemon.printed("gear.stl", binary_stl(cube(2)))
        os.mkdir(self.path("metrics"))
        self.wait_for("contourd_jobs_total", 1, 'outcome="done"')
        wait_until(lambda: "contourd.prom is written again" in daemon.log(), "the message that the file is written again")
        self.assertEqual(daemon.log().count("cannot be written"), 1)

    def test_the_documented_folder_is_in_the_unit_and_readable_for_all(self):
        [place] = re.findall(r"/run/contourd-[\w/]+\.prom", text_of(os.path.join(SOURCE, "config", "contourd.schema.json")))
        folder = os.path.dirname(place)
        for name, line in (("contourd.service", f"ReadWritePaths=-{folder}"), ("contourd.tmpfiles", f"d {folder} 0755 contourd contourd")):
            self.assertIn(line, text_of(os.path.join(SOURCE, "systemd", name)).splitlines())

    def test_the_guide_lists_exactly_the_metrics_of_the_file(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.begin("gear.stl", binary_stl(cube(2)))
        values = self.wait_for("contourd_layer", 1)
        documented = set(re.findall(r"contourd_[a-z_]+", text_of(os.path.join(SOURCE, "docs", "connections.md"))))
        self.assertEqual({name for name, _ in values}, documented)
