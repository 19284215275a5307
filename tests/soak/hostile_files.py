"""Drops hostile files with the rights of a member of the group, until it is killed: hostile_files.py RIGHTS SEED INCOMING HOME
SECRETS. Prints a line for each action."""

import json
import os
import random
import socket
import struct
import sys
import time

from member import become_member

become_member(sys.argv[1])
seed, incoming, home, secrets = int(sys.argv[2]), *sys.argv[3:6]
rng = random.Random(seed)
spool = os.path.dirname(incoming)
numbers = iter(range(1 << 30))
ODD = ("\x1b[31m", "line\nbreak", "\x9b2J", "\u202egnp", "\u2066isolate", "\u2028separator", "\x07bell\r", "%s{}{0}", "\udcff\udcfe")


def name():
    odd = rng.choice(ODD) if rng.random() < 0.2 else ""
    return f"bad{seed}-{next(numbers)}{odd}" + ("n" * rng.randint(150, 230) if rng.random() < 0.05 else "")


def facets(count, scale=5.0):
    """Returns random facets that do not form a solid."""
    return b"".join(struct.pack("<12fH", 0, 0, 0, *(rng.random() * scale for _ in range(9)), 0) for _ in range(count))


def stl(count, said=None, scale=5.0):
    return b"hostile".ljust(80, b"\0") + struct.pack("<I", count if said is None else said) + facets(count, scale)


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)
    return path


def at_home(file):
    """Returns a path in home that does not exist."""
    path = os.path.join(home, file)
    if os.path.lexists(path):
        os.unlink(path)
    return path


def move_in(file, data):
    """Moves a complete file into incoming at once."""
    os.rename(write(at_home("staging"), data), os.path.join(incoming, file))


def fifo():
    os.mkfifo(os.path.join(incoming, name() + rng.choice((".stl", ".json"))))


def link():
    target = rng.choice((os.path.join(secrets, "secret.stl"), "nowhere", "../../../secrets/secret.stl", "/dev/zero", "/proc/self/mem", ".."))
    os.symlink(target, os.path.join(incoming, name() + rng.choice((".stl", ".STL", ""))))


def linked_ticket():
    stem = name()
    os.symlink(os.path.join(secrets, "secret.json"), os.path.join(incoming, stem + ".json"))
    move_in(stem + ".stl", stl(12))


def fifo_ticket():
    stem = name()
    os.mkfifo(os.path.join(incoming, stem + ".json"))
    move_in(stem + ".stl", stl(12))


def endpoint():
    with socket.socket(socket.AF_UNIX) as bound:
        path = at_home("s")
        bound.bind(path)
        os.rename(path, os.path.join(incoming, name() + ".stl"))


def sparse():
    path = at_home("sparse")
    facets_said = rng.choice((20_000, 5_000_000, 80_000_000, 0xFFFFFFFF))  # 1 MB to 215 GB
    with open(path, "wb") as file:
        file.write(stl(2, facets_said))
        file.truncate(84 + 50 * facets_said + rng.choice((0, 0, 1)))
    os.rename(path, os.path.join(incoming, name() + ".stl"))


def truncated():
    data = stl(40, 41)
    move_in(name() + ".stl", data[: rng.randrange(len(data))])


def rubbish():
    move_in(name() + ".stl", rng.choice((b"", b"solid ", b"MZ", b"\xff" * 83)) + rng.randbytes(rng.randint(0, 20000)))


def odd_text():
    text = "".join(rng.choice(ODD[:-1]) for _ in range(20))
    move_in(name() + ".stl", f"solid {text}\nfacet normal {text}\n".encode() * 20)


def many_tiny():
    for _ in range(rng.randint(20, 150)):
        move_in(name() + ".stl", rng.choice((b"x", b"solid\n", stl(1), stl(0))))


def soup():
    """Drops a file that is read, repaired, checked and, if something is left, printed."""
    move_in(name() + ".stl", stl(rng.choice((1, 4, 100)), scale=rng.choice((0.5, 5, 1e3, 1e30))))


