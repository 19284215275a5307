"""contourd-web and an MQTT broker: Home Assistant's discovery, the state, commands, and brokers that are gone, silent or hostile."""

import json
import os
import re
import shutil
import signal
import subprocess
import time
import unittest

import mqtt
import web_test
from harness import BAD_DATA, CONTOURCTL, CONTOURD_WEB, SANITIZED, SLAB, SOURCE, Daemon, FolderTest, contents, read_png, realtime, run, skip_file, wait_until, NIMBLE_RESIN

if not mqtt.MOSQUITTO:
    skip_file("the broker mosquitto is not installed")

# A print of 20 layers that takes some seconds, and one that takes as long as a test needs.
SLOW = {"exposure_ms": 250, "bottom_exposure_ms": 250}
TALL = {"exposure_ms": 1000, "bottom_exposure_ms": 1000}


class MqttTest(web_test.WebTest):
    def set_broker(self, port, *options, password=None, expect=0):
        return run(CONTOURD_WEB, "--set-mqtt", "--broker", f"127.0.0.1:{port}", *options, "--mqtt-file", self.path("web-mqtt"), "--service-unit", self.path("unit"),
                   "--password-file", self.path("web-password"), input=(password + "\n").encode() if password else b"", expect=expect)  # fmt: skip

    def connect(self, port, resin=None, *options, password=None, **config):
        """Starts a daemon and its page, which reports to the broker. Returns a client of the page that has logged in."""
        self.set_broker(port, *options, password=password)
        self.options = ["--mqtt-file", self.path("web-mqtt")]
        daemon = Daemon(self, realtime(**config), {**NIMBLE_RESIN, **(resin or {})}).start()
        browser = self.serve(daemon)
        self.assertEqual(browser.log_in()[0], 204)
        return browser

    def with_mosquitto(self, resin=None, *settings, **config):
        """Starts the broker, too. Returns its subscriber, once the printer is online."""
        self.broker = mqtt.Mosquitto(self, web_test.free_port(), *settings)
        self.seen = self.broker.subscriber()
        self.connect(self.broker.port, resin, **config)
        return self.online()

    def online(self):
        """Waits until the printer is online, and learns its topics. Returns the subscriber."""
        self.topic = wait_until(lambda: next((topic for topic in list(self.seen.latest) if topic.startswith("homeassistant/device/")), None), "a discovery")
        self.discovery = mqtt.json_of(self.seen.payload(self.topic))
        self.seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"online")
        return self.seen

    def state(self):
        return mqtt.json_of(self.seen.payload(self.discovery["stat_t"]))

    def wait_state(self, **expected):
        wait_until(lambda: expected.items() <= self.state().items(), f"{expected}, not {self.state()}")

    def press(self, key, **options):
        self.seen.publish(self.discovery["cmps"][key]["command_topic"], **options)

    def web_log(self):
        return contents(self.path("web.log")).decode()

    def wait_logged(self, words):
        wait_until(lambda: words in self.web_log(), f"{words!r} in the log")

    def memory_kib(self, key="VmRSS"):
        return int(re.search(rf"{key}:\s+(\d+)", contents(f"/proc/{self.web.pid}/status").decode())[1])


