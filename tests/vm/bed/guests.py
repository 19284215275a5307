"""The guests that the tests boot: what is in their initial file systems."""

import json
import tempfile
from contextlib import contextmanager
from pathlib import Path

from bed import models
from bed.architecture import BED, SOURCE, VM
from bed.initramfs import Initramfs

_SCREEN_MODULES = ("drm_kms_helper", "drm_shmem_helper")
_VIRTIO_MODULES = ("virtio_pci", "virtio_blk", "virtio_console")


def printer_guest(arch, config, model_height_mm=0.2, resin=None, ticket=None):
    """contourd with its configuration, a model to print and our devices' modules."""
    guest = Initramfs(arch)
    guest.add_kernel_modules(*_SCREEN_MODULES, *_VIRTIO_MODULES)
    guest.add_our_modules()
    for program in ("contourd", "contourctl", "fake-projector"):
        guest.add_program(program)
    guest.add_text("/etc/contourd/contourd.json", json.dumps(config, indent=1))
    guest.add_folder("/etc/contourd", SOURCE / "config" / "projectors")
    profile = json.loads((SOURCE / "config" / "resins" / "standard.json").read_text())
    profile.pop("$schema")
    guest.add_text("/etc/contourd/resins/standard.json", json.dumps({**profile, **(resin or {})}))
    guest.add_bytes("/model.stl", models.binary_stl(models.twisted_star(model_height_mm)))
    guest.add_file("/lib.sh", VM / "guest" / "lib.sh")
    return guest


@contextmanager
def written(guest):
    """The guest's initramfs as a file, for as long as the context lasts."""
    with tempfile.NamedTemporaryFile(prefix="initramfs.", dir=BED) as file:
        guest.write(Path(file.name))
        yield Path(file.name)


def simulated_config(**changes):
    config = json.loads((SOURCE / "config" / "contourd.json").read_text())
    config.pop("$schema")
    config["projector"]["warm_up_s"] = 1
    config["wait_for_plate_cleared"] = False
    config["min_free_disk_mb"] = 0
    return {**config, **changes}


# Short prints: every layer is short of nothing that a long one has.
QUICK_RESIN = {
    "exposure_ms": 1000,
    "bottom_exposure_ms": 2000,
    "bottom_layers": 1,
    "fade_layers": 0,
    "lift_mm": 1,
    "settle_ms": 200,
    "rest_ms": 100,
}