def ticket_of_mistakes():
    stem = name()
    wrong = {
        "keys": lambda: "{" + ",".join(f'"{number}":1' for number in range(60000)) + "}",
        "deep": lambda: '{"scale": ' + "[" * 100000,
        "large": lambda: '{"resin": "' + "x" * 1_000_000 + '"}',
        "values": lambda: json.dumps({"copies": -1, "scale": "x", "resin": "../secrets/secret"}),
        "binary": lambda: rng.randbytes(5000).decode("latin-1"),
    }
    write(os.path.join(incoming, stem + ".json"), wrong[rng.choice(sorted(wrong))]().encode())
    move_in(stem + ".stl", stl(12))


def swapped():
    """Drops a good file and replaces it by something else while the daemon may be reading it."""
    path = os.path.join(incoming, name() + ".stl")
    for _ in range(rng.randint(5, 40)):
        move_in(os.path.basename(path), stl(200))
        other = at_home("other")
        rng.choice((os.mkfifo, lambda p: os.symlink(os.path.join(secrets, "secret.stl"), p), lambda p: write(p, b"")))(other)
        time.sleep(rng.random() * 0.003)
        os.rename(other, path)


def changed_while_read():
    path = os.path.join(incoming, name() + ".stl")
    original = write(at_home("growing"), stl(3000))
    os.link(original, path)
    for _ in range(rng.randint(1, 10)):
        with open(original, "r+b") as file:
            file.seek(rng.randrange(150000))
            file.write(rng.randbytes(400))
            file.truncate(rng.choice((84, 84 + 50 * 3000, rng.randrange(200000))))
        time.sleep(rng.random() * 0.01)
    os.unlink(original)


def slow_copy():
    with open(os.path.join(incoming, name() + ".stl"), "wb", buffering=0) as file:
        data = stl(20)
        for start in range(0, len(data), 200):
            file.write(data[start : start + 200])
            time.sleep(0.01)


def plate():
    """Drops a plate in a folder that cannot be moved or read, or that contains hostile entries."""
    path = os.path.join(incoming, name())
    os.mkdir(path)
    write(os.path.join(path, "part.stl"), stl(30))
    models = [{"file": rng.choice(("part.stl", "part.stl", "none.stl", "../part.stl", "fifo.stl"))} for _ in range(rng.choice((1, 60)))]
    os.mkfifo(os.path.join(path, "fifo.stl"))
    os.symlink(secrets, os.path.join(path, "link"))
    for number in range(rng.choice((0, 0, 2000))):
        os.symlink("nowhere", os.path.join(path, f"{number}.stl"))
    if rng.random() < 0.8:
        write(os.path.join(path, "plate.json"), json.dumps({"models": models}).encode())
    os.chmod(path, rng.choice((0o755, 0o700, 0o775, 0o000)))
    time.sleep(rng.random() * 0.02)
    if rng.random() < 0.3:
        os.rename(path, os.path.join(incoming, name()))


def folders():
    for _ in range(rng.randint(1, 50)):
        os.mkdir(os.path.join(incoming, name() + rng.choice(("", ".stl", ".json"))))


def planted():
    """Makes fifos at paths to which the daemon writes."""
    for folder in ("done", "failed"):
        for suffix in ("report.json", "reason.txt", "stl"):
            os.mkfifo(os.path.join(spool, folder, f"bad{seed}-{next(numbers) + 3}.{suffix}"))
        os.mkfifo(os.path.join(spool, folder, f".contourd-{rng.randrange(1 << 64):016x}.new"))


def unreadable():
    path = write(at_home("unreadable"), stl(12))
    os.chmod(path, 0)
    os.rename(path, os.path.join(incoming, name() + ".stl"))


def both_cases():
    stem = name()
    for extension in (".json", ".stl", ".STL", ".Stl"):
        move_in(stem + extension, b"{}" if extension == ".json" else stl(12))


ACTIONS = (
    fifo, link, linked_ticket, fifo_ticket, endpoint, sparse, truncated, rubbish, odd_text, many_tiny, soup, ticket_of_mistakes,
    swapped, changed_while_read, slow_copy, plate, folders, planted, unreadable, both_cases,
)  # fmt: skip


def main():
    while True:
        os.umask(rng.choice((0o022, 0o022, 0o022, 0o002, 0o077)))
        action = rng.choice(ACTIONS)
        try:
            action()
            result = ""
        except OSError as error:  # the disk is full, or the daemon was faster
            result = f" ({error.strerror})"
        print(f"{time.monotonic():.3f} {action.__name__}{result}", flush=True)
        time.sleep(rng.expovariate(6))


main()
