import json
import unittest

from bed import spool_checks
from bed.spool_checks import Cut
from bed.spool_jobs import all_jobs

JOBS = {job.name: job for job in all_jobs()}
TICKETED, BROKEN, FOREIGN, LEFT, PLATE = (JOBS[name] for name in ("ticketed", "broken", "foreign", "broken-foreign", "plate"))
INTERRUPTED = b"The print was interrupted: the power was cut.\n"


def report(name, outcome="done"):
    return json.dumps({"job": name, "outcome": outcome}).encode()


def lying(job, folder, name=None, **beside):
    """Returns the job's files in that folder, with additional files."""
    name = name or job.name
    files = {f"spool/{folder}/{name}{suffix}": data for suffix, data in job.items[0].items()}
    suffixes = {"report": ".report.json", "reason": ".reason.txt"}
    return files | {f"spool/{folder}/{name}{suffixes[what]}": data for what, data in beside.items()}


def done(job, name=None):
    return lying(job, "done", name, report=report(name or job.name))


def failed(job, reason=INTERRUPTED):
    return lying(job, "failed", reason=reason)


def broken(jobs, marks, found, left, **more):
    cut = Cut(marks.split(), found, left, more.pop("status", {}), **more)
    return list(spool_checks.broken_rules(jobs, cut))


