"""README.md, CONTRIBUTING.md and docs/: their links have targets, the files, symbols and options they name exist, and the
pages are installed."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from harness import BAD_DATA, OK, binary_stl, box

ROOT = pathlib.Path(os.environ["CONTOURD_SOURCE"])
BIN = pathlib.Path(os.environ["CONTOURD_BIN"])
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
# Folders with sources. Files that a build or a run makes are not looked for.
FOLDERS = ("core", "hw", "daemon", "config", "tests", "docs", "systemd", "packaging", ".ci", ".readme")
MOST_WORDS = 900


def text_of(page):
    return page.read_text(encoding="utf-8")


def without_fences(text):
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def without_code(text):
    text = without_fences(text)
    text = re.sub(r"(?:^\n)(?:^    .*\n)+", "\n", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "", text)


def links(page):
    return re.findall(r"\[[^\]]*\]\(([^)\s]+)\)", without_code(text_of(page)))


def anchors(page):
    """Yields the anchors that GitHub makes from the page's headings."""
    for heading in re.findall(r"^#+ (.*)$", without_fences(text_of(page)), re.MULTILINE):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def code_spans(page):
    return re.findall(r"`([^`\n]+)`", without_fences(text_of(page)))


def command_lines(page):
    """Yields the commands in indented lines, sh fences and code spans: each part of a pipe or list by itself, without comments."""
    text = text_of(page)
    lines = re.findall(r"^    (.*)$", text, re.MULTILINE)
    for block in re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        lines += block.splitlines()
    for line in [*lines, *code_spans(page)]:
        yield from (part.strip() for part in re.split(r"&&|\|\||[|;]", line.split(" #")[0]))


def table_rows(page):
    """Yields the rows of all tables as dictionaries from column name to cell."""
    names = None
    for line in text_of(page).splitlines():
        if not line.startswith("|"):
            names = None
            continue
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip("|"))]
        if names is None:
            names = cells
        elif not set(line) <= set("|-: "):
            yield dict(zip(names, cells, strict=True))


def broken_relative_links(pages, root):
    for page in pages:
        for link in links(page):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page.resolve()
            if not target.exists() or not target.is_relative_to(root.resolve()):
                yield f"{page.name}: {link}"
            elif anchor and anchor not in anchors(target):
                yield f"{page.name}: {link}: no such heading"


