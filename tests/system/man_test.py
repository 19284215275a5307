"""Compares the manual pages with the programs and the schemas, and checks their markup."""

import glob
import json
import os
import re
import shutil
import subprocess
import unittest

from harness import BIN, CONTOURCTL, CONTOURD, CONTOURD_WEB, SOURCE, check_generated, contents, text_of

PAGES = [*glob.glob(os.path.join(SOURCE, "docs/man/*.[18]")), *glob.glob(os.path.join(os.path.dirname(BIN), "config/*.5"))]
FORMATS = {"contourd.json": "contourd", "contourd-resin": "resin", "contourd-projector": "projector",
           "contourd-ticket": "ticket", "contourd-plate": "plate", "contourd-web.json": "web"}  # fmt: skip


def source_of(page):
    [path] = [path for path in PAGES if os.path.basename(path) == page]
    return text_of(path)


def plain(page):
    """Returns the text of a page without roff's escapes."""
    return re.sub(r"\\f.", "", source_of(page).replace("\\-", "-").replace("\\&", "").replace("\\e", "\\"))


def help_of(*command):
    return subprocess.run([*command, "--help"], capture_output=True, text=True, check=True).stdout


def commands_in(text):
    return re.findall(r"^  ([a-z][a-z-]*) ", text, re.MULTILINE)


def options_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text)) - {"--help"}


def keys_of(schema, root, folder, path=""):
    """Yields the keys of a schema in the notation of the pages: z_axis.lead_mm, models[].file."""
    if "$ref" in schema:
        file, pointer = schema["$ref"].split("#/")
        if file:
            with open(os.path.join(folder, file), encoding="utf-8") as source:
                root = json.load(source)
        schema = root
        for name in pointer.split("/"):
            schema = schema[name]
    for key, value in schema.get("properties", {}).items():
        if key != "$schema" and value is not False:
            yield path + key
            yield from keys_of(value, root, folder, f"{path}{key}.")
    if "items" in schema:
        yield from keys_of(schema["items"], root, folder, path[:-1] + "[].")


def roff(text):
    return text.replace("\\", "\\e").replace("-", "\\-")


def usage_of(option):
    """Returns an option with its value, as roff: --aa on|off."""
    value = "|".join(f"\\fB{roff(choice)}\\fR" for choice in option["choices"])
    value = value or (f"\\fI{option['value']}\\fR" if option["value"] else "")
    if not option["name"].startswith("-"):
        value = "|".join(f"\\fB{roff(choice)}\\fR" for choice in option["choices"]) or f"\\fI{option['name']}\\fR"
        value += "..." if option["list"] else ""
        return value if option["required"] else f"[{value}]"
    return ", ".join(f"\\fB{roff(name)}\\fR" for name in option["name"].split(",")) + (f" {value}" if value else "")


def entry(command):
    """Returns the page's entry about a command: its usage, its help and its options. Options that most commands have are described
    in the section's introduction."""
    options, arguments = [], []
    names = [option["name"] for option in command["options"]]
    for option in command["options"]:
        common = option["name"] == "--socket" or (option["name"] == "--json" and "--socket" in names)
        if not option["name"].startswith("-"):
            arguments.append(usage_of(option))
        elif not common:
            options.append(option)
    usage = [f"\\fB{roff(command['command'])}\\fR", *(["[\\fIOPTION\\fR...]"] if options else []), *arguments]
    lines = [".TP", " ".join(usage), roff(command["help"]) + "."]
    if options:
        lines.append(".RS")
        for option in options:
            default = f"; default: {option['default']}" if option["default"] else ""
            lines += [".TP", usage_of(option), roff(f"{option['help']}{default}.".replace("....", "..."))]
        lines.append(".RE")
    return "".join(line + "\n" for line in lines)