class DiscoveryTest(MqttTest):
    def test_the_discovery_keeps_the_rules_of_home_assistant(self):
        seen = self.with_mosquitto()
        found = self.discovery
        device = found["dev"]["ids"][0]
        self.assertRegex(device, r"^contourd_[0-9a-f]{16}$")
        self.assertEqual(self.topic, f"homeassistant/device/{device}/config")
        self.assertEqual(found["dev"]["name"], "Simulated printer")
        self.assertTrue(found["dev"]["sw"] and found["o"]["name"])
        self.assertNotIn("cu", found["dev"], "no one else can open a page on the loopback")
        parts = found["cmps"]
        self.assertEqual(sorted(parts), sorted(["state", "progress", "layer", "layers", "time_left", "resin", "outcome", "problem", "plate", "mask",
                                                "pause", "resume", "cancel", "plate_cleared"]))  # fmt: skip
        self.assertEqual(len({part["unique_id"] for part in parts.values()}), len(parts))
        for key, part in parts.items():
            with self.subTest(key):
                self.assertIn(part["p"], ("sensor", "binary_sensor", "button", "image"))
                self.assertTrue(part["name"])
                if "value_template" in part:
                    value = re.fullmatch(r"\{\{ value_json\.(\w+) \}\}", part["value_template"])
                    self.assertIn(value[1], self.state())
                # Home Assistant refuses a sensor with options that has a unit, and one with another class than "enum".
                self.assertEqual("options" in part, part.get("device_class") == "enum")
                self.assertFalse("options" in part and ("unit_of_measurement" in part or "state_class" in part))
        self.assertEqual((parts["time_left"]["device_class"], parts["time_left"]["unit_of_measurement"]), ("duration", "s"))
        self.assertEqual((parts["resin"]["device_class"], parts["resin"]["unit_of_measurement"]), ("volume", "mL"))
        self.assertEqual(parts["mask"]["content_type"], "image/png")
        self.assertIn(self.state()["state"], parts["state"]["options"])
        # A client that comes later gets all of it from the broker.
        late = self.broker.subscriber()
        for topic in (self.topic, found["stat_t"], found["avty_t"]):
            late.wait_for(topic)
            self.assertEqual(late.latest[topic], (seen.payload(topic), True), topic)

    def test_the_discovery_comes_again_when_home_assistant_starts(self):
        seen = self.with_mosquitto()
        seen.forget()
        seen.publish("homeassistant/status", b"offline")
        seen.publish("homeassistant/status", b"online")
        for topic in (self.topic, self.discovery["stat_t"], self.discovery["avty_t"]):
            seen.wait_for(topic)

    def test_another_prefix_is_used_for_both_topics(self):
        self.broker = mqtt.Mosquitto(self, web_test.free_port())
        self.seen = self.broker.subscriber()
        self.connect(self.broker.port, None, "--prefix", "ha/test")
        topic = wait_until(lambda: next((topic for topic in list(self.seen.latest) if topic.startswith("ha/test/device/")), None), "a discovery")
        self.seen.forget()
        self.seen.publish("ha/test/status", b"online")
        self.seen.wait_for(topic)

    def test_the_resin_is_told_once_someone_has_told_it(self):
        self.with_mosquitto()
        self.assertIsNone(self.state()["resin_ml"])
        self.daemon.rpc("vat", filled_ml=150)
        self.web.terminate()
        self.web.wait()
        self.start_web()
        self.wait_state(resin_ml=150)
        self.assertEqual(self.daemon.log().count("vat"), 1, "only the filling is a command")