class DocsTest(unittest.TestCase):
    def test_every_link_has_a_target(self):
        self.assertGreater(sum(len(links(page)) for page in PAGES), 30)
        self.assertEqual(list(broken_relative_links(PAGES, ROOT)), [])

    def test_every_page_can_be_reached_from_the_readme(self):
        reached, new = set(), {ROOT / "README.md"}
        while new:
            reached |= new
            targets = {(page.parent / link.split("#")[0]).resolve() for page in new for link in links(page)}
            new = {page for page in PAGES if page.resolve() in targets} - reached
        self.assertEqual(set(PAGES) - reached, set())

    def test_the_readme_can_be_read_in_five_minutes(self):
        self.assertLessEqual(len(text_of(ROOT / "README.md").split()), MOST_WORDS)

    def test_every_source_that_is_named_exists(self):
        named = 0
        for page in PAGES:
            for span in code_spans(page):
                for path in re.findall(rf"(?<![\w/.-])(?:{'|'.join(map(re.escape, FOLDERS))})/[\w.*/-]*", span):
                    named += 1
                    self.assertTrue(list(ROOT.glob(path.rstrip("/."))), f"{page.name}: {path}")
        self.assertGreater(named, 100)

    def test_every_symbol_of_a_table_is_in_its_file(self):
        checked = 0
        for page in PAGES:
            for row in table_rows(page):
                if "file" not in row or "symbol" not in row:
                    continue
                with self.subTest(page=page.name, row=row):
                    files = re.findall(r"`([^`]+)`", row["file"])
                    symbols = re.findall(r"`([^`]+)`", row["symbol"])
                    self.assertTrue(files and symbols)
                    code = "".join(text_of(ROOT / file) for file in files)
                    for symbol in symbols:
                        checked += 1
                        self.assertRegex(code, rf"\b{re.escape(symbol)}\b")
        self.assertGreater(checked, 60)

    def test_every_option_that_is_named_exists(self):
        checked = 0
        for page in PAGES:
            for line in command_lines(page):
                words = line.split()
                while words and (words[0] in ("sudo", "nice") or re.fullmatch(r"\w+=\S*", words[0])):
                    words.pop(0)
                name = os.path.basename(words[0]) if words else ""
                if name not in ("contourd", "contourctl", "contourd-bench", "print-rig"):
                    continue
                # A command has one word, or two.
                length = 2 if words[1:2] and words[1] in ("motor", "light", "projector", "config", "calibrate", "export", "fit", "web") else 1
                if words[1:2] == ["queue"] and re.match("[a-z]", " ".join(words[2:])):
                    length = 2
                command = [BIN / name, *(words[1:1 + length] if name == "contourctl" and words[1:2] else []), "--help"]
                given = [word.split("=")[0] for word in words[1:] if word.startswith("--")]
                with self.subTest(page=page.name, line=line):
                    result = subprocess.run(command, capture_output=True, timeout=60, check=False)
                    self.assertEqual(result.returncode, 0, result.stderr)
                    if name == "contourctl" and words[1:2] and not words[1].startswith("-"):
                        self.assertRegex(result.stdout.decode(), rf"Usage: \S+ {re.escape(' '.join(words[1:1 + length]))} ")
                    for option in given:
                        checked += 1
                        self.assertRegex(result.stdout.decode(), rf"(?<![\w-]){re.escape(option)}(?![\w-])")
        self.assertGreater(checked, 10)

    def test_the_readmes_commands_run_on_the_model_that_the_demo_leaves(self):
        rows = [row["try"] for row in table_rows(ROOT / "README.md") if "try" in row]
        commands = [command for cell in rows for command in re.findall(r"`([^`]+)`", cell)]
        commands += re.findall(r"^    (build/bin/.*?)(?:  +#.*)?$", text_of(ROOT / "README.md"), re.MULTILINE)
        commands = [command for command in commands if not command.startswith(("./demo.sh", ".ci/build build -- contourd-bench &&"))]
        self.assertGreater(len(commands), 10)
        self.assertIn("build/part.stl", text_of(ROOT / "demo.sh"))
        with tempfile.TemporaryDirectory() as folder:
            model = pathlib.Path(folder, "part.stl")
            model.write_bytes(binary_stl([*box((0, 0, 0), (10, 5, 12)), *box((20, 0, 3), (25, 5, 12))]))
            for command in commands:
                with self.subTest(command):
                    self.assertTrue(command.startswith("build/bin/"), command)
                    words = [re.sub("^build/", f"{folder}/", re.sub("^build/bin", str(BIN), word)) for word in command.split()]
                    result = subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False)
                    # README.md is not a model.
                    self.assertEqual(result.returncode, BAD_DATA if words[-1] == "README.md" else OK, result)

    def test_every_heading_that_a_source_refers_to_exists(self):
        """Sources refer to a heading as: page, comma, the heading in quotes."""
        referred = 0
        for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*")):
            if path.suffix not in (".cpp", ".hpp", ".py", ".json", ".md", ".service") or not path.is_file():
                continue
            for page, heading in re.findall(r'((?:docs/[\w-]+|README|CONTRIBUTING)\.md), \\?"([^"\\]+)\\?"', text_of(path)):
                referred += 1
                self.assertRegex(text_of(ROOT / page), rf"(?m)^#+ {re.escape(heading)}$", path)
        self.assertGreater(referred, 0)

    def test_links_between_installed_pages_have_targets(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["cmake", "--install", BIN.parent, "--prefix", "/usr", "--component", "docs"], check=True,
                           capture_output=True, env={**os.environ, "DESTDIR": folder})  # fmt: skip
            root = pathlib.Path(folder, "usr/share/doc/contourd")
            pages = [root / page.relative_to(ROOT) for page in PAGES]
            for page in pages:
                self.assertTrue(page.is_file(), page)
            self.assertEqual(list(broken_relative_links(pages, root)), [])
