"""MQTT 3.1.1 for the system tests: a client, mosquitto as the broker, and a broker that does what a test tells it."""

import json
import os
import queue
import shutil
import socket
import struct
import subprocess
import threading
import time

from harness import DEADLINE_S, contents, wait_until

MOSQUITTO = shutil.which("mosquitto", path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")

CONNECT, CONNACK, PUBLISH, SUBSCRIBE, SUBACK, DISCONNECT = 1, 2, 3, 8, 9, 14


def text(value):
    data = value.encode()
    return struct.pack(">H", len(data)) + data


def length_of(size):
    coded = b""
    while True:
        size, digit = size >> 7, size & 127
        coded += bytes([digit | (128 if size else 0)])
        if not size:
            return coded


def packet(kind, body, flags=0):
    return bytes([kind << 4 | flags]) + length_of(len(body)) + body


def publish(topic, payload, retain=False):
    return packet(PUBLISH, text(topic) + payload, int(retain))


def read_packet(file):
    """Returns the kind, the flags and the body of the next packet; None at the end."""
    first = file.read(1)
    if not first:
        return None
    size, shift = 0, 0
    while True:
        digit = file.read(1)[0]
        size |= (digit & 127) << shift
        shift += 7
        if digit < 128:
            return first[0] >> 4, first[0] & 15, file.read(size)


class Subscriber:
    """A client that has subscribed to everything. A thread of its own reads what arrives."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=DEADLINE_S)
        self.file = self.socket.makefile("rb")
        self.socket.sendall(packet(CONNECT, text("MQTT") + bytes([4, 2, 0, 0]) + text(f"test-{os.getpid()}-{time.monotonic_ns()}")))
        assert read_packet(self.file) == (CONNACK, 0, b"\0\0")
        self.socket.sendall(packet(SUBSCRIBE, b"\0\1" + text("#") + b"\0", 2))
        self.latest = {}  # by topic: the payload, and whether the broker had kept it
        self.messages = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            while got := read_packet(self.file):
                kind, flags, body = got
                if kind == PUBLISH:
                    (size,) = struct.unpack(">H", body[:2])
                    message = body[2 : 2 + size].decode(), body[2 + size :], bool(flags & 1)
                    self.latest[message[0]] = message[1:]
                    self.messages.put(message)
        except (OSError, ValueError, IndexError):
            return

    def publish(self, topic, payload=b"PRESS", retain=False):
        self.socket.sendall(publish(topic, payload, retain))

    def payload(self, topic):
        return self.latest.get(topic, (b"", False))[0]

    def wait_for(self, topic, accept=bool):
        """Waits until the latest payload on the topic is accepted, and returns it."""
        return wait_until(lambda: topic in self.latest and accept(self.payload(topic)) and self.payload(topic), f"{topic}: {self.latest.get(topic)}")

    def next(self, topic):
        """Returns the next message on the topic that has not been returned: its payload, and whether the broker had kept it."""
        end = time.monotonic() + DEADLINE_S
        while True:
            got = self.messages.get(timeout=max(0.001, end - time.monotonic()))
            if got[0] == topic:
                return got[1:]

    def forget(self):
        while not self.messages.empty():
            self.messages.get()
        self.latest.clear()

    def close(self):
        self.socket.close()


class Mosquitto:
    """The broker mosquitto on a free port of the loopback."""

    def __init__(self, test, port, *settings):
        self.test, self.port = test, port
        self.config = test.write("mosquitto.conf", "\n".join([f"listener {port} 127.0.0.1", "user root", *(settings or ["allow_anonymous true"]), ""]))
        self.start()

    def start(self):
        with open(self.test.path("mosquitto.log"), "ab") as log:
            self.process = self.test.killed_at_the_end(subprocess.Popen([MOSQUITTO, "-v", "-c", self.config], stdout=log, stderr=log))
        wait_until(self.answers, "mosquitto")

    def answers(self):
        assert self.process.poll() is None, contents(self.test.path("mosquitto.log"))
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self):
        self.process.kill()
        self.process.wait()

    def subscriber(self):
        subscriber = Subscriber(self.port)
        self.test.addCleanup(subscriber.close)
        return subscriber


class OddBroker:
    """A broker that hands each connection, by a thread, to the test's function."""

    def __init__(self, test, serve):
        self.listener = socket.create_server(("127.0.0.1", 0))
        test.addCleanup(self.listener.close)
        self.port = self.listener.getsockname()[1]
        self.connections = 0
        self.serve = serve
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while True:
            try:
                connection = self.listener.accept()[0]
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        try:
            with connection:
                self.serve(connection)
        except (OSError, IndexError):
            return


def greet(connection):
    """Answers the request to connect and the subscriptions of a client. Returns the topics."""
    file = connection.makefile("rb")
    kind = read_packet(file)[0]
    assert kind == CONNECT, kind
    connection.sendall(packet(CONNACK, b"\0\0"))
    topics = []
    while len(topics) < 2:
        kind, _, body = read_packet(file)
        if kind == SUBSCRIBE:
            (size,) = struct.unpack(">H", body[2:4])
            topics.append(body[4 : 4 + size].decode())
            connection.sendall(packet(SUBACK, body[:2] + b"\0"))
    return topics


def json_of(payload):
    return json.loads(payload) if payload else {}
