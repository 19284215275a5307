"""A process' figures from the kernel: its memory, its descriptors, and how long its loop waited for a processor."""

import bisect
import os
import threading
import time


def _lines(path):
    with open(path, encoding="ascii") as file:
        return file.read().splitlines()


def memory_mb(pid):
    """Returns the process' own memory in MB, without pages of files, which the kernel may reclaim."""
    return next(int(line.split()[1]) for line in _lines(f"/proc/{pid}/status") if line.startswith("RssAnon")) / 1024


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


def threads(pid):
    return len(os.listdir(f"/proc/{pid}/task"))


def watched_folders(pid):
    """Returns the number of inotify watches."""
    count = 0
    for number in os.listdir(f"/proc/{pid}/fdinfo"):
        try:
            count += sum(line.startswith("inotify") for line in _lines(f"/proc/{pid}/fdinfo/{number}"))
        except FileNotFoundError:  # closed meanwhile
            pass
    return count


class Waits:
    """The times during which the loop was ready but did not run: because other threads had its processor, the hypervisor ran
    another machine (stolen time), or we had stopped it. Sampled continuously on a separate thread."""

    PERIOD_S = 0.05

    def __init__(self):
        self._times, self._waited, self._total = [], [], 0.0
        self._pid, self._last = None, 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._sample, daemon=True)
        self._thread.start()

    def watch(self, pid):
        """Samples this process from now on. REQUIRES: a kernel with CONFIG_SCHED_INFO."""
        self._last = self._own(pid) + self._stolen()
        self._pid = pid

    def stopped_for(self, seconds):
        self._total += seconds

    def close(self):
        self._ended.set()
        self._thread.join()

    def most_within(self, seconds, since, until):
        """Returns the longest wait in s within any period of `seconds` between two times."""
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
