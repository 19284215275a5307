"""What the kernel says of a process: its memory, its descriptors, and how long its loop had to wait for a processor."""

import bisect
import os
import threading
import time


def _lines(path):
    with open(path, encoding="ascii") as file:
        return file.read().splitlines()


def memory_mb(pid):
    """What it has taken for itself; pages of files, which the kernel may take back, are not counted."""
    return next(int(line.split()[1]) for line in _lines(f"/proc/{pid}/status") if line.startswith("RssAnon")) / 1024


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


def threads(pid):
    return len(os.listdir(f"/proc/{pid}/task"))


def watched_folders(pid):
    """By inotify."""
    count = 0
    for number in os.listdir(f"/proc/{pid}/fdinfo"):
        try:
            count += sum(line.startswith("inotify") for line in _lines(f"/proc/{pid}/fdinfo/{number}"))
        except FileNotFoundError:  # closed meanwhile
            pass
    return count


class Waits:
    """How long the loop did not run though it could have: behind others on its processor, or while another machine had it
    (stolen time), or stopped by us. Sampled all the time on a thread of its own."""

    PERIOD_S = 0.05

    def __init__(self):
        self._times, self._waited, self._total = [], [], 0.0
        self._pid, self._last = None, 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._sample, daemon=True)
        self._thread.start()

    def watch(self, pid):
        """From now on that process. REQUIRES: a kernel that counts it (CONFIG_SCHED_INFO)."""
        self._last = self._own(pid) + self._stolen()
        self._pid = pid

    def stopped_for(self, seconds):
        self._total += seconds

    def close(self):
        self._ended.set()
        self._thread.join()

    def most_within(self, seconds, since, until):
        """The most that was waited in any such time between two moments, in s."""
        most, first = 0.0, bisect.bisect_left(self._times, since)
        for i in range(max(0, first - 2), len(self._times)):
            if self._times[i] > until:
                break
            end = bisect.bisect_left(self._times, self._times[i] + seconds + 2 * self.PERIOD_S)
            most = max(most, self._waited[min(end, len(self._waited) - 1)] - self._waited[i])
        return most

    @staticmethod
    def _own(pid):
        return int(_lines(f"/proc/{pid}/task/{pid}/schedstat")[0].split()[1]) / 1e9

    @staticmethod
    def _stolen():
        return int(_lines("/proc/stat")[0].split()[8]) / os.sysconf("SC_CLK_TCK")

    def _sample(self):
        while not self._ended.wait(self.PERIOD_S):
            if self._pid is None:
                continue
            try:
                now = self._own(self._pid) + self._stolen()
            except (FileNotFoundError, ProcessLookupError):
                continue
            self._total += max(0.0, now - self._last)
            self._last = now
            self._waited.append(self._total)
            self._times.append(time.monotonic())
