"""Power cuts at random moments: jobs are dropped and printed on a disk whose writes are recorded (dm-log-writes), and the
daemon is started on the disk that each cut leaves."""

import base64
import io
import json
import os
import shutil
import tarfile
import tempfile
from contextlib import contextmanager
from pathlib import Path

from bed import guests, spool_checks, spool_jobs
from bed.architecture import AMD64, BED, VM, root_image
from bed.qemu import GuestFailure, Machine, disk_over

_DISK_MB = 16
_RECORD_MB = 1024  # sparse
_LIMIT_S = 3600


def _config(**changes):
    config = guests.simulated_config(spool_folder="/disk/spool", **changes)
    config["simulation"]["pace"] = "fast"
    config["z_axis"]["travel_mm"] = 20
    # Small masks, since this test is not about them.
    config["display"] |= {"width_px": 320, "height_px": 240, "pixel_pitch_um": 200}
    return config


def _guest():
    guest = guests.systemd_guest(_config())
    guest.add_kernel_modules("dm_log_writes")
    guest.add_program("replay-log", "/install/usr/local/bin/replay-log")
    for name, changes in (("printer", {}), ("careful-printer", {"wait_for_plate_cleared": True})):
        guest.add_text(f"/install/etc/contourd/{name}.json", json.dumps(_config(**changes)))
    for script in ("lib.sh", "power_cuts.sh"):
        guest.add_file(f"/install/srv/{script}", VM / "guest" / script)
    for job in spool_jobs.all_jobs():
        for path, data in job.files.items():
            guest.add_bytes(f"/install/srv/jobs/{job.name}/{path}", data)
    return guest


def _sparse(path, megabytes):
    with open(path, "wb") as file:
        file.truncate(megabytes << 20)


def _drive(name, path):
    drive = f"file={path},format=raw,if=none,id={name},cache=unsafe"
    return ["-drive", drive, "-device", f"virtio-blk-pci,drive={name},serial={name}"]


@contextmanager
def _machine(initramfs, disk, folder):
    drives = _drive("data", folder / "data") + _drive("record", folder / "record")
    with Machine(AMD64, initramfs, disk=disk, extra=drives, limit_s=_LIMIT_S) as machine:
        machine.wait_until_ready()
        machine.run("systemd-sysusers && udevadm settle")
        yield machine


def _kept_record(kind):
    return BED / f"power-cuts-{kind}.record"


def _seeds(kind, count):
    """Returns all seeds, or only the one that CUT=KIND:SEED asks for, to repeat a failure with its kept record."""
    wanted = os.environ.get("CUT", "").split(":")
    return range(1, count + 1) if wanted == [""] else [int(wanted[1])] if wanted[0] == kind else []


def _record_work(machine, kind):
    try:
        machine.run(f"sh /srv/power_cuts.sh work {kind}", limit_s=600)
    except GuestFailure as failure:
        said = machine.run("cat /run/out/daemon.log; tail -n 3 /run/out/told; find /disk", check=False)
        raise GuestFailure(f"{failure}\n{said}") from None


def _files(archive):
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        return {member.name.removeprefix("./"): tar.extractfile(member).read() for member in tar if member.isfile()}


def _cut(machine, seed):
    """Cuts the power. Returns the content of /run/out after guest/power_cuts.sh, and the place of the cut."""
    packed = machine.run(f"sh /srv/power_cuts.sh cut_power {seed} && tar -C /run/out -cz . | base64 -w0", limit_s=300)
    out = _files(base64.b64decode(packed))
    *marks, where = out["cut"].decode().splitlines()
    cut = spool_checks.Cut(
        marks=[mark.removeprefix("mark ") for mark in marks],
        found=_files(out["before.tar"]),
        left=_files(out["after.tar"]),
        status=json.loads(out["status"] or b"{}").get("result", {}),
        log=out["daemon.log"].decode(errors="replace"),
        exit_code=int(out["exit_code"]),
        trouble=out["trouble"].decode(errors="replace").strip(),
        empty=out["empty"].decode().splitlines(),
    )
    return cut, where


def _told(kind, seed, where, cut, broken):
    listings = (f"{title}: {' '.join(sorted(files))}" for title, files in (("found", cut.found), ("left", cut.left)))
    marks = f"marks: {' '.join(cut.marks)}"
    return "\n".join([f"CUT={kind}:{seed}, {where}", *(f"  {sentence}" for sentence in broken), marks, *listings, cut.log])


def run(kind, count):
    """Makes `count` power cuts. `kind` selects the other writer on the disk, see guest/power_cuts.sh. Returns a sentence
    with the number of cuts and barriers."""
    seeds = _seeds(kind, count)
    if not seeds:
        return "not selected"
    repeated = len(seeds) < count
    failures, barriers = [], {}
    with tempfile.TemporaryDirectory(prefix="cuts.", dir=BED) as name, guests.written(_guest()) as initramfs:
        folder = Path(name)
        _sparse(folder / "data", _DISK_MB)
        if repeated:
            shutil.copy(_kept_record(kind), folder / "record")
        else:
            _sparse(folder / "record", _RECORD_MB)
        with disk_over(root_image()) as disk, _machine(initramfs, disk, folder) as machine:
            if not repeated:
                _record_work(machine, kind)
            for seed in seeds:
                cut, where = _cut(machine, seed)
                barriers[where.split("barrier ")[1].split(";")[0]] = True
                broken = spool_checks.broken_rules(spool_jobs.all_jobs(), cut)
                if broken:
                    failures.append(_told(kind, seed, where, cut, broken))
            machine.power_off()
        if failures and not repeated:
            (folder / "record").rename(_kept_record(kind))
    if failures:
        raise AssertionError(f"{len(failures)} of {len(seeds)} cuts\n" + "\n\n".join(failures[:5]))
    return f"{len(seeds)} cuts, after {len(barriers)} of {next(iter(barriers)).split(' of ')[1]} barriers"