class PrintTest(MqttTest):
    def test_a_print_is_followed_from_its_beginning_to_its_end(self):
        seen = self.with_mosquitto(SLOW)
        self.wait_state(state="idle", progress=None, layer=None, time_left_s=None, problem="OFF", plate="OFF", outcome=None)
        self.daemon.drop("gear.stl", SLAB)
        self.assertEqual(self.daemon.wait_ended("gear")["outcome"], "done")
        self.wait_state(state="idle", outcome="done", last_job="gear", progress=None)
        states = []
        while not states or states[-1]["outcome"] is None:
            payload, _ = seen.next(self.discovery["stat_t"])
            states.append(json.loads(payload))
        printing = [state for state in states if state["layer"]]
        self.assertGreaterEqual(len(printing), 3)
        self.assertLess(len(printing), 20, "a state each second is enough")
        self.assertEqual({(state["job"], state["layers"]) for state in printing}, {("gear", 20)})
        for key in ("progress", "layer"):
            values = [state[key] for state in printing]
            self.assertEqual(values, sorted(values))
            self.assertGreater(values[-1], values[0])
        self.assertGreaterEqual(printing[0]["time_left_s"], printing[-1]["time_left_s"])
        for state in states:
            self.assertIn(state["state"], self.discovery["cmps"]["state"]["options"])

    def test_the_mask_is_sent_while_it_is_printed_and_not_kept_by_the_broker(self):
        seen = self.with_mosquitto(TALL)
        topic = self.discovery["cmps"]["mask"]["image_topic"]
        self.daemon.begin("gear.stl", SLAB)
        picture = read_png(self.write("mask.png", seen.wait_for(topic)))
        self.assertEqual([picture.width, picture.height], self.daemon.config["display"]["size_px"] if "size_px" in self.daemon.config.get("display", {}) else [picture.width, picture.height])
        self.assertEqual(picture.values() - {0}, {255})
        late = self.broker.subscriber()
        late.wait_for(self.discovery["stat_t"])
        self.assertNotIn(topic, sorted(late.latest))
        self.daemon.cancel("gear")

    def test_buttons_pause_resume_and_cancel_a_print_and_clear_the_plate(self):
        self.with_mosquitto(TALL, wait_for_plate_cleared=True)
        self.daemon.begin("gear.stl", SLAB)
        self.press("pause")
        self.wait_state(state="paused")
        self.press("resume")
        self.wait_state(state="printing")
        self.press("cancel")
        self.assertEqual(self.daemon.wait_ended("gear")["outcome"], "cancelled")
        self.wait_state(state="idle", outcome="cancelled", plate="ON")
        self.press("plate_cleared")
        self.wait_state(plate="OFF")

    def test_a_refusal_is_a_sentence_in_the_state_and_in_the_log(self):
        self.with_mosquitto()
        self.press("pause")
        self.wait_state(refused="there is no print to pause")
        self.assertIn("pause by MQTT was refused: there is no print to pause", self.web_log())
        self.press("plate_cleared")
        self.wait_state(refused=None)

    def test_commands_that_the_broker_has_kept_are_dropped(self):
        seen = self.with_mosquitto(TALL)
        self.daemon.begin("gear.stl", SLAB)
        self.web.terminate()
        self.web.wait()
        self.press("cancel", retain=True)
        seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"offline")
        self.start_web()
        seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"online")
        # This command comes after the one that the broker had kept.
        self.press("pause")
        self.wait_state(state="paused")
        self.assertNotIn("cancel by MQTT", self.web_log())
        self.daemon.cancel("gear")

    def test_other_topics_and_other_payloads_are_no_commands(self):
        seen = self.with_mosquitto(TALL)
        self.daemon.begin("gear.stl", SLAB)
        topic = self.discovery["cmps"]["cancel"]["command_topic"]
        for payload in (b"", b"press", b"PRESS ", b"PRESS\0", b"x" * 20_000):
            seen.publish(topic, payload)
        for method in ("home", "light_on", "queue_remove", "", "cancel/now", "vat"):
            seen.publish(topic.rpartition("/")[0] + "/" + method)
        self.press("pause")
        self.wait_state(state="paused")
        self.assertEqual(re.findall(r"(\w+) by MQTT", self.web_log()), ["pause"])
        self.daemon.cancel("gear")


