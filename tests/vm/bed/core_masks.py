"""The core's masks, computed outside the guest with contourctl at exact heights, and their CRC as zproj computes it."""

import os
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy

from bed.architecture import AMD64, SOURCE

os.environ.setdefault("CONTOURD_BIN", str(AMD64.program("contourd").parent))
os.environ.setdefault("CONTOURD_SOURCE", str(SOURCE))
sys.path.insert(0, str(SOURCE / "tests" / "system"))
import harness  # noqa: E402


def mask_at(model, height_nm, *options):
    """Returns the mask of a model file at a height, as rows of grey values (numpy, height x width)."""
    with tempfile.TemporaryDirectory() as folder:
        png = Path(folder, "mask.png")
        _slice(model, "--z", f"{height_nm / 1e6:.6f}", "--mask", png, *options)
        return _grey(png)


def layers_of(model, layer_nm, folder, *options):
    """Returns the masks of a model file's layers, from the plate up. Uses files in the folder."""
    _slice(model, "--layer-height-um", f"{layer_nm / 1000:g}", "--masks", folder, *options)
    return [_grey(png) for png in sorted(folder.glob("*.png"))]


def _slice(model, *options):
    subprocess.run([AMD64.program("contourctl"), "slice", model, *options], check=True, capture_output=True)


def _grey(png):
    picture = harness.read_png(str(png))
    return numpy.frombuffer(b"".join(picture.rows), numpy.uint8).reshape(picture.height, picture.width)


def xrgb_crc(grey):
    """Returns the CRC-32 of the picture as XRGB8888, row by row with X zero, as zproj logs it."""
    pixels = numpy.zeros((*grey.shape, 4), numpy.uint8)
    pixels[..., :3] = grey[..., None]
    return zlib.crc32(pixels.tobytes())


def rgb565_crc(grey):
    """Returns the CRC-32 of the picture as RGB565, with each colour rounded to its nearest value."""
    five, six = ((2 * grey.astype(numpy.uint32) * most + 255) // 510 for most in (31, 63))
    return zlib.crc32((five << 11 | six << 5 | five).astype("<u2").tobytes())
