"""The report page of a print: well-formed, self-contained, within its size limit, and with a picture for each of its links."""

import base64
import html
import html.parser
import re

from harness import ENDLESS, FLOATING, NIMBLE_RESIN, REALTIME, Daemon, FolderTest, binary_stl, box, read_png, wedge

LARGEST_PAGE = 3_000_000  # docs/printing.md
HOSTILE = 'a & b "quoted" <b>bold <script>alert(1)<img src=x onerror=y>'


class Page(html.parser.HTMLParser):
    """Parses a page, and collects its tags, ids, references, pictures and text."""

    VOID = {"meta", "img", "br", "link", "input", "hr"}

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.references, self.tags, self.ids, self.images, self.text = [], [], [], [], {}, ""
        self.figure, self.meta = None, {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        values = dict(attributes)
        assert len(values) == len(attributes), f"<{tag}> has an attribute twice"
        self.references += [value for name, value in attributes if name in ("src", "href", "srcset", "data", "action")]
        self.ids += [values["id"]] if "id" in values else []
        if tag == "figure":
            self.figure = values.get("id")  # the preview's figure has no id
        if tag == "img":
            assert values["alt"], "a picture without an alternative text"
            self.images[self.figure] = values["src"]
        if "http-equiv" in values:
            self.meta[values["http-equiv"]] = values["content"]
        if tag == "svg":
            assert values["role"] == "img" and values["aria-label"], attributes
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open}"
        self.open.pop()

    def handle_data(self, data):
        self.text += data


class PageTest(FolderTest):
    def daemon(self, config=None, resin=None, masks=False):
        return Daemon(self, config, resin, masks).start()

    def page_of(self, daemon, folder, name):
        """Returns the page of a job that ended, after checks that every page must pass."""
        text = daemon.read(folder, name + ".report.html")
        self.assertLess(len(text.encode()), LARGEST_PAGE)
        self.assertIsNone(re.search(r"(?i)https?:|url\(|@import|<script", text))
        self.assertIsNone(re.search(r"\b(nan|inf)\b", text))  # numbers that browsers do not draw
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(page.meta["Content-Security-Policy"],
                         "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'")
        self.assertEqual(len(page.ids), len(set(page.ids)))
        for reference in page.references:
            if reference.startswith("#"):
                self.assertIn(reference[1:], page.ids)
            else:
                self.assertTrue(reference.startswith("data:image/png;base64,"), reference[:60])
        return page

    def picture(self, page, figure):
        path = self.write("picture.png", base64.b64decode(page.images[figure].split(",", 1)[1], validate=True))
        return read_png(path)


class OnTheDisk(PageTest):
    def test_the_page_is_self_contained_and_well_formed_whatever_the_job_s_name(self):
        daemon = self.daemon()
        daemon.printed(HOSTILE + ".stl", binary_stl(wedge(20, 10, 10)))
        page = self.page_of(daemon, "done", HOSTILE)
        daemon.stop()
        self.assertEqual(page.tags.count("svg"), 5)  # time, light, three plots
        self.assertNotIn("b", page.tags)
        self.assertIn(HOSTILE, page.text)
        self.assert_words(page.text, "done", "Simulated printer", "standard", "200 of 200", "mask", "loops", "Resin used", "exposing")
        preview = self.picture(page, None)
        self.assertGreaterEqual(len(preview.values()), 3)  # black, and two faces in different light
        self.assertEqual(preview, read_png(daemon.file("done", HOSTILE + ".preview.png")))

    def test_a_warning_links_to_the_mask_that_was_shown_at_its_layer(self):
        daemon = self.daemon(masks=True)
        report = daemon.printed("part.stl", FLOATING)
        text = daemon.read("done", "part.report.html")
        page = self.page_of(daemon, "done", "part")
        daemon.stop()
        for warning in report["analysis"]["warnings"]:
            self.assertIn(warning, html.unescape(text))
        self.assertIn("#layer-41", page.references)  # where the island begins
        self.assertIn("#layer-21", page.references)  # the first empty layer
        figures = [name for name in page.images if name]
        self.assertEqual(len(figures), 12)
        for figure in figures:
            number = int(figure.removeprefix("layer-"))
            shown = read_png(self.path("masks", "part", f"{number:04}.png"))
            small = self.picture(page, figure)
            # A part of 200 pixels is cut out without being reduced.
            lit = [row.strip(b"\0") for row in shown.rows if row.strip(b"\0")]
            self.assertEqual([row.strip(b"\0") for row in small.rows if row.strip(b"\0")], lit, figure)
        self.assertIsNone(self.picture(page, "layer-21").lit_box())

    def test_the_page_shows_the_time_in_each_state_and_each_pause(self):
        # The first exposure is long enough to pause during it.
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, "bottom_exposure_ms": 2000})
        daemon.begin("part.stl", FLOATING)
        daemon.rpc("pause")
        daemon.wait_state("paused")
        daemon.rpc("resume")
        report = daemon.wait_done("part")
        page = self.page_of(daemon, "done", "part")
        daemon.stop()
        (pause,) = report["pauses"]
        self.assertEqual(report["pause_count"], 1)
        self.assertEqual(pause["layer"], 1)
        self.assertGreater(pause["lasted_s"], 0)
        self.assertAlmostEqual(report["states_s"]["paused"], pause["lasted_s"], delta=1e-6)
        # Every moment belongs to one state.
        self.assertAlmostEqual(sum(report["states_s"].values()), report["print_time_s"], delta=1e-6)
        self.assertIn(f"layer {pause['layer']}: stopped for", page.text)
        self.assertIn("paused", page.text)

    def test_a_print_that_is_cancelled_in_its_first_layer_has_a_page(self):
        daemon = self.daemon(REALTIME, {**NIMBLE_RESIN, **ENDLESS})
        daemon.begin("part.stl", FLOATING)
        self.assertEqual(daemon.cancel("part")["outcome"], "cancelled")
        page = self.page_of(daemon, "failed", "part")
        daemon.stop()
        self.assertIn("cancelled", page.text)
        self.assertIn("0 of 60 exposed", page.text)

    def test_a_plate_of_many_copies_shows_all_copies_in_every_picture(self):
        daemon = self.daemon()
        daemon.printed("many.stl", binary_stl(box((0, 0, 0), (1, 1, 0.5))), {"copies": 100, "unit": "mm"})
        page = self.page_of(daemon, "done", "many")
        daemon.stop()
        lit = self.picture(page, "layer-1")
        # Counts upper left corners of boxes; no box touches another box or the edge.
        corners = sum(row[x] > 0 == row[x - 1] == above[x] for above, row in zip(lit.rows, lit.rows[1:])
                      for x in range(1, lit.width))  # fmt: skip
        self.assertEqual(corners, 100)

    def test_a_job_that_is_refused_has_a_reason_and_no_page(self):
        daemon = self.daemon()
        daemon.refused("bad.stl", b"no model")
        self.assertFalse(daemon.has("failed", "bad.report.html"))
