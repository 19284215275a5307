#!/usr/bin/env python3
"""Measures what the README promises, on this machine, and prints a table (or --json).

    tests/bench/bench.py [--bin build/bin] [--runs 5] [--json]

Figures are medians of whole runs. The thesis's models are not public; where the liver that it shares with Minetto et al.
is at hand (../shared/models), it is measured too. Slic3r is run beside it when it is installed.
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
LIVER = ROOT.parent / "shared/models/minetto-liver.stl"


def seconds(command):
    start = time.monotonic()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - start


def first_mask_ms(bin_folder, runs):
    """From the file's close in incoming/ to the first mask, by the running daemon's own report."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        shutil.copytree(ROOT / "config", folder, dirs_exist_ok=True)
        config = json.loads((folder / "simulated.json").read_text())
        config["wait_for_plate_cleared"] = False
        del config["simulation"]["masks_folder"]
        (folder / "printer.json").write_text(json.dumps(config))
        model = folder / "model.stl"
        subprocess.run([bin_folder / "make-model", "gyroid-sphere", model, "53"], check=True, stdout=subprocess.DEVNULL)
        facets = (model.stat().st_size - 84) // 50
        daemon = subprocess.Popen([bin_folder / "contourd", "--config", folder / "printer.json"], stderr=subprocess.DEVNULL)
        figures = []
        try:
            incoming, done = folder / "spool/incoming", folder / "spool/done"
            for run in range(runs):
                while not incoming.exists():
                    time.sleep(0.01)
                shutil.copy(model, incoming / f"run{run}.stl")
                subprocess.run([bin_folder / "contourctl", "watch", "--socket", folder / "control.sock", "--job", f"run{run}"],
                               check=True, stdout=subprocess.DEVNULL)
                report = json.loads((done / f"run{run}.report.json").read_text())
                figures.append(report["arrival_to_first_mask_ms"])
        finally:
            daemon.terminate()
            daemon.wait()
    return facets, figures


def measure(bin_folder, runs):
    rows = []

    def row(what, figures, unit, reach=None, note=""):
        rows.append({"what": what, "median": statistics.median(figures), "worst": max(figures), "unit": unit,
                     "reach": reach, "note": note})

    facets, figures = first_mask_ms(bin_folder, runs)
    row(f"file closed in incoming/ to first mask, {facets} facets", figures, "ms", 200)
    if not LIVER.exists():
        print("SKIPPED: the liver model is not at hand")
        return rows
    with tempfile.TemporaryDirectory() as name:
        slice_liver = [bin_folder / "contourctl", "slice", LIVER, "--layer-height-um", "32", "--csv", f"{name}/liver.csv"]
        ours = [seconds(slice_liver) for _ in range(runs)]
        row("liver, contours of 6242 layers to CSV", ours, "s", 1.0, "thesis 1.483 s, Slic3r there 3.89 s, Park 37.24 s")
        if shutil.which("slic3r"):
            theirs = seconds(["slic3r", "--export-svg", "--layer-height", "0.032", "--first-layer-height", "0.032",
                              "-o", f"{name}/liver.svg", LIVER])
            row("the same by Slic3r (SVG)", [theirs], "s", None, f"{theirs / statistics.median(ours):.0f} times ours")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/bin")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    rows = measure(arguments.bin.resolve(), arguments.runs)
    if arguments.json:
        print(json.dumps(rows, indent=1))
        return
    print(f"{'what':<58} {'median':>9} {'worst':>9}       {'reach':>7}")
    for row in rows:
        reach = f"<= {row['reach']:g}" if row["reach"] else ""
        print(f"{row['what']:<58} {row['median']:>9.3f} {row['worst']:>9.3f} {row['unit']:<4} {reach:>9}  {row['note']}")


if __name__ == "__main__":
    main()
