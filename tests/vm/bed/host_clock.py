"""The host's own real-time latency, including delays by a hypervisor below it."""

import os
import threading
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class LateWakes:
    wakes: int
    late: int  # wakes that were late by a period or more
    worst_s: float

    def __str__(self):
        return f"the host's own real-time thread: {self.late} of {self.wakes} wake-ups late by a period, the worst {self.worst_s * 1e3:.1f} ms"


def late_wakes(period_s, seconds):
    """Measures a thread with the highest real-time priority that only wakes up every period."""
    lateness = []

    def wake():
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(os.sched_get_priority_max(os.SCHED_FIFO)))
        due = time.monotonic()
        for _ in range(round(seconds / period_s)):
            due += period_s
            time.sleep(max(due - time.monotonic(), 0))
            lateness.append(time.monotonic() - due)

    thread = threading.Thread(target=wake)
    thread.start()
    thread.join()
    return LateWakes(len(lateness), sum(late >= period_s for late in lateness), max(lateness))