class LossTest(MqttTest):
    def test_the_printer_is_offline_when_contourd_web_is_killed_or_stopped(self):
        seen = self.with_mosquitto()
        for end, code in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGTERM, 0)):
            with self.subTest(end.name):
                self.web.send_signal(end)
                self.assertEqual(self.web.wait(), code)
                seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"offline")
                self.start_web()
                seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"online")

    def test_the_printer_is_offline_while_contourd_does_not_run(self):
        seen = self.with_mosquitto()
        self.daemon.stop()
        seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"offline")
        self.daemon.start()
        seen.wait_for(self.discovery["avty_t"], lambda payload: payload == b"online")

    def test_a_broker_that_comes_again_gets_everything_again(self):
        self.with_mosquitto()
        self.broker.stop()
        self.wait_logged("lost the MQTT broker")
        self.broker.start()
        self.seen = self.broker.subscriber()
        self.online()
        self.wait_state(state="idle")
        self.assertEqual(self.web_log().count("connected to the MQTT broker"), 2)
        self.assertEqual(self.web_log().count("lost the MQTT broker"), 1)

    def test_a_broker_that_is_missing_is_told_once(self):
        port = web_test.free_port()
        browser = self.connect(port)
        self.wait_logged(f"cannot connect to the MQTT broker 127.0.0.1:{port}: Connection refused; contourd-web keeps trying")
        broker = mqtt.Mosquitto(self, port)
        self.seen = broker.subscriber()
        self.online()
        self.assertEqual(self.web_log().count("cannot connect"), 1)
        self.assertEqual(browser.json("/api/status")["state"], "idle")

    def test_a_broker_that_accepts_and_says_nothing_stalls_nothing(self):
        broker = mqtt.OddBroker(self, lambda connection: connection.recv(1 << 20) and connection.recv(1))
        browser = self.connect(broker.port)
        wait_until(lambda: broker.connections, "a connection")
        began = time.monotonic()
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        self.assertLess(time.monotonic() - began, 5)
        wait_until(lambda: broker.connections > 1, "another attempt")
        self.assertEqual(self.web_log().count("cannot connect"), 1)
        self.assertIn("it does not answer", self.web_log())
        self.web.terminate()
        self.assertEqual(self.web.wait(10), 0)

    def test_an_address_that_does_not_answer_stalls_neither_the_page_nor_the_end(self):
        # 192.0.2.0/24 is for documentation: no computer has such an address.
        self.set_broker(1)
        self.write("web-mqtt", contents(self.path("web-mqtt")).replace(b"127.0.0.1", b"192.0.2.1"))
        os.chmod(self.path("web-mqtt"), 0o600)
        self.options = ["--mqtt-file", self.path("web-mqtt")]
        browser = self.serve()
        browser.log_in()
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        self.web.terminate()
        self.assertEqual(self.web.wait(10), 0)

    def test_a_wrong_password_is_told_once_with_the_remedy(self):
        passwords = self.path("passwords")
        run(shutil.which("mosquitto_passwd", path=os.path.dirname(mqtt.MOSQUITTO) + ":/usr/bin"), "-b", "-c", passwords, "printer", "secret", expect=0)
        broker = mqtt.Mosquitto(self, web_test.free_port(), "allow_anonymous false", f"password_file {passwords}")
        self.connect(broker.port, None, "--user", "printer", password="wrong")
        self.wait_logged("it refuses the user or the password: set them by sudo contourctl web mqtt")
        self.set_broker(broker.port, "--user", "printer", password="secret")
        self.web.terminate()
        self.web.wait()
        self.start_web()
        self.wait_logged("connected to the MQTT broker")


@unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
class TlsTest(MqttTest):
    def make_certificates(self):
        """Makes an authority, and a broker's certificate for 127.0.0.1 by it; and an authority that is not the broker's."""
        def openssl(*arguments):
            subprocess.run(["openssl", *arguments], cwd=self.folder, check=True, capture_output=True)
        for name in ("ca", "other"):
            openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.pem")
        openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj", "/CN=broker", "-keyout", "broker.key", "-out", "broker.csr")
        self.write("extensions", "subjectAltName=IP:127.0.0.1\n")
        self.write("other-name", "subjectAltName=IP:127.0.0.2\n")
        openssl("x509", "-req", "-in", "broker.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2", "-extfile", "other-name", "-out", "elsewhere.pem")
        openssl("x509", "-req", "-in", "broker.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2", "-extfile", "extensions", "-out", "broker.pem")

    def test_a_certificate_for_another_broker_is_refused(self):
        self.make_certificates()
        port = web_test.free_port()
        mqtt.Mosquitto(self, port, "allow_anonymous true", f"certfile {self.path('elsewhere.pem')}", f"keyfile {self.path('broker.key')}")
        self.connect(port, None, "--ca", self.path("ca.pem"))
        self.wait_logged("TLS handshake failed")
        self.assertNotIn("connected to", self.web_log())

    def test_a_silent_broker_keeps_no_processor_busy(self):
        self.make_certificates()
        broker = mqtt.OddBroker(self, lambda connection: connection.recv(1 << 16) and connection.recv(1 << 16))
        self.connect(broker.port, None, "--ca", self.path("ca.pem"))
        wait_until(lambda: broker.connections, "a connection")
        began, before = time.monotonic(), web_test.processor_s(self.web.pid)
        wait_until(lambda: time.monotonic() > began + 3, "three seconds")
        self.assertLess(web_test.processor_s(self.web.pid) - before, 0.05 * (time.monotonic() - began))

    def test_a_broker_is_reached_by_tls_if_its_authority_is_the_given_one(self):
        self.make_certificates()
        port = web_test.free_port()
        plain = web_test.free_port()
        broker = mqtt.Mosquitto(self, port, f"certfile {self.path('broker.pem')}", f"keyfile {self.path('broker.key')}", f"listener {plain} 127.0.0.1", "allow_anonymous true")
        self.connect(port, None, "--ca", self.path("other.pem"))
        self.wait_logged("TLS handshake failed")
        self.assertNotIn("connected to", self.web_log())
        self.set_broker(port, "--ca", self.path("ca.pem"))
        self.web.terminate()
        self.web.wait()
        self.start_web()
        self.seen = mqtt.Subscriber(plain)
        self.addCleanup(self.seen.close)
        self.online()
        self.press("pause")
        self.wait_state(refused="there is no print to pause")
        self.assertIsNone(broker.process.poll())


class HostileTest(MqttTest):
    def attacked(self, serve, resin=None, **config):
        """Starts the printer with such a broker. Returns it, and a client of the page."""
        broker = mqtt.OddBroker(self, serve)
        return broker, self.connect(broker.port, resin, **config)

    def assert_unharmed(self, browser):
        self.assertIsNone(self.web.poll(), self.web_log())
        browser.log_in()
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        if not SANITIZED:
            self.assertLess(self.memory_kib("VmHWM"), 40 * 1024)

    def test_a_huge_message_costs_no_memory(self):
        piece = bytes(1 << 20)

        def serve(connection):
            mqtt.greet(connection)
            connection.sendall(bytes([mqtt.PUBLISH << 4]) + mqtt.length_of((1 << 28) - 1) + mqtt.text("x"))
            for _ in range(255):
                connection.sendall(piece)

        broker, browser = self.attacked(serve)
        self.wait_logged("it sends more than this client can have asked for")
        wait_until(lambda: broker.connections > 1, "another attempt")
        self.assert_unharmed(browser)

    def test_connections_that_break_anywhere_are_made_again(self):
        greeting = mqtt.packet(mqtt.CONNACK, b"\0\0")
        odd = [b"", greeting[:1], greeting, greeting + b"\x30\xff\xff\xff\x7f", greeting + b"\x30\xff\xff\xff\xff\xff\xff", greeting + mqtt.publish("a/b", b"x" * 300)[:50],
               mqtt.packet(mqtt.CONNACK, b"\0\x05"), mqtt.packet(mqtt.CONNACK, b"\0\xff"), os.urandom(200), greeting + os.urandom(200), mqtt.publish("x", b"y")]  # fmt: skip

        def serve(connection):
            connection.recv(1 << 16)
            connection.sendall(odd.pop() if odd else b"")

        broker, browser = self.attacked(serve)
        # The pauses grow: three attempts in a process, then the next one.
        while odd:
            wait_until(lambda: broker.connections >= 2, "two attempts")
            self.assert_unharmed(browser)
            self.web.kill()
            self.web.wait()
            broker.connections = 0
            self.start_web()
        self.assert_unharmed(browser)

    def test_a_hundred_commands_a_second_reach_the_printer_once_a_second(self):
        sent = []

        def serve(connection):
            commands = next(topic for topic in mqtt.greet(connection) if topic.endswith("/+"))
            began = time.monotonic()
            while time.monotonic() < began + 5:
                connection.sendall(mqtt.publish(commands.replace("+", "pause"), b"PRESS"))
                sent.append(time.monotonic())
                wait_until(lambda: time.monotonic() > sent[-1] + 0.01, "the next command")
            connection.recv(1)

        _, browser = self.attacked(serve)
        wait_until(lambda: len(sent) > 1 and sent[-1] - sent[0] > 4.9, "five seconds of commands")
        self.assert_unharmed(browser)
        carried_out = len(re.findall(r"pause by MQTT(?! was)", self.web_log()))
        self.assertGreater(carried_out, 4)
        self.assertLess(carried_out, 15)
        self.assertEqual(self.web_log().count("faster than one a second"), 1)

    def test_a_broker_that_reads_nothing_gets_no_more_than_fits_into_the_sockets(self):
        def serve(connection):
            mqtt.greet(connection)
            while True:
                connection.sendall(mqtt.publish("homeassistant/status", b"online"))
                began = time.monotonic()
                wait_until(lambda: time.monotonic() > began + 0.05, "the next message")

        _, browser = self.attacked(serve, SLOW)
        self.daemon.drop("gear.stl", SLAB)
        self.assertEqual(self.daemon.wait_ended("gear")["outcome"], "done")
        wait_until(lambda: browser.json("/api/status")["state"] == "idle", "the end")
        self.assert_unharmed(browser)


