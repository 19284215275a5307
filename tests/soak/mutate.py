#!/usr/bin/env python3
"""Puts defects into the daemon, one at a time, and checks that the soak finds each: a soak that finds nothing proves nothing.
It works on a copy of the committed sources in a new folder.

    tests/soak/mutate.py FOLDER [--minutes N] [--seed S] [--only PART_OF_A_NAME]
"""

import argparse
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "rig"))

from mutate import copy_head  # noqa: E402

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


def found(source, build, options):
    made = subprocess.run([source / ".ci/build", build, "--", "contourd", "make-model", "slow-disk", "give-back"], capture_output=True, text=True)
    if made.returncode != 0:
        sys.exit(f"the build failed:\n{made.stdout[-3000:]}{made.stderr[-3000:]}")
    soak = subprocess.run([source / "tests/soak/soak", "--bin", build / "bin", "--minutes", str(options.minutes), "--seed", str(options.seed)],
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
    source, build = copy_head(options.folder), options.folder / "build"
    if not options.only and (what := found(source, build, options)):
        sys.exit(f"without any defect: {what}")
    missed = 0
    for name, file, old, new in MUTATIONS:
        if options.only not in name:
            continue
        path = source / file
        sound = path.read_text()
        if sound.count(old) != 1:
            sys.exit(f"{name}: {file} has {sound.count(old)} times: {old}")
        path.write_text(sound.replace(old, new))
        what = found(source, build, options)
        path.write_text(sound)
        print(f"{'found ' if what else 'MISSED'}  {name}" + (f"\n        {what[:300]}" if what else ""), flush=True)
        missed += not what
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
