#!/usr/bin/env python3
"""Puts defects into the daemon, one at a time, and checks that the soak finds each: a soak that finds nothing proves nothing.
It works in FOLDER, on a copy of the committed sources.

    tests/soak/mutate.py FOLDER [--minutes N] [--seed S] [--only PART_OF_A_NAME]
"""

import argparse
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "planted"))

from planting import build, copy_head, planted  # noqa: E402

CONTROL = "daemon/control/control_server.cpp"
PROCESS = "daemon/print/layered_print.cpp"
COPIES = "daemon/spool/printing_copies.cpp"

# Name, file, the text that occurs once in it, the replacement.
MUTATIONS = [
    ("a descriptor of each client stays open", CONTROL, "  const int key = socket.get();",
     "  const int key = ::dup(socket.get());"),
    ("a client's memory is not given back", CONTROL, "    std::erase_if(clients_, [](",
     "    for (auto& entry : clients_)\n      if (entry.second->closed()) (void)new std::string(2000, 'x');\n"
     "    std::erase_if(clients_, []("),
    ("the eighth layer has the mask of the seventh", PROCESS, "mask_within(record_.mask_height, budget)",
     "mask_within(record_.mask_height - (layer_ == 7 ? thickness_ : Nanometers{0}), budget)"),
    ("an interrupted layer has all its light once more", PROCESS, "  record_.exposure_least += light_->least();",
     "  record_.exposure_least = light_->least();"),
    ("what was being printed is removed at the start", COPIES,
     "void PrintingCopies::remove_leftovers() const {\n  std::error_code ignored;\n  fs::remove_all(under_way_, ignored);",
     "void PrintingCopies::remove_leftovers() const {\n  std::error_code ignored;\n"
     "  fs::remove_all(under_way_.parent_path(), ignored);\n  fs::create_directories(under_way_.parent_path(), ignored);"),
    ("a copied plate is not remembered", COPIES, "    originals_.add(mark);\n", "    (void)mark;\n"),
    ("links are followed", "daemon/system/regular_file.cpp", "kReading | O_NOFOLLOW", "kReading"),
    ("a file's name goes into the log as it is", "daemon/jobs/print_queue.cpp",
     'fmt::format("{}: arrived, number {} in the queue", printable(file), place + 1)',
     'fmt::format("{}: arrived, number {} in the queue", file, place + 1)'),
    ("a question takes 80 ms", "daemon/control/printer_status.cpp", "  const CurrentJob& job = parts_.job;\n",
     "  const timespec moment{0, 80'000'000};\n  ::nanosleep(&moment, nullptr);\n"
     "  const CurrentJob& job = parts_.job;\n"),
]


def found(source, options):
    build(source, source / "build", "contourd", "make-model", "slow-disk", "give-back")
    soak = subprocess.run([source / "tests/soak/soak", "--bin", source / "build/bin", "--minutes", str(options.minutes), "--seed", str(options.seed)],
                          capture_output=True, text=True)  # fmt: skip
    if soak.returncode == 0:
        return None
    return next((line for line in soak.stdout.splitlines() if line.startswith("BROKEN")), soak.stderr[-3000:])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--minutes", type=float, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    source = copy_head(options.folder)
    if not options.only and (what := found(source, options)):
        sys.exit(f"without any defect: {what}")
    missed = 0
    for name, file, old, new in MUTATIONS:
        if options.only not in name:
            continue
        with planted(name, source / file, (old, new)):
            what = found(source, options)
        print(f"{'found ' if what else 'MISSED'}  {name}" + (f"\n        {what[:300]}" if what else ""), flush=True)
        missed += not what
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
