"""Checks of light and screen: the display's log, the axis' log and the core's masks are compared with each other. Every
check returns a sentence for each violation."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ExpectedLayer:
    """A layer of the job, counted from 1."""

    number: int
    position: int  # the plate's, in steps above the switch
    mask_crc: int  # CRC of the core's mask at the plate's position in the axis' log, as zproj computes it
    exposure_ns: int


REFRESH_NS = 16_666_667


def masks(frames, edges, layers):
    """Checks that every lit picture is its layer's mask at the plate's height."""
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
    """Checks that the light is on once per layer for the requested time, and that the mask's time on the screen, from
    vblank to vblank, differs from it by at most a refresh."""
    light = edges.active(edges.lines.light)
    pictures = frames.lit_pictures()
    broken = []
    if len(light) != len(layers):
        broken.append(f"the light was on {len(light)} times for {len(layers)} layers")
    for layer, (on, off), picture in zip(layers, light, pictures):
        if off is None or picture.end_ns is None:
            broken.append(f"layer {layer.number}: {'the light' if off is None else 'the mask'} stayed on")
            continue
        # The exposure can be longer only by the timer's own lateness.
        if not 0 <= off - on - layer.exposure_ns <= 1_000_000:
            broken.append(f"layer {layer.number} had light for {off - on} ns; {layer.exposure_ns} ns were requested")
        # Black comes at the vblank after light off: at most one refresh later, plus the delay until light on.
        beyond = picture.end_ns - picture.start_ns - layer.exposure_ns
        if not 0 <= beyond <= refresh_ns + 2_000_000:
            broken.append(f"layer {layer.number}'s mask was on the screen for {beyond} ns more than was requested")
    return broken


def light_only_on_masks(frames, edges, light=None, on_the_way_ns=0):
    """Checks that while there is light one mask is on the screen and the plate does not move. If the light is not
    switched by a line, `light` is [(on_ns, off_ns)], and the screen may be black already while light off is being
    sent."""
    pictures = frames.lit_pictures()
    steps = edges.steps()["time_ns"]
    broken = []
    for on, off in edges.active(edges.lines.light) if light is None else light:
        if off is None:
            broken.append(f"the light came on at {on} ns and never went off")
            continue
        covering = [p for p in pictures if p.start_ns <= on and (p.end_ns is None or p.end_ns >= off - on_the_way_ns)]
        if not covering:
            broken.append(f"the light from {on} to {off} ns was not on a single mask")
        moved = int(((steps >= on) & (steps <= off)).sum())
        if moved:
            broken.append(f"the plate made {moved} steps in the light from {on} to {off} ns")
    return broken


def dark_at_the_end(frames, edges):
    """Checks that the light is off and the screen black or off when the logs end."""
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
