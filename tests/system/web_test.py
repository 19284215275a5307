"""contourd-web with a real contourd: the page, uploads, slicers, and what strangers try."""

import contextlib
import glob
import hashlib
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import threading
import time
import unittest
import xml.etree.ElementTree

from harness import (
    BAD_CONFIG, BAD_DATA, BAD_USAGE, CONTOURCTL, CONTOURD_WEB, DEADLINE_S, FAILED, ENDLESS, NIMBLE_RESIN, SANITIZED, SLAB, SMALL, SOURCE, Daemon, FolderTest, binary_stl, box, contents, realtime, run, wait_until,
)  # fmt: skip
from sliced import pictures, sl1

PASSWORD = "correct horse"
# The exit code of contourd-web after an error that is no mistake on the command line.
CANNOT = 70
PAGE = os.path.join(SOURCE, "daemon", "web", "page")
PAGE_FILES = ["/", *(f"/{name}" for name in sorted(os.listdir(PAGE)) if name.endswith((".css", ".js", ".svg")))]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def in_terminal(command, **environment):
    """Returns what the command prints on a terminal."""
    mine, its = os.openpty()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=its, stderr=its, env={**os.environ, **environment})
    os.close(its)
    shown = b""
    with contextlib.suppress(OSError):  # the command has closed the terminal
        while data := os.read(mine, 4096):
            shown += data
    os.close(mine)
    process.wait(DEADLINE_S)
    return shown.decode().replace("\r", "")


class Browser:
    """A client with the cookie of its session, over a connection of its own for each request."""

    def __init__(self, port):
        self.port, self.cookie = port, None

    def request(self, method, path, body=None, headers=None):
        """Returns the status, the body and the headers of the reply."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=DEADLINE_S)
        try:
            cookie = {"Cookie": self.cookie} if self.cookie else {}
            connection.request(method, path, body, {**cookie, **(headers or {})})
            reply = connection.getresponse()
            return reply.status, reply.read(), reply.headers
        finally:
            connection.close()

    def get(self, path, **headers):
        return self.request("GET", path, headers=headers)

    def json(self, path):
        status, body, _ = self.get(path)
        assert status == 200, (path, status, body)
        return json.loads(body)

    def call(self, method, **parameters):
        return self.request("POST", f"/api/call/{method}", json.dumps(parameters))

    def log_in(self, password=PASSWORD):
        status, body, headers = self.request("POST", "/api/login", json.dumps({"password": password}))
        if status == 204:
            self.cookie = headers["Set-Cookie"].split(";")[0]
        return status, body, headers

    def upload(self, name, model, **headers):
        return self.request("POST", f"/api/upload?name={name}", model, headers)


def processor_s(process):
    """Returns the time for which the threads of a process have run, by the scheduler's clock."""
    threads = glob.glob(f"/proc/{process}/task/*/schedstat")
    return sum(int(pathlib.Path(thread).read_text(encoding="ascii").split()[0]) for thread in threads) / 1e9


class WebTest(FolderTest):
    options = ()  # further options of contourd-web

    def files(self):
        """Returns the options for the files by which the page is set up."""
        return ["--password-file", self.path("web-password"), "--socket-unit", self.path("unit"), "--avahi-service", self.path("avahi", "contourd.service")]

    def set_password(self, password=PASSWORD, expect=0):
        return run(CONTOURD_WEB, "--set-password", *self.files(), input=(password + "\n").encode(), expect=expect)

    def serve(self, daemon=None, started=True, **config):
        """Starts a daemon, unless one is given, and its page. Returns a client that has not logged in."""
        self.daemon = daemon or Daemon(self).start()
        self.write("web.json", json.dumps({"control_socket": "control.sock", "min_free_disk_mb": 0, **config}))
        if not os.path.exists(self.path("web-password")):
            self.key = re.search(rb"[0-9a-f]{32}", self.set_password().stdout)[0].decode()
        self.port = free_port()
        self.start_web()
        return Browser(self.port)

    def start_web(self, **environment):
        with open(self.path("web.log"), "ab") as log:
            self.web = self.killed_at_the_end(subprocess.Popen(
                [CONTOURD_WEB, "--config", self.path("web.json"), "--password-file", self.path("web-password"), "--listen", f"127.0.0.1:{self.port}", *self.options],
                stdout=log, stderr=log, env={**os.environ, **environment}))  # fmt: skip
        wait_until(self.answers, "the page")

    def answers(self):
        assert self.web.poll() is None, contents(self.path("web.log"))
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def logged_in(self, **config):
        browser = self.serve(**config)
        self.assertEqual(browser.log_in()[0], 204)
        return browser

    def incoming(self):
        return sorted(os.listdir(os.path.join(self.daemon.spool, "incoming")))

    def raw(self, data, timeout=DEADLINE_S):
        """Sends bytes on a new connection, and returns the connection."""
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=timeout)
        self.addCleanup(connection.close)
        connection.sendall(data)
        return connection


