"""The interfaces of other print hosts in contourd-web: each held to the requests that its clients send, read by the clients' rules."""

import contextlib
import http.client
import json
import os
import re
import socket
import time

from harness import CONTOURD_WEB, DEADLINE_S, ENDLESS, SANITIZED, SMALL, Daemon, binary_stl, box, contents, realtime, run, wait_until
from sliced import nanodlp, pictures, sl1
from web_test import Browser, WebTest, free_port

BOUNDARY = "b5f7cf3ff4e8c1b1-9a6c2f5b7d0c"
UNLISTED = "127.0.0.9"


def form(*parts):
    """Returns a form of parts (key, file's name or None, content), as reqwest and Dart write it."""
    body = b""
    for key, file, content in parts:
        name = f'; filename="{file}"\r\nContent-Type: application/octet-stream' if file is not None else ""
        body += f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{key}"{name}\r\n\r\n'.encode()
        body += (content if isinstance(content, bytes) else content.encode()) + b"\r\n"
    return body + f"--{BOUNDARY}--\r\n".encode()


class HostTest(WebTest):
    KEY = None  # of web.json

    def serve_host(self, daemon=None, clients=("127.0.0.1", "127.0.0.2"), **config):
        self.host_port = free_port()
        self.options = ("--listen", f"127.0.0.1:{self.host_port}")
        return self.serve(daemon, **{self.KEY: {"port": self.host_port, "clients": list(clients)}}, **config)

    def answers(self):
        # The service listens on the page's port first.
        return super().answers() and all(self.is_open(int(address.split(":")[1])) for address in self.options[1::2])

    def is_open(self, port):
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    def ask(self, method, path, body=None, source="127.0.0.1", **headers):
        """Returns the status, the headers and the body; follows no redirection, as DragonFruit."""
        connection = http.client.HTTPConnection("127.0.0.1", self.host_port, timeout=DEADLINE_S, source_address=(source, 0))
        try:
            connection.request(method, path, body, headers)
            reply = connection.getresponse()
            return reply.status, reply.headers, reply.read()
        finally:
            connection.close()

    def get(self, path, status=200):
        got, headers, body = self.ask("GET", path)
        self.assertEqual(got, status, (path, body))
        return json.loads(body) if headers.get_content_type() == "application/json" else body.decode()

    def send(self, path, *parts, **headers):
        return self.ask("POST", path, form(*parts), **{"Content-Type": f"multipart/form-data; boundary={BOUNDARY}", **headers})

    def layers(self, count=3):
        display = self.daemon.config["display"]
        return pictures(count, display["width_px"], display["height_px"])

    def printing_slowly(self):
        """Starts a daemon whose prints stay in their first exposure."""
        return Daemon(self, realtime(), ENDLESS).start()

    def refused(self, method, path, status, *words, body=None, **headers):
        got, _, sentence = self.ask(method, path, body, **headers)
        self.assertEqual(got, status, (path, sentence))
        self.assert_one_line(sentence, *(word.encode() for word in words))


