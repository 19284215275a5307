"""contourctl help: the project's pages and the commands, in a terminal or through a pipe."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

from harness import BAD_USAGE, CONTOURCTL, OK, SOURCE, FolderTest, contourctl, text_of


def shown(*words):
    result = contourctl("help", *words)
    if (result.returncode, result.stderr) != (OK, b""):
        raise AssertionError(result)
    return result.stdout.decode()


def in_terminal(*words, columns=80, **environment):
    """Returns the exit code of contourctl help in a terminal of this width, and the text that the terminal receives."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen([CONTOURCTL, "help", *words], stdin=slave, stdout=slave, stderr=slave,
                               env={**os.environ, "TERM": "xterm", **environment})  # fmt: skip
    os.close(slave)
    received = b""
    while True:
        try:
            data = os.read(master, 65536)
        except OSError:
            break
        if not data:
            break
        received += data
    os.close(master)
    return process.wait(), received.decode().replace("\r\n", "\n")


def pages():
    return re.findall(r"(?m)^  (\S+) ", shown())


class Help(FolderTest):
    def test_each_page_of_the_list_is_a_file_and_is_shown(self):
        self.assertIn("printing", pages())
        for page in pages():
            title, *_ = text_of(os.path.join(SOURCE, "docs", f"{page}.md")).splitlines()
            self.assertTrue(shown(page).startswith(title.removeprefix("# ") + "\n==="), page)

    def test_each_section_of_the_list_is_shown(self):
        sections = re.findall(r"(?m)^    (\S.*)$", shown())
        self.assertGreater(len(sections), 40)
        for section in sections:
            self.assertIn(section, shown(section))

    def test_help_finds_a_page_for_each_of_these_words(self):
        for words, said in (
            (["levelling"], "contourctl level"),
            (["exposure"], "working_curve"),
            (["trouble"], "contourctl status"),
            (["Limited", "range"], "Broadcast RGB"),
            (["island"], "nothing under it"),
            (["when the next job begins"], "plate is clear"),
            (["usb"], "contourd-usb@.service"),
        ):
            self.assertIn(said, shown(*words), words)

    def test_a_command_is_shown_with_its_options_and_related_sections(self):
        text = shown("submit")
        usage = contourctl("submit", "--help").stdout.decode()
        self.assertTrue(text.startswith(usage), text)
        self.assertIn("\nSee also:\n\n    contourctl help printing the folders\n", text)
        self.assertIn("Usage: ", shown("queue", "move"))
        self.assertIn("--first", shown("queue", "move"))
        self.assertIn("Subcommands:", shown("queue"))

    def test_each_section_named_by_see_also_can_be_shown(self):
        named = [line.split()[2:] for line in shown("history").splitlines() if line.startswith("    contourctl help ")]
        self.assertIn(["maintenance", "history"], named)
        self.assertTrue(shown("maintenance", "history").startswith("History\n-------\n"))

    def test_an_unknown_word_is_an_error_that_suggests_a_similar_one(self):
        for words, like in (["printng"], b"printing"), (["submti"], b"submit"), (["xyzzyxyzzy"], b"contourctl help lists"):
            result = contourctl("help", *words)
            self.assert_refusal(result, BAD_USAGE, like)
        for words in ([""], ["\x1b[2J\n"], ["x" * 100_000], [b"\xff"]):
            result = contourctl("help", *words)
            self.assert_refusal(result, BAD_USAGE)
            self.assertNotIn(b"\x1b", result.stderr)
            self.assertLess(len(result.stderr), 5000)

    def test_no_line_is_wider_than_the_terminal_except_commands_and_addresses(self):
        for columns in (40, 80, 200):
            for page in pages():
                code, text = in_terminal(page, columns=columns, PAGER="cat")
                self.assertEqual(code, OK)
                wide = [line for line in text.splitlines() if len(line) > min(columns, 100) and not line.startswith("    ")]
                self.assertEqual([line for line in wide if " " in line.strip()], [], (page, columns))
                self.assertNotRegex(text, r"(?m)\*\*|\]\([a-z-]+\.md|^\|")

    def test_in_a_terminal_the_page_goes_to_the_user_s_pager(self):
        code, text = in_terminal("safety", PAGER="sed 's/^/> /'; exit 3")
        self.assertEqual((code, text.splitlines()[0]), (3, "> Light safety"))
        self.assertTrue(all(line.startswith("> ") for line in text.splitlines()))
        self.assertEqual(in_terminal("safety", PAGER="printf %s $LESS", LESS="X")[1], "X")
        self.assertEqual(in_terminal("safety", PAGER="printf %s $LESS")[1], os.environ.get("LESS", "FRX"))

    def test_without_a_pager_or_in_a_dumb_terminal_the_page_is_printed(self):
        for environment in ({"PAGER": ""}, {"PAGER": "cat"}, {"PAGER": "false", "TERM": "dumb"}):
            code, text = in_terminal("safety", **environment)
            self.assertEqual(code, OK)
            self.assertTrue(text.startswith("Light safety\n==="), text[:80])

    def test_help_needs_no_file_besides_the_program(self):
        result = subprocess.run([self.reachable(CONTOURCTL), "help", "trouble"], capture_output=True, text=True, check=True, cwd="/")
        self.assertIn("A job waits\n-----------\n", result.stdout)
