"""The rules that a spool must keep after a power cut: as found, and after the daemon has processed it."""

import json
import re
from dataclasses import dataclass, field

_BESIDE = (".report.json", ".report.html", ".preview.png", ".reason.txt")
_INTERRUPTED = "The print was interrupted"
# "reading" is not synchronized and has no meaning after a power cut.
_READING = {"state/reading", "state/reading.next"}
# SQLite's files. The write-ahead log is empty before the first write and after a checkpoint.
_HISTORY_LOG = "state/history.sqlite-wal"
_HISTORY = {"state/history.sqlite", _HISTORY_LOG, "state/history.sqlite-shm"}
_SPARES = {f"state/ended-jobs.spare-{number}" for number in (1, 2)}
_KNOWN = _READING | _HISTORY | _SPARES | {"spool/.lock", "state/plate-occupied", "state/queue-held", "state/copied-originals", "state/claim", "state/print-progress", "state/print-frames"}


@dataclass
class Cut:
    """A power cut. `found` and `left` are files by path below the disk, such as spool/done/part.stl: before and after the
    daemon processed the disk. `marks` were on the disk before the cut: in, begun, done or failed, and a job's name."""

    marks: list
    found: dict
    left: dict
    status: dict  # before the operator's commands
    log: str = ""
    exit_code: int = 0
    trouble: str = ""
    empty: list = field(default_factory=list)

    def has(self, event, job):
        return f"{event}:{job.name}" in self.marks


@dataclass(frozen=True)
class Place:
    folder: str
    name: str

    def path(self, suffix):
        return f"spool/{self.folder}/{self.name}{suffix}"


def broken_rules(jobs, cut):
    """Returns a sentence for each violated rule."""
    broken = [cut.trouble] if cut.trouble else []
    for job in jobs:
        for item in job.items:
            broken += [f"{job.name}: {sentence}" for sentence in _broken_by(job, item, cut)]
    return [*broken, *_found_without_owner(jobs, cut), *_plate(jobs, cut), *_daemon(jobs, cut)]


def places_of(item, files):
    """Finds the item's first file by its content, and returns its places."""
    (suffix, model), *_ = item.items()
    places = []
    for path, data in files.items():
        # A hidden file is not dropped yet.
        match = re.fullmatch(r"spool/(\w+)/([^.].*)", path)
        if data == model and match:
            name = match[2].removesuffix(suffix) if suffix.startswith("/") else re.sub(r"(?i)\.stl$", "", match[2])
            places.append(Place(match[1], name))
    return places


# --- a job


def _broken_by(job, item, cut):
    return [
        *_place(job, item, cut),
        *_contents(job, item, cut),
        *_what_was_told(job, item, cut),
        *_what_became_of_it(job, item, cut),
    ]


def _ended(item, files):
    return [place for place in places_of(item, files) if place.folder in ("done", "failed")]


def _is_left_there(job, cut):
    """True for a job that was refused while it waited and cannot be moved: only its reason is in failed/."""
    return job.foreign and cut.left.get(f"spool/failed/{job.name}.reason.txt") and not any(
        path.startswith(f"spool/failed/{job.name}/") for path in cut.left
    )


def _place(job, item, cut):
    places = _ended(item, cut.left)
    count = len(places) + (1 if _is_left_there(job, cut) else 0)
    if count > 1:
        yield f"it exists {count} times: {', '.join(map(str, places))}"
    if count == 0 and cut.has("in", job):
        yield "it is lost"
    for place in places_of(item, cut.left):
        if place.folder == "printing" or (place.folder == "incoming" and not job.foreign):
            yield f"it stayed in {place.folder}"


def _contents(job, item, cut):
    for place in _ended(item, cut.left):
        for suffix, data in item.items():
            # Until the user has marked the job as complete, a model may come without its ticket.
            owed = cut.has("in", job) or suffix.startswith("/")
            there = cut.left.get(place.path(suffix))
            if there != data and (owed or there is not None):
                yield f"{place.path(suffix)} is {'missing' if there is None else 'not the dropped file'}"
        if place.folder == "failed" and not cut.left.get(place.path(".reason.txt"), b"").strip():
            yield f"{place} has no reason"
        report = cut.left.get(place.path(".report.json"))
        if report is not None and not _is_report(report, place):
            yield f"the report of {place} is incomplete: {report[:100]}"