class StrangersTest(HostTest):
    KEY = "nanodlp"

    def test_only_listed_addresses_may_ask(self):
        self.serve_host()
        self.refused("GET", "/status", 403, UNLISTED, "web.json", source=UNLISTED)
        self.refused("GET", "/printer/stop", 403, UNLISTED, source=UNLISTED)
        status, _, _ = self.ask("POST", "/plate/add", form(("ZipFile", "a.stl", SMALL)), source=UNLISTED)
        self.assertEqual((status, self.incoming()), (403, []))
        self.assertEqual(self.ask("GET", "/status", source="127.0.0.2")[0], 200)

    def test_two_hundred_silent_clients_keep_no_one_out(self):
        browser = self.serve_host()
        for source in (UNLISTED, "127.0.0.2"):
            with self.subTest(source=source):
                silent = [socket.create_connection(("127.0.0.1", self.host_port), DEADLINE_S, (source, 0)) for _ in range(200)]
                for each in silent:
                    self.addCleanup(each.close)
                    with contextlib.suppress(OSError):  # contourd-web has closed the connection
                        each.sendall(b"GET /status HTTP/1.1\r\n")
                self.assertEqual(self.ask("GET", "/status")[0], 200)
                self.assertEqual(browser.log_in()[0], 204)
                self.assertLess(len(os.listdir(f"/proc/{self.web.pid}/fd")), 160)

    def test_a_browser_on_a_listed_address_may_not_ask(self):
        self.serve_host(self.printing_slowly())
        self.daemon.begin("part.stl", SMALL)
        for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": f"http://127.0.0.1:{self.host_port}"},
                        {"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "none"}, {"Referer": "http://evil.example/"}, {"Accept-Language": "en"},
                        {"User-Agent": "Mozilla/5.0 (X11; Linux x86_64) Gecko/20100101 Firefox/128.0"}):  # fmt: skip
            with self.subTest(headers=headers):
                self.refused("GET", "/printer/stop", 403, "browser", **headers)
        self.refused("GET", "/printer/stop", 403, "evil.example", "names", **{"Host": "evil.example"})
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def test_the_ports_are_off_without_clients_and_the_page_has_none_of_their_paths(self):
        browser = self.logged_in()
        for path in ("/status", "/printer/stop", "/plates/list/json", "/files"):
            self.assertEqual(browser.get(path)[0], 404)
        # A port that no interface has is one of the page, which asks for the password.
        self.options = ("--listen", f"127.0.0.1:{free_port()}")
        self.write("web.json", json.dumps({"control_socket": "control.sock", "nanodlp": {"port": 12345, "clients": ["127.0.0.1"]}}))
        self.web.terminate()
        self.web.wait(DEADLINE_S)
        self.start_web()
        self.assertEqual(Browser(int(self.options[1].split(":")[1])).get("/api/status")[0], 401)
        wait_until(lambda: b"nothing listens" in contents(self.path("web.log")), "the sentence in the log")

    def test_a_page_that_has_lost_all_its_addresses_is_reported(self):
        self.serve_host()
        self.web.terminate()
        self.web.wait(DEADLINE_S)
        self.options, self.port = (), self.host_port
        self.start_web()
        wait_until(lambda: b"the page has no address" in contents(self.path("web.log")), "the sentence in the log")

    def test_only_the_addresses_of_the_page_are_announced(self):
        config = self.write("web.json", json.dumps({"nanodlp": {"port": 80, "clients": ["192.0.2.9"]}, "odyssey": {"clients": ["192.0.2.9"]}}))
        self.set_password()
        addresses = [word for each in ("192.0.2.1:8080", "192.0.2.1:80", "192.0.2.1:12357") for word in ("--address", each)]
        run(CONTOURD_WEB, "--set-addresses", *addresses, "--config", config, *self.files(), expect=0)
        announced = contents(self.path("avahi", "contourd.service"))
        self.assertEqual(re.findall(rb"<port>(\d+)</port>", announced), [b"8080"])
        self.assertIn(b"ListenStream=192.0.2.1:12357\n", contents(self.path("unit", "addresses.conf")))

    def test_both_ports_idle_take_little_memory(self):
        ports = free_port(), free_port()
        self.options = ("--listen", f"127.0.0.1:{ports[0]}", "--listen", f"127.0.0.1:{ports[1]}")
        self.serve(nanodlp={"port": ports[0], "clients": ["127.0.0.1"]}, odyssey={"port": ports[1], "clients": ["127.0.0.1"]})
        for self.host_port in ports:
            self.assertEqual(self.ask("GET", "/status")[0], 200)
        memory = int(re.search(r"RssAnon:\s+(\d+) kB", contents(f"/proc/{self.web.pid}/status").decode())[1])
        if not SANITIZED:
            self.assertLess(memory, 12 * 1024)


