"""The jobs for the power cuts, one of each kind. guest/power_cuts.sh drops them by name."""

import json
from dataclasses import dataclass

from bed import models

_HEIGHT_MM = 0.2  # four layers
_LONG_MM = 5.0  # 200 layers, so that there is time to pause the print


@dataclass(frozen=True)
class Job:
    """`files` are the dropped files, by path in incoming/. `items` are the models or plates of the job: each maps the
    endings after the item's name to contents; the first file of an item is in no other item."""

    name: str
    files: dict
    items: tuple
    good: bool = True
    foreign: bool = False  # a folder that the daemon may not move


def _star(points, height_mm=_HEIGHT_MM):
    return models.binary_stl(models.twisted_star(height_mm, points=points, levels=6))


def _ticket(layer_height_um):
    return json.dumps({"layer_height_um": layer_height_um}).encode()


def _single(name, model, ticket=None, good=True):
    item = {".stl": model}
    if ticket:
        item[".json"] = ticket
    return Job(name, {name + suffix: data for suffix, data in item.items()}, (item,), good)


def _plate(name, points, good=True, foreign=False):
    parts = [{"file": "a.stl", "scale": {"x": 0.3, "y": 0.3}}, {"file": "b.stl", "scale": {"x": 0.3 if good else 1000, "y": 0.3}}]
    item = {
        "/a.stl": _star(points),
        "/b.stl": _star(points + 1),
        "/plate.json": json.dumps({"models": parts}).encode(),
    }
    return Job(name, {name + path: data for path, data in item.items()}, (item,), good, foreign)


def _twins():
    """Returns two models whose names differ only in case and that share their ticket."""
    files = {"twin.stl": _star(30), "twin.STL": _star(31), "twin.json": _ticket(60)}
    items = tuple({".stl": files[name], ".json": files["twin.json"]} for name in ("twin.stl", "twin.STL"))
    return Job("twins", files, items)


def all_jobs():
    """Returns the jobs in the order in which they are dropped."""
    return (
        _single("plain", _star(5)),
        _single("ticketed", _star(6), _ticket(40)),
        _plate("plate", 7),
        _plate("foreign", 9, foreign=True),
        _single("broken", b"solid broken\nfacet nonsense\n", _ticket(50), good=False),
        _plate("broken-foreign", 11, good=False, foreign=True),
        _single("cancelled", _star(13, _LONG_MM), _ticket(25)),
        _twins(),
        _single("broken-waiting", b"solid waiting\nfacet nonsense\n", _ticket(52), good=False),
        _plate("broken-plate", 15, good=False),
        _single("queued", _star(17)),
        _single("stopped", _star(18, _LONG_MM), _ticket(26)),
        _single("held", _star(19), _ticket(53)),
        _single("first", _star(20)),
        _single("second", _star(21), _ticket(54)),
    )
