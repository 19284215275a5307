"""Sliced archives for printers of the type SL1, made by the tests."""

import io
import json
import random
import struct
import zipfile
import zlib


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(rows, depth=8, colour=0, interlaced=0, more=b"", size=None):
    """Returns a PNG file with these rows of bytes; `more` are chunks before the pixels."""
    width, height = size or (len(rows[0]), len(rows))
    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlaced)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows), 1)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + more + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def pictures(count, width, height, seed=1):
    """Returns the rows of `count` pictures: a block in each, with grey edges that chance draws."""
    chance = random.Random(seed)
    made = []
    for number in range(count):
        left, top = 4 + number % 3, 5
        row = bytes(left) + bytes([chance.randrange(1, 255)]) + b"\xff" * (width // 2) + bytes([chance.randrange(1, 255)])
        lit = row + bytes(width - len(row))
        made.append([lit if top <= y < height // 2 + number % 2 else bytes(width) for y in range(height)])
    return made


def config_ini(layers, **changes):
    values = {"action": "print", "jobDir": "part", "layerHeight": 0.05, "expTime": 2.5, "expTimeFirst": 20, "numFade": 2, "numFast": layers, "numSlow": 0, "materialName": "resin"}
    return ini({**values, **changes})


def slicer_ini(width, height, pitch_um=50, **changes):
    values = {"display_width": width * pitch_um / 1000, "display_height": height * pitch_um / 1000, "display_pixels_x": width, "display_pixels_y": height,
              "display_mirror_x": 0, "display_mirror_y": 0, "display_orientation": "landscape", "gamma_correction": 1}  # fmt: skip
    return ini({**values, **changes})


def ini(values):
    return "".join(f"{key} = {value}\n" for key, value in values.items() if value is not None)


def svg(rings, width_mm, height_mm, precision_mm=0.001):
    """Returns a layer as PrusaSlicer's format SL1SVG has it: rings of points in millimetres from the plate's middle, seen from above."""

    def path(ring):
        points = [(round((width_mm / 2 + x) / precision_mm), round((height_mm / 2 - y) / precision_mm)) for x, y in ring]
        sides = "".join(f" {x - px} {y - py}" for (px, py), (x, y) in zip(points, points[1:]))
        return f'<path d="M {points[0][0]} {points[0][1]} l {sides} z" />\n'

    head = (
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
        '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.0//EN" "http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd">\n'
        f'<svg height="{height_mm}mm" width="{width_mm}mm" viewBox="0 0 {round(width_mm / precision_mm)} {round(height_mm / precision_mm)}" '
        'style="fill: white; stroke: none; fill-rule: nonzero" xmlns="http://www.w3.org/2000/svg">\n'
    )
    return head + "".join(path(ring) for ring in rings) + "</svg>"


def sl1_svg(layers, config=None, slicer="", more=()):
    """Returns an archive of outlines; `layers` are the texts of svg()."""
    files = {"config.ini": config or config_ini(len(layers)), "prusaslicer.ini": slicer}
    files |= {f"part{number:05}.svg": text for number, text in enumerate(layers)}
    return archive(files | dict(more))


def archive(files):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in files.items():
            if content is not None:
                made.writestr(name, content)
    return packed.getvalue()


def sl1(layers, config=None, slicer=None, more=()):
    """Returns an archive; `layers` are the pictures' rows, `more` are files that are added, or replace others; None removes one."""
    width, height = len(layers[0][0]), len(layers[0])
    files = {"config.ini": config or config_ini(len(layers)), "prusaslicer.ini": slicer or slicer_ini(width, height), "thumbnail/thumbnail400x400.png": b"x"}
    files |= {f"part{number:05}.png": png(rows) for number, rows in enumerate(layers)}
    return archive(files | dict(more))


def nanodlp(layers, pitch_mm=0.05, more=()):
    """Returns a plate as DragonFruit writes it for NanoDLP; `more` are files that are added, or replace others; None removes one."""
    width, height = len(layers[0][0]), len(layers[0])
    profile = {"Title": "DragonFruit", "Depth": 50.0, "SupportDepth": 50.0, "CureTime": 2.5, "SupportCureTime": 20.0, "SupportLayerNumber": 2}
    options = {"PWidth": width, "PHeight": height, "Thickness": 50.0, "SupportDepth": 50.0, "XPixelSize": pitch_mm, "YPixelSize": pitch_mm, "ImageMirror": 1}
    files = {"meta.json": json.dumps({"format_version": 3, "program": "DragonFruit", "layer_count": len(layers)}), "slicer.json": "{}",
             "plate.json": json.dumps({"PlateID": 0, "LayersCount": len(layers), "LayerThickness": 0}), "profile.json": json.dumps(profile),
             "options.json": json.dumps(options), "info.json": json.dumps([{}] * len(layers))}  # fmt: skip
    files |= {f"{number}.png": png(rows) for number, rows in enumerate(layers, 1)}
    files |= {"3d.png": png(layers[0]), "3d.png.meta": "{}"}
    return archive(files | dict(more))
