"""The file of figures (metrics_file), read by the rules of OpenMetrics 1.0 and by those of node-exporter's collector."""

import os
import re
import stat

from harness import CONTOURD, ENDLESS, REALTIME, SOURCE, Daemon, FolderTest, binary_stl, cube, main, run, wait_until

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
LABEL = r'[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\["\\n])*"'
SAMPLE = re.compile(rf"({NAME})(?:\{{((?:{LABEL}(?:,{LABEL})*)?)\}})? (-?[0-9]+(?:\.[0-9]+)?)")
PRINTER = 'odd "name" \\ 50 µm'


def parse(text):
    """{(sample, labels): value}; whatever the format does not allow is an AssertionError."""
    assert text.endswith("\n"), "the last line has no end"
    *lines, end = text[:-1].split("\n")
    assert end == "# EOF", end
    values, families, family, kind = {}, set(), None, None
    for line in lines:
        if line.startswith("#"):
            word, name, rest = re.fullmatch(rf"# (TYPE|UNIT|HELP) ({NAME}) (.*)", line).groups()
            if word == "TYPE":
                assert name not in families, f"{name} is there twice"
                families.add(name)
                family, kind = name, rest
                # Those that node-exporter's parser knows, too.
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
        assert (name, pairs) not in values, f"{line} is there twice"
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
        with open(self.metrics, encoding="utf-8") as file:
            return parse(file.read())

    def wait_for(self, name, value, *labels):
        """Until that sample is so; all samples then."""
        def so():
            if not os.path.exists(self.metrics):
                return None
            values = self.values()
            return values if values.get((name, labels)) == value else None
        return wait_until(so, f"{name}{labels} = {value}")

    def test_figures_are_there_from_the_start_to_the_end(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon().start()
        values = self.wait_for("contourd_state", 1, 'state="idle"')
        self.assertEqual(sum(value for (name, _), value in values.items() if name == "contourd_state"), 1)
        version = run(CONTOURD, "--version").stdout.decode().split()[-1]
        self.assertEqual(values["contourd_build_info", ('printer="odd \\"name\\" \\\\ 50 µm"', f'version="{version}"')], 1)
        self.assertEqual(values["contourd_jobs_total", ('outcome="done"',)], 0)
        self.assertNotIn(("contourd_layer", ()), values)
        self.assertEqual(stat.S_IMODE(os.stat(self.metrics).st_mode) & 0o444, 0o444)
        daemon.drop("gear.stl", binary_stl(cube(1)))
        report = daemon.wait_done("gear")
        daemon.drop("bad.stl", b"no model")
        daemon.wait_refused("bad")
        values = self.wait_for("contourd_jobs_total", 1, 'outcome="failed"')
        self.assertEqual(values["contourd_jobs_total", ('outcome="done"',)], 1)
        lit = sum(layer["exposure_most_ms"] for layer in report["layer_records"]) / 1000
        self.assertAlmostEqual(values["contourd_light_seconds_total", ()], lit, delta=0.01)  # the report is rounded
        self.assertEqual(os.listdir(self.path("metrics")), ["contourd.prom"])
        daemon.stop()
        self.assertEqual(os.listdir(self.path("metrics")), [])

    def test_a_print_is_told_while_it_is_under_way(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.drop("gear.stl", binary_stl(cube(1)))
        daemon.wait_state("exposing")
        daemon.drop("next.stl", binary_stl(cube(1)))
        values = self.wait_for("contourd_queued_jobs", 1)
        self.assertEqual(values["contourd_state", ('state="exposing"',)], 1)
        self.assertEqual((values["contourd_layer", ()], values["contourd_layers", ()]), (1, 20))
        self.assertEqual(values["contourd_light_may_be_on", ()], 1)
        self.assertEqual(values["contourd_plate_occupied", ()], 1)
        daemon.kill()
        daemon.start()
        values = self.wait_for("contourd_queue_held", 1)
        self.assertNotIn(("contourd_layer", ()), values)

    def test_a_folder_that_takes_no_file_is_told_once_and_prints_go_on(self):
        daemon = self.daemon().start()
        wait_until(lambda: "contourd.prom cannot be written" in daemon.log(), "the warning")
        daemon.drop("gear.stl", binary_stl(cube(1)))
        daemon.wait_done("gear")
        os.mkdir(self.path("metrics"))
        self.wait_for("contourd_jobs_total", 1, 'outcome="done"')
        wait_until(lambda: "contourd.prom is written again" in daemon.log(), "the good news")
        self.assertEqual(daemon.log().count("cannot be written"), 1)

    def test_the_documented_place_is_the_units_and_all_may_read_there(self):
        with open(os.path.join(SOURCE, "config", "contourd.schema.json"), encoding="utf-8") as file:
            [place] = re.findall(r"/run/contourd-[\w/]+\.prom", file.read())
        folder = os.path.dirname(place)
        for name, line in (("contourd.service", f"ReadWritePaths=-{folder}"), ("contourd.tmpfiles", f"d {folder} 0755 contourd contourd")):
            with open(os.path.join(SOURCE, "systemd", name), encoding="utf-8") as file:
                self.assertIn(line, file.read().splitlines())

    def test_every_figure_is_in_the_guide_and_no_other(self):
        os.mkdir(self.path("metrics"))
        daemon = self.daemon(config=REALTIME, resin=ENDLESS).start()
        daemon.drop("gear.stl", binary_stl(cube(1)))
        daemon.wait_state("exposing")
        values = self.wait_for("contourd_layer", 1)
        with open(os.path.join(SOURCE, "docs", "connections.md"), encoding="utf-8") as file:
            told = set(re.findall(r"contourd_[a-z_]+", file.read()))
        self.assertEqual({name for name, _ in values}, told)


if __name__ == "__main__":
    main()