def _is_report(text, place):
    try:
        report = json.loads(text)
    except ValueError:
        return False
    return (report["outcome"] == "done") == (place.folder == "done") and report["job"] == place.name


def _what_was_told(job, item, cut):
    found = places_of(item, cut.found)
    for event in ("done", "failed"):
        if cut.has(event, job) and not [place for place in found if place.folder == event]:
            if not (event == "failed" and _is_left_there(job, cut)):
                yield f"it was reported as {event}, but is in {', '.join(map(str, found)) or 'no folder'}"
    for place in found if cut.has("done", job) else []:
        if place.folder == "done" and place.path(".report.json") not in cut.found:
            yield "it was reported as done, but its report is missing"
    if cut.has("begun", job) and any(place.folder == "incoming" for place in found):
        yield "its print had begun, but it waits as if it had not"


def _recorded_outcome(name, cut):
    """Returns how a job in printing/ ended, by daemon/spool/job_ends.cpp: a print's outcome, "refused", or None."""
    fields = cut.found.get("state/ended-jobs", b"").decode().split("\0")
    for at in range(0, len(fields) - 10, 11):
        _, job, outcome, _, _, kind, file, _, _, consumers, _ = fields[at : at + 11]
        if job == name and kind != "interrupted" and not file and "f" in consumers:
            return "refused" if kind == "refused" else outcome
    return None


def _what_became_of_it(job, item, cut):
    found, ended = places_of(item, cut.found), _ended(item, cut.left)
    folders = {place.folder for place in found}
    if folders == {"incoming"}:
        wanted = "done" if job.good else "failed"
        for place in ended:
            if place.folder != wanted:
                yield f"it waited, but went to {place}: {cut.left.get(place.path('.reason.txt'), b'')}"
            elif job.good and place.path(".report.json") not in cut.left:
                yield "it was printed after the cut, but has no report"
    for place in found:
        if place.folder == "printing" and ended:
            yield from _interrupted(place, ended[0], cut)


def _interrupted(was, place, cut):
    outcome = _recorded_outcome(was.name, cut)
    reason = cut.left.get(place.path(".reason.txt"), b"").decode()
    if (place.folder == "done") != (outcome == "done"):
        yield f"it was in printing, its print {outcome or 'not ended'}, but went to {place}"
    if outcome is None and _INTERRUPTED not in reason:
        yield f"it was interrupted, but its reason is {reason!r}"
    if outcome in (None, "failed") and not cut.status.get("held"):
        yield "it was interrupted, but the queue was not held"


# --- all together


def _found_without_owner(jobs, cut):
    """Finds files that neither belong to a job nor accompany one."""
    owned = set()
    for job in jobs:
        for place in (place for item in job.items for place in _ended(item, cut.left)):
            owned |= {place.path(suffix) for item in job.items for suffix in item}
            owned |= {place.path(suffix) for suffix in _BESIDE}
        if _is_left_there(job, cut):
            owned.add(f"spool/failed/{job.name}.reason.txt")
        # Files of a user who had not finished dropping them.
        if job.foreign or not cut.has("in", job):
            owned |= {f"spool/incoming/{path}" for path in job.files if job.foreign or path.endswith(".json")}
    for path in sorted(set(cut.left) - owned):
        hidden_in_incoming = path.startswith("spool/incoming/.")
        if path not in _KNOWN and not hidden_in_incoming:
            yield f"{path} belongs to no job"
    for path in cut.empty:
        if path not in _READING | {"spool/.lock", _HISTORY_LOG} and not path.startswith("spool/incoming/."):
            yield f"{path} is empty"


def _plate(jobs, cut):
    occupant = cut.status.get("plate_job")
    for job in jobs:
        if cut.has("occupied", job) and not cut.has("clearing", job) and occupant != job.name:
            yield f"the plate holds {job.name}, but the daemon reports {occupant}"
        if cut.has("cleared", job) and occupant == job.name:
            yield f"the plate was cleared of {job.name}, but the daemon has forgotten it"


def _daemon(jobs, cut):
    if cut.exit_code != 0:
        yield f"the daemon exited with {cut.exit_code}"
    refused = [job.name for job in jobs if not job.good]
    for line in cut.log.splitlines():
        error = re.fullmatch(r"\S+ error +(.*)", line)
        if not error or ": contourd stopped before " in error[1] or error[1].endswith("/print-progress is damaged"):
            continue
        if not any(error[1].startswith(name) for name in refused):
            yield f"the daemon logged: {error[1]}"