class SpoolChecksTest(unittest.TestCase):
    def assert_told(self, words, *what, **more):
        told = broken(*what, **more)
        self.assertTrue(any(words in sentence for sentence in told), told)

    def test_a_job_that_is_done_before_and_after_breaks_no_rule(self):
        self.assertEqual(broken([TICKETED], "in:ticketed done:ticketed", done(TICKETED), done(TICKETED)), [])

    def test_a_waiting_job_that_is_printed_breaks_no_rule(self):
        self.assertEqual(broken([TICKETED], "in:ticketed", lying(TICKETED, "incoming"), done(TICKETED)), [])

    def test_an_interrupted_job_that_is_reported_breaks_no_rule(self):
        held = {"held": "check the printer"}
        found = lying(TICKETED, "printing")
        self.assertEqual(broken([TICKETED], "in:ticketed begun:ticketed", found, failed(TICKETED), status=held), [])

    def test_a_foreign_plate_may_stay_where_it_is(self):
        found = lying(FOREIGN, "incoming")
        self.assertEqual(broken([FOREIGN], "in:foreign", found, found | done(FOREIGN)), [])

    def test_a_refused_foreign_plate_may_have_only_its_reason_in_failed(self):
        found = lying(LEFT, "incoming")
        left = found | {"spool/failed/broken-foreign.reason.txt": b"wrong\n"}
        self.assertEqual(broken([LEFT], "in:broken-foreign failed:broken-foreign", left, left), [])

    def test_a_job_that_was_not_dropped_completely_may_be_missing(self):
        left = {"spool/incoming/.ticketed.stl": b"", "spool/incoming/ticketed.json": TICKETED.items[0][".json"]}
        self.assertEqual(broken([TICKETED], "", left, left), [])

    def test_a_lost_job_is_found(self):
        self.assert_told("lost", [TICKETED], "in:ticketed", {}, {})

    def test_a_duplicated_job_is_found(self):
        left = done(TICKETED) | done(TICKETED, "ticketed-2")
        self.assert_told("2 times", [TICKETED], "in:ticketed", lying(TICKETED, "incoming"), left)

    def test_printing_both_a_copy_and_its_original_is_found(self):
        left = lying(FOREIGN, "incoming") | failed(FOREIGN) | done(FOREIGN, "foreign-2")
        self.assert_told("2 times", [FOREIGN], "in:foreign", lying(FOREIGN, "incoming"), left)

    def test_a_job_that_stays_is_found(self):
        for folder in ("incoming", "printing"):
            self.assert_told(f"stayed in {folder}", [TICKETED], "", lying(TICKETED, folder), lying(TICKETED, folder))

    def test_a_truncated_model_is_found(self):
        left = done(TICKETED)
        left["spool/done/ticketed.stl"] = left["spool/done/ticketed.stl"][:4096]
        self.assert_told("lost", [TICKETED], "in:ticketed", done(TICKETED), left)
        self.assert_told("belongs to no job", [TICKETED], "in:ticketed", done(TICKETED), left)

    def test_a_missing_ticket_is_found(self):
        left = done(TICKETED)
        del left["spool/done/ticketed.json"]
        self.assert_told("is missing", [TICKETED], "in:ticketed", lying(TICKETED, "incoming"), left)

    def test_a_plate_with_an_incomplete_file_is_found(self):
        left = done(PLATE) | {"spool/done/plate/b.stl": b""}
        self.assert_told("not the dropped file", [PLATE], "", lying(PLATE, "incoming"), left)

    def test_a_print_reported_as_done_that_is_not_in_done_is_found(self):
        for folder in ("printing", "incoming"):
            self.assert_told("it was reported as done", [TICKETED], "done:ticketed", lying(TICKETED, folder), done(TICKETED))

    def test_a_reported_refusal_that_is_missing_is_found(self):
        self.assert_told("it was reported as failed", [BROKEN], "failed:broken", lying(BROKEN, "incoming"), failed(BROKEN, b"wrong"))

    def test_a_missing_or_incomplete_report_is_found(self):
        without = lying(TICKETED, "done")
        self.assert_told("report is missing", [TICKETED], "done:ticketed", without, without)
        for text in (b"", b'{"job": "tick', report("ticketed", "failed"), report("other")):
            left = lying(TICKETED, "done", report=text)
            self.assert_told("is incomplete", [TICKETED], "done:ticketed", left, left)

    def test_a_failure_without_a_reason_is_found(self):
        self.assert_told("no reason", [BROKEN], "", lying(BROKEN, "incoming"), failed(BROKEN, b"\n"))

    def test_a_print_that_begins_again_is_found(self):
        self.assert_told("had begun", [TICKETED], "begun:ticketed", lying(TICKETED, "incoming"), done(TICKETED))

    def test_an_interruption_that_is_not_reported_or_does_not_hold_the_queue_is_found(self):
        found, held = lying(TICKETED, "printing"), {"held": "check the printer"}
        self.assert_told("went to", [TICKETED], "", found, done(TICKETED), status=held)
        self.assert_told("its reason is", [TICKETED], "", found, failed(TICKETED, b"wrong"), status=held)
        self.assert_told("not held", [TICKETED], "", found, failed(TICKETED))

    def test_a_print_that_ended_is_judged_by_its_record(self):
        found = lying(TICKETED, "printing") | {"state/ended-jobs": b"1\0ticketed\0done\0\x000\0printed\0\0\x000\0fhn\0\0"}
        self.assertEqual(broken([TICKETED], "", found, lying(TICKETED, "done")), [])
        self.assert_told("went to", [TICKETED], "", found, failed(TICKETED), status={"held": "check the printer"})

    def test_a_refused_job_need_not_hold_the_queue_but_a_failed_print_does(self):
        found = lying(BROKEN, "printing")
        ended = b"1\0broken\0failed\0line 2\x000\0%s\0\0\x000\0fhn\0\0"
        self.assertEqual(broken([BROKEN], "", found | {"state/ended-jobs": ended % b"refused"}, failed(BROKEN, b"line 2")), [])
        self.assert_told("not held", [BROKEN], "", found | {"state/ended-jobs": ended % b"printed"}, failed(BROKEN, b"line 2"))

    def test_files_that_belong_to_no_job_are_found(self):
        for path in ("spool/failed/broken.reason.txt", "spool/done/.contourd-0.new", "spool/printing/.copies/a", "state/x"):
            self.assert_told(f"{path} belongs", [BROKEN], "", {}, {path: b""})
        self.assert_told("is empty", [BROKEN], "", {}, {}, empty=["spool/done/part.preview.png"])

    def test_the_history_is_allowed_and_a_damaged_copy_of_it_is_found(self):
        history = {f"state/history.sqlite{suffix}": b"SQLite" for suffix in ("", "-wal", "-shm")}
        self.assertEqual(broken([TICKETED], "", {}, history, empty=["state/history.sqlite-wal"]), [])
        self.assert_told("history.sqlite is empty", [TICKETED], "", {}, history, empty=["state/history.sqlite"])
        self.assert_told("state/history.sqlite.damaged-1 belongs", [TICKETED], "", {}, {"state/history.sqlite.damaged-1": b"SQLite"})

    def test_a_forgotten_plate_and_an_uncleared_plate_are_found(self):
        self.assert_told("the plate holds", [TICKETED], "occupied:ticketed", {}, {}, status={"plate_job": None})
        marks = "occupied:ticketed clearing:ticketed cleared:ticketed"
        self.assert_told("was cleared", [TICKETED], marks, {}, {}, status={"plate_job": "ticketed"})

    def test_errors_of_the_daemon_are_found(self):
        self.assert_told("exited with 1", [BROKEN], "", {}, {}, exit_code=1)
        self.assert_told("cannot write", [BROKEN], "", {}, {}, log="12:00:00.000 error   cannot write")
        log = "12:00:00.000 error   broken: line 2\n12:00:00.000 error   plain: contourd stopped before this print ended (power cut)"
        self.assertEqual(broken([BROKEN], "", {}, {}, log=log), [])
        self.assert_told("timed out waiting", [BROKEN], "", {}, {}, trouble="timed out waiting for the queue to be empty")