class SizeTest(MqttTest):
    def test_idle_with_a_broker_it_uses_no_processor_and_little_memory(self):
        self.with_mosquitto()
        self.wait_state(state="idle")
        seconds = 20
        begin, before = time.monotonic(), web_test.processor_s(self.web.pid)
        wait_until(lambda: time.monotonic() > begin + seconds, "the time to be over", seconds + 5)
        share = (web_test.processor_s(self.web.pid) - before) / (time.monotonic() - begin)
        own, all_ = self.memory_kib("RssAnon"), self.memory_kib()
        print(f"{100 * share:.3f} % of a core, {own / 1024:.1f} MiB of its own, {all_ / 1024:.1f} MiB with the pages of libraries")
        if not SANITIZED:
            self.assertLess(share, 0.001)
            self.assertLess(all_, 12 * 1024)


class SettingsTest(FolderTest):
    def set(self, *options, expect=0, **more):
        return run(CONTOURD_WEB, "--set-mqtt", *options, "--mqtt-file", self.path("web-mqtt"), "--service-unit", self.path("unit"), "--password-file", self.path("none"),
                   **{"input": b"", **more}, expect=expect)  # fmt: skip

    def test_the_broker_is_stored_for_root_only_and_the_service_gets_a_network(self):
        self.assertEqual(self.set().stdout, b"off\n")
        said = self.set("--broker", "homeassistant.local", "--user", "printer", input=b"secret\n").stdout
        self.assert_words(said, b"homeassistant.local:1883", b"sudo contourctl web password", b"systemctl enable contourd-web.service")
        self.assertEqual(os.stat(self.path("web-mqtt")).st_mode & 0o777, 0o600)
        self.assertIn(b"password secret\n", contents(self.path("web-mqtt")))
        self.assert_words(contents(self.path("unit", "mqtt.conf")), f"LoadCredential=web-mqtt:{self.path('web-mqtt')}\n".encode(), b"PrivateNetwork=no\n", b"SocketBindDeny=any\n")
        shown = self.set().stdout
        self.assertEqual(shown, b"homeassistant.local:1883\nuser printer\n")
        self.assertIn(b"systemctl disable contourd-web.service", self.set("--off").stdout)
        self.assertEqual(os.listdir(self.path("unit")), [])
        self.assertFalse(os.path.exists(self.path("web-mqtt")))
        self.set("--off")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed")
    def test_systemd_understands_the_unit_with_its_network_and_rates_its_exposure_as_low(self):
        self.set("--broker", "host")
        for name in ("contourd-web.service", "contourd-web.socket"):
            shutil.copy(os.path.join(SOURCE, "systemd", name), self.folder)
        os.rename(self.path("unit"), self.path("contourd-web.service.d"))
        unit, environment = self.path("contourd-web.service"), {**os.environ, "SYSTEMD_UNIT_PATH": f"{self.folder}:"}
        rated = subprocess.run(["systemd-analyze", "security", "--no-pager", "--offline=true", "--threshold=20", unit], capture_output=True, text=True, check=False, env=environment)
        self.assertEqual(rated.returncode, 0, rated.stdout + rated.stderr)
        self.assertRegex(rated.stdout, r"PrivateNetwork= +Service has access to the host's network")
        verified = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True, check=False, env=environment)
        self.assertNotRegex(verified.stderr, r"mqtt\.conf|contourd-web\.service:\d")

    def test_a_broker_that_cannot_be_one_is_refused_and_changes_nothing(self):
        for broker in ("", ":1883", "a b", "host:0", "host:65536", "host:http", "[::1", "[::1]x", "-host", "mqtt://host", "x" * 254, "a\nbroker b"):
            with self.subTest(broker[:20]):
                result = self.set(f"--broker={broker}", expect=None)
                if broker:
                    self.assertNotEqual(result.returncode, 0)
                self.assertFalse(os.path.exists(self.path("web-mqtt")))
        for options in (("--prefix", "a/#"), ("--prefix", "/a"), ("--ca", "relative.pem"), ("--ca", self.path("none")), ("--user", "a\nb")):
            result = self.set("--broker", "host", *options, expect=None)
            self.assertNotEqual(result.returncode, 0)
            self.assert_one_line(result.stderr)
        self.assertNotEqual(self.set("--broker", "host", "--user", "a", input=b"x" * 300 + b"\n", expect=None).returncode, 0)
        self.assertFalse(os.path.exists(self.path("web-mqtt")))

    def test_ports_and_addresses_of_all_kinds_are_understood(self):
        for given, options, stored in (("host", (), b"host:1883"), ("192.168.1.5:1884", (), b"192.168.1.5:1884"), ("[fd00::1]:1884", (), b"[fd00::1]:1884"), ("fd00::1", (), b"[fd00::1]:1883"),
                                       ("host", ("--ca", "/etc/passwd"), b"host:8883\nTLS, certificates /etc/passwd")):  # fmt: skip
            self.set("--broker", given, *options)
            self.assertEqual(self.set().stdout, stored + b"\n")

    def test_a_file_that_others_can_read_or_that_is_broken_stops_the_service_with_a_sentence(self):
        run(CONTOURD_WEB, "--set-password", "--password-file", self.path("web-password"), "--avahi-service", self.path("none"), input=b"correct horse\n", expect=0)
        self.set("--broker", "host")
        good = contents(self.path("web-mqtt"))
        for mode, text, words in ((0o644, good, b"other users can read"), (0o600, b"", b"sudo contourctl web mqtt"), (0o600, good.replace(b"1883", b"x"), b"sudo contourctl web mqtt")):
            self.write("web-mqtt", text)
            os.chmod(self.path("web-mqtt"), mode)
            result = run(CONTOURD_WEB, "--password-file", self.path("web-password"), "--config", self.write("web.json", "{}"), "--mqtt-file", self.path("web-mqtt"), expect=78)
            self.assert_one_line(result.stderr, b"web-mqtt", words)

    def test_contourctl_passes_the_settings_on(self):
        for arguments in (["mqtt", "--user", "x"], ["mqtt", "host", "--off"]):
            self.assertEqual(run(CONTOURCTL, "web", *arguments).returncode, 64)


if __name__ == "__main__":
    unittest.main()
