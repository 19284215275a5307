"""Sends hostile requests to the control socket with the rights of a member of the group, until it is killed:
hostile_clients.py RIGHTS SEED SOCKET. Prints a line for each action. It asks, watches and floods but does not pause, resume or
cancel, because a member may do that."""

import json
import random
import select
import socket
import sys
import time

from member import become_member

become_member(sys.argv[1])
rng = random.Random(int(sys.argv[2]))
path = sys.argv[3]
held = []

QUESTIONS = ("status", "queue", "history", "watch", "nonsense", "\x1b[31m")


def request(method=None):
    message = {"jsonrpc": "2.0", "method": method or rng.choice(QUESTIONS), "id": rng.randrange(1000)}
    return json.dumps(message).encode() + b"\n"


def connect(keep=False):
    client = socket.socket(socket.AF_UNIX)
    client.connect(path)
    client.setblocking(False)
    if keep:
        held.append(client)
    return client


def push(client, data, seconds):
    """Sends as much of the data as the daemon accepts in the time, without reading the answers."""
    end = time.monotonic() + seconds
    while data and time.monotonic() < end:
        try:
            data = data[client.send(data) :]
        except BlockingIOError:
            select.select((), (client,), (), max(0.0, end - time.monotonic()))


def pull(client, seconds):
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0 and select.select((client,), (), (), left)[0]:
        if not client.recv(1 << 16):
            return


def idle():
    for _ in range(rng.randint(10, 150)):
        connect(keep=True)


def watchers_that_never_read():
    for _ in range(rng.randint(1, 40)):
        push(connect(keep=True), request("watch"), 0.1)


def half_a_message():
    line = request()
    for _ in range(rng.randint(1, 30)):
        push(connect(keep=True), line[: rng.randrange(len(line))], 0.1)


def hundred_requests_a_write():
    with connect() as client:
        for _ in range(rng.randint(1, 10)):
            push(client, b"".join(request() for _ in range(100)), 0.1)
            pull(client, 0.05)


def questions_without_end_and_nothing_read():
    push(connect(keep=True), b"".join(request("status") for _ in range(20000)), rng.random())


def batches():
    with connect() as client:
        batch = b"[" + b",".join(request("status").strip() for _ in range(64)) + b"]\n"
        for _ in range(rng.randint(1, 20)):
            push(client, batch, 0.2)
        pull(client, 0.2)


def huge_line():
    with connect() as client:
        push(client, b"x" * rng.choice((8193, 70000, 5 << 20)) + rng.choice((b"\n", b"")), 0.5)
        pull(client, 0.05)


def deep_json():
    with connect() as client:
        push(client, rng.choice((b"[" * 8000, b'{"a":' * 1300, b"[" * 4000 + b"]" * 4000)) + b"\n", 0.2)
        pull(client, 0.05)


def rubbish():
    with connect() as client:
        push(client, rng.randbytes(rng.randint(1, 100000)), 0.3)
        pull(client, 0.05)


def come_and_go():
    for _ in range(rng.randint(10, 200)):
        with connect() as client:
            push(client, rng.choice((b"", request(), request("watch"), b"{")), 0.1)


def flood():
    """Asks and reads as fast as possible."""
    end = time.monotonic() + rng.random()
    with connect() as client:
        while time.monotonic() < end:
            push(client, request("status") * 20, 0.1)
            pull(client, 0.002)


ACTIONS = (
    idle, watchers_that_never_read, half_a_message, hundred_requests_a_write, questions_without_end_and_nothing_read, batches,
    huge_line, deep_json, rubbish, come_and_go, flood,
)  # fmt: skip


def main():
    while True:
        action = rng.choice(ACTIONS)
        try:
            action()
            result = ""
        except OSError as error:  # the daemon closed the connection, or does not run
            result = f" ({error.strerror})"
        print(f"{time.monotonic():.3f} {action.__name__}{result}", flush=True)
        while len(held) > 200 or (held and rng.random() < 0.2):
            held.pop(rng.randrange(len(held))).close()
        time.sleep(rng.expovariate(8))


main()
