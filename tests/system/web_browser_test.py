"""The printer's page in a real browser, with a real contourd behind it: login, a print, an upload, the keyboard, contrast."""

import base64
import json
import os
import signal

from browser import CHROMIUM, Browser
from camera_test import CameraService
from harness import CONTOURD_WEB, NIMBLE_RESIN, SLAB, Daemon, binary_stl, box, contents, realtime, run, skip_file, wait_until
from web_test import PASSWORD, WebTest
from web_test import Browser as Client

LONG = "a very long name of a part that somebody has exported again and again " * 2

# The least contrast between a shown text or placeholder and the background that it stands on (WCAG 2, 1.4.3), and that text.
LEAST_CONTRAST = """(() => {
  const parse = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
  const luminance = (rgb) => rgb.slice(0, 3).map((c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const paper = (element) => {
    for (; element; element = element.parentElement) {
      const colour = parse(getComputedStyle(element).backgroundColor);
      if (colour.length === 3) return colour;
    }
    return [255, 255, 255];
  };
  let least = [99, ""];
  for (const element of document.querySelectorAll("body *")) {
    const hint = element.placeholder && !element.value && !element.disabled;
    if (!element.checkVisibility() || !(hint || [...element.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))) continue;
    const style = getComputedStyle(element, hint ? "::placeholder" : null), back = paper(element);
    const ink = parse(style.color).slice(0, 3).map((c, i) => Number(style.opacity) * c + (1 - Number(style.opacity)) * back[i]);
    const both = [luminance(ink), luminance(back)].sort((a, b) => b - a);
    const contrast = (both[0] + 0.05) / (both[1] + 0.05);
    if (contrast < least[0]) least = [contrast, element.outerHTML.slice(0, 80)];
  }
  return least;
})()"""

# Buttons and inputs that are shown without a name for a screen reader, or too small for a finger (WCAG 2, 2.5.8: 24 px).
BAD_CONTROLS = """[...document.querySelectorAll("button, input, a, label.button")].filter((each) => each.checkVisibility()
  && !each.classList.contains("unseen") && !each.classList.contains("skip")).filter((each) => {
  const box = each.getBoundingClientRect();
  return box.width < 24 || box.height < 24 || !(each.textContent.trim() || each.getAttribute("aria-label") || (each.labels && each.labels.length));
}).map((each) => each.outerHTML)"""


