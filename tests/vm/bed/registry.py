"""The list of tests, and how they are run. A test is a function that raises on failure; its docstring is a sentence."""

import importlib
import sys
import threading
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Callable

from bed.architecture import VM

_tests = []


class Skipped(Exception):
    """Raised with a reason if this machine cannot run the test."""


@dataclass(frozen=True)
class VmTest:
    name: str
    tier: str
    other_debian: bool
    alone: bool
    call: Callable

    @property
    def sentence(self):
        return " ".join(self.call.__doc__.split())


def vm_test(tier, name=None, other_debian=False, alone=False):
    """Makes a test of a function, with tier "quick" (which is also part of "full") or "full". A test with `alone`
    measures real time and runs while no other test does."""

    def register(call):
        test = VmTest(name or call.__name__.replace("_", "-"), tier, other_debian, alone, call)
        if any(other.name == test.name for other in _tests):
            raise ValueError(f"two tests are called {test.name}")
        _tests.append(test)
        return call

    return register


def select(names):
    for file in sorted((VM / "tests").glob("*_test.py")):
        importlib.import_module(f"tests.{file.stem}")
    if names in (["list"], ["full"]):
        return _tests
    if names == ["quick"]:
        return [test for test in _tests if test.tier == "quick"]
    known = {test.name: test for test in _tests}
    unknown = [name for name in names if name not in known]
    if unknown:
        sys.exit(f"No test is called {', '.join(unknown)}; there are: {', '.join(known)}")
    return [known[name] for name in names]


def check(broken):
    """Fails with the first ten sentences of a check."""
    if broken:
        more = f"\n... and {len(broken) - 10} more" if len(broken) > 10 else ""
        raise AssertionError("\n".join(broken[:10]) + more)


def run(tests, jobs):
    """Runs the tests. Returns the number of failed ones."""
    printing = threading.Lock()
    failed, skipped = [], []

    def one(test):
        start = time.monotonic()
        note, trouble, word = "", None, "ok  "
        try:
            note = test.call() or ""
        except Skipped as why:
            note, word = str(why), "SKIP"
            skipped.append(test.name)
        except Exception as error:  # any exception is a failure of this test only
            trouble = traceback.format_exc() if not isinstance(error, AssertionError) else str(error) or traceback.format_exc()
        with printing:
            print(f"{'FAIL' if trouble else word} {test.name} ({time.monotonic() - start:.1f} s) {note}", flush=True)
            if trouble:
                failed.append(test.name)
                print("     " + trouble.rstrip().replace("\n", "\n     "), flush=True)

    with ThreadPoolExecutor(max(1, jobs)) as pool:
        list(pool.map(one, [test for test in tests if not test.alone]))
    for test in tests:
        if test.alone:
            one(test)
    skips = f"{len(skipped)} skipped, " if skipped else ""
    print(f"{len(tests) - len(failed) - len(skipped)} passed, {skips}{len(failed)} failed")
    return len(failed)