class NanodlpTest(HostTest):
    """The requests of DragonFruit (plugins/athena/rust/network.rs) and of Orion (nanodlp_http_client.dart)."""

    KEY = "nanodlp"

    def status(self):
        """Returns the status, as both clients accept it."""
        code, _, body = self.ask("GET", "/status", Accept="application/json")
        text = body.decode()
        self.assertEqual(code, 200)
        self.assertTrue(text.startswith("{"))
        known = ("Printing", "Path", "LayerID", "Version", "Hostname", "State", "Status", "LayersCount", "PlateID", "Build", "Paused", "CurrentHeight", "IP")
        self.assertGreaterEqual(sum(f'"{key}"' in text for key in known), 3)
        status = json.loads(text)
        # DragonFruit: the first of these decides whether the printer is one of its models.
        model = next(status[key] for key in ("Model", "PrinterModel", "Machine", "Name", "Build") if isinstance(status.get(key), str) and status[key].strip())
        self.assertIn("athena", re.sub("[^a-z0-9]+", " ", model.lower()))
        self.assertNotIn("PrevLayerTime", status)
        for key in ("State", "LayerID", "LayersCount", "PlateID", "CurrentHeight", "TimeRemain"):
            self.assertIn(type(status.get(key)), (int, type(None)), key)
        self.assertLessEqual(status.get("Progress", 0), 1)
        return status

    def phase(self, *states):
        wait_until(lambda: self.status()["State"] in states, f"state {states}")
        return self.status()

    def profile(self):
        profiles = self.get("/json/db/profiles.json")
        self.assertTrue(all(type(each["ProfileID"]) is int and each["ProfileID"] > 0 and each["Title"] and each["locked"] is True for each in profiles))
        machine = self.get("/json/db/machine.json")
        self.assertEqual(machine["Name"], "Simulated printer")
        self.assertTrue(all(isinstance(value, (int, str, dict)) for value in machine.values()))
        default = [each for each in profiles if each["ProfileID"] == machine["DefaultProfile"]]
        self.assertEqual(len(default), 1)
        return default[0]

    def add(self, path, plate, profile=None, **headers):
        """Adds a plate as DragonFruit does. Returns its number, from Location alone."""
        profile = profile or self.profile()["ProfileID"]
        status, reply, body = self.send("/plate/add", ("Path", None, path), ("ProfileID", None, str(profile)), ("ZipFile", f"{path}.nanodlp", plate), **headers)
        self.assertEqual(status, 302, body)
        numbers = [int(part) for part in reversed(reply["Location"].split("/")) if part.isdigit()]
        self.assertEqual(json.loads(body)["PlateID"], numbers[0])
        return numbers[0]

    def plate(self, number):
        """Polls the list until the plate has its figures, as DragonFruit does."""

        def ready():
            plates = [each for each in self.get("/plates/list/json") if each["PlateID"] == number]
            return plates and any(float(plates[0].get(key) or 0) > 0 for key in ("LayerHeight", "LayersCount", "UsedMaterial"))

        wait_until(ready, "the plate's figures")
        return next(each for each in self.get("/plates/list/json") if each["PlateID"] == number)

    def test_dragonfruit_adds_a_plate_and_prints_it(self):
        self.serve_host()
        self.assertEqual(self.status()["State"], 0)
        self.assertEqual(self.ask("GET", "/athena-iot/dragonfruit/printer_data")[0], 404)
        layers = self.layers()
        data = nanodlp(layers)
        number = self.add("my gear", data)
        plate = self.plate(number)
        self.assertEqual((plate["Path"], plate["LayersCount"], plate["LayerCount"], plate["LayerThickness"], plate["ProfileName"]), ("my gear", 3, 3, 50, "standard"))
        self.assertGreater(plate["PrintTime"], 0)
        self.assertEqual(self.daemon.job("my gear")["asks"], ["to_be_confirmed"])
        code, headers, picture = self.ask("GET", f"/static/plates/{number}/3d.png")
        self.assertEqual((plate["Preview"], code, headers["Content-Type"], picture[:4]), (True, 200, "image/png", b"\x89PNG"))
        self.assertEqual(self.status()["State"], 0)
        self.assertEqual(self.ask("GET", f"/printer/start/{number}")[0], 200)
        self.assertEqual(self.daemon.wait_ended("my gear")["outcome"], "done")
        self.assertEqual(contents(os.path.join(self.daemon.spool, "done", "my gear.nanodlp")), data)
        report = self.daemon.report("my gear")
        self.assertEqual((report["model"]["format"], report["layers"], report["resin"]), ("nanodlp", 3, "standard"))

    def test_a_name_that_is_not_ascii_is_that_of_the_field_path(self):
        self.serve_host()
        # reqwest writes such a file's name as filename*, which few parsers of forms know.
        body = form(("Path", None, "h\u00e4ndel"), ("ZipFile", "X", nanodlp(self.layers()))).replace(b'filename="X"', b"filename*=UTF-8''h%C3%A4ndel.nanodlp")
        status, reply, sentence = self.ask("POST", "/plate/add", body, **{"Content-Type": f"multipart/form-data; boundary={BOUNDARY}"})
        self.assertEqual(status, 302, sentence)
        self.assertEqual(self.plate(int(reply["Location"].rsplit("/", 1)[1]))["Path"], "h\u00e4ndel")

    def test_orion_follows_pauses_and_cancels_a_print(self):
        self.serve_host(self.printing_slowly())
        number = self.add("part", nanodlp(self.layers()))
        self.plate(number)
        # Orion follows a redirection, and takes 200 alone for success.
        self.assertEqual(self.ask("GET", f"/printer/start/{number}")[0], 200)
        self.daemon.wait_state("exposing")
        status = self.phase(5)
        self.assertEqual((status["Printing"], status["Paused"], status["Path"], status["PlateID"], status["LayerID"], status["LayersCount"]), (True, False, "part", number, 1, 3))
        self.assertEqual([each["PlateID"] for each in self.get("/plates/list/json")], [number])
        # 1/6400 mm
        self.assertEqual(status["CurrentHeight"], 320)
        code, headers, picture = self.ask("GET", f"/static/plates/{number}/1.png")
        self.assertEqual((code, headers["Content-Type"], picture[:4]), (200, "image/png", b"\x89PNG"))
        self.refused("GET", f"/static/plates/{number}/2.png", 404, "layer")
        self.refused("GET", f"/printer/start/{number}", 409, "part is being printed already")
        self.refused("GET", f"/plate/delete/{number}", 409, "cancel it first")
        self.assertEqual(self.ask("GET", "/printer/pause")[0], 200)
        self.assertEqual(self.phase(2)["Printing"], True)
        self.assertEqual(self.ask("GET", "/printer/unpause")[0], 200)
        self.assertEqual(self.phase(5)["Paused"], False)
        self.assertEqual(self.ask("GET", "/printer/stop")[0], 200)
        seen = {self.status()["State"]}
        while 0 not in seen:
            seen.add(self.status()["State"])
        self.assertLessEqual(seen, {4, 0})
        self.assertEqual(self.daemon.wait_ended("part")["outcome"], "cancelled")
        idle = self.status()
        self.assertEqual((idle["Printing"], idle.get("PlateID"), idle.get("LayerID")), (False, None, None))

    def test_the_end_of_a_print_that_was_followed_shows_in_its_layers(self):
        self.serve_host()
        number = self.add("part", nanodlp(self.layers(40)))
        self.plate(number)
        self.ask("GET", f"/printer/start/{number}")
        followed = []
        wait_until(lambda: followed.append(self.status()) or (followed[-1]["State"] == 0 and len(followed) > 1), "the end")
        if any("LayersCount" in each for each in followed[:-1]):
            self.assertEqual((followed[-1]["LayerID"], followed[-1]["LayersCount"]), (40, 40))

    def test_a_plate_waits_for_its_start_and_a_start_for_the_plate(self):
        self.serve_host()
        self.daemon.printed("first.stl", SMALL)
        number = self.add("second", nanodlp(self.layers()))
        self.plate(number)
        self.refused("GET", f"/printer/start/{number}", 409, "a part is on the plate")
        self.daemon.rpc("plate_cleared")
        time.sleep(0.3)
        self.assertEqual(self.daemon.job("second")["state"], "unaccepted")
        self.assertEqual(self.ask("GET", f"/printer/start/{number}")[0], 200)
        self.assertEqual(self.daemon.wait_ended("second")["outcome"], "done")

    def test_no_print_is_started_while_somebody_moves_the_printer_by_hand(self):
        # Homing takes a minute, however busy the machine is.
        self.serve_host(Daemon(self, realtime(z_axis={"homing_speed_mm_s": 0.5}), ENDLESS).start())
        number = self.add("part", nanodlp(self.layers()))
        self.plate(number)
        self.daemon.client().call("home")  # which goes on as long as its client is connected
        # The emergency stop would end the homing, and so let the job begin.
        self.refused("GET", f"/printer/start/{number}", 409, "by hand")
        self.assertEqual(self.ask("GET", "/printer/force-stop")[0], 200)
        wait_until(lambda: self.daemon.status()["manual"]["state"] == "idle", "the end of the homing")
        self.assertEqual(self.daemon.job("part")["asks"], ["to_be_confirmed"])
        self.assertEqual(self.ask("GET", f"/printer/start/{number}")[0], 200)
        # The job may be on its way from the queue to the printer.
        wait_until(lambda: self.ask("GET", "/printer/force-stop")[0] == 200, "the stop of the print")
        self.assertEqual(self.daemon.wait_ended("part")["outcome"], "cancelled")
        self.daemon.rpc("plate_cleared")
        # A print that has ended stands in the way of no other one.
        number = self.add("next", nanodlp(self.layers()))
        self.plate(number)
        self.assertEqual(self.ask("GET", f"/printer/start/{number}")[0], 200)

    def test_an_interrupted_print_is_named_before_its_part_on_the_plate(self):
        self.serve_host(self.printing_slowly())
        self.daemon.begin("part.stl", SMALL)
        number = self.add("second", nanodlp(self.layers()))
        self.plate(number)
        self.daemon.process.kill()
        self.daemon.process.wait()
        self.daemon.start()
        wait_until(lambda: self.ask("GET", "/status")[0] == 200, "contourd")
        self.plate(number)
        self.refused("GET", f"/printer/start/{number}", 409, "contourctl resume")

    def test_of_two_starts_at_once_one_is_refused_and_its_plate_still_waits(self):
        self.serve_host(self.printing_slowly())
        plates = {self.add(name, nanodlp(self.layers())): name for name in ("one", "two")}
        started = []
        for number in plates:
            self.plate(number)
        clients = {number: socket.create_connection(("127.0.0.1", self.host_port), timeout=DEADLINE_S) for number in plates}
        for number, client in clients.items():
            self.addCleanup(client.close)
            client.sendall(f"GET /printer/start/{number} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        for number, client in clients.items():
            reply = client.recv(65536)
            self.assertIn(reply.split()[1], (b"200", b"409"))
            if reply.split()[1] == b"200":
                started.append(plates[number])
            else:
                self.assert_one_line(reply.partition(b"\r\n\r\n")[2])
        self.assertEqual(len(started), 1)
        (other,) = set(plates.values()) - set(started)
        late = {number: name for number, name in plates.items() if name == other}.popitem()[0]
        while self.daemon.status()["state"] != "exposing":
            self.assertEqual(self.ask("GET", f"/printer/start/{late}")[0], 409)
        self.assertEqual(self.status()["Path"], started[0])
        # It would print after the first one if its start had been taken.
        self.assertEqual(self.daemon.job(other)["asks"], ["to_be_confirmed"])

    def test_a_plate_is_deleted_and_other_numbers_are_refused(self):
        self.serve_host()
        number = self.add("part", nanodlp(self.layers()))
        self.plate(number)
        # DragonFruit tries this first.
        self.assertNotIn(self.ask("DELETE", "/file?location=Local&file_path=part")[0], (200, 202, 204, 302))
        self.assertEqual(self.ask("GET", f"/plate/delete/{number}")[0], 200)
        wait_until(lambda: self.get("/plates/list/json") == [], "the plate is gone")
        self.refused("GET", f"/printer/start/{number}", 404, "no such job")
        for text in ("0", "-1", "x", "", "99999999999999999999", "../1", "1/2"):
            self.assertEqual(self.ask("GET", f"/printer/start/{text}")[0], 400, text)
        self.refused("GET", "/printer/fly", 404, "no such path")
        self.refused("POST", "/printer/stop", 405, "GET")
        self.refused("GET", "/plate/add", 405, "POST")

    def test_what_orion_asks_besides_has_small_replies(self):
        self.serve_host()
        self.assertEqual(self.get("/notification"), [])
        self.assertRegex(self.get("/static/image_version"), r"\d+\.\d+\.\d+")
        for path in ("/analytic/data/10", "/athena-iot/status", "/athena-camera/stream", "/slicer"):
            self.assertEqual(self.ask("GET", path)[0], 404)

    def test_nothing_moves_and_nothing_is_lit_by_hand(self):
        self.serve_host()
        before = self.daemon.status()["manual"]
        for path in ("/z-axis/top", "/z-axis/bottom", "/z-axis/calibrate", "/z-axis/move/up/micron/1000", "/projector/on", "/projector/blank",
                     "/projector/generate/white", "/display/test/White", "/athena-iot/control/preheat_and_mix"):  # fmt: skip
            self.refused("GET", path, 403, "by hand only at the printer")
        self.refused("POST", "/gcode", 403, "by hand only at the printer", body=b"gcode=G28")
        self.refused("POST", "/profile/edit/simple/1", 403, "resin profiles", body=b"CureTime=1")
        self.assertEqual(self.daemon.status()["manual"], before)
        # The emergency stop ends what another client does by hand.
        self.assertEqual(self.ask("GET", "/printer/force-stop")[0], 200)

    def test_names_are_no_paths_and_files_are_not_taken_by_their_paths(self):
        self.serve_host()
        plate, profile = nanodlp(self.layers()), str(self.profile()["ProfileID"])
        outside = self.write("outside.nanodlp", plate)
        for path in ("../../outside", "/etc/passwd", "..", ".hidden", "a\\b", "x" * 250):
            with self.subTest(path=path):
                status, _, sentence = self.send("/plate/add", ("Path", None, path), ("ProfileID", None, profile), ("ZipFile", "a.nanodlp", plate))
                self.assertEqual(status, 415)
                self.assert_one_line(sentence)
        for usb in (outside, "../outside.nanodlp", "/media/usb/part.nanodlp"):
            status, _, sentence = self.send("/plate/add", ("Path", None, "part"), ("ProfileID", None, profile), ("USBFile", None, usb))
            self.assertEqual(status, 403)
            self.assert_one_line(sentence, b"path")
        status, _, sentence = self.send("/plate/add", ("Path", None, "part"), ("ProfileID", None, "4711"), ("ZipFile", "part.nanodlp", plate))
        self.assertEqual(status, 400)
        self.assert_one_line(sentence, b"4711")
        for key, value in (("Path", "part"), ("ProfileID", profile)):
            status, _, sentence = self.send("/plate/add", (key, None, value), ("Path", None, "part"), ("ProfileID", None, profile), ("ZipFile", "a.nanodlp", plate))
            self.assertEqual(status, 400)
            self.assert_one_line(sentence, f"more than one {key}".encode())
        self.assertEqual(self.send("/plate/add", ("Path", None, "y" * 300), ("ZipFile", "a.nanodlp", plate))[0], 400)
        self.assertEqual(self.send("/plate/add", ("Path", None, "part"), ("ProfileID", None, profile))[0], 400)
        self.assertEqual(self.ask("POST", "/plate/add", plate)[0], 415)
        self.assertEqual(self.incoming(), [])
        # A field that is left empty names no file.
        self.assertEqual(self.send("/plate/add", ("Path", None, "part"), ("USBFile", None, ""), ("ZipFile", "part.nanodlp", plate))[0], 302)
        # A name in the file's part alone, as of another client.
        self.assertEqual(self.send("/plate/add", ("ProfileID", None, profile), ("ZipFile", "umlaut-\u00e4.nanodlp", plate))[0], 302)
        wait_until(lambda: "umlaut-\u00e4.nanodlp" in self.incoming(), "the job")

    def test_an_upload_is_bounded_and_takes_little_memory(self):
        self.serve_host(largest_upload_mb=64)
        before = self.memory()
        self.assertEqual(self.send("/plate/add", ("Path", None, "big"), ("ZipFile", "big.nanodlp", bytes(60 << 20)))[0], 302)
        self.assertLess(self.memory() - before, 20 << 20)
        # The size is refused before the body comes.
        with socket.create_connection(("127.0.0.1", self.host_port), timeout=DEADLINE_S) as client:
            client.sendall(f"POST /plate/add HTTP/1.1\r\nHost: localhost\r\nContent-Length: {66 << 20}\r\nContent-Type: multipart/form-data; boundary={BOUNDARY}\r\n\r\n".encode())
            self.assertIn(b" 413 ", client.recv(65536).splitlines()[0])
        self.assertEqual([name for name in self.incoming() if "bigger" in name], [])

    def memory(self):
        text = contents(f"/proc/{self.web.pid}/status").decode()
        return int(re.search(r"VmHWM:\s+(\d+) kB", text)[1]) << 10

    def test_a_job_with_findings_is_accepted_on_the_page_only(self):
        self.serve_host(Daemon(self, {"ask_before": ["islands"]}).start())
        island = binary_stl(box((0, 0, 0), (4, 4, 1)) + box((6, 0, 0.5), (8, 2, 1)))
        status, reply, _ = self.send("/plate/add", ("Path", None, "island.stl"), ("ZipFile", "island.stl", island))
        self.assertEqual(status, 302)
        number = int(reply["Location"].rsplit("/", 1)[1])
        self.daemon.wait_job("island")
        self.refused("GET", f"/printer/start/{number}", 409, "island.stl has findings", "page")

    def test_slow_and_broken_clients_end_alone(self):
        self.serve_host()
        with socket.create_connection(("127.0.0.1", self.host_port), timeout=DEADLINE_S) as noise:
            noise.sendall(b"\x16\x03\x01\0\r\n\r\n")
            self.assertNotIn(b" 200 ", noise.recv(65536))
        half = form(("Path", None, "part"), ("ZipFile", "part.nanodlp", SMALL))[:-100]
        with socket.create_connection(("127.0.0.1", self.host_port), timeout=DEADLINE_S) as cut:
            cut.sendall(f"POST /plate/add HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(half) + 100}\r\nContent-Type: multipart/form-data; boundary={BOUNDARY}\r\n\r\n".encode() + half)
        self.assertEqual(self.status()["State"], 0)
        self.assertEqual(self.incoming(), [])


class OdysseyTest(HostTest):
    """The requests of Orion (odyssey_http_client.dart), read as its models read them: Dart throws where a decimal is a whole number."""

    KEY = "odyssey"

    def typed(self, value, **types):
        for key, kind in types.items():
            self.assertIs(type(value[key]), kind, (key, value))

    def file_data(self, data):
        self.typed(data, path=str, name=str, last_modified=int, file_size=int, location_category=str, parent_path=str)
        return data

    def print_data(self, data):
        self.typed(data, layer_count=int, used_material=float, print_time=float, layer_height=float, layer_height_microns=int)
        self.file_data(data["file_data"])
        return data

    def read(self, status):
        self.assertIn(status["status"], ("Printing", "Idle", "Shutdown"))
        self.typed(status, paused=bool)
        self.typed(status["physical_state"], z=float, z_microns=int, curing=bool)
        self.assertIn(type(status["layer"]), (int, type(None)))
        if status["print_data"] is not None:
            self.print_data(status["print_data"])
        return status

    def status(self):
        return self.read(self.get("/status"))

    def listed(self, **query):
        query = {"location": "Local", "subdirectory": "", "page_index": 0, "page_size": 100, **query}
        listed = self.get("/files?" + "&".join(f"{key}={value}" for key, value in query.items()))
        self.assertEqual(listed["dirs"], [])
        for each in listed["files"]:
            self.assertEqual(each["location_category"], "Local")
            self.print_data(each)
        return listed

    def upload(self, name, data):
        status, _, body = self.send("/files", ("file", name, data))
        self.assertEqual((status, body), (200, b""))
        wait_until(lambda: [each for each in self.listed()["files"] if each["file_data"]["path"] == name and each["layer_count"]], "the file")

    def post(self, path, status=200):
        code, _, body = self.ask("POST", path)
        self.assertEqual(code, status, body)
        return body

    def test_orion_uploads_and_prints_a_file(self):
        self.serve_host()
        idle = self.status()
        self.assertEqual((idle["status"], idle["paused"], idle["layer"], idle["print_data"]), ("Idle", False, None, None))
        data = sl1(self.layers())
        self.upload("my part.sl1", data)
        metadata = self.print_data(self.get("/file/metadata?location=Local&file_path=my%20part.sl1"))
        self.assertEqual((metadata["layer_count"], metadata["layer_height"], metadata["layer_height_microns"]), (3, 0.05, 50))
        # The size is that of the job's files, one of which is its ticket.
        self.assertEqual(metadata["file_data"]["file_size"], len(data) + os.path.getsize(os.path.join(self.daemon.spool, "incoming", "my part.json")))
        code, headers, picture = self.ask("GET", "/file/thumbnail?location=Local&file_path=my%20part.sl1&size=Large")
        self.assertEqual((code, headers["Content-Type"], picture[:4]), (200, "image/png", b"\x89PNG"))
        self.assertEqual(self.daemon.job("my part")["state"], "unaccepted")
        self.assertEqual(self.post("/print/start?location=Local&file_path=my%20part.sl1"), b"")
        self.assertEqual(self.daemon.wait_ended("my part")["outcome"], "done")
        self.assertEqual(contents(os.path.join(self.daemon.spool, "done", "my part.sl1")), data)
        self.assertEqual(self.daemon.report("my part")["model"]["format"], "sl1")

    def test_orion_follows_pauses_and_cancels_a_print_by_the_stream(self):
        self.serve_host(self.printing_slowly())
        self.upload("part.stl", SMALL)
        stream = http.client.HTTPConnection("127.0.0.1", self.host_port, timeout=DEADLINE_S)
        self.addCleanup(stream.close)
        stream.request("GET", "/status/stream")
        reply = stream.getresponse()
        self.assertEqual((reply.status, reply.headers["Content-Type"]), (200, "text/event-stream"))
        names = set()

        def until(accept):
            while True:
                line = reply.readline().decode().rstrip("\n")
                if line.startswith("event:"):
                    names.add(line[6:].strip())
                if line.startswith("data:"):
                    status = self.read(json.loads(line[5:]))
                    if accept(status):
                        return status

        until(lambda status: status["status"] == "Idle")
        self.post("/print/start?location=Local&file_path=part.stl")
        lit = until(lambda status: status["physical_state"]["curing"])
        self.assertEqual((lit["status"], lit["layer"], lit["paused"], lit["print_data"]["file_data"]["name"]), ("Printing", 1, False, "part"))
        self.assertEqual(lit["physical_state"]["z"], 0.05)
        # The file of the print under way is known by both of its names.
        for name in ("part", "part.stl"):
            self.assertEqual(self.get(f"/file/metadata?location=Local&file_path={name}")["layer_count"], lit["print_data"]["layer_count"])
        self.refused("POST", "/print/start?location=Local&file_path=part.stl", 409, "being printed already")
        self.refused("DELETE", "/file?location=Local&file_path=part", 409, "cancel it first")
        self.refused("POST", "/print/resume", 409)
        self.post("/print/pause")
        self.post("/print/resume")
        self.post("/print/cancel")
        ended = until(lambda status: status["status"] == "Idle")
        self.assertEqual((ended["layer"], ended["paused"], names), (None, False, {"status"}))
        self.refused("POST", "/print/cancel", 409, "no print to cancel")

    def test_the_emergency_stop_of_orion_cancels_the_print(self):
        self.serve_host(Daemon(self, realtime(), ENDLESS).start())
        self.daemon.begin("part.stl", SMALL)
        self.post("/manual/hardware_command?command=M112")
        self.assertEqual(self.daemon.wait_ended("part")["outcome"], "cancelled")

    def test_files_are_listed_by_pages_and_deleted(self):
        self.serve_host()
        for name in ("a.stl", "b.stl", "c.stl"):
            self.upload(name, SMALL)
        first = self.listed(page_size=2)
        self.assertEqual(([each["file_data"]["name"] for each in first["files"]], first["next_index"]), (["a.stl", "b.stl"], 1))
        second = self.listed(page_size=2, page_index=1)
        self.assertEqual(([each["file_data"]["name"] for each in second["files"]], second["next_index"]), (["c.stl"], None))
        self.assertEqual(self.listed(page_index=900)["files"], [])
        code, _, body = self.ask("DELETE", "/file?location=Local&file_path=b.stl")
        self.assertEqual((code, self.file_data(json.loads(body))["name"]), (200, "b.stl"))
        wait_until(lambda: len(self.listed()["files"]) == 2, "the file is gone")
        # Orion asks in this way whether there is a USB stick.
        self.refused("GET", "/files?location=Usb&subdirectory=&page_index=0&page_size=1", 404, "Local")
        self.refused("GET", "/files?location=Local&subdirectory=x", 404, "folders")
        for query in ("page_size=0", "page_size=1001", "page_index=-1", "page_index=x"):
            self.refused("GET", f"/files?{query}", 400, "page_size")

    def test_paths_lead_nowhere(self):
        self.serve_host()
        self.upload("part.stl", SMALL)
        outside = self.write("outside.stl", SMALL)
        for path in ("../outside.stl", "..%2Foutside.stl", outside, "/part.stl", "./part.stl", "incoming/part.stl", "part", "part.json", "*"):
            with self.subTest(path=path):
                for method, request in (("GET", "/file/metadata"), ("GET", "/file/thumbnail"), ("DELETE", "/file"), ("POST", "/print/start")):
                    self.refused(method, f"{request}?location=Local&file_path={path}", 404, "no such job")
        self.refused("POST", "/print/start?location=Usb&file_path=part.stl", 404, "Local")
        self.refused("DELETE", "/file?location=Local", 400, "file_path")
        for name in ("../../evil.stl", "a/b.stl", "..", ".stl", "evil.ctb", "evil.json"):
            status, _, sentence = self.send("/files", ("file", name, SMALL))
            self.assertEqual(status, 415)
            self.assert_one_line(sentence)
        self.assertEqual(self.incoming(), ["part.json", "part.stl"])

    def test_the_configuration_has_the_greatest_height_and_nothing_is_done_by_hand(self):
        self.serve_host()
        config = self.get("/config")
        self.assertEqual((config["printer"]["max_z"], type(config["printer"]["max_z"])), (self.daemon.config["z_axis"]["travel_mm"], float))
        self.assertRegex(self.get("/version"), r"^contourd \d")
        before = self.daemon.status()["manual"]
        for path in ("/manual?z=10.0", "/manual?cure=true", "/manual/home", "/manual/display_test?test=White", "/manual/hardware_command?command=G28", "/manual/hardware_command"):
            self.refused("POST", path, 403, "by hand only at the printer")
        self.assertEqual(self.daemon.status()["manual"], before)
        self.refused("GET", "/file?location=Local&file_path=part.stl", 501, "spool")
        self.refused("GET", "/update/releases", 404, "no such path")
        self.refused("POST", "/shutdown", 404, "no such path")
        self.refused("PUT", "/status", 405, "no such method")

    def test_strangers_and_browsers_may_not_ask(self):
        self.serve_host()
        self.refused("GET", "/status", 403, UNLISTED, source=UNLISTED)
        self.refused("POST", "/print/cancel", 403, "browser", Origin="http://evil.example")
        self.refused("GET", "/status/stream", 403, "browser", **{"User-Agent": "Mozilla/5.0"})

    def test_too_many_clients_of_the_stream_are_refused(self):
        self.serve_host()
        streams = [socket.create_connection(("127.0.0.1", self.host_port), timeout=DEADLINE_S) for _ in range(17)]
        replies = []
        for stream in streams:
            self.addCleanup(stream.close)
            stream.sendall(b"GET /status/stream HTTP/1.1\r\nHost: localhost\r\n\r\n")
            replies.append(int(stream.recv(4096).split()[1]))
        self.assertEqual(sorted(replies), [200] * 16 + [503])
