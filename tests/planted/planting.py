"""Plants mistakes into a scratch copy of the committed sources, one at a time."""

import contextlib
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MARK = "contourd.scratch"


def git(folder, *arguments):
    return subprocess.run(["git", "-C", folder, *arguments], check=True, capture_output=True, text=True).stdout


def copy_head(folder):
    """Checks out the last commit in a new folder, or again in one that this function made. Files that git ignores, such as
    build folders, stay."""
    folder = folder.resolve()
    if not folder.exists() or not any(folder.iterdir()):
        folder.mkdir(parents=True, exist_ok=True)
        git(folder, "init", "--quiet")
        git(folder, "config", MARK, "true")
    if subprocess.run(["git", "config", "--file", folder / ".git/config", MARK], capture_output=True).returncode != 0:
        sys.exit(f"{folder} is not empty and was not made by this command: name a new folder")
    git(folder, "fetch", "--quiet", "--depth=1", f"file://{ROOT}", "HEAD")
    git(folder, "checkout", "--quiet", "--force", "--detach", "FETCH_HEAD")
    return folder


def planted_text(name, text, changes):
    for old, new in zip(changes[::2], changes[1::2]):
        if text.count(old) != 1:
            sys.exit(f"{name}: this text occurs {text.count(old)} times instead of once: {old}")
        text = text.replace(old, new)
    return text


@contextlib.contextmanager
def planted(name, path, changes):
    """Replaces texts, each of which occurs exactly once in the file, as long as the context lasts."""
    sound = path.read_text()
    path.write_text(planted_text(name, sound, changes))
    try:
        yield
    finally:
        path.write_text(sound)


def build(source, folder, *targets):
    made = subprocess.run([source / ".ci/build", folder, "--", *targets], capture_output=True, text=True)
    if made.returncode != 0:
        sys.exit(f"the build failed:\n{made.stdout[-3000:]}{made.stderr[-3000:]}")
