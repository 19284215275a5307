#!/usr/bin/env python3
"""Measures the running daemon, which contourd-bench cannot do: from the close of a file in incoming/ to the first mask.

    tests/bench/daemon_first_mask.py [--bin build/bin] [--runs 5] [--cells 53]

The figure comes from the daemon's own report of the print. A gyroid of 53 cells has 294,000 facets; one of 110, 1.3 million.
"""

import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def configure(folder):
    shutil.copytree(ROOT / "config", folder, dirs_exist_ok=True)
    config = json.loads((folder / "simulated.json").read_text())
    config["wait_for_plate_cleared"] = False
    del config["simulation"]["masks_folder"]
    (folder / "printer.json").write_text(json.dumps(config))


def print_once(bin_folder, folder, model, job):
    """Returns the milliseconds from the model's arrival to its first mask."""
    # copy() would set the mode afterwards, when the daemon may already have moved the file.
    shutil.copyfile(model, folder / f"spool/incoming/{job}.stl")
    subprocess.run([bin_folder / "contourctl", "watch", "--socket", folder / "control.sock", "--job", job],
                   check=True, stdout=subprocess.DEVNULL)
    report = json.loads((folder / f"spool/done/{job}.report.json").read_text())
    return report["arrival_to_first_mask_ms"]


def measure(bin_folder, runs, cells):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        configure(folder)
        model = folder / "model.stl"
        subprocess.run([bin_folder / "make-model", "gyroid-sphere", model, str(cells)], check=True,
                       stdout=subprocess.DEVNULL)
        facets = (model.stat().st_size - 84) // 50
        daemon = subprocess.Popen([bin_folder / "contourd", "--config", folder / "printer.json"],
                                  stderr=subprocess.DEVNULL)
        try:
            while not (folder / "spool/incoming").exists():
                time.sleep(0.01)
            return facets, [print_once(bin_folder, folder, model, f"run{run}") for run in range(runs)]
        finally:
            daemon.terminate()
            daemon.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/bin")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--cells", type=int, default=53)
    arguments = parser.parse_args()
    facets, figures = measure(arguments.bin.resolve(), arguments.runs, arguments.cells)
    print(f"file closed in incoming/ to first mask, {facets} facets: median {statistics.median(figures):.1f} ms, "
          f"worst {max(figures):.1f} ms of {len(figures)}")


if __name__ == "__main__":
    main()