class Man(unittest.TestCase):
    def test_the_entries_of_the_commands_come_from_the_program(self):
        described = json.loads(subprocess.run([CONTOURCTL, "describe"], capture_output=True, text=True, check=True).stdout)
        self.assertGreater(len(described), 30)
        check_generated(self, "docs/man/contourctl.1", '.\\" begin {}\n', '.\\" end\n', {each["command"]: entry(each) for each in described})

    def test_each_page_of_a_program_has_exactly_its_options(self):
        commands = commands_in(help_of(CONTOURCTL))
        self.assertGreater(len(commands), 10)
        groups = {each: commands_in(help_of(CONTOURCTL, each)) for each in commands}
        commands = [words for each, below in groups.items() for words in ([f"{each} {word}" for word in below] or [each])]
        existing = options_in(help_of(CONTOURCTL)).union(*(options_in(help_of(CONTOURCTL, *each.split())) for each in commands))
        page = plain("contourctl.1")
        self.assertEqual(options_in(page), existing)
        for command in commands:
            self.assertRegex(page, rf"(?m)^{command}\b", command)
        self.assertEqual(options_in(plain("contourd.8")), options_in(help_of(CONTOURD)))
        self.assertEqual(options_in(plain("contourd-web.8")), options_in(help_of(CONTOURD_WEB)))

    def test_the_page_groups_the_commands_by_task_as_help_does(self):
        groups = re.findall(r"(?ms)^([A-Z][\w ]+):\n(.*?)(?=^\w|\Z)", help_of(CONTOURCTL))
        in_help = {heading: commands_in(text) for heading, text in groups if heading != "Options"}
        self.assertGreater(len(in_help), 4)
        self.assertLess(max(map(len, in_help.values())), 15)
        commands = plain("contourctl.1").partition(".SH EXIT STATUS")[0]
        in_page = {heading: list(dict.fromkeys(re.findall(r"(?m)^\.TP\n([a-z][a-z-]*)", text))) for heading, text in re.findall(r"(?ms)^\.SS (.*?)\n(.*?)(?=^\.S[SH]|\Z)", commands)}
        self.assertEqual(list(in_page.items()), list(in_help.items()))

    def test_each_option_of_a_command_is_in_the_paragraph_of_the_command(self):
        page = plain("contourctl.1")
        for command, least in (("slice", 18), ("analyze", 9), ("preview", 5), ("submit", 15), ("offer", 3), ("history", 1), ("queue move", 3), ("logs", 2), ("diagnose", 2), ("watch", 1), ("setup", 6)):
            own = options_in(help_of(CONTOURCTL, *command.split())) - {"--socket"}
            part = re.search(rf"(?ms)^{command} .*?(?=^\.TP\n[a-z]|^\.S[HS] )", page)
            self.assertIsNotNone(part, command)
            documented = options_in(part[0])
            self.assertGreaterEqual(len(documented), least, command)
            self.assertEqual(own - documented - {"--json"}, set(), command)

    def test_each_format_page_has_the_keys_of_its_schema(self):
        folder = os.path.join(SOURCE, "config")
        for page, name in FORMATS.items():
            with self.subTest(page):
                schema = json.loads(contents(os.path.join(folder, f"{name}.schema.json")))
                named = re.findall(r"(?m)^\.B (\S+)$", plain(f"{page}.5"))
                self.assertEqual(sorted(named), sorted(keys_of(schema, schema, folder)))
                self.assertGreater(len(named), 4 if name == "web" else 6)

    def test_every_page_that_is_referred_to_exists(self):
        existing = {re.sub(r"\.(\d)$", r"(\1)", os.path.basename(path)) for path in PAGES}
        self.assertEqual(len(existing), 3 + len(FORMATS))
        for path in PAGES:
            name = os.path.basename(path)
            for other, section in re.findall(r"(?m)^\.BR (contour\S+) \((\d)\)", plain(name)):
                self.assertIn(f"{other}({section})", existing, name)

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_groff_reports_no_mistake_in_a_page(self):
        for path in PAGES:
            seen = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-rLL=80n", path], capture_output=True, text=True, check=True)
            self.assertEqual(seen.stderr, "", path)
            self.assertGreater(len(seen.stdout.splitlines()), 30, path)
