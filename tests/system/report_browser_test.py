"""The report page in a real browser: no errors, no requests to other hosts, and nothing wider than the screen."""

import base64
import os
import re
import shutil

from browser import CHROMIUM, Browser
from harness import FLOATING, Daemon, FolderTest, skip_file, text_of

HOSTILE = 'a & b "quoted" <b>bold <script>alert(1)<img src=x onerror=y>'


# The least contrast between a text of the page and its background (WCAG 2, 1.4.3), and the element with that text.
LEAST_CONTRAST = """(() => {
  const parse = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
  const luminance = (rgb) => rgb.map((c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const paper = parse(getComputedStyle(document.body).backgroundColor);
  let least = [99, ""];
  for (const element of document.querySelectorAll("h1, h2, th, td, li, a, p, figcaption, .outcome, svg text")) {
    const style = getComputedStyle(element);
    const colour = parse(element.closest("svg") ? style.fill : style.color);
    const alpha = Number(style.opacity);
    const seen = colour.slice(0, 3).map((c, i) => c * alpha + paper[i] * (1 - alpha));
    const both = [luminance(seen), luminance(paper)].sort((a, b) => b - a);
    const contrast = (both[0] + 0.05) / (both[1] + 0.05);
    if (contrast < least[0]) least = [contrast, element.outerHTML.slice(0, 80)];
  }
  return least;
})()"""


# Texts in pictures that are cut off at the picture's edge.
CUT_OFF = """[...document.querySelectorAll("svg text")].filter((text) => {
  const box = text.getBBox(), all = text.ownerSVGElement.viewBox.baseVal;
  return box.x < 0 || box.y < 0 || box.x + box.width > all.width || box.y + box.height > all.height;
}).map((text) => text.textContent)"""


class InABrowser(FolderTest):
    """Screenshots are saved in the folder CONTOURD_SCREENSHOTS, if it is set."""

    def test_the_page_is_shown_without_an_error_or_a_request_on_a_phone_and_a_screen_light_and_dark(self):
        daemon = Daemon(self).start()
        daemon.printed(HOSTILE + ".stl", FLOATING)
        path = self.path("page.html")
        shutil.copy(daemon.file("done", HOSTILE + ".report.html"), path)
        daemon.stop()
        # The labels of the last plots differ from print to print; none is wider than 0.0125.
        before, plots = text_of(path).split("<h2>Time from height to mask", 1)
        plots = re.sub(r'(text-anchor="end">)[^<]*', r"\g<1>0.0125", plots)
        self.write("page.html", before + "<h2>Time from height to mask" + plots)
        browser = Browser(self)
        for width in (390, 1280):
            for scheme in ("light", "dark"):
                with self.subTest(width=width, scheme=scheme):
                    browser.open(path, width, scheme)
                    self.assertEqual(browser.value("document.documentElement.scrollWidth"), width)
                    self.assertEqual(browser.value("[...document.images].filter((i) => !i.complete || !i.naturalWidth).length"), 0)
                    self.assertEqual(browser.value("document.images.length"), 13)
                    self.assertEqual(browser.value(CUT_OFF), [])
                    contrast, of = browser.value(LEAST_CONTRAST)
                    self.assertGreaterEqual(contrast, 4.5, of)
                    if folder := os.environ.get("CONTOURD_SCREENSHOTS"):
                        browser.screenshot(os.path.join(folder, f"report-{width}-{scheme}.png"))
                    self.assertEqual(browser.errors, [])
                    self.assertEqual([url for url in browser.requests if not url.startswith("data:")], ["file://" + path])
        # A link leads to the picture of its layer.
        browser.value("document.querySelector('a[href=\"#layer-41\"]').click()")
        self.assertEqual(browser.value("document.querySelector(':target').id"), "layer-41")
        printed = base64.b64decode(browser.call("Page.printToPDF")["data"])
        if folder := os.environ.get("CONTOURD_SCREENSHOTS"):
            self.write(os.path.join(folder, "report.pdf"), printed)
        self.assertLessEqual(len(re.findall(rb"/Type\s*/Page\b", printed)), 6)

    def test_a_page_with_requests_or_errors_is_detected(self):
        """Checks that the test above can detect such a page."""
        browser = Browser(self)
        browser.open(self.write("asks.html", '<img src="http://192.0.2.1/x.png">').decode(), 390, "light")
        self.assertIn("http://192.0.2.1/x.png", browser.requests)
        self.assertNotEqual(browser.errors, [])
        browser.open(self.write("fails.html", "<script>throw 1</script>").decode(), 390, "light")
        self.assertNotEqual(browser.errors, [])
        policy = "<meta http-equiv=Content-Security-Policy content=\"default-src 'none'\">"
        browser.open(self.write("held.html", policy + "<script>throw 1</script>").decode(), 390, "light")
        self.assertIn("Content Security Policy", browser.errors[0])
        cut = "<svg viewBox='0 0 9 9'><text y='8'>far too long</text></svg>"
        browser.open(self.write("cut.html", cut).decode(), 390, "light")
        self.assertEqual(browser.value(CUT_OFF), ["far too long"])
        browser.open(self.write("wide.html", "<div style='width: 500px'>x</div>").decode(), 390, "light")
        self.assertGreater(browser.value("document.documentElement.scrollWidth"), 390)


if CHROMIUM is None:
    skip_file("chromium, Debian's package, is not installed")
