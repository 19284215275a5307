"""The screen seen from outside the machine: QEMU's picture of a virtio-gpu display is compared with the core's mask."""

import tempfile
from pathlib import Path

import numpy

from bed import core_masks, guests, models
from bed.architecture import AMD64
from bed.qemu import Machine
from bed.registry import vm_test

_MODEL_MM = 0.1
_LAYER_NM = 50_000


def _screen(machine):
    """Returns the screen's picture, height x width x 3."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "screen.ppm")
        machine.qmp("screendump", filename=str(path))
        kind, size, depth, pixels = path.read_bytes().split(b"\n", 3)
    assert (kind, depth) == (b"P6", b"255")
    width, height = map(int, size.split())
    return numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3)


def _mask(layer):
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.stl")
        model.write_bytes(models.binary_stl(models.twisted_star(_MODEL_MM)))
        return core_masks.mask_at(model, _LAYER_NM * layer - _LAYER_NM // 2)


def _differing(screen, mask):
    assert screen.shape[:2] == mask.shape, f"the screen is {screen.shape[1]}x{screen.shape[0]}"
    return int((screen != mask[..., None]).any(axis=2).sum())


@vm_test("full")
def pixel_truth():
    """In each exposure all 2,073,600 pixels of the screen equal the core's mask; the screen is black after the print, and
    no console appears when the daemon has ended."""
    config = guests.real_config(display={"card": "virtio_gpu"}, projector={"port": None, "table": None})
    resin = {**guests.QUICK_RESIN, "exposure_ms": 20000, "bottom_exposure_ms": 20000}
    guest = guests.printer_guest(AMD64, config, _MODEL_MM, resin)
    guest.add_kernel_modules("virtio_gpu")
    gpu = ["-device", "virtio-gpu-pci,xres=1920,yres=1080"]
    with guests.written(guest) as initramfs, Machine(AMD64, initramfs, extra=gpu, memory_mb=768) as machine:
        machine.wait_until_ready()
        machine.run(". /lib.sh; insmod /mod/zplant.ko start_pos=2000")
        machine.run("start_daemon; print_model")
        compared = []
        for layer in (1, 2):
            machine.wait_for("light_is_on", limit_s=120)
            screen = _screen(machine)
            assert machine.run("light_is_on && echo lit") == "lit", "the exposure was over before the picture was taken"
            compared.append(_differing(screen, _mask(layer)))
            machine.wait_for("light_is_off")
        machine.wait_for("print_is_over", limit_s=120)
        assert not _screen(machine).any(), "the screen is not black after the print"
        machine.run("stop_daemon")
        assert not _screen(machine).any(), "the screen is not black after the daemon has ended"
    assert compared == [0, 0], f"{compared} pixels differ"
    return "0 of 2,073,600 pixels differ"
