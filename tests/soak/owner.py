"""The printer's user: drops good jobs, gives a user's commands, drops interrupted jobs again, and keeps account."""

import json
import os
import re
import shutil
import time

from good_jobs import ROUNDING_MS, digests, light_off_asked, light_trouble, masks_trouble, report_trouble
from printer import AS_ROOT, GROUP, MEMBER, SERVICE, remove

OUTSTANDING = 6
# No job takes longer without progress, whatever else is in the queue. A full disk is tried again after 30 s.
LONGEST_JOB_S = 150

# The causes that may end a job, with the text that its reason file contains then.
REASONS = {
    "kill": "The print was interrupted: the power was cut, or contourd was killed or crashed|contourd ended while it read this: it was killed",
    "stop": "contourd was stopped",
    "switch": "homing failed: the limit switch",
    "projector": "the projector does not answer|timed out after 30 s waiting for the projector to confirm",
    "disk": "No space left on device",
}


class Broken(Exception):
    """A violated rule of the soak."""


class Attempt:
    def __init__(self, kind, name):
        self.kind, self.name = kind, name
        self.file = kind.file_of(name)
        self.dropped = time.monotonic()
        self.causes = set()  # the causes that occurred meanwhile
        self.pace = None


class Owner:
    def __init__(self, printer, kinds, rng):
        self.printer, self.kinds, self.rng = printer, kinds, rng
        self.outstanding, self.closed = [], set()
        self.to_repeat = []
        self.names = (f"good{number}" for number in range(1 << 30))
        self.causes, self.pace = set(), "fast"  # those of the present life
        self.last_done = time.monotonic()
        self.figures = {"done": 0, "masks": 0, "again": 0, "without_report": 0, "refused_commands": 0}
        self.most_off_ms = {"fast": 0.0, "realtime": 0.0}
        self.by_pace = {"fast": 0, "realtime": 0}
        self.busiest = (0.0, 0.0)
        self.longest_answer_s = 0.0

    # --- jobs

    def put_in(self, wanted=OUTSTANDING):
        while len(self.outstanding) < wanted:
            kind = self.to_repeat[0] if self.to_repeat else self.rng.choice(self.kinds)
            attempt = Attempt(kind, next(self.names))
            try:
                self._drop(attempt)
            except OSError:  # the disk is full
                return
            if self.to_repeat:
                self.to_repeat.pop(0)
                self.figures["again"] += 1
            attempt.causes |= self.causes
            attempt.pace = self.pace
            self.outstanding.append(attempt)

    def _drop(self, attempt):
        spool, kind = self.printer.daemon.file, attempt.kind
        staging = spool("incoming", "." + attempt.name)  # hidden, so the daemon ignores it
        try:
            if kind.is_plate:
                os.mkdir(staging)
            for name, data in kind.files.items():
                with open(os.path.join(staging, name) if kind.is_plate else staging, "wb") as file:
                    file.write(data)
            if AS_ROOT:
                self._give_to_somebody(staging, kind)
            os.chmod(staging, 0o755 if kind.immovable else 0o775)
            if kind.ticket is not None:
                with open(staging + ".json", "w", encoding="utf-8") as file:
                    json.dump(kind.ticket, file)
                os.rename(staging + ".json", spool("incoming", attempt.name + ".json"))
            os.rename(staging, spool("incoming", attempt.file))
        except OSError:
            for path in (staging, staging + ".json", spool("incoming", attempt.name + ".json")):
                remove(path)
            raise

    def _give_to_somebody(self, path, kind):
        """Gives the files a random user. The service gets no lease on other users' files and has to watch them for longer."""
        user = MEMBER if kind.immovable else self.rng.choice((SERVICE, SERVICE, SERVICE, MEMBER))
        for each in [path, *(os.path.join(path, name) for name in kind.files if kind.is_plate)]:
            os.chown(each, user, GROUP)

    def happens(self, cause):
        """Adds the cause to all outstanding jobs and to all later jobs of this life."""
        self.causes.add(cause)
        for attempt in self.outstanding:
            attempt.causes.add(cause)

    def begin_life(self, causes, pace):
        self.causes, self.pace = set(), pace
        for cause in causes:
            self.happens(cause)
        for attempt in self.outstanding:
            attempt.pace = pace if attempt.pace == pace else "realtime"

    def places(self, attempt):
        folders = ("printing", "done", "failed") if attempt.kind.immovable else ("incoming", "printing", "done", "failed")
        return [folder for folder in folders if os.path.lexists(self.printer.daemon.file(folder, attempt.file))]

    def count_places(self):
        """Checks, while no process moves files, that every job is in exactly one folder."""
        for attempt in self.outstanding:
            places = self.places(attempt)
            waits = attempt.kind.immovable and os.path.exists(self.printer.daemon.file("incoming", attempt.file))
            if len(places) > 1 or not (places or waits):
                raise Broken(f"{attempt.name} ({attempt.kind.name}) lies in {places or 'no folder'}")

    def look(self):
        """Handles the jobs that have ended."""
        for attempt in list(self.outstanding):
            ended_in = [folder for folder in self.places(attempt) if folder in ("done", "failed")]
            if ended_in and not self._is_being_filed(attempt):
                self._ended(attempt, ended_in[0])
            else:
                if time.monotonic() - max(attempt.dropped, self.last_done) > LONGEST_JOB_S:
                    raise Broken(f"{attempt.name} ({attempt.kind.name}) has not ended after {LONGEST_JOB_S} s; it lies in "
                                 f"{self.places(attempt)}; status {self.printer.status()[0]}")  # fmt: skip
        for folder in ("done", "failed", "printing", "incoming"):
            for name in os.listdir(self.printer.daemon.file(folder)):
                self._known(folder, name)

    def _is_being_filed(self, attempt):
        """True while the daemon files the job: the ticket is moved last."""
        return os.path.lexists(self.printer.daemon.file("printing", attempt.name + ".json"))

    def _known(self, folder, name):
        match = re.match(r"(good\d+)(-\d+)?", name)
        if not match:
            return
        if match[2]:
            raise Broken(f"{folder}/{name}: the job was taken a second time")
        if match[1] in self.closed and folder != "incoming":
            raise Broken(f"{folder}/{name}: the job had ended before and was removed")

    def _ended(self, attempt, folder):
        read = lambda suffix: self._read(folder, attempt.name + suffix)  # noqa: E731
        report, reason = read(".report.json"), read(".reason.txt")
        report = json.loads(report) if report else None
        if folder == "done":
            self._is_as_alone(attempt, report)
            self.figures["done"] += 1
        else:
            if not any(re.search(REASONS[cause], reason or "") for cause in attempt.causes if cause in REASONS) and not (
                    reason is None and "disk" in attempt.causes):  # fmt: skip
                raise Broken(f"{attempt.name} ({attempt.kind.name}) failed: {reason!r}; what happened: {sorted(attempt.causes)}")
            self.to_repeat.append(attempt.kind)
        self.last_done = time.monotonic()
        self._take_away(attempt)

    def _read(self, folder, name):
        try:
            with open(self.printer.daemon.file(folder, name), encoding="utf-8") as file:
                return file.read()
        except FileNotFoundError:
            return None

    def _is_as_alone(self, attempt, report):
        kind, masks = attempt.kind, digests(self.printer.path("masks", attempt.name))
        who = f"{attempt.name} ({kind.name}, {attempt.pace})"
        interruptions = len(report["interruptions"]) if report else 1 << 30
        if trouble := masks_trouble(masks, kind.masks, interruptions):
            raise Broken(f"{who}: {trouble}")
        self.figures["masks"] += len(masks)
        if report is None:
            if not attempt.causes & {"disk", "kill", "stop"}:
                raise Broken(f"{who} is done but has no report")
            self.figures["without_report"] += 1
            return
        if trouble := report_trouble(report, kind.report):
            raise Broken(f"{who}: {trouble}")
        self._light(attempt, report, who)

    def _light(self, attempt, report, who):
        busy = report["loop_busy_ms_worst_lit"]
        excused = 1000 * self.printer.waits.most_within(busy / 1000, attempt.dropped, time.monotonic())
        # In real time the light goes off when the loop gets to it, which may be late.
        tolerated = ROUNDING_MS if attempt.pace == "fast" else LONGEST_TURN_MS + 1000 * self.printer.waits.most_within(
            1.0, attempt.dropped, time.monotonic())  # fmt: skip
        if trouble := light_trouble(report, tolerated):
            raise Broken(f"{who}: {trouble}; {tolerated:g} ms are tolerated")
        off = max(light_off_asked(layer) for layer in report["layer_records"])
        self.by_pace[attempt.pace] += 1
        self.most_off_ms[attempt.pace] = max(self.most_off_ms[attempt.pace], off)
        self.busiest = max(self.busiest, (busy, excused))
        if busy > LONGEST_TURN_MS + excused:
            raise Broken(f"{who}: the loop was busy for {busy:.1f} ms while the light was on; {LONGEST_TURN_MS} ms are the limit, "
                         f"and {excused:.1f} ms it may have waited for its processor")  # fmt: skip

    def _take_away(self, attempt):
        self.outstanding.remove(attempt)
        self.closed.add(attempt.name)
        for folder in ("done", "failed"):
            for suffix in ("", ".stl", ".json", ".report.json", ".report.html", ".preview.png", ".reason.txt"):
                remove(self.printer.daemon.file(folder, attempt.name + suffix))
        if attempt.kind.immovable:
            remove(self.printer.daemon.file("incoming", attempt.file))
        shutil.rmtree(self.printer.path("masks", attempt.name), ignore_errors=True)

    # --- commands

    def say_what_is_due(self):
        status, took = self.printer.status()
        self.longest_answer_s = max(self.longest_answer_s, took)
        wanted = None
        if status["held"] or (status["waiting_for"] or "").startswith("the plate holds"):
            wanted = self.rng.choice(("plate_cleared", "resume")) if not status["waiting_for"] else "plate_cleared"
        if status["state"] in ("paused", "held"):
            wanted = "resume"
        elif self.rng.random() < 0.01 and status["state"] not in ("idle", "preparing", "finishing"):
            wanted = "pause"
        if wanted and "error" in self.printer.call(wanted):
            self.figures["refused_commands"] += 1
        return status


# The longest turn of the loop while the light is on, by the wall clock minus the time that the loop waited for a processor.
# The daemon itself warns above 10 ms. In the soak, with its flood of clients, a turn takes less than that on any computer of
# the last ten years, and five times as much on the slowest computer that builds this.
LONGEST_TURN_MS = 50