class LoginTest(WebTest):
    def test_the_page_is_off_until_a_password_is_set(self):
        result = run(CONTOURD_WEB, "--password-file", self.path("none"), "--config", self.write("web.json", "{}"))
        self.assertEqual(result.returncode, BAD_CONFIG)
        self.assert_one_line(result.stderr, b"the web page is off until a password is set: sudo contourctl web password")

    def test_the_password_is_stored_as_a_hash_that_only_its_owner_can_read(self):
        self.set_password()
        self.assertEqual(os.stat(self.path("web-password")).st_mode & 0o777, 0o600)
        text = contents(self.path("web-password"))
        self.assertNotIn(PASSWORD.encode(), text)
        self.assertRegex(text, rb"^password \$y\$\S+\nkey [0-9a-f]{32}\n$")

    def test_a_file_of_secrets_that_others_can_read_is_refused(self):
        self.set_password()
        os.chmod(self.path("web-password"), 0o644)
        result = run(CONTOURD_WEB, "--password-file", self.path("web-password"), "--config", self.write("web.json", "{}"), expect=BAD_CONFIG)
        self.assert_one_line(result.stderr, b"other users can read the secrets")

    def test_a_bad_password_changes_nothing(self):
        self.set_password()
        before = contents(self.path("web-password"))
        for password in ("", "short", "x" * 257, "with\x07bell"):
            with self.subTest(password[:10]):
                self.assert_one_line(self.set_password(password, BAD_DATA).stderr, b"password")
        self.assertEqual(contents(self.path("web-password")), before)

    def test_without_a_session_only_the_page_itself_is_served(self):
        stranger = self.serve()
        for path in PAGE_FILES:
            self.assertEqual(stranger.get(path)[0], 200, path)
        for method, path in (("GET", "/api/status"), ("GET", "/api/queue"), ("GET", "/api/history"), ("GET", "/api/mask"), ("GET", "/api/events"),
                             ("POST", "/api/call/cancel"), ("POST", "/api/upload?name=a.stl"), ("POST", "/api/logout"), ("GET", "/api/nothing"),
                             ("POST", "/api/files/local"), ("GET", "/api/version")):  # fmt: skip
            self.assertEqual(stranger.request(method, path)[0], 401, path)
        stranger.cookie = "contourd=" + "0" * 64
        self.assertEqual(stranger.get("/api/status")[0], 401)

    def test_a_session_begins_with_the_password_and_ends_with_the_logout(self):
        browser = self.serve()
        self.assertEqual(browser.log_in("wrong horse")[:2], (401, b"the password is wrong\n"))
        status, _, headers = browser.log_in()
        self.assertEqual(status, 204)
        self.assertRegex(headers["Set-Cookie"], r"^contourd=[0-9a-f]{64}; Path=/; HttpOnly; SameSite=Strict; Max-Age=604800$")
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        cookie = browser.cookie
        self.assertEqual(browser.request("POST", "/api/logout")[0], 204)
        browser.cookie = cookie
        self.assertEqual(browser.get("/api/status")[0], 401)

    def set_role(self, role, password, expect=0):
        return run(CONTOURD_WEB, "--set-password", "--role", role, *self.files(), input=(password + "\n").encode(), expect=expect)

    def test_the_roles_have_passwords_of_their_own_and_do_what_they_may(self):
        self.assert_one_line(self.set_role("watch", "watching only", expect=CANNOT).stderr, b"contourctl web password")
        self.set_password()
        self.key = re.search(r"(?m)^key (.*)$", pathlib.Path(self.path("web-password")).read_text(encoding="ascii"))[1]
        self.set_role("watch", "watching only")
        self.set_role("service", "service only")
        self.assertIn(b"another role", self.set_role("service", PASSWORD, expect=BAD_DATA).stderr)
        self.assertIn(b"another role", self.set_password("watching only", expect=BAD_DATA).stderr)
        self.assertIn(f"key {self.key}\n", pathlib.Path(self.path("web-password")).read_text(encoding="ascii"))
        self.serve(Daemon(self, realtime()).start())
        people = {role: Browser(self.port) for role in ("watch", "print", "service")}
        for role, password in (("watch", "watching only"), ("print", PASSWORD), ("service", "service only")):
            self.assertEqual(people[role].log_in(password)[0], 204)
            self.assertEqual(people[role].json("/api/session"), {"role": role})
        changes = ("accept", "cancel", "exclude", "pause", "plate_cleared", "queue_move", "queue_remove", "queue_ticket", "replaced", "resume", "set", "vat")
        for method in changes:
            status, body, _ = people["watch"].call(method)
            self.assertEqual(status, 403, method)
            self.assert_one_line(body, b"needs the role print", b"logged in as watch")
            self.assertNotEqual(people["print"].call(method, no=1)[0], 403, method)
        for role, method in (("watch", "home"), ("print", "home"), ("watch", "stop"), ("watch", "light_off")):
            self.assertEqual(people[role].call(method)[0], 403, (role, method))
        # Who may print may always end what was begun by hand.
        for method in ("light_off", "stop"):
            client = self.daemon.client()
            self.assertIn("result", client.call("light_on", seconds=5, in_resin=True))
            wait_until(lambda: people["print"].json("/api/status")["manual"]["state"] == "lit", "the light")
            self.assertEqual(people["print"].call(method)[0], 200, method)
            wait_until(lambda: people["print"].json("/api/status")["manual"]["dark"], "the dark")
            wait_until(lambda: people["print"].json("/api/status")["manual"]["state"] == "idle", "the end of the operation")
            client.close()
        self.assertEqual(people["print"].get("/api/inputs")[0], 403)
        self.assertEqual(people["service"].get("/api/inputs")[0], 200)
        for role in ("watch", "print"):
            self.assertEqual(people[role].get("/api/log")[0], 403)
        self.assertIn("light_off requested by", people["service"].get("/api/log")[1].decode())
        self.assertEqual(people["service"].call("home")[0], 200)
        for method in ("move", "light_on", "show", "upload", "motor_off", "rescue", "projector"):
            self.assertEqual(people["service"].call(method)[0], 404, method)
        self.assertEqual(people["watch"].upload("part.stl", SMALL)[0], 403)
        form = {"Content-Type": "multipart/form-data; boundary=x"}
        self.assertEqual(people["watch"].request("POST", "/api/files/local", b"--x--", form)[0], 401)
        self.assertEqual(self.incoming(), [])
        for path in ("status", "queue", "history", "resins", "usage", "vat"):
            self.assertEqual(people["watch"].get(f"/api/{path}")[0], 200, path)
        self.assertEqual(people["watch"].get("/api/status", **{"X-Api-Key": self.key})[0], 200)
        # The cookie of one role is none of another.
        self.assertEqual(Browser(self.port).get("/api/session")[0], 401)

    def test_a_role_is_removed_and_the_password_of_the_page_stays(self):
        self.set_password()
        self.set_role("watch", "watching only")
        run(CONTOURD_WEB, "--set-password", "--role", "watch", "--remove", *self.files())
        run(CONTOURD_WEB, "--set-password", "--role", "print", "--remove", *self.files(), expect=CANNOT)
        run(CONTOURD_WEB, "--set-password", "--role", "root", *self.files(), expect=BAD_USAGE)
        self.serve()
        self.assertEqual(Browser(self.port).log_in("watching only")[0], 401)
        self.assertEqual(Browser(self.port).log_in()[0], 204)

    def test_wrong_passwords_are_slowed_down_before_they_are_hashed(self):
        browser = self.serve()
        replies = [browser.log_in(f"wrong horse {number}") for number in range(7)]
        self.assertEqual([reply[0] for reply in replies[:5]], [401] * 5)
        self.assertEqual(replies[-1][0], 429)
        self.assert_one_line(replies[-1][1], b"wait")
        self.assertGreaterEqual(int(replies[-1][2]["Retry-After"]), 1)
        self.assertEqual(browser.log_in()[0], 429, "the right password must not get through before the wait is over")

    def test_tries_at_the_same_time_are_counted_too(self):
        browser = self.serve()
        got = []

        def guess(number):
            # 503: too many are checked at this moment.
            got.append(wait_until(lambda: (status := browser.log_in(f"wrong horse {number}")[0]) != 503 and status, "a check"))

        threads = [threading.Thread(target=guess, args=(number,)) for number in range(20)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertLessEqual(got.count(401), 6, got)
        self.assertEqual(len(got), 20)


class UnitTest(WebTest):
    """What systemd does for the service, done by hand: tests/vm has the real one."""

    @unittest.skipUnless(os.geteuid() == 0, "only root can make a network namespace")
    def test_sockets_that_the_manager_passes_are_enough_in_a_process_without_a_network(self):
        self.daemon = Daemon(self).start()
        self.write("web.json", json.dumps({"control_socket": "control.sock", "min_free_disk_mb": 0}))
        self.set_password()
        with socket.socket() as listener:
            listener.bind(("127.0.0.1", 0))
            listener.listen()
            self.port = listener.getsockname()[1]
            script = 'LISTEN_PID=$$ LISTEN_FDS=1 exec unshare --net "$@" 3<&%d' % listener.fileno()
            self.web = self.killed_at_the_end(subprocess.Popen(
                ["bash", "-c", script, "-", CONTOURD_WEB, "--config", self.path("web.json"), "--password-file", self.path("web-password")],
                pass_fds=[listener.fileno()]))  # fmt: skip
        browser = Browser(self.port)
        self.assertEqual(browser.log_in()[0], 204)
        self.assertEqual(browser.upload("part.stl", SMALL)[0], 201)
        self.assertEqual(self.daemon.wait_ended("part")["outcome"], "done")

    def test_idle_without_pages_it_uses_no_processor_and_little_memory(self):
        self.serve()
        begin, before = time.monotonic(), processor_s(self.web.pid)
        wait_until(lambda: time.monotonic() > begin + 3, "three seconds")
        self.assertLess(processor_s(self.web.pid) - before, 0.001 * (time.monotonic() - begin))
        with open(f"/proc/{self.web.pid}/status", encoding="utf-8") as status:
            memory = int(re.search(r"VmRSS:\s+(\d+)", status.read())[1])
        print(f"{memory / 1024:.1f} MiB with the pages of libraries when idle")
        if not SANITIZED:
            self.assertLess(memory, 12 * 1024)

    def test_the_process_that_faces_the_network_has_no_code_for_devices_or_model_files(self):
        self.serve()
        libraries = set(re.findall(r"/lib([a-z_]+)[^/\s]*\.so", contents(f"/proc/{self.web.pid}/maps").decode()))
        self.assertIn("microhttpd", libraries)
        self.assertEqual(libraries & {"drm", "expat", "gpiod", "png", "serialport", "sqlite", "zip"}, set())


class AddressesTest(WebTest):
    def set(self, *addresses, expect=0):
        options = [word for each in addresses for word in ("--address", each)]
        return run(CONTOURD_WEB, "--set-addresses", *options, *self.files(), expect=expect)

    def announced(self):
        """Returns the types and ports of the services that avahi announces; none without a file."""
        path = self.path("avahi", "contourd.service")
        if not os.path.exists(path):
            return []
        self.assertEqual(os.stat(path).st_mode & 0o777, 0o644)
        group = xml.etree.ElementTree.parse(path).getroot()
        self.assertEqual((group.tag, group.find("name").text, group.find("name").get("replace-wildcards")), ("service-group", "contourd on %h", "yes"))
        return [(service.find("type").text, int(service.find("port").text)) for service in group.findall("service")]

    def test_the_page_is_announced_while_it_has_a_password_and_an_address_for_others(self):
        self.set("127.0.0.1:8080", "192.0.2.1:81")
        self.assertEqual(self.announced(), [], "there is no password yet")
        self.set_password()
        self.assertEqual(self.announced(), [("_http._tcp", 81)])
        self.set("[fd00::1]:81", "0.0.0.0:81", "192.0.2.1:8080")
        self.assertEqual(self.announced(), [("_http._tcp", 8080), ("_http._tcp", 81)])
        self.set("127.0.0.1:8080", "[::1]:81", "127.1.2.3:82")
        self.assertEqual(self.announced(), [])
        self.set("0.0.0.0:80")
        self.assertEqual(self.announced(), [("_http._tcp", 80)])
        said = run(CONTOURD_WEB, "--turn-off", *self.files(), expect=0).stdout
        self.assertIn(b"systemctl stop contourd-web.socket contourd-web.service", said)
        self.assertEqual(self.announced(), [])
        self.assertFalse(os.path.exists(self.path("web-password")))
        run(CONTOURD_WEB, "--turn-off", *self.files(), expect=0)

    def modules(self, shown):
        """Returns the dark modules of a QR code on a terminal, as rows of truth values."""
        glyphs = {" ": (False, False), "\u2580": (True, False), "\u2584": (False, True), "\u2588": (True, True)}
        lines = re.findall(r"\x1b\[30;107m(.*?)\x1b\[0m", shown)
        return [[glyphs[letter][half] for letter in line] for line in lines for half in (0, 1)]

    def test_a_terminal_shows_the_first_address_for_others_as_a_qr_code(self):
        self.set("127.0.0.1:8080", "192.0.2.1:8080", "[fd00::1]:80")
        show = [CONTOURD_WEB, "--set-addresses", *self.files()]
        shown = in_terminal(show, TERM="xterm", LC_ALL="C.UTF-8")
        self.assert_words(shown, "http://192.0.2.1:8080/")
        rows = self.modules(shown)
        width = len(rows[0])
        self.assertEqual({len(row) for row in rows}, {width})
        self.assertLess(width, 50)
        self.assertFalse(any(any(row) for row in rows[:4]) or any(any(row[:4] + row[-4:]) for row in rows), "a code needs a margin of four modules")
        finder = [[max(abs(row - 3), abs(column - 3)) != 2 for column in range(7)] for row in range(7)]
        for top, left in ((4, 4), (4, width - 11), (width - 11, 4)):
            self.assertEqual([row[left : left + 7] for row in rows[top : top + 7]], finder)
        self.set("[fd00::1]:80")
        self.assertNotEqual(self.modules(in_terminal(show, TERM="xterm", LC_ALL="C.UTF-8")), rows)

    def test_there_is_no_qr_code_where_it_cannot_be_shown_or_opened(self):
        self.set("192.0.2.1:8080")
        show = [CONTOURD_WEB, "--set-addresses", *self.files()]
        for environment in ({"TERM": "dumb", "LC_ALL": "C.UTF-8"}, {"TERM": "xterm", "LC_ALL": "C"}):
            self.assertEqual(in_terminal(show, **environment), "192.0.2.1:8080\n")
        self.assertEqual(self.set().stdout, b"192.0.2.1:8080\n")
        self.set("127.0.0.1:8080")
        self.assertEqual(in_terminal(show, TERM="xterm", LC_ALL="C.UTF-8"), "127.0.0.1:8080\n")

    def test_the_addresses_replace_those_of_the_unit(self):
        self.assertEqual(self.set().stdout, b"127.0.0.1:8080\n")
        self.assertIn(b"systemctl restart contourd-web.socket", self.set("127.0.0.1:8080", "[::1]:81").stdout)
        self.assertEqual(self.set().stdout, b"127.0.0.1:8080\n[::1]:81\n")
        # An empty setting removes those of the unit.
        lines = contents(self.path("unit", "addresses.conf")).decode().splitlines()
        self.assertEqual([line for line in lines if line.startswith("ListenStream")], ["ListenStream=", "ListenStream=127.0.0.1:8080", "ListenStream=[::1]:81"])

    def test_what_is_no_address_is_refused_and_changes_nothing(self):
        for address in ("printer:80", "127.0.0.1", "127.0.0.1:http", ":80", "", "1.2.3.4:80\nExecStart=x", "[::1:80"):
            with self.subTest(address):
                result = run(CONTOURD_WEB, "--set-addresses", f"--address={address}", "--socket-unit", self.path("unit"))
                self.assertNotEqual(result.returncode, 0)
        self.assertFalse(os.path.exists(self.path("unit")))

    def test_contourctl_runs_the_program_of_the_page_or_says_that_it_is_missing(self):
        result = run(CONTOURCTL, "web", "addresses")
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        alone = self.path("contourctl")
        shutil.copy(CONTOURCTL, alone)
        result = run(alone, "web", "password", env={**os.environ, "PATH": self.folder})
        self.assert_refusal(result, FAILED, b"install the package contourd-web")


class StrangersTest(WebTest):
    def test_every_reply_forbids_frames_foreign_sources_and_guessed_types(self):
        browser = self.serve()
        for path in ("/", "/api/status", "/nothing"):
            headers = browser.get(path)[2]
            self.assert_words(headers["Content-Security-Policy"], "default-src 'self'", "frame-ancestors 'none'")
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertIsNone(headers["Access-Control-Allow-Origin"])

    def test_a_request_for_another_host_is_refused(self):
        browser = self.logged_in(names=["Printer.Example.org"])
        for host in ("evil.example", "127.0.0.1.evil.example", "127.0.0.2", "localhost.evil.example", "", "[::1]", "a b", "localhost:8080:1", "x" * 300):
            with self.subTest(host[:30]):
                self.assertEqual(browser.get("/api/status", Host=host)[0], 403)
                self.assertEqual(browser.get("/", Host=host)[0], 403)
        name = socket.gethostname().lower()
        for host in ("127.0.0.1", f"127.0.0.1:{self.port}", "localhost:80", name, f"{name}.local", f"{name}.local.", name.upper(), "printer.example.org"):
            with self.subTest(host):
                self.assertEqual(browser.get("/api/status", Host=host)[0], 200)

    def test_a_request_that_another_site_made_a_browser_send_is_refused(self):
        browser = self.logged_in()
        own = f"http://127.0.0.1:{self.port}"
        for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"}, {"Sec-Fetch-Site": "cross-site"},
                        {"Sec-Fetch-Site": "same-site"}, {"Origin": own, "Sec-Fetch-Site": "cross-site"}):  # fmt: skip
            with self.subTest(headers):
                self.assertEqual(browser.request("POST", "/api/call/cancel", "{}", headers)[0], 403)
                self.assertEqual(browser.request("POST", "/api/login", json.dumps({"password": PASSWORD}), headers)[0], 403)
                self.assertEqual(browser.upload("a.stl", SMALL, **headers)[0], 403)
                self.assertEqual(browser.get("/api/events", **headers)[0], 403)
        self.assertEqual(browser.request("POST", "/api/call/cancel", "{}", {"Origin": own, "Sec-Fetch-Site": "same-origin"})[0], 409)
        self.assertEqual(self.incoming(), [])

    def test_only_the_methods_of_the_list_are_passed_on(self):
        browser = self.logged_in()
        for method in ("move", "light_on", "show", "upload", "projector", "motor_off", "go_on", "rescue", "report", "watch", "methods", "", "../status", "pause/"):
            status, sentence, _ = browser.call(method)
            self.assertEqual(status, 404, method)
            self.assert_one_line(sentence, f'no method "{method}"')
        for method, path in (("PUT", "/api/status"), ("DELETE", "/api/queue"), ("POST", "/"), ("TRACE", "/")):
            self.assertIn(browser.request(method, path)[0], (404, 405, 501), (method, path))

    def test_bad_requests_get_one_sentence(self):
        browser = self.logged_in()
        for body in ("[", "[]", "7", '"x"', "\xff", "{" * 2000):
            self.assertEqual(browser.request("POST", "/api/call/pause", body.encode("latin-1"))[0], 400, body[:9])
        status, body, _ = browser.call("pause")
        self.assertEqual((status, body), (409, b"there is no print to pause\n"))
        status, body, _ = browser.call("queue_move", job="a", to=-1)
        self.assertEqual(status, 400)
        self.assert_one_line(body, b"to must be")
        self.assertEqual(browser.request("POST", "/api/call/pause", "x" * 8193)[0], 413)
        self.assertEqual(browser.get("/api/history?before=x")[0], 400)

    def test_a_chunked_body_beyond_its_limit_is_refused_with_a_sentence(self):
        browser = self.logged_in(largest_upload_mb=1)
        head = "Host: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n"
        slow = f"POST /api/upload?name=a.stl HTTP/1.1\r\n{head}Cookie: {browser.cookie}\r\n\r\n"
        form = f"POST /api/files/local HTTP/1.1\r\n{head}X-Api-Key: {self.key}\r\nContent-Type: multipart/form-data; boundary=x\r\n\r\n"
        small = f"POST /api/call/pause HTTP/1.1\r\n{head}Cookie: {browser.cookie}\r\n\r\n"
        for request, size in ((slow, 4 << 20), (form, 4 << 20), (small, 9000), (f"POST /api/login HTTP/1.1\r\n{head}\r\n", 200_000)):
            for end in (b"\r\n0\r\n\r\n", b""):  # a body that ends, and one that waits for the reply
                connection = self.raw(request.encode() + f"{size:x}\r\n".encode() + b"x" * size + end)
                reply = b""
                while not reply.endswith(b"bytes\n"):
                    piece = connection.recv(65536)
                    self.assertTrue(piece, (request, reply))
                    reply += piece
                self.assertTrue(reply.startswith(b"HTTP/1.1 413 "), reply)
                self.assert_one_line(reply.partition(b"\r\n\r\n")[2], b"at most")
        self.assertEqual(self.incoming(), [])

    def test_a_client_that_goes_on_after_the_refusal_of_its_body_is_cut_off(self):
        self.serve()
        connection = self.raw(b"POST /api/login HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n")
        began = time.monotonic()
        with self.assertRaises(OSError):
            while time.monotonic() < began + DEADLINE_S:
                connection.sendall(b"10000\r\n" + b"x" * 65536 + b"\r\n")
                time.sleep(0.01)
        self.assertLess(time.monotonic() - began, 5 + 5)

    def test_the_files_of_the_page_come_over_one_connection(self):
        self.serve()
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=DEADLINE_S)
        self.addCleanup(connection.close)
        connection.connect()
        socket_ = connection.sock
        for path in (*PAGE_FILES, "/api/session", "/nothing", "/"):
            connection.request("GET", path)
            reply = connection.getresponse()
            reply.read()
            self.assertIs(connection.sock, socket_, path)

    def test_large_headers_many_headers_and_noise_are_refused(self):
        browser = self.serve()
        for data in (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 100_000 + b"\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"X: y\r\n" * 20_000 + b"\r\n",
                     b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
                     os.urandom(4096) + b"\r\n\r\n", b"\0" * 4096, b"\r\n" * 4096):  # fmt: skip
            connection = self.raw(b"")
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
                reply = connection.recv(65536)
            except OSError:
                reply = b""
            self.assertNotRegex(reply, rb"^HTTP/1.1 200")
        self.assertEqual(browser.get("/")[0], 200)

    def test_a_client_that_sends_its_headers_slowly_is_cut_off(self):
        browser = self.serve()
        began = time.monotonic()
        slow = self.raw(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        slow.settimeout(0.5)
        while True:
            try:
                slow.sendall(b"X: y\r\n")
                if slow.recv(1) == b"":
                    break
            except TimeoutError:
                continue
            except OSError:
                break
        took = time.monotonic() - began
        self.assertGreater(took, 8)
        self.assertLess(took, 10 + 5)
        self.assertEqual(browser.get("/")[0], 200)

    def test_two_hundred_silent_clients_keep_no_one_out(self):
        browser = self.logged_in()
        events = self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\n\r\n".encode())
        wait_until(lambda: b"data:" in events.recv(65536), "the first event")
        silent = [self.raw(b"GET / HTTP/1.1\r\n") for _ in range(200)]
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        self.assertEqual(Browser(self.port).log_in()[0], 204)
        with open(f"/proc/{self.web.pid}/status", encoding="utf-8") as status:
            descriptors = len(os.listdir(f"/proc/{self.web.pid}/fd"))
            self.assertLess(int(re.search(r"VmRSS:\s+(\d+)", status.read())[1]), 60_000 * (4 if SANITIZED else 1))
        self.assertLess(descriptors, 160)
        # The page that has logged in still gets its events.
        self.daemon.printed("after.stl", SMALL)
        wait_until(lambda: b"after" in events.recv(65536), "an event")
        del silent


class PageTest(WebTest):
    def test_the_fields_of_a_job_have_the_limits_of_its_ticket(self):
        keys = json.loads(contents(os.path.join(SOURCE, "config", "ticket.schema.json")))["properties"]
        fields = {"copies": keys["copies"], "wall": keys["hollow"]["properties"]["wall_mm"]}
        page = contents(os.path.join(PAGE, "job.js")).decode()
        for name, key in fields.items():
            least, most = re.search(rf'this\.{name}, {{type: "number", min: ([\d.]+), max: ([\d.]+)', page).groups()
            self.assertEqual((float(least), float(most)), (key["minimum"], key["maximum"]), name)

    def test_the_page_is_small_and_asks_for_nothing_from_elsewhere(self):
        browser = self.serve()
        files = [browser.get(path)[1] for path in PAGE_FILES]
        self.assertLess(sum(map(len, files)), 150_000)
        for text in files:
            self.assertEqual(re.findall(rb"(?:https?:)?//[\w.-]+\.\w+|@import|url\(", text.replace(b"http://www.w3.org/2000/svg", b"")), [])

    def test_a_print_is_changed_within_the_bounds_of_its_resin(self):
        browser = self.serve(Daemon(self, realtime(), {**ENDLESS, "ticket_limits": {"lift_mm": [1, 3]}}).start())
        self.assertEqual(browser.log_in()[0], 204)
        for method, parameters in (("set", {"setting": "exposure", "value": 90}), ("exclude", {"copy": "1"}), ("pause", {"at_layer": 2})):
            self.assertEqual(browser.call(method, **parameters)[0], 409)
        self.daemon.begin("part.stl", SLAB, {"copies": 2})
        self.assertEqual([each["name"] for each in browser.json("/api/copies")["copies"]], ["part (copy 1)", "part (copy 2)"])
        self.assertEqual(browser.call("set", setting="lift", value=2.5)[0], 200)
        self.assertEqual(browser.call("exclude", copy="2")[0], 200)
        self.assertEqual(browser.call("pause", at_layer=7)[0], 200)
        job = self.daemon.status()["job"]
        self.assertEqual((job["planned_pause"], job["excluded"]), ("before layer 7", ["part (copy 2)"]))
        for method, parameters, code in (("set", {"setting": "lift", "value": 50}, 409), ("set", {"setting": "lift", "value": "2"}, 400), ("set", {"setting": "lift"}, 400),
                                         ("set", {"setting": "lamp", "value": 2}, 400), ("set", {"setting": "lift", "value": 1e300}, 400), ("set", {"setting": "lift", "value": -1}, 400),
                                         ("exclude", {"copy": "1"}, 409), ("exclude", {"copy": 1}, 400), ("exclude", {"copy": "x" * 5000}, 409), ("pause", {"at_layer": 0}, 400),
                                         ("pause", {"at_layer": 1}, 409), ("pause", {"at_layer": 21}, 409), ("pause", {"at_layer": 2.5}, 400), ("pause", {"at_layer": {}}, 400)):  # fmt: skip
            status, body, _ = browser.call(method, **parameters)
            self.assertEqual(status, code, (method, parameters, body))
            self.assert_one_line(body)
        self.assertEqual(self.daemon.status()["job"]["planned_pause"], "before layer 7")
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def test_the_report_of_a_print_is_served_without_the_rights_of_the_page(self):
        browser = self.logged_in()
        self.daemon.printed("my part.stl", SLAB)
        wait_until(lambda: browser.get("/api/report?job=my%20part")[0] == 200, "the report")
        status, page, headers = browser.get("/api/report?job=my%20part")
        # The report may be written again when the cured part has been computed.
        self.assertEqual((status, page[:15], page.rstrip()[-7:]), (200, b"<!doctype html>", contents(self.daemon.file("done", "my part.report.html")).rstrip()[-7:]))
        text = b"<!doctype html>" + os.urandom(150_000)
        with open(self.daemon.file("failed", "long.report.html"), "wb") as file:
            file.write(text)
        self.assertEqual(browser.get("/api/report?job=long")[1], text)  # in several pieces
        self.assertTrue(headers["Content-Security-Policy"].startswith("sandbox; default-src 'none';"))
        self.assertEqual(len(headers.get_all("Content-Security-Policy")), 1)
        os.symlink(self.path("web-password"), self.daemon.file("done", "link.report.html"))
        os.mkfifo(self.daemon.file("failed", "pipe.report.html"))
        for job in ("", "no", "..", ".", "../done/my%20part", "..%2F..%2Fweb-password", "/etc/passwd", "link", "pipe", "my%20part%00", "x" * 500, "my%20part.report.html"):
            status, body, _ = browser.get(f"/api/report?job={job}")
            if job == "my%20part%00":
                self.assertIn(status, (200, 400, 409))  # libmicrohttpd ends a parameter at a NUL
                continue
            self.assertIn(status, (400, 409), (job, body[:200]))
            self.assert_one_line(body)
            self.assertNotIn(b"$y$", body)
        self.assertEqual(Browser(self.port).get("/api/report?job=my%20part")[0], 401)

    def test_a_flood_of_reports_takes_little_memory(self):
        browser = self.logged_in()
        self.daemon.printed("part.stl", SMALL)
        with open(self.daemon.file("done", "large.report.html"), "wb") as file:
            file.write(b"x" * 8_000_000)
        with open(self.daemon.file("done", "huge.report.html"), "wb") as file:
            file.write(b"x" * 9_000_000)
        self.assertEqual(browser.get("/api/report?job=huge")[0], 502)
        replies = []
        def fetch():
            replies.append(browser.get("/api/report?job=large")[0])
        threads = [threading.Thread(target=fetch) for _ in range(30)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(set(replies), {200, 503})
        self.assertEqual(browser.get("/api/report?job=large")[0], 200)  # the places are free again
        status = pathlib.Path(f"/proc/{self.web.pid}/status").read_text(encoding="ascii")
        if not SANITIZED:
            self.assertLess(int(re.search(r"VmHWM:\s+(\d+)", status)[1]), 120_000)

    def test_vat_wear_and_resins_are_shown_and_changed(self):
        browser = self.logged_in()
        self.assertEqual(browser.json("/api/vat"), {"ml": None})
        self.assertEqual(browser.call("vat", filled_ml=150)[0], 200)
        self.assertEqual(browser.json("/api/vat"), {"ml": 150})
        self.assertEqual(browser.call("replaced", part="film")[0], 200)
        self.assertIsNotNone(next(each for each in browser.json("/api/usage")["parts"] if each["part"] == "film")["replaced"])
        for method, parameters in (("vat", {"filled_ml": -1}), ("vat", {"filled_ml": "1"}), ("vat", {"filled_ml": 1e9}), ("replaced", {"part": "light"}), ("replaced", {"part": ["film"]}), ("replaced", {})):
            status, body, _ = browser.call(method, **parameters)
            self.assertEqual(status, 400, (method, parameters, body))
            self.assert_one_line(body)

    def test_events_follow_the_printer(self):
        browser = self.serve(Daemon(self, realtime(), {"exposure_ms": 120000, "bottom_exposure_ms": 120000}).start())
        self.assertEqual(browser.log_in()[0], 204)
        events = self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\n\r\n".encode())
        seen = b""

        def arrived(text):
            nonlocal seen
            seen += events.recv(65536)
            return text in seen

        wait_until(lambda: arrived(b'"state":"idle"'), "the first event")
        self.assertIn(b"text/event-stream", seen)
        self.daemon.begin("part.stl", SLAB)
        wait_until(lambda: arrived(b'"state":"exposing"'), "the exposure")
        status, body, _ = browser.get("/api/mask")
        self.assertEqual((status, body[:8]), (200, b"\x89PNG\r\n\x1a\n"))
        self.assertEqual(browser.call("pause")[0], 200)
        wait_until(lambda: arrived(b'"pause_pending":true'), "the pause")
        self.assertEqual(browser.call("cancel")[0], 200)
        wait_until(lambda: arrived(b'"outcome":"cancelled"'), "the end")
        self.assertEqual(browser.get("/api/mask")[0], 404)
        self.assertEqual([job["job"] for job in browser.json("/api/history")["ended"]], ["part"])

    def test_while_contourd_is_down_the_page_says_so_and_recovers(self):
        browser = self.logged_in()
        self.daemon.stop()
        status, body, _ = browser.get("/api/status")
        self.assertEqual(status, 503)
        self.assert_one_line(body, b"contourd")
        events = self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\n\r\n".encode())
        wait_until(lambda: b'"unreachable"' in events.recv(65536), "the event")
        self.daemon.start()
        wait_until(lambda: b'"state":"idle"' in events.recv(65536), "the recovery")
        self.assertEqual(browser.get("/api/status")[0], 200)

    def test_too_many_open_pages_are_refused(self):
        browser = self.logged_in()
        pages = []
        for _ in range(16):
            pages.append(self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\n\r\n".encode()))
            self.assertIn(b" 200 ", pages[-1].recv(65536).split(b"\r\n")[0])
        self.assertEqual(browser.get("/api/events")[0], 503)
        self.assertEqual(browser.get("/api/status")[0], 200)

    def test_the_events_of_a_session_end_with_it(self):
        browser = self.serve(Daemon(self, realtime(), ENDLESS).start())
        self.assertEqual(browser.log_in()[0], 204)
        other = Browser(self.port)
        self.assertEqual(other.log_in()[0], 204)
        ask = lambda access: self.raw(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1\r\n{access}\r\n\r\n".encode())
        events, kept, slicer = ask(f"Cookie: {browser.cookie}"), ask(f"Cookie: {other.cookie}"), ask(f"X-Api-Key: {self.key}")
        for each in (events, kept, slicer):
            wait_until(lambda: b'"state":"idle"' in each.recv(65536), "the first event")
        self.assertEqual(browser.request("POST", "/api/logout")[0], 204)
        self.daemon.begin("part.stl", SLAB)
        for each in (kept, slicer):
            wait_until(lambda: b'"state":"exposing"' in each.recv(65536), "the exposure")
        seen = b""

        def ended():
            nonlocal seen
            seen += events.recv(65536)
            return seen.endswith(b"0\r\n\r\n")

        wait_until(ended, "the end of the events")
        self.assertNotIn(b"part", seen)

    def test_the_service_stops_at_once_with_clients_of_every_kind(self):
        browser = self.logged_in()
        request = f"Host: 127.0.0.1\r\nCookie: {browser.cookie}\r\n"
        kept = [self.raw(f"GET /api/events HTTP/1.1\r\n{request}\r\n".encode()),
                self.raw(f"POST /api/upload?name=a.stl HTTP/1.1\r\n{request}Content-Length: 1000\r\n\r\nabc".encode()), self.raw(b"GET")]  # fmt: skip
        wait_until(lambda: b"data:" in kept[0].recv(65536), "the first event")
        self.web.send_signal(signal.SIGTERM)
        self.assertEqual(self.web.wait(DEADLINE_S), 0)
        self.assertEqual(self.incoming(), [])

    def test_pictures_and_a_part_of_the_time_lapse_are_served(self):
        browser = self.logged_in()
        folder = self.daemon.file("done", "part.pictures")
        os.mkdir(folder)
        picture, film = b"\xff\xd8\xff" + os.urandom(200_000), b"0123456789" * 10_000
        for name, content in (("00003.jpg", picture), ("time-lapse.mp4", film)):
            self.write(os.path.join(folder, name), content)
        self.assertEqual(browser.json("/api/pictures?job=part"), {"job": "part", "layers": [3], "time_lapse": True})
        for path in ("/api/picture?job=part&layer=3", "/api/picture?job=part"):
            status, body, headers = browser.get(path)
            self.assertEqual((status, body, headers["Content-Type"]), (200, picture, "image/jpeg"))
        status, body, headers = browser.get("/api/time_lapse?job=part")
        self.assertEqual((status, body, headers["Content-Type"], headers["Accept-Ranges"]), (200, film, "video/mp4", "bytes"))
        status, body, headers = browser.get("/api/time_lapse?job=part", Range="bytes=50001-50003")
        self.assertEqual((status, body, headers["Content-Range"], headers["Content-Length"]), (206, b"123", "bytes 50001-50003/100000", "3"))
        status, body, headers = browser.get("/api/time_lapse?job=part", Range="bytes=100000-")
        self.assertEqual((status, headers["Content-Range"]), (416, "bytes */100000"))
        for path, status in (("/api/picture?job=part&layer=4", 409), ("/api/picture?job=../done/part", 409), ("/api/picture?job=part&layer=x", 400), ("/api/picture", 400), ("/api/time_lapse?job=no", 409)):
            refused = browser.get(path)
            self.assertEqual(refused[0], status, path)
            self.assert_one_line(refused[1])
        self.assertEqual(Browser(self.port).get("/api/picture?job=part")[0], 401)


class UploadTest(WebTest):
    def test_an_uploaded_model_is_printed(self):
        browser = self.logged_in()
        status, body, _ = browser.upload("my%20part.stl", SMALL)
        self.assertEqual((status, json.loads(body)), (201, {"job": "my part"}))
        self.assertEqual(self.daemon.wait_ended("my part")["outcome"], "done")
        self.assertEqual(contents(os.path.join(self.daemon.spool, "done", "my part.stl")), SMALL)
        # The same name again is another job.
        self.assertEqual(json.loads(browser.upload("my%20part.stl", SMALL)[1]), {"job": "my part-2"})

    def test_an_upload_to_be_confirmed_waits_with_its_outlook_its_ticket_and_its_picture(self):
        browser = self.logged_in()
        status, body, _ = browser.request("POST", "/api/upload?name=part.stl&confirm=1", SLAB)
        self.assertEqual((status, json.loads(body)), (201, {"job": "part"}))
        job = self.daemon.wait_job("part")
        self.assertEqual(job["asks"], ["to_be_confirmed"])
        self.assertEqual(browser.json("/api/ticket?job=part.stl")["ticket"], {"confirm": True})
        for query, waits in (("&confirm", True), ("&confirm=true", True), ("&confirm=0", False), ("&confirm=false", False), ("", False)):
            status, body, _ = browser.request("POST", f"/api/upload?name=other.stl{query}", SMALL)
            self.assertEqual(status, 201, body)
            name = json.loads(body)["job"]
            if waits:
                self.assertEqual(self.daemon.wait_job(name)["asks"], ["to_be_confirmed"])
                self.assertEqual(browser.call("queue_remove", job=f"{name}.stl")[0], 200)
            else:
                self.daemon.wait_done(name)
        status, picture, headers = browser.get("/api/preview?job=part.stl")
        self.assertEqual((status, headers["Content-Type"], picture[:8]), (200, "image/png", b"\x89PNG\r\n\x1a\n"))
        self.assertEqual([each["resin"] for each in browser.json("/api/resins")["resins"]], ["standard"])
        # A second one of this name is another job, with a ticket of its own.
        self.assertEqual(json.loads(browser.request("POST", "/api/upload?name=part.stl&confirm=1", SLAB)[1]), {"job": "part-2"})
        self.daemon.wait_job("part-2")
        status, body, _ = browser.call("queue_ticket", job="part.stl", ticket={"confirm": True, "copies": 2})
        self.assertEqual(status, 200, body)
        wait_until(lambda: self.daemon.job("part").get("parts") == 2 and self.daemon.job("part")["state"] == "unaccepted", "two copies")
        self.assertEqual(browser.call("accept", job="part.stl")[0], 200)
        self.daemon.wait_done("part")
        self.assertEqual(self.incoming(), ["part-2.json", "part-2.stl"])

    def test_tickets_and_pictures_of_strange_jobs_are_refused_with_a_sentence(self):
        browser = self.serve(Daemon(self, realtime(), ENDLESS).start())
        for path in ("/api/ticket?job=part.stl", "/api/preview?job=part.stl", "/api/resins"):
            self.assertEqual(browser.get(path)[0], 401)
        self.assertEqual(browser.log_in()[0], 204)
        self.daemon.begin("first.stl", SMALL)
        self.assertEqual(browser.request("POST", "/api/upload?name=part.stl&confirm=1", SMALL)[0], 201)
        self.daemon.wait_job("part")
        for path in ("/api/ticket", "/api/preview"):
            for query, code in (("", 400), ("?job=", 400), ("?job=first", 409), ("?job=..%2Fpart.stl", 409), ("?job=../../web-password", 409), ("?job=%00", 409), ("?job=" + "x" * 3000, 409)):
                status, body, _ = browser.get(path + query)
                # libmicrohttpd ends a parameter at a NUL.
                self.assertIn(status, (code, 400), (path, query, body))
                self.assert_one_line(body)
        for body, code in ((b"[]", 400), (b"{", 400), (b'{"job": "part.stl"}', 400), (b'{"job": 1, "ticket": {}}', 400), (b'{"job": "part.stl", "ticket": []}', 400),
                           (b'{"job": "part.stl", "ticket": {"model": "../../etc/passwd", "copies": -1}}', 409), (b'{"job": "first", "ticket": {}}', 409),
                           (b'{"job": "part.stl", "ticket": {}, "more": 1}', 400), (json.dumps({"job": "part.stl", "ticket": {"resin": "x" * 9000}}).encode(), 413)):  # fmt: skip
            status, reply, _ = browser.request("POST", "/api/call/queue_ticket", body)
            self.assertEqual(status, code, (body[:80], reply))
            self.assert_one_line(reply)
        self.assertEqual(json.loads(self.daemon.read("incoming", "part.json")), {"confirm": True})
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def test_pictures_of_many_jobs_at_once_are_drawn_one_after_the_other(self):
        browser = self.serve(Daemon(self, realtime(), ENDLESS).start())
        self.assertEqual(browser.log_in()[0], 204)
        self.daemon.begin("first.stl", SMALL)
        names = [f"part{i}" for i in range(12)]
        for name in names:
            self.assertEqual(browser.request("POST", f"/api/upload?name={name}.stl&confirm=1", SMALL)[0], 201)
        for name in names:
            self.daemon.wait_job(name)
        replies = []
        def fetch(name):
            replies.append(browser.get(f"/api/preview?job={name}.stl")[0])
        threads = [threading.Thread(target=fetch, args=(name,)) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(set(replies), {200})
        self.assertEqual(self.daemon.status()["state"], "exposing")

    def test_names_that_lead_elsewhere_or_are_no_models_are_refused(self):
        browser = self.logged_in()
        for name in ("..%2f..%2fetc%2fpasswd.stl", "%2Fetc%2Fx.stl", "..%5Cx.stl", ".hidden.stl", "..", ".stl", "a%00.stl", "a%0A.stl", "a%1b[2J.stl", "%ff%fe.stl",
                     "x" * 300 + ".stl", "part.exe", "part", "part.json", "plate.ctb"):  # fmt: skip
            with self.subTest(name[:40]):
                status, body, _ = browser.upload(name, SMALL)
                # A C string ends at a NUL, which leaves a name without extension.
                self.assertIn(status, (400, 415))
                self.assert_one_line(body)
        self.assertEqual(self.incoming(), [])
        self.assertEqual(sorted(os.listdir(self.daemon.spool)), [".lock", "done", "failed", "incoming", "printing"])

    def test_a_file_for_another_printer_is_refused_with_what_is_possible(self):
        browser = self.logged_in()
        status, body, _ = browser.upload("plate.ctb", b"PK\3\4" + b"x" * 200_000)
        self.assertEqual(status, 415)
        self.assert_one_line(body, b"plate.ctb", b"such as an STL file")

    def test_a_model_beyond_the_limit_is_refused(self):
        browser = self.logged_in(largest_upload_mb=1)
        status, body, _ = browser.request("POST", "/api/upload?name=a.stl", None, {"Content-Length": str(3 << 20)})
        self.assertEqual(status, 413)
        self.assert_one_line(body, b"at most 1 MiB")
        # Without a declared length, the limit counts what arrives.
        status, body, _ = browser.request("POST", "/api/upload?name=a.stl", iter([b"x" * 65536] * 20))
        self.assertEqual(status, 413)
        self.assertEqual(self.incoming(), [])

    def test_a_disk_without_room_is_told_and_keeps_nothing(self):
        browser = self.logged_in(min_free_disk_mb=1048576)
        status, body, _ = browser.upload("a.stl", SLAB)
        self.assertEqual(status, 507)
        self.assert_one_line(body, b"the printer's disk has less than 1048576 MiB left")
        self.assertEqual(self.incoming(), [])

    def test_a_disk_that_fills_up_in_an_upload_keeps_nothing(self):
        browser = self.logged_in()
        self.web.kill()
        self.web.wait()
        with open(self.path("web.log"), "ab") as log:
            limit = f"ulimit -f 100; trap '' XFSZ; exec {CONTOURD_WEB} --config {self.path('web.json')} --password-file {self.path('web-password')} --listen 127.0.0.1:{self.port}"
            self.web = self.killed_at_the_end(subprocess.Popen(["bash", "-c", limit], stdout=log, stderr=log))
        wait_until(self.answers, "the page")
        self.assertEqual(browser.log_in()[0], 204)
        status, body, _ = browser.upload("a.stl", b"x" * 1_000_000)
        self.assertIn(status, (500, 507))
        self.assert_one_line(body, b"cannot be stored on the printer")
        self.assertEqual(self.incoming(), [])
        self.assertEqual(browser.upload("b.stl", SMALL)[0], 201)

    @unittest.skipUnless(os.geteuid() == 0, "only root can mount a small disk")
    def test_a_full_disk_is_called_full(self):
        browser = self.logged_in()  # no space has to stay free
        self.web.kill()
        self.web.wait()
        incoming = os.path.join(self.daemon.spool, "incoming")
        with open(self.path("web.log"), "ab") as log:
            small = f"mount -t tmpfs -o size=64k none {incoming}; exec {CONTOURD_WEB} --config {self.path('web.json')} --password-file {self.path('web-password')} --listen 127.0.0.1:{self.port}"
            self.web = self.killed_at_the_end(subprocess.Popen(["unshare", "--mount", "bash", "-c", small], stdout=log, stderr=log))
        wait_until(self.answers, "the page")
        self.assertEqual(browser.log_in()[0], 204)
        status, body, _ = browser.upload("a.stl", b"x" * 1_000_000)
        self.assertEqual(status, 507)
        self.assert_one_line(body, b"the printer's disk is full; delete finished jobs")

    def test_an_upload_that_ends_early_leaves_nothing(self):
        browser = self.logged_in()
        head = f"POST /api/upload?name=a.stl HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\nContent-Length: 1000000\r\n\r\n"
        cut = self.raw(head.encode() + b"x" * 200_000)
        cut.close()
        killed = self.raw(head.encode() + b"x" * 200_000)
        wait_until(lambda: self.open_files() > 0, "the upload's file")
        self.web.kill()
        self.web.wait()
        self.assertEqual(self.incoming(), [])
        killed.close()

    def open_files(self):
        """Returns the number of files in the spool that the service has open."""
        folder, count = f"/proc/{self.web.pid}/fd", 0
        for name in os.listdir(folder):
            try:
                count += os.readlink(os.path.join(folder, name)).startswith(self.daemon.spool)
            except FileNotFoundError:
                continue
        return count

    def test_a_flood_of_uploads_is_refused_and_the_page_still_answers(self):
        browser = self.logged_in()
        head = f"POST /api/upload?name=a.stl HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {browser.cookie}\r\nContent-Length: 1000000\r\n\r\n"
        flood = [self.raw(head.encode() + b"x") for _ in range(4)]
        wait_until(lambda: browser.upload("b.stl", SMALL)[0] == 503, "the limit")
        self.assertEqual(browser.json("/api/status")["state"], "idle")
        for each in flood:
            each.close()
        wait_until(lambda: browser.upload("b.stl", SMALL)[0] == 201, "room")

    def test_a_large_upload_takes_little_memory(self):
        browser = self.logged_in()
        size = 200 << 20
        status, _, _ = browser.request("POST", "/api/upload?name=large.stl", iter([b"\0" * 1_048_576] * (size >> 20)), {"Content-Length": str(size)})
        self.assertEqual(status, 201)
        with open(f"/proc/{self.web.pid}/status", encoding="utf-8") as text:
            most = int(re.search(r"VmHWM:\s+(\d+)", text.read())[1])
        print(f"{most / 1024:.1f} MiB at most while 200 MiB are uploaded")
        if not SANITIZED:
            self.assertLess(most, 45 * 1024)  # 16 MiB of them are yescrypt's, for the login


class LoadTest(WebTest):
    """What clients of the page do to a print in real time. As in the unit, the page has a lower priority than contourd."""

    CLIENTS = 200
    LAYERS = 20
    EXPOSURE_MS = 250  # shorter than any resin's, and long beside the late wake-ups of a machine that runs other tests

    def serve_beside_a_print(self):
        resin = {"exposure_ms": self.EXPOSURE_MS, "bottom_exposure_ms": self.EXPOSURE_MS}
        browser = self.serve(Daemon(self, realtime(), {**NIMBLE_RESIN, **resin}).start())
        os.setpriority(os.PRIO_PROCESS, self.web.pid, 10)
        return browser

    def light_errors(self, job):
        """Prints a job in real time, and returns how much longer the light of each layer was than asked for, in ms."""
        model = binary_stl(box((0, 0, 0), (10, 5, 0.05 * self.LAYERS)))
        self.daemon.drop(f"{job}.stl", model)
        self.assertEqual(self.daemon.wait_ended(job, 4 * DEADLINE_S)["outcome"], "done")
        layers = self.daemon.report(job)["layer_records"]
        self.assertEqual(len(layers), self.LAYERS)
        return sorted(layer["exposure_most_ms"] - layer["exposure_asked_ms"] for layer in layers)

    def assert_same_light(self, alone, loaded, load):
        """Requires that a load of the page changes the median of the layers' light by less than 1 %, which is less than a lamp's own noise.
        The machine of the test may be busy with other things, so single layers do not count."""
        middle = self.LAYERS // 2
        ratio = (self.EXPOSURE_MS + loaded[middle]) / (self.EXPOSURE_MS + alone[middle])
        print(f"light beyond {self.EXPOSURE_MS} ms, median and most: {alone[middle]:.3f} and {alone[-1]:.3f} ms alone, "
              f"{loaded[middle]:.3f} and {loaded[-1]:.3f} ms {load}; ratio of the light {ratio:.4f}")  # fmt: skip
        self.assertLess(abs(ratio - 1), 0.01)

    def attack(self, stop):
        """Sends requests of strangers of every kind, on as many connections at once as the test has clients, until `stop` is set."""
        requests = [b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", b"GET /api/status HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", b"GET / HTTP/1.1\r\nX: ",
                    b'POST /api/login HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 27\r\n\r\n{"password": "wrong horse"}', b"POST /api/upload?name=a.stl HTTP/1.1\r\n\r\n"]  # fmt: skip
        connections, sent = [], 0
        while not stop.is_set():
            connection = socket.socket()
            connection.setblocking(False)
            connection.connect_ex(("127.0.0.1", self.port))
            connections.append(connection)
            sent += 1
            if len(connections) < self.CLIENTS:
                continue
            for number, each in enumerate(connections):
                try:
                    each.send(requests[number % len(requests)])
                except OSError:
                    continue
            for each in connections[: self.CLIENTS // 2]:
                each.close()
            del connections[: self.CLIENTS // 2]
            stop.wait(0.05)  # leaves the processor to what is measured
        for each in connections:
            each.close()
        self.attacked = sent

    def test_two_hundred_hostile_clients_do_not_change_the_light_of_a_print(self):
        self.serve_beside_a_print()
        alone = self.light_errors("alone")
        stop = threading.Event()
        attacker = threading.Thread(target=self.attack, args=(stop,))
        attacker.start()
        try:
            attacked = self.light_errors("attacked")
        finally:
            stop.set()
            attacker.join()
        self.assertGreater(self.attacked, 2 * self.CLIENTS)
        self.assert_same_light(alone, attacked, f"with {self.CLIENTS} hostile clients ({self.attacked} connections)")

    def use(self, browser, stop):
        """Has a large job drawn and tried with other settings, and reads reports and resins, until `stop` is set."""
        copies = 1
        while not stop.is_set():
            copies = 3 - copies
            replies = [browser.call("queue_ticket", job="large.stl", ticket={"confirm": True, "supports": "on", "copies": copies})[0]]
            # The picture of a job can be drawn once the job was checked.
            while not stop.is_set() and browser.json("/api/queue")["jobs"][0]["state"] != "unaccepted":
                stop.wait(0.05)
            for path in ("/api/preview?job=large.stl", "/api/report?job=alone", "/api/resins", "/api/ticket?job=large.stl", "/api/queue", "/api/history"):
                replies.append(browser.get(path)[0])
            self.drawn += replies[:2] == [200, 200]
            self.assertNotIn(500, replies)

    def test_pictures_settings_and_reports_again_and_again_do_not_change_the_light_of_a_print(self):
        browser = self.serve_beside_a_print()
        self.assertEqual(browser.log_in()[0], 204)
        alone = self.light_errors("alone")
        grid = [facet for x in range(8) for y in range(5) for z in (0, 2) for facet in box((x, y, z), (x + 0.6, y + 0.6, z + 1))]
        self.assertEqual(browser.request("POST", "/api/upload?name=large.stl&confirm=1", binary_stl(grid))[0], 201)
        self.daemon.wait_job("large")
        stop, self.drawn = threading.Event(), 0
        user = threading.Thread(target=self.use, args=(browser, stop))
        user.start()
        try:
            used = self.light_errors("used")
            wait_until(lambda: self.drawn > 0, "a picture")
        finally:
            stop.set()
            user.join()
        self.assert_same_light(alone, used, f"while {self.drawn} pictures of {len(grid)} facets with supports are drawn")


class SlicerTest(WebTest):
    """PrusaSlicer's host of the type SL1: its requests as curl writes them for PrusaSlicer 2.9 (OctoPrint.cpp)."""

    BOUNDARY = "------------------------d74496d66958873e"
    AGENT = "User-Agent: PrusaSlicer/2.9.0\r\nAccept: */*\r\n"

    def setUp(self):
        super().setUp()
        self.browser = self.serve()

    def form(self, name, model, parts=(("print", "false"), ("path", ""))):
        text = "".join(f'--{self.BOUNDARY}\r\nContent-Disposition: form-data; name="{key}"\r\n\r\n{value}\r\n' for key, value in parts)
        text += f'--{self.BOUNDARY}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\nContent-Type: application/octet-stream\r\n\r\n'
        return text.encode() + model + f"\r\n--{self.BOUNDARY}--\r\n".encode()

    def ask(self, request):
        """Sends a request without a body. Returns the status and the reply."""
        reply = self.reply(self.raw(request.encode()))
        return int(reply.split()[1]), reply

    def reply(self, connection):
        """Returns the reply up to the end of its body."""
        reply = b""
        while True:
            head, end, body = reply.partition(b"\r\n\r\n")
            length = re.search(rb"Content-Length: (\d+)", head)
            if end and length and len(body) >= int(length[1]):
                return reply
            more = connection.recv(65536)
            self.assertTrue(more, reply)
            reply += more

    def send(self, body, authorization=None, host="127.0.0.1"):
        """Sends a form as curl does: waits for "100 Continue" before the body. Returns the status and the sentence."""
        authorization = authorization or f"X-Api-Key: {self.key}"
        connection = self.raw((f"POST /api/files/local HTTP/1.1\r\nHost: {host}\r\n{self.AGENT}{authorization}\r\nContent-Length: {len(body)}\r\n"
                               f"Content-Type: multipart/form-data; boundary={self.BOUNDARY}\r\nExpect: 100-continue\r\n\r\n").encode())  # fmt: skip
        first = connection.recv(65536)
        if first.startswith(b"HTTP/1.1 401 "):
            return 401, first
        self.assertEqual(first, b"HTTP/1.1 100 Continue\r\n\r\n")
        for at in range(0, len(body), 50_000):
            connection.sendall(body[at : at + 50_000])
        reply = self.reply(connection)
        return int(reply.split()[1]), reply.partition(b"\r\n\r\n")[2]

    def test_a_model_that_prusaslicer_sends_is_printed(self):
        status, reply = self.ask(f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}X-Api-Key: {self.key}\r\n\r\n")
        self.assertEqual(status, 200)
        version = json.loads(reply.partition(b"\r\n\r\n")[2])
        self.assertTrue(version["text"].startswith("Prusa SLA"), version)
        self.assertIn("api", version)
        status, _ = self.ask(f"GET /api/v1/storage HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}X-Api-Key: {self.key}\r\n\r\n")
        self.assertEqual(status, 404)
        status, _ = self.send(self.form("my part.stl", SMALL))
        self.assertLess(status, 400)
        self.assertEqual(self.daemon.wait_ended("my part")["outcome"], "done")
        self.assertEqual(contents(os.path.join(self.daemon.spool, "done", "my part.stl")), SMALL)

    def test_layers_that_prusaslicer_sends_are_printed_as_they_are(self):
        display = self.daemon.config["display"]
        layers = pictures(3, display["width_px"], display["height_px"])
        for name in ("plate.sl1", "other.sl1s"):
            data = sl1(layers)
            status, sentence = self.send(self.form(name, data))
            self.assertLess(status, 400, sentence)
            job = name.split(".")[0]
            self.assertEqual(self.daemon.wait_ended(job)["outcome"], "done")
            self.assertEqual(contents(os.path.join(self.daemon.spool, "done", name)), data)
            self.assertEqual(self.daemon.report(job)["model"]["format"], "sl1")

    def test_a_file_for_another_printer_is_refused_with_a_sentence_that_the_slicer_shows(self):
        status, sentence = self.send(self.form("plate.ctb", b"PK\3\4" + bytes(300_000)))
        self.assertEqual(status, 415)
        self.assert_one_line(sentence, "plate.ctb", b"such as an STL file")
        self.assertEqual(self.incoming(), [])

    def test_a_wrong_key_is_refused_before_the_body(self):
        status, reply = self.ask(f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}X-Api-Key: {'0' * 32}\r\n\r\n")
        self.assertEqual(status, 401)
        self.assertIn(b"the API key in X-Api-Key is wrong", reply)
        status, reply = self.ask(f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}\r\n")
        self.assertEqual(status, 401)
        self.assertIn(b"the API key is missing: send it as X-Api-Key, or as the password of the user maker", reply)
        status, sentence, _ = Browser(self.port).get("/api/status", **{"X-Api-Key": "0" * 32})
        self.assertEqual(status, 401)
        self.assert_one_line(sentence, b"the API key in X-Api-Key is wrong")
        status, _ = self.ask(f"POST /api/files/local HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}X-Api-Key: {PASSWORD}\r\nContent-Length: 1000000\r\nExpect: 100-continue\r\n\r\n")
        self.assertEqual(status, 401)

    def digest(self, challenge, method, path, password, user="maker"):
        """Answers a challenge as curl does for a user and a password."""
        fields = dict(re.findall(r'(\w+)="?([^",]+)"?', challenge))
        md5 = lambda text: hashlib.md5(text.encode()).hexdigest()
        first, second = md5(f"{user}:{fields['realm']}:{password}"), md5(f"{method}:{path}")
        response = md5(f"{first}:{fields['nonce']}:00000001:abcdef:auth:{second}")
        return (f'Authorization: Digest username="{user}", realm="{fields["realm"]}", nonce="{fields["nonce"]}", uri="{path}", cnonce="abcdef", nc=00000001, '
                f'qop=auth, response="{response}", opaque="{fields.get("opaque", "")}", algorithm=MD5')  # fmt: skip

    def test_a_user_with_the_key_as_password_sends_by_digest(self):
        get = f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}"
        for user, password, expected, why in (("maker", self.key, 200, b""), ("maker", "0" * 32, 401, b"the password of the user maker is not the API key"),
                                              ("admin", self.key, 401, b"the user admin is unknown: the user of slicers is maker")):  # fmt: skip

            def is_answered():
                # A client tries again if another one used its nonce.
                challenge = self.challenge(*self.ask(f"{get}\r\n"))
                status, reply = self.ask(f"{get}{self.digest(challenge, 'GET', '/api/version', password, user)}\r\n\r\n")
                self.assertTrue(status == expected or b'stale="true"' in reply, reply)
                return status == expected and b'stale="true"' not in reply and why in reply

            wait_until(is_answered, "a nonce of its own")

        def arrives():
            # curl sends its first POST without a body, to be asked for the digest.
            challenge = self.challenge(*self.ask(f"POST /api/files/local HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}Content-Length: 0\r\n\r\n"))
            status, reply = self.send(self.form("digest.stl", SMALL), self.digest(challenge, "POST", "/api/files/local", self.key))
            self.assertTrue(status == 201 or b'stale="true"' in reply, reply)
            return status == 201

        wait_until(arrives, "a nonce of its own")

    def challenge(self, status, reply):
        """Returns the challenge of a refusal."""
        self.assertEqual(status, 401, reply)
        return re.search(r"WWW-Authenticate: (Digest .*)\r\n", reply.decode())[1]

    def test_two_hundred_challenges_leave_room_for_one_more(self):
        get = f"GET /api/version HTTP/1.1\r\nHost: 127.0.0.1\r\n{self.AGENT}"
        for _ in range(200):
            self.challenge(*self.ask(f"{get}\r\n"))

        def comes_in():
            challenge = self.challenge(*self.ask(f"{get}\r\n"))
            status, reply = self.ask(f"{get}{self.digest(challenge, 'GET', '/api/version', self.key)}\r\n\r\n")
            self.assertTrue(status == 200 or b'stale="true"' in reply, reply)
            return status == 200

        # libmicrohttpd 0.9.75 makes two nonces a second for one address, and a nonce serves one client: others try again.
        wait_until(comes_in, "a nonce of its own")

    def test_broken_and_hostile_forms_are_refused(self):
        model = self.form("a.stl", SMALL)
        many = self.form("a.stl", SMALL, [(f"k{number}", "v") for number in range(40)])
        two = self.form("a.stl", SMALL)[: -len(self.BOUNDARY) - 6] + self.form("b.stl", SMALL)
        for body in (model[: len(model) - 30], b"x" * 100_000, many, self.form("../../x.stl", SMALL), self.form("", SMALL),
                     self.form("a.stl", SMALL).replace(b'name="file"', b'name="fiel"'), two):  # fmt: skip
            status, sentence = self.send(body)
            self.assertIn(status, (400, 415), (body[:80], sentence))
            self.assert_one_line(sentence)
        self.assertEqual(self.incoming(), [])


if __name__ == "__main__":
    unittest.main()
