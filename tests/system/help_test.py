"""contourctl help: the manual page, and the usage of commands."""

import os

from harness import BAD_USAGE, CONTOURD, OK, FolderTest, contourctl, run


class Help(FolderTest):
    def with_man(self, script):
        """Returns an environment whose `man` is this shell script."""
        path = self.write("man", "#!/bin/sh\n" + script)
        os.chmod(path, 0o755)
        return {**os.environ, "PATH": f"{os.fsdecode(self.path())}:{os.environ['PATH']}"}

    def shown(self, *words, **options):
        result = contourctl("help", *words, **options)
        self.assertEqual((result.returncode, result.stderr), (OK, b""), result)
        return result.stdout.decode()

    def test_without_a_command_man_shows_the_manual_page(self):
        page = self.with_man('[ "$1" = -w ] && exec echo /man1/contourctl.1\necho page: "$@"; exit 3')
        result = contourctl("help", env=page)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (3, b"page: contourctl\n", b""))

    def test_without_man_or_its_page_the_commands_are_listed(self):
        commands = contourctl("--help").stdout.decode()
        stub = "echo 'No manual entry for contourctl'; exit 16"
        for environment in (self.with_man(stub), {**os.environ, "PATH": os.fsdecode(self.path("none"))}):
            text = self.shown(env=environment)
            self.assertTrue(text.startswith(commands), text)
            self.assertRegex(text, r"\nManual: man contourctl, .*; guides: /\S+/docs\n$")

    def test_the_usage_of_a_command_is_that_of_its_help_option(self):
        for words in (["submit"], ["queue"], ["queue", "move"]):
            text = self.shown(*words)
            self.assertTrue(text.startswith(contourctl(*words, "--help").stdout.decode()), text)
            self.assertIn("\nManual: man contourctl", text)

    def test_an_unknown_command_is_an_error_that_says_how_to_list_the_commands(self):
        for words in ["submti"], ["queue", "sort"], [""], ["\x1b[2J\n"], ["x" * 100_000], [b"\xff"]:
            result = contourctl("help", *words)
            self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), words)
            meant = b"did you mean submit?" if words == ["submti"] else b"contourctl --help lists the commands"
            self.assert_one_line(result.stderr, b"there is no command", meant)
            self.assertNotIn(b"\x1b", result.stderr)
            self.assertLess(len(result.stderr), 5000)

    def test_a_command_or_option_that_is_mistyped_leads_to_the_nearest_one(self):
        for words, sentence in (
            (["statsu"], "unknown command statsu; did you mean status?"),
            (["statsu", "--json"], "unknown command statsu; did you mean status?"),
            (["queue", "mvoe", "part"], "unknown command mvoe; did you mean move?"),
            (["light", "onn"], "unknown command onn; did you mean on?"),
            (["print"], "unknown command print"),
            ([b"\xff\x1b[2J"], "unknown command \ufffd?[2J"),
            (["status", "--jsno"], "unknown option --jsno; did you mean --json?"),
            (["status", "-json"], "unknown option -json; did you mean --json?"),
            (["slice", "part.stl", "--layer-hight-um=50"], "unknown option --layer-hight-um; did you mean --layer-height-um?"),
            (["move", "--by", "-3", "--sped", "1"], "unknown option --sped; did you mean --speed?"),
            (["--json", "status"], "--json has to follow the command status"),
            (["--versoin"], "unknown option --versoin; did you mean --version?"),
        ):
            with self.subTest(words):
                result = contourctl(*words)
                self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), result)
                self.assertEqual(result.stderr.decode(), f"{sentence}\nRun with --help for more information.\n")
        self.assertLess(len(contourctl("x" * 100_000).stderr), 200)
        self.assertEqual(run(CONTOURD, "--confg", "x").stderr.splitlines()[0], b"unknown option --confg; did you mean --config?")

    def test_where_a_command_is_missing_the_help_lists_the_commands(self):
        for words in [], ["light"], ["motor"]:
            result = contourctl(*words)
            self.assertEqual((result.returncode, result.stdout), (BAD_USAGE, b""), result)
            self.assertEqual(result.stderr, contourctl(*words, "--help").stdout)
