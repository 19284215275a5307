"""contourctl watch on a pseudo terminal: the contents of the screen, and that the terminal is restored."""

import codecs
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import unicodedata

from harness import (
    CONTOURCTL, DEADLINE_S, ENDLESS, FAILED, NIMBLE_RESIN, OK, SLAB, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, contourctl, realtime,
    wait_until,
)  # fmt: skip

ISLAND = binary_stl(box((0, 0, 0), (10, 5, 1)) + box((20, 0, 0.5), (25, 5, 1)))
SEQUENCE = re.compile(r"\x1b\[(\??)([0-9;]*)([A-Za-z])")
# A signal may interrupt a sequence; a terminal drops it at the next ESC.
CUT_SEQUENCE = re.compile(r"\x1b(?:\[[?\d;]*)?(?=\x1b)")


class Terminal:
    """A terminal of this size with a program on it. Knows only the sequences that the view is drawn with."""

    def __init__(self, test, command, columns=80, rows=24, **environment):
        self.columns, self.rows, self.received, self.raw = columns, rows, "", b""
        self.decode = codecs.getincrementaldecoder("utf-8")().decode
        self.lines, self.at, self.seen_colour = [""] * rows, (0, 0), False
        self.alternate, self.cursor, self.wraps, self.before = False, True, True, ""
        self.ours, its = pty.openpty()
        self.resize(columns, rows)
        self.modes = termios.tcgetattr(its)
        environment = {"TERM": "xterm", **environment}
        # A separate process group in this session, since an orphaned one cannot be stopped.
        self.process = subprocess.Popen(
            command, stdin=its, stdout=its, stderr=its, process_group=0,
            env={**{k: v for k, v in os.environ.items() if k not in ("TERM", "NO_COLOR")}, **environment})  # fmt: skip
        self.its = its
        test.addCleanup(os.close, its)
        test.addCleanup(os.close, self.ours)
        test.killed_at_the_end(self.process)

    def resize(self, columns, rows):
        fcntl.ioctl(self.ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.columns, self.rows = columns, rows
        self.lines = (self.lines + [""] * rows)[:rows]

    def read(self, seconds=0.02):
        """Reads what has been drawn meanwhile; returns False if there is nothing."""
        if not select.select([self.ours], [], [], seconds)[0]:
            return False
        data = os.read(self.ours, 65536)
        self.raw += data
        self._take(data)
        return True

    def _take(self, data):
        self.received += self.decode(data)
        while self.received:
            found = SEQUENCE.match(self.received)
            if found:
                self._obey(*found.groups())
                self.received = self.received[found.end() :]
            elif cut := CUT_SEQUENCE.match(self.received):
                self.received = self.received[cut.end() :]
            elif self.received[0] == "\x1b" and len(self.received) < 12:
                return  # half a sequence
            else:
                self._print(self.received[0])
                self.received = self.received[1:]

    def _obey(self, private, numbers, command):
        row, _ = self.at
        if private:
            {"1049": self._switch, "25": self._show_cursor, "7": self._wrap}[numbers](command == "h")
        elif command == "H":
            row, column = map(int, numbers.split(";"))
            assert row <= self.rows and column == 1, numbers
            self.at = (row - 1, 0)
        elif command == "K":
            self.lines[row] = ""
        elif command == "J":
            for below in range(0 if numbers == "2" else row, self.rows):
                self.lines[below] = ""
        elif command == "m":
            self.seen_colour = self.seen_colour or numbers != "0"
        else:
            raise AssertionError(f"ESC [ {numbers} {command}")

    def _switch(self, on):
        self.alternate, self.lines = on, [""] * self.rows

    def _show_cursor(self, on):
        self.cursor = on

    def _wrap(self, on):
        self.wraps = on

    def _print(self, character):
        if not self.alternate:
            self.before += character
            return
        assert unicodedata.category(character)[0] != "C", f"{character!r} reached the terminal"
        row, column = self.at
        column += 0 if unicodedata.combining(character) else 2 if unicodedata.east_asian_width(character) in "WF" else 1
        assert column <= self.columns, f"line {row + 1} is wider than {self.columns} columns: {self.lines[row]}"
        self.lines[row] += character
        self.at = (row, column)

    def text(self):
        return "\n".join(self.lines)

    def wait_for(self, part, what=None):
        def shown():
            self.read()
            return part in self.text()
        try:
            wait_until(shown, what or repr(part))
        except AssertionError as error:
            raise AssertionError(f"{error}:\n{self.before}\n{self.text()}") from None

    def wait_end(self):
        """Waits for the end of the program, asserts that it has restored the terminal, and returns its exit code."""
        def ended():
            return not self.read() and self.process.poll() is not None
        wait_until(ended, "the view to end")
        while self.read():
            pass
        self.assert_restored()
        return self.process.returncode

    def end(self):
        """Ends the program, which must restore the terminal."""
        self.process.terminate()
        assert self.wait_end() == -signal.SIGTERM, self.process.returncode

    def assert_restored(self):
        assert not self.alternate and self.cursor and self.wraps, self.raw[-200:]
        assert termios.tcgetattr(self.its) == self.modes, "the terminal's modes are not restored"


class Watch(FolderTest):
    def daemon(self, resin=None, **config):
        return Daemon(self, realtime(**config), {**NIMBLE_RESIN, **(ENDLESS if resin is None else resin)}).start()

    def printing(self, name="part"):
        return FolderTest.printing(self, name + ".stl", ISLAND)

    def watch(self, daemon, *arguments, until=None, **options):
        terminal = Terminal(self, [CONTOURCTL, "watch", "--socket", daemon.socket_path, *arguments], **options)
        if until:
            terminal.wait_for(until)
        return terminal

    def test_watch_shows_the_print_and_its_warnings_and_ends_with_the_print(self):
        daemon = self.printing("Bär-部品")
        terminal = self.watch(daemon, until="warning   1 island")
        for part in ("Bär-部品", "]   0 %", "phase     exposing, ", "light     ON", "layer     1 of 20, 50 um", "until ",
                     "height    0.050 of 1.000 mm", "resin     0.", "next      resting", "queue     empty"):  # fmt: skip
            self.assertIn(part, terminal.text())
        self.assertTrue(terminal.seen_colour)
        daemon.rpc("cancel")
        self.assertEqual(terminal.wait_end(), FAILED)
        lines = terminal.before.splitlines()
        self.assertIn("Bär-部品: warning: 1 island", lines[0])
        self.assertEqual(lines[1:], ["Bär-部品: cancelled"])

    def test_the_current_mask_is_drawn_below_if_there_is_room(self):
        daemon = self.printing()
        terminal = self.watch(daemon, rows=40, NO_COLOR="1", until="mask      layer 1, cut at 0.0")
        terminal.wait_for("\u2588")
        self.assertLess(terminal.text().index("queue     empty"), terminal.text().index("mask "))
        self.assertFalse(terminal.seen_colour)
        coloured = self.watch(daemon, rows=24, COLORTERM="truecolor", until="mask      layer 1")
        wait_until(lambda: coloured.read() is not None and b"\x1b[48;2;255;255;255m" in coloured.raw, "the lit area in white")
        small = self.watch(daemon, rows=14, until="queue     empty")
        self.assertNotIn("mask", small.text())
        for each in (terminal, coloured, small):
            each.end()

    def test_warnings_leave_room_for_the_mask_on_a_usual_terminal(self):
        # Islands above layers without anything: two warnings, of several lines together.
        boxes = [*box((0, 0, 0), (1, 1, 0.2)), *(facet for i in range(6) for facet in box((5 + 3 * i, 0, 0.3), (6 + 3 * i, 1, 1)))]
        daemon = FolderTest.printing(self, "part.stl", binary_stl(boxes))
        terminal = self.watch(daemon, until="mask      layer 1, cut at 0.0")
        terminal.wait_for("\u2580")
        self.assertGreater(terminal.text().count("\nwarning   "), 1, terminal.text())
        for part in ("phase     exposing", "light     ON", "time left ", "next      resting"):
            self.assertIn(part, terminal.text())
        terminal.end()

    def test_q_leaves_the_wait_for_all_jobs_of_submit(self):
        daemon = self.printing()
        model = self.write("other.stl", SLAB)
        terminal = Terminal(self, [CONTOURCTL, "submit", model, model, "--wait", "--yes", "--spool", daemon.spool, "--socket", daemon.socket_path])
        terminal.wait_for("other waits")
        os.write(terminal.ours, b"q")
        self.assertEqual(terminal.wait_end(), OK)
        daemon.wait_status("queued", 2)

    def test_a_manually_shown_picture_is_drawn_until_it_is_removed(self):
        daemon = self.daemon()
        terminal = self.watch(daemon, rows=40, until="queue     empty")
        shows = subprocess.Popen([CONTOURCTL, "show", "grid", "--socket", daemon.socket_path], stdout=subprocess.DEVNULL)
        self.killed_at_the_end(shows)
        terminal.wait_for("mask      grid")
        shows.kill()
        wait_until(lambda: terminal.read() is not None and "mask" not in terminal.text(), "the picture to be gone")
        terminal.end()

    def test_a_whole_print_can_be_watched_on_terminals_of_every_size(self):
        daemon = self.daemon({})
        for columns, rows in ((200, 60), (80, 24), (40, 10), (20, 3), (1, 1)):
            with self.subTest(columns=columns, rows=rows):
                name = f"part-部品-{columns}"
                terminal = self.watch(daemon, "--job", name, columns=columns, rows=rows)
                daemon.drop(name + ".stl", ISLAND)
                self.assertEqual(terminal.wait_end(), OK)
                self.assertEqual(terminal.before.splitlines()[-1], f"{name}: done")

    def test_the_time_left_counts_down(self):
        daemon = self.printing()
        terminal = self.watch(daemon)
        seen = set()

        def counted():
            terminal.read()
            seen.update(re.findall(r"exposing, 1 min (\d\d) s left", terminal.text()))
            return len(seen) > 2
        wait_until(counted, "three different times")
        terminal.end()

    def test_the_view_is_redrawn_in_place_when_the_terminal_changes_its_size(self):
        daemon = self.printing()
        terminal = self.watch(daemon, until="light     ON")
        terminal.resize(30, 5)
        terminal.process.send_signal(signal.SIGWINCH)  # the session's own terminal would send it
        terminal.lines = [""] * 5
        terminal.wait_for("light     ON")
        self.assertEqual(len(terminal.lines), 5)
        self.assertIn("%", terminal.text())
        terminal.end()

    def test_the_terminal_is_restored_however_the_program_ends(self):
        daemon = self.printing()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            with self.subTest(number):
                terminal = self.watch(daemon, until="light     ON")
                terminal.process.send_signal(number)
                self.assertEqual(terminal.wait_end(), -number)
        with self.subTest("q"):
            terminal = self.watch(daemon, until="light     ON")
            os.write(terminal.ours, b"xq")
            self.assertEqual(terminal.wait_end(), OK)
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_the_terminal_is_restored_while_the_program_is_stopped(self):
        daemon = self.printing()
        terminal = self.watch(daemon, until="light     ON")
        terminal.process.send_signal(signal.SIGTSTP)
        self.assertTrue(os.WIFSTOPPED(os.waitpid(terminal.process.pid, os.WUNTRACED)[1]))
        while terminal.read():
            pass
        terminal.assert_restored()
        terminal.process.send_signal(signal.SIGCONT)
        terminal.wait_for("light     ON")
        terminal.process.send_signal(signal.SIGSTOP)
        self.assertTrue(os.WIFSTOPPED(os.waitpid(terminal.process.pid, os.WUNTRACED)[1]))
        terminal.process.send_signal(signal.SIGCONT)
        terminal.wait_for("light     ON")
        terminal.end()

    def test_a_blocked_terminal_does_not_delay_the_end(self):
        daemon = self.printing()
        terminal = self.watch(daemon, until="light     ON")
        termios.tcflow(terminal.its, termios.TCOOFF)  # the effect of Ctrl-S
        while terminal.read():
            pass
        terminal.process.send_signal(signal.SIGWINCH)  # requests a complete redraw
        terminal.process.terminate()
        self.assertEqual(terminal.process.wait(DEADLINE_S), -signal.SIGTERM)
        self.assertEqual(termios.tcgetattr(terminal.its), terminal.modes)

    def test_watch_reports_that_contourd_is_gone_and_continues_when_it_is_back(self):
        daemon = self.printing()
        terminal = self.watch(daemon, until="light     ON")
        daemon.kill()
        terminal.wait_for("closed the connection")
        self.assertIn("light     unknown", terminal.text())
        daemon.start()
        terminal.wait_for("held      the queue is held")
        self.assertNotIn("closed the connection", terminal.text())
        terminal.end()

    def test_an_unknown_job_is_reported_on_the_restored_terminal(self):
        daemon = self.daemon()
        terminal = self.watch(daemon, "--job", "nothere")
        self.assertEqual(terminal.wait_end(), FAILED)
        self.assertIn("there is no job nothere", terminal.before)
        self.assertEqual(len(terminal.before.splitlines()), 1)

    def test_watch_shows_the_queue_and_manual_operations_while_nothing_prints(self):
        daemon = self.daemon(wait_for_plate_cleared=True, resin={})
        daemon.printed("one.stl", SLAB)
        terminal = self.watch(daemon, until="plate     occupied by one")
        daemon.drop("two.stl", SLAB)
        terminal.wait_for("queue     1 job\n   1  two.stl")
        self.assertIn("plate-cleared", terminal.text())
        self.assertIn("last job  one: done", terminal.text())
        client = daemon.client()
        client.call("show", pattern="grid")
        terminal.wait_for("screen: grid")
        terminal.end()

    def test_names_reach_the_terminal_without_control_characters(self):
        daemon = self.printing("\x1b[31m\n\u202e\x9b2J" + "品" * 60)  # Terminal checks what it prints
        daemon.drop("b\x1b]0;x\x07.stl", SLAB)
        terminal = self.watch(daemon, until="?[31m??")
        terminal.wait_for("1  b?]0;x?.stl")
        terminal.end()

    def test_no_color_and_a_dumb_terminal_are_respected(self):
        daemon = self.printing()
        terminal = self.watch(daemon, NO_COLOR="1", until="light     ON")
        terminal.process.terminate()
        terminal.wait_end()
        self.assertFalse(terminal.seen_colour)
        plain = [self.watch(daemon, TERM="dumb"), self.watch(daemon, "--json")]
        for terminal in plain:
            wait_until(lambda terminal=terminal: terminal.read() or "exposing" in terminal.before, "a line of output")
        daemon.rpc("cancel")
        for terminal in plain:
            self.assertEqual(terminal.wait_end(), FAILED)
            self.assertNotIn(b"\x1b", terminal.raw)

    def test_without_a_daemon_the_terminal_is_not_touched(self):
        terminal = Terminal(self, [CONTOURCTL, "watch", "--socket", self.path("none")])
        self.assertEqual(terminal.wait_end(), UNAVAILABLE)
        self.assertNotIn(b"\x1b", terminal.raw)
        self.assertEqual(len(terminal.before.splitlines()), 1)
        self.assertEqual(contourctl("watch", "--socket", self.path("none")).returncode, UNAVAILABLE)
