"""The entries that contourd sends to journald, received by a datagram socket in journald's place."""

import os
import socket

import harness

JOURNAL = "/run/systemd/journal/socket"


def place_is_free():
    if os.path.exists(JOURNAL):
        return False
    try:
        os.makedirs(os.path.dirname(JOURNAL), exist_ok=True)
    except OSError:
        return False
    return os.access(os.path.dirname(JOURNAL), os.W_OK)


if not place_is_free():
    harness.skip_file("a journald runs here, or the folder of its socket cannot be written")


def fields(datagram):
    """Parses the native journal protocol: NAME=value lines, or NAME, a newline, a length and the value."""
    entry = {}
    while datagram:
        line, _, rest = datagram.partition(b"\n")
        name, equals, value = line.partition(b"=")
        if not equals:
            size = int.from_bytes(rest[:8], "little")
            value, rest = rest[8 : 8 + size], rest[8 + size + 1 :]
        entry[name.decode()] = value.decode()
        datagram = rest
    return entry


class Journal(harness.FolderTest):
    def setUp(self):
        super().setUp()
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)
        self.socket.bind(JOURNAL)
        self.addCleanup(os.unlink, JOURNAL)
        self.socket.settimeout(harness.DEADLINE_S)
        self.daemon = harness.Daemon(self)

    def start(self):
        """Starts the daemon so that its stderr seems to be connected to the journal."""
        self.write(self.daemon.log_path, b"")
        status = os.stat(self.daemon.log_path)
        self.daemon.launch(JOURNAL_STREAM=f"{status.st_dev}:{status.st_ino}")

    def next_with(self, event):
        while True:
            entry = fields(self.socket.recv(65536))
            if entry["EVENT"] == event:
                return entry

    def test_a_layer_is_one_entry_with_the_job_the_layer_and_its_height(self):
        self.start()
        self.assertIn("is ready", self.next_with("ready")["MESSAGE"])
        self.daemon.drop("cube.stl", harness.binary_stl(harness.cube(2)))
        second = [self.next_with("layer") for _ in range(2)][1]
        self.assertEqual((second["JOB_ID"], second["LAYER"], second["Z_NM"]), ("cube", "2", "100000"))
        self.assertEqual((second["PRIORITY"], second["SYSLOG_IDENTIFIER"]), ("6", "contourd"))

    def test_a_refusal_is_an_error_entry_and_nothing_goes_to_stderr(self):
        self.start()
        self.next_with("ready")
        self.daemon.drop("junk.stl", b"this is no model at all")
        entry = self.next_with("refused")
        self.assertEqual((entry["JOB_ID"], entry["PRIORITY"]), ("junk", "3"))
        self.assertIn("not a usable model", entry["MESSAGE"])
        self.assertEqual(self.daemon.log(), "")

    def test_a_journal_that_does_not_read_delays_no_print_and_gets_all_entries_later(self):
        # The kernel holds ten to some hundreds of datagrams until they are read.
        with open("/proc/sys/net/unix/max_dgram_qlen", encoding="ascii") as file:
            layers = int(file.read()) + 50
        self.start()
        self.daemon.drop("tall.stl", harness.binary_stl(harness.box((0, 0, 0), (2, 2, layers * 0.05))))
        harness.wait_until(lambda: self.daemon.has("done", "tall.stl"), "the end of the print")
        numbers = [int(self.next_with("layer")["LAYER"]) for _ in range(layers)]
        self.assertEqual(numbers, list(range(1, layers + 1)))
        self.next_with("done")

    def test_without_a_matching_journal_stream_the_log_goes_to_stderr(self):
        self.daemon.start()  # JOURNAL_STREAM is not set, or names another stream
        self.assertIn("is ready", self.daemon.log())
