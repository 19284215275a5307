"""The models that the guests print: a star that turns and tapers as it rises, so that no two layers are equal and an
error of one step in height changes the mask; and a table whose top needs supports."""

import math
import struct


def twisted_star(height_mm, points=9, levels=24):
    """Returns the facets of a closed solid, counter-clockwise seen from outside."""
    rings = [_ring(level / levels, height_mm, points) for level in range(levels + 1)]
    facets = []
    for below, above in zip(rings, rings[1:]):
        for i, (a, b) in enumerate(zip(below, below[1:] + below[:1])):
            c, d = above[(i + 1) % len(above)], above[i]
            facets += [(a, b, c), (a, c, d)]
    for ring, turn in ((rings[0], -1), (rings[-1], 1)):
        centre = (0.0, 0.0, ring[0][2])
        for a, b in zip(ring, ring[1:] + ring[:1]):
            facets.append((centre, a, b) if turn == 1 else (centre, b, a))
    return facets


def _ring(part, height_mm, points):
    corners = []
    for i in range(2 * points):
        angle = math.pi * i / points + part * 0.7
        radius = (18.0 if i % 2 == 0 else 9.0) * (1 - 0.4 * part)
        corners.append((radius * math.cos(angle), radius * math.sin(angle), part * height_mm))
    return corners


def table(height_mm):
    """Returns the facets of a slab of 20 by 16 mm, 1 mm thick, on a post of 6 by 6 mm, so that the slab overhangs on all
    sides."""
    under = height_mm - 1
    post, slab = _box((-3, -3, 0), (3, 3, under + 0.5)), _box((-10, -8, under), (10, 8, height_mm))
    return post + slab  # they overlap, like parts that a user has assembled


def _box(low, high):
    facets = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for at, order in ((low, (0, 2, 1, 0, 3, 2)), (high, (0, 1, 2, 0, 2, 3))):
            corners = []
            for a, b in ((low[u], low[v]), (high[u], low[v]), (high[u], high[v]), (low[u], high[v])):
                corner = [0.0, 0.0, 0.0]
                corner[axis], corner[u], corner[v] = float(at[axis]), float(a), float(b)
                corners.append(tuple(corner))
            facets += [tuple(corners[i] for i in order[:3]), tuple(corners[i] for i in order[3:])]
    return facets


def binary_stl(facets):
    data = [b"printed by a guest".ljust(80, b"\0"), struct.pack("<I", len(facets))]
    for facet in facets:
        data.append(struct.pack("<12fH", 0, 0, 0, *(x for vertex in facet for x in vertex), 0))
    return b"".join(data)
