"""What light and screen must hold to: the display's log, the axis' log and the core's masks against each other. Every
check returns sentences on what broke its rule, none when nothing did."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ExpectedLayer:
    """A layer as the printer was told to make it, counted from 1."""

    number: int
    position: int  # of the plate, in steps above the switch
    mask_crc: int  # of the core's mask at the plate's position in the axis' log, as zproj counts it
    exposure_ns: int


REFRESH_NS = 16_666_667


def masks(frames, edges, layers):
    """Every picture with light in it is its layer's mask, at the height that the plate had."""
    pictures = frames.lit_pictures()
    broken = []
    if len(pictures) != len(layers):
        broken.append(f"{len(pictures)} pictures were shown for {len(layers)} layers")
    for picture, layer in zip(pictures, layers):
        position = edges.position_at(picture.start_ns)
        if position != layer.position:
            broken.append(f"layer {layer.number} was shown with the plate at step {position}, not {layer.position}")
        if picture.crc != layer.mask_crc:
            broken.append(f"layer {layer.number} showed {picture.crc:08x}, the core's mask there is {layer.mask_crc:08x}")
    return broken


def exposures(frames, edges, layers, refresh_ns=REFRESH_NS):
    """Light is on once a layer, for as long as was asked; the mask's time on the screen, from vblank to vblank, is
    within a refresh of it."""
    light = edges.active(edges.lines.light)
    pictures = frames.lit_pictures()
    broken = []
    if len(light) != len(layers):
        broken.append(f"the light was on {len(light)} times for {len(layers)} layers")
    for layer, (on, off), picture in zip(layers, light, pictures):
        if off is None or picture.end_ns is None:
            broken.append(f"layer {layer.number}: {'the light' if off is None else 'the mask'} stayed on")
            continue
        # Nothing but the timer's own lateness lies between light on and light off.
        if not 0 <= off - on - layer.exposure_ns <= 1_000_000:
            broken.append(f"layer {layer.number} had light for {off - on} ns, {layer.exposure_ns} ns were asked")
        # Black comes with the vblank after light off: one refresh later at most, but for the way to light on.
        beyond = picture.end_ns - picture.start_ns - layer.exposure_ns
        if not 0 <= beyond <= refresh_ns + 2_000_000:
            broken.append(f"layer {layer.number}'s mask was on the screen for {beyond} ns more than was asked")
    return broken


def light_only_on_masks(frames, edges, light=None, on_the_way_ns=0):
    """While there is light, a mask is on the screen, the same one all the time, and the plate does not move. Where the
    light is not a line's, `light` is [(on_ns, off_ns)], and the screen may be black already while light off is on its
    way."""
    pictures = frames.lit_pictures()
    steps = edges.steps()["time_ns"]
    broken = []
    for on, off in edges.active(edges.lines.light) if light is None else light:
        if off is None:
            broken.append(f"the light came on at {on} ns and never went off")
            continue
        covering = [p for p in pictures if p.start_ns <= on and (p.end_ns is None or p.end_ns >= off - on_the_way_ns)]
        if not covering:
            broken.append(f"the light from {on} to {off} ns was not on one mask")
        moved = int(((steps >= on) & (steps <= off)).sum())
        if moved:
            broken.append(f"the plate made {moved} steps in the light from {on} to {off} ns")
    return broken


def dark_at_the_end(frames, edges):
    """Light off and the screen black, or off, when the logs end."""
    broken = []
    pictures = frames.pictures()
    if pictures and pictures[-1].end_ns is None and pictures[-1].lit:
        broken.append(f"{pictures[-1].lit} pixels are lit at the end")
    light = edges.active(edges.lines.light)
    if light and light[-1][1] is None:
        broken.append("the light is on at the end")
    return broken


def all_checks(frames, edges, layers):
    return [
        *masks(frames, edges, layers),
        *exposures(frames, edges, layers),
        *light_only_on_masks(frames, edges),
        *dark_at_the_end(frames, edges),
    ]