class PageInABrowser(WebTest):
    """Screenshots are saved in the folder CONTOURD_SCREENSHOTS, if it is set."""

    def setUp(self):
        super().setUp()
        daemon = Daemon(self, realtime(wait_for_plate_cleared=True), {"exposure_ms": 120000, "bottom_exposure_ms": 120000}).start()
        self.serve(daemon)
        self.browser = Browser(self, "~NOTFOUND, EXCLUDE 127.0.0.1")
        self.url = f"http://127.0.0.1:{self.port}/"

    def wait(self, expression):
        return wait_until(lambda: self.browser.value(f"Boolean({expression})"), expression)

    def log_in(self, password=PASSWORD):
        self.wait("!document.getElementById('login').hidden")
        self.browser.value(f"document.getElementById('password').value = '{password}'; document.querySelector('#login-form button').click()")
        self.wait("!document.getElementById('page').hidden && document.body.classList.contains('known')")

    def text(self, name):
        return self.browser.value(f"document.getElementById('{name}').textContent")

    def look(self, name, width, scheme):
        """Checks what is shown, and saves a screenshot."""
        self.assertEqual(self.browser.value("document.documentElement.scrollWidth"), width, name)
        contrast, text = self.browser.value(LEAST_CONTRAST)
        self.assertGreaterEqual(contrast, 4.5, f"{name}, {scheme}: {text}")
        self.assertEqual(self.browser.value(BAD_CONTROLS), [], name)
        folder = os.environ.get("CONTOURD_SCREENSHOTS")
        if folder:
            self.browser.screenshot(os.path.join(folder, f"web-{name}-{width}-{scheme}.png"))

    def test_the_page_follows_a_print_on_a_phone_and_a_screen_light_and_dark(self):
        self.browser.open(self.url, 390, "light")
        self.wait("!document.getElementById('login').hidden")
        self.look("login", 390, "light")
        self.log_in()
        self.daemon.begin("part.stl", SLAB)
        self.daemon.drop(LONG[:120] + ".stl", SLAB)
        self.wait("document.getElementById('state').textContent == 'exposing' && document.querySelectorAll('#queue li').length == 1")
        self.wait("!document.getElementById('mask').hidden && document.getElementById('mask').naturalWidth > 0")
        self.assertEqual((self.text("printer"), self.text("job"), self.text("layer"), self.text("light-text")), ("Simulated printer", "part", "1 of 20", "light on"))
        self.assertEqual(self.text("announced"), "printing: part")
        for width in (390, 1280):
            for scheme in ("light", "dark"):
                self.browser.open(self.url, width, scheme)
                self.wait("document.getElementById('state').textContent == 'exposing' && document.querySelectorAll('#queue .more').length > 0")
                self.wait("!document.getElementById('mask').hidden && document.getElementById('mask').naturalWidth > 0")
                self.look("printing", width, scheme)
                self.assertEqual([url for url in self.browser.requests if not url.startswith(self.url)], [])
                self.assertEqual(self.browser.errors, [])
        # Cancelling asks first; "No" has the focus.
        self.browser.value("document.getElementById('cancel').click()")
        self.wait("document.getElementById('confirm').open")
        self.assertEqual(self.browser.value("document.activeElement.value"), "no")
        self.look("confirm", 1280, "dark")
        self.browser.value("document.activeElement.click()")
        self.assertEqual(self.daemon.status()["state"], "exposing")
        self.browser.value("document.getElementById('cancel').click()")
        self.wait("document.getElementById('confirm').open")
        self.browser.value("document.getElementById('yes').click()")
        self.daemon.wait_ended("part")
        self.wait("document.querySelectorAll('#history li').length == 1")
        self.assertIn("cancelled", self.text("history"))
        self.wait("!document.getElementById('cleared').hidden")
        self.browser.open(self.url, 390, "light")
        self.wait("document.querySelectorAll('#history li').length == 1 && !document.getElementById('cleared').hidden")
        self.look("ended", 390, "light")

    def test_a_dropped_file_is_uploaded_and_a_refused_one_is_told(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.browser.value("""(() => {
          const data = new DataTransfer();
          data.items.add(new File([new Uint8Array(684)], "empty part.stl"));
          data.items.add(new File(["PK"], "<img src=x onerror=alert(1)>.ctb"));
          document.getElementById("drop").dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));
        })()""")
        self.wait("document.querySelector('#uploads .error')")
        self.assertIn("such as an STL file", self.text("uploads"))
        self.assertEqual(self.browser.value("document.querySelectorAll('#uploads img').length"), 0)
        self.look("upload", 390, "light")
        # A file of zeros has no facet, and is refused by contourd.
        self.daemon.wait_ended("empty part")
        self.assertEqual(contents(os.path.join(self.daemon.spool, "failed", "empty part.stl")), bytes(684))
        self.wait("document.getElementById('history').textContent.includes('empty part')")

    def test_an_uploaded_model_shows_what_it_will_be_and_is_printed_as_the_user_wants(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        part = base64.b64encode(binary_stl([*box((0, 0, 0), (10, 5, 1)), *box((0, 0, 1), (2, 5, 8))])).decode()
        self.browser.value(f"""(() => {{
          const data = new DataTransfer();
          data.items.add(new File([Uint8Array.from(atob("{part}"), (c) => c.charCodeAt(0))], "bracket.stl"));
          document.getElementById("drop").dispatchEvent(new DragEvent("drop", {{dataTransfer: data, bubbles: true, cancelable: true}}));
        }})()""")
        self.wait("document.querySelector('#queue .preview') && !document.querySelector('#queue .preview').hidden")
        self.wait("document.querySelector('#queue .settings select')")
        self.assertEqual(self.daemon.status()["state"], "idle")
        self.assertIn("160 of 50 \u00b5m", self.browser.value("document.querySelector('#queue .panel').textContent"))
        self.assertIn("ml of standard", self.browser.value("document.querySelector('#queue .panel').textContent"))
        self.look("job", 390, "light")
        # The reason for a refusal stands in the form, and nothing changes.
        self.fill("Layer height", "2")
        self.submit()
        self.wait("document.querySelector('#queue .settings .error').textContent")
        self.assertIn("25", self.browser.value("document.querySelector('#queue .settings .error').textContent"))
        self.look("job-refused", 390, "dark")
        self.fill("Layer height", "100")
        self.fill("Orientation", "+y")
        self.fill("Copies", "2")
        self.fill("Hollow", "0.5")
        self.submit()
        self.wait("document.querySelector('#queue .panel').textContent.includes('50 of 100 \u00b5m')")
        self.wait("document.querySelector('#queue .preview') && !document.querySelector('#queue .preview').hidden")
        self.assertEqual(json.loads(self.daemon.read("incoming", "bracket.json")), {"confirm": True, "layer_height_um": 100, "up": {"y": 1}, "copies": 2, "hollow": {"wall_mm": 0.5}})
        for width in (390, 1280):
            for scheme in ("light", "dark"):
                self.browser.open(self.url, width, scheme)
                self.wait("document.querySelector('#queue button[aria-expanded]')")
                self.browser.value("document.querySelector('#queue button[aria-expanded]').click()")
                self.wait("document.querySelector('#queue .preview') && !document.querySelector('#queue .preview').hidden && document.querySelector('#queue .settings select')")
                self.look("waiting", width, scheme)
                self.assertEqual([url for url in self.browser.requests if not url.startswith(self.url)], [])
                self.assertEqual(self.browser.errors, [])
        self.browser.value("[...document.querySelectorAll('#queue button')].find((each) => each.textContent === 'Print').click()")
        self.wait("document.getElementById('state').textContent == 'exposing'")
        self.assertEqual(self.text("layer"), "1 of 50")

    def test_a_print_is_changed_beside_the_fields_that_refuse(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.daemon.begin("part.stl", SLAB, {"copies": 2})
        self.wait("!document.getElementById('change').hidden")
        self.browser.value("document.querySelector('#change summary').click()")
        self.wait("document.querySelectorAll('#copies li').length == 2")
        bounds = "[...document.querySelectorAll('#change-fields form')].map((form) => form.hidden ? '' : form.querySelector('p.more[id$=bounds]').textContent)"
        self.wait(f"({bounds})[0].startsWith('Now')")
        told = dict(zip(("exposure", "lift", "lift-speed", "rest", "speed", "light"), self.browser.value(bounds)))
        settings = {each["setting"]: each for each in self.daemon.rpc("settings")["result"]["settings"]}
        for setting in ("exposure", "lift", "lift-speed", "rest"):
            each = settings[setting]
            self.assertEqual(told[setting], f"Now {each['value']:.5g} {each['unit']}; {each['least']:.5g} to {each['most']:.5g} {each['unit']}.")
        # Nothing rises in this print.
        self.assertEqual((told["speed"], told["light"]), ("", ""))
        self.change("Lift in mm", "80")
        self.wait("document.querySelector('#change-fields .error:not(:empty)')")
        self.assertIn("lift 80 mm is not allowed", self.text("change-fields"))
        self.look("change-refused", 390, "light")
        self.change("Lift in mm", "2")
        self.wait("document.getElementById('change-fields').textContent.includes('2 applies from the next layer on')")
        self.wait(f"({bounds})[1].startsWith('Now 2 mm;')")
        self.change("Pause before layer", "9")
        self.wait("!document.getElementById('planned').hidden")
        self.assertIn("The print pauses before layer 9.", self.text("planned"))
        self.browser.value("document.querySelector('#copies button').click()")
        self.wait("document.getElementById('confirm').open")
        self.browser.value("document.getElementById('yes').click()")
        self.wait("document.getElementById('copies').textContent.includes('left out from layer 2')")
        self.assertEqual(self.daemon.status()["job"]["excluded"], ["part (copy 1)"])
        for width, scheme in ((390, "dark"), (1280, "light")):
            self.browser.open(self.url, width, scheme)
            self.wait("document.getElementById('state').textContent == 'exposing' && !document.getElementById('change').hidden")
            self.browser.value("document.querySelector('#change summary').click()")
            self.wait("document.querySelectorAll('#copies li').length == 2")
            self.look("change", width, scheme)
        self.browser.value("document.getElementById('no-pause').click()")
        self.wait("document.getElementById('planned').hidden")
        self.assertIsNone(self.daemon.status()["job"]["planned_pause"])

    def change(self, label, value):
        self.fill(label, value)
        self.browser.value(f"""[...document.querySelectorAll("#change-fields button")].find((each) => each.getAttribute("aria-label").includes("{label}")).click()""")

    def test_the_vat_the_wear_the_resins_and_a_report_are_shown(self):
        self.daemon.write_resin("bad", {"layer_height_um": 4000})
        self.daemon.write_resin("grey", {"calibrations": [{"kind": "exposure", "date": "2026-11-20", "values": [{"key": "/exposure_ms", "before": 2500, "after": 3000, "uncertainty": 40}]}]})
        self.daemon.begin("part.stl", SLAB)
        self.daemon.cancel("part")
        for width, scheme in ((390, "light"), (1280, "dark")):
            self.browser.open(self.url, width, scheme)
            if width == 390:
                self.log_in()
            self.wait("document.querySelectorAll('#history a').length == 1")
            self.browser.value("document.querySelector('#care summary').click()")
            self.wait("document.querySelectorAll('#resins details').length == 3 && document.querySelectorAll('#parts li').length == 3")
            self.browser.value("for (const each of document.querySelectorAll('#resins details')) each.open = true")
            self.look("care", width, scheme)
        self.assertEqual(self.browser.errors, [])
        self.assertIn("exposure ms: 2500 \u2192 3000 \u00b1 40", self.text("resins"))
        self.fill("Resin in the vat now", "150")
        self.browser.value("document.querySelector('#vat-form button').click()")
        self.wait("document.getElementById('vat').textContent.includes('150 ml')")
        self.browser.value("document.querySelectorAll('#parts button')[1].click()")
        self.wait("document.getElementById('confirm').open")
        self.browser.value("document.getElementById('yes').click()")
        self.wait("document.querySelectorAll('#parts li')[1].textContent.includes('new since')")
        self.browser.open(self.url + "api/report?job=part", 390, "light")
        self.assertIn("part", self.browser.value("document.body.textContent"))
        self.assertEqual(self.browser.value("document.documentElement.scrollWidth"), 390)
        self.assertEqual(self.browser.errors, [])

    def test_a_model_in_doubt_of_its_unit_waits_for_the_unit_and_then_for_a_word(self):
        self.daemon.drop("tiny.stl", binary_stl(box((0, 0, 0), (1.2, 0.8, 0.2))))
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.wait("document.getElementById('queue').textContent.includes('in inches')")
        self.assertNotIn("contourctl", self.text("queue"))
        self.assertIn("Print anyway", self.text("queue"))
        self.browser.value("document.querySelector('#queue button[aria-expanded]').click()")
        self.wait("document.querySelector('#queue .settings select')")
        self.look("unit", 390, "light")
        self.fill("Unit of the file", "inch")
        self.submit()
        self.wait("document.querySelector('#queue .panel').textContent.includes('5.08 mm')")
        self.wait("document.querySelector('#queue .row button').textContent === 'Print'")
        self.assertEqual(json.loads(self.daemon.read("incoming", "tiny.json")), {"unit": "inch", "confirm": True})
        self.browser.value("document.querySelector('#queue .row button').click()")
        self.wait("document.getElementById('state').textContent == 'exposing'")

    def test_the_pictures_of_the_camera_stand_beside_the_mask_and_in_the_history(self):
        self.browser.open(self.url, 390, "light")
        picture = self.browser.value("(() => { const c = document.createElement('canvas'); c.getContext('2d').fillRect(0, 0, 300, 150); return c.toDataURL('image/jpeg'); })()")
        self.write("picture.jpg", base64.b64decode(picture.partition(",")[2]))
        commands = (("snapshot", f"cp {self.path('picture.jpg')} $CONTOURD_FILE"), ("time-lapse", r"printf '\000\000\000\020ftypisom' >$CONTOURD_FILE"))
        for name, body in commands:
            os.chmod(self.write(f"camera-{name}", f"#!/bin/sh\n{body}\n"), 0o755)
        CameraService(self, self.path("camera.socket"), self.path("camera"))
        self.web.kill()
        self.web.wait()
        self.daemon.stop()
        daemon = Daemon(self, realtime(camera={"socket": "camera.socket", "every_layers": 1}), {**NIMBLE_RESIN, "exposure_ms": 500, "bottom_exposure_ms": 500}).start()
        run(CONTOURD_WEB, "--set-password", "--role", "watch", *self.files(), input=b"only watch\n" * 2)
        self.serve(daemon)
        self.url = f"http://127.0.0.1:{self.port}/"
        self.browser.open(self.url, 390, "light")
        self.log_in("only watch")
        self.daemon.drop("part.stl", SLAB)
        self.wait("!document.getElementById('picture').hidden && document.getElementById('picture').naturalWidth == 300")
        self.assertRegex(self.browser.value("document.getElementById('picture').alt"), r"Picture after layer \d+")
        self.look("camera", 390, "light")
        self.daemon.wait_done("part")
        wait_until(lambda: self.daemon.has("done", "part.pictures", "time-lapse.mp4"), "the time lapse")
        self.wait("document.querySelectorAll('#history li').length == 1")
        self.assertFalse(self.browser.value("document.getElementById('picture').checkVisibility()"))
        self.browser.value("document.querySelector('#history li button').click()")
        self.wait("document.querySelector('.shots img') && document.querySelector('.shots img').naturalWidth == 300")
        self.assertEqual(self.browser.value("new URL(document.querySelector('.shots video').src).search"), "?job=part")
        self.assertEqual(self.browser.value("document.querySelector('.shots img').alt"), "After layer 20")
        self.browser.value("(() => { const slider = document.querySelector('.shots input'); slider.value = 0; slider.dispatchEvent(new Event('change')); })()")
        self.wait("/After layer [1-5]$/.test(document.querySelector('.shots img').alt)")
        self.look("camera-history", 390, "light")
        self.browser.value("document.querySelector('#history li button').click()")
        self.assertFalse(self.browser.value("Boolean(document.querySelector('.shots'))"))

    def test_who_may_print_can_turn_off_a_light_that_was_turned_on_by_hand(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.assertFalse(self.browser.value("document.getElementById('dark-hand').checkVisibility()"))
        client = self.daemon.client()
        self.assertIn("result", client.call("light_on", seconds=5, in_resin=True))
        self.wait("document.getElementById('dark-hand').checkVisibility()")
        self.look("by-hand", 390, "light")
        self.browser.value("document.getElementById('dark-hand').click()")
        wait_until(lambda: self.daemon.status()["manual"]["dark"], "the dark")
        self.wait("!document.getElementById('dark-hand').checkVisibility()")
        client.close()

    def test_each_role_sees_what_it_may_do(self):
        for role in ("watch", "service"):
            run(CONTOURD_WEB, "--set-password", "--role", role, *self.files(), input=f"only {role}\n".encode() * 2)
        self.web.kill()
        self.web.wait()
        self.start_web()
        self.daemon.begin("part.stl", SLAB)
        self.daemon.drop("next.stl", SLAB)
        shown = "(name) => document.getElementById(name).checkVisibility()"
        for role, width, scheme in (("watch", 390, "light"), ("service", 1280, "dark")):
            self.browser.open(self.url, width, scheme)
            self.log_in(f"only {role}")
            self.wait("document.querySelectorAll('#queue .row button').length > 0")
            self.wait(f"document.body.dataset.role == '{role}'")
            serves = role == "service"
            for name in ("pause", "cancel", "change", "ask-first"):
                self.assertEqual(self.browser.value(f"({shown})('{name}')"), serves, (role, name))
            self.assertEqual(self.browser.value(f"({shown})('service')"), serves)
            self.assertEqual(self.browser.value("[...document.querySelectorAll('#queue .row button')].filter((each) => each.checkVisibility()).length"), 2 if serves else 1)
            self.browser.value("document.querySelector('#queue button[aria-expanded]').click()")
            self.wait("document.querySelector('#queue .preview') && !document.querySelector('#queue .preview').hidden")
            if serves:
                self.browser.value("document.querySelector('#service summary').click()")
                self.browser.value("document.getElementById('look').click()")
                self.wait("document.querySelectorAll('#inputs li').length > 0 || document.getElementById('service-error').textContent")
                self.browser.value("document.getElementById('show-log').click()")
                self.wait("document.getElementById('log').textContent.includes('part')")
                self.browser.value("const make = URL.createObjectURL; URL.createObjectURL = (blob) => { blob.text().then((text) => { window.saved = text; }); return make.call(URL, blob); }")
                self.browser.value("document.getElementById('diagnose').click()")
                self.wait("window.saved")
                saved = json.loads(self.browser.value("window.saved"))
                self.assertEqual(saved["status"]["state"], "exposing")
                self.assertEqual([each for each in saved if "refused" in saved[each]], ["inputs"])  # which are not read in a print
                self.browser.value("document.getElementById('home').click()")
                self.wait("document.getElementById('confirm').open")
                self.browser.value("document.getElementById('yes').click()")
                self.wait("document.getElementById('service-error').textContent")
            self.look(f"role-{role}", width, scheme)
            self.browser.value("document.getElementById('logout').click()")
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def fill(self, label, value):
        self.browser.value(f"""(() => {{
          const input = document.getElementById([...document.querySelectorAll("label")].find((each) => each.textContent.startsWith("{label}")).htmlFor);
          input.value = "{value}";
          input.dispatchEvent(new Event("change", {{bubbles: true}}));
        }})()""")

    def submit(self):
        self.browser.value("document.querySelector('#queue .settings button').click()")

    def test_the_page_can_be_used_by_keyboard(self):
        self.browser.open(self.url, 1280, "light")
        self.wait("document.activeElement.id == 'password'")
        self.browser.call("Input.insertText", text=PASSWORD)
        self.press("Enter")
        self.wait("!document.getElementById('page').hidden && document.activeElement.id == 'printer'")
        self.daemon.begin("part.stl", SLAB)
        self.wait("!document.getElementById('cancel').hidden")
        seen = []
        for _ in range(12):
            self.press("Tab")
            seen.append(self.browser.value("document.activeElement.id || document.activeElement.textContent"))
            # Where the focus is can be seen.
            self.assertNotEqual(self.browser.value("""(() => { const e = document.activeElement;
              const shown = e.id === "files" ? document.querySelector("label.button") : e;
              return e === document.body || e.className === "skip" ? "body" : getComputedStyle(shown).outlineStyle; })()"""), "none", seen[-1])
        self.assert_words(seen, "logout", "pause", "cancel", "files")

    def click(self, selector):
        """Presses a button as the keyboard does: it has the focus before."""
        self.browser.value(f"document.querySelector({json.dumps(selector)}).focus(); document.querySelector({json.dumps(selector)}).click()")

    def test_the_focus_stays_where_the_user_is(self):
        self.browser.open(self.url, 1280, "light")
        self.log_in()
        self.daemon.begin("part.stl", SLAB)
        for name in ("first", "second"):
            self.daemon.drop(f"{name}.stl", SLAB)
            self.daemon.wait_job(name, "ready")
        self.wait("document.querySelector('[aria-label=\"Move second up\"]')")
        self.click('[aria-label="Move second up"]')
        self.wait("document.querySelector('#queue li .name').textContent == 'second'")
        self.assertEqual(self.browser.value("document.activeElement.getAttribute('aria-label')"), "Details of second")
        self.click('[aria-label="Details of second"]')
        self.wait("document.querySelector('#queue .settings button')")
        self.browser.value("window.former = document.querySelector('#queue .settings button')")
        self.click("#queue .settings button")
        self.wait("document.querySelector('#queue .settings button') != window.former")
        self.assertEqual(self.browser.value("document.activeElement.textContent"), "Apply")
        self.click("#pause")
        self.wait("document.activeElement.id == 'resume'")
        self.click("#resume")
        self.wait("document.activeElement.id == 'pause'")
        self.daemon.rpc("pause", at_layer=9)
        self.browser.value("document.querySelector('#change summary').click()")
        self.wait("document.getElementById('no-pause').checkVisibility()")
        self.click("#no-pause")
        self.wait("document.getElementById('planned').hidden")
        self.assertEqual(self.browser.value("document.activeElement.textContent"), "Change this print")
        self.click('[aria-label="Remove first"]')
        self.wait("document.getElementById('confirm').open")
        self.browser.value("document.getElementById('yes').click()")
        self.wait("document.querySelectorAll('#queue li').length == 1")
        self.assertEqual(self.browser.value("document.activeElement.getAttribute('aria-label')"), "Details of second")

    def assert_unknown(self):
        """Requires that the page neither claims a state nor offers what depends on it."""
        self.assertEqual((self.text("state"), self.text("light-text")), ("unknown", "light unknown"))
        names = ("pause", "resume", "cancel", "cleared", "by-hand", "change", "printing", "queue", "queue-empty", "history-empty", "notices")
        self.assertEqual([name for name in names if self.browser.value(f"document.getElementById('{name}').checkVisibility()")], [])
        self.assertTrue(self.browser.value("document.getElementById('connection').checkVisibility()"))

    def test_without_a_status_the_page_claims_nothing_and_offers_no_button_for_a_print(self):
        self.daemon.stop()
        self.browser.open(self.url, 390, "light")
        self.wait("!document.getElementById('login').hidden")
        self.browser.value(f"document.getElementById('password').value = '{PASSWORD}'; document.querySelector('#login-form button').click()")
        self.wait("document.getElementById('connection').checkVisibility()")
        self.assertTrue(self.text("connection").startswith("cannot reach contourd"), self.text("connection"))
        self.assert_unknown()
        self.look("unknown", 390, "light")
        self.daemon.start()
        self.wait("document.getElementById('state').textContent == 'idle'")
        self.wait("document.getElementById('queue-empty').checkVisibility()")
        self.daemon.begin("part.stl", SLAB)
        self.wait("document.getElementById('light-text').textContent == 'light on'")
        self.daemon.kill()
        self.wait("document.getElementById('connection').checkVisibility()")
        self.assert_unknown()

    def test_a_page_too_many_says_why_and_a_hidden_page_takes_no_connection(self):
        client = Client(self.port)
        self.assertEqual(client.log_in()[0], 204)
        ask = lambda: self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {client.cookie}\r\n\r\n".encode())
        hide = "Object.defineProperty(document, 'hidden', {get: () => %s, configurable: true}); document.dispatchEvent(new Event('visibilitychange'))"
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.browser.value(hide % "true")
        pages = []
        def fills():
            # The sixteenth is answered once the hidden page is gone.
            pages.append(ask())
            if b" 200 " not in pages[-1].recv(65536).split(b"\r\n")[0]:
                pages.pop().close()
            return len(pages) == 16
        wait_until(fills, "sixteen other pages")
        self.browser.value(hide % "false")
        self.wait("document.getElementById('connection').textContent.startsWith('16 pages of this printer are open')")
        self.assert_unknown()
        for each in pages:
            each.close()
        self.wait("document.getElementById('state').textContent == 'idle' && !document.getElementById('connection').checkVisibility()")

    def test_a_server_that_is_silent_is_noticed(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.addCleanup(self.web.send_signal, signal.SIGCONT)
        self.web.send_signal(signal.SIGSTOP)
        self.wait("document.getElementById('connection').checkVisibility()")
        self.assert_unknown()
        self.web.send_signal(signal.SIGCONT)
        self.wait("document.getElementById('state').textContent == 'idle'")

    def test_an_upload_after_the_end_of_the_session_waits_for_the_login(self):
        self.browser.open(self.url, 390, "light")
        self.log_in()
        part = base64.b64encode(SLAB).decode()
        self.browser.value(f"""fetch("/api/logout", {{method: "POST"}}).then(() => {{
          const data = new DataTransfer();
          data.items.add(new File([Uint8Array.from(atob("{part}"), (c) => c.charCodeAt(0))], "late.stl"));
          document.getElementById("drop").dispatchEvent(new DragEvent("drop", {{dataTransfer: data, bubbles: true, cancelable: true}}));
        }})""")
        self.wait("!document.getElementById('login').hidden")
        self.assertNotIn("POST", self.text("uploads"))
        self.log_in()
        self.daemon.wait_job("late")

    def test_a_page_that_is_opened_between_two_exposures_says_when_the_mask_comes(self):
        self.daemon.stop()
        self.web.kill()
        self.web.wait()
        self.serve(Daemon(self, realtime(), {**NIMBLE_RESIN, "exposure_ms": 1000, "bottom_exposure_ms": 1000}).start())
        self.url = f"http://127.0.0.1:{self.port}/"
        self.daemon.begin("part.stl", SLAB)
        self.daemon.rpc("pause")
        wait_until(lambda: self.daemon.status()["state"] == "paused", "the pause")
        self.browser.open(self.url, 390, "light")
        self.log_in()
        self.wait("document.getElementById('mask-told').checkVisibility()")
        self.assertEqual(self.text("announced"), "paused: part")
        self.look("paused", 390, "dark")
        self.browser.value("document.getElementById('resume').click()")
        self.wait("document.getElementById('mask').checkVisibility() && !document.getElementById('mask-told').checkVisibility()")

    def press(self, key):
        code = {"Enter": 13, "Tab": 9}[key]
        for kind in ("keyDown", "keyUp"):
            text = {"text": "\r"} if key == "Enter" and kind == "keyDown" else {}
            self.browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **text)


if not CHROMIUM:
    skip_file("chromium is not installed")
