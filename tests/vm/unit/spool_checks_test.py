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
    """The job's files in that folder, and what is beside them."""
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

    def test_what_was_done_before_and_is_done_after_breaks_no_rule(self):
        self.assertEqual(broken([TICKETED], "in:ticketed done:ticketed", done(TICKETED), done(TICKETED)), [])

    def test_what_waited_and_is_printed_breaks_no_rule(self):
        self.assertEqual(broken([TICKETED], "in:ticketed", lying(TICKETED, "incoming"), done(TICKETED)), [])

    def test_what_was_printing_and_is_told_breaks_no_rule(self):
        held = {"held": "see to the printer"}
        found = lying(TICKETED, "printing")
        self.assertEqual(broken([TICKETED], "in:ticketed begun:ticketed", found, failed(TICKETED), status=held), [])

    def test_a_foreign_plate_may_stay_where_it_is(self):
        found = lying(FOREIGN, "incoming")
        self.assertEqual(broken([FOREIGN], "in:foreign", found, found | done(FOREIGN)), [])

    def test_a_foreign_plate_that_is_refused_leaves_its_reason_alone(self):
        found = lying(LEFT, "incoming")
        left = found | {"spool/failed/broken-foreign.reason.txt": b"wrong\n"}
        self.assertEqual(broken([LEFT], "in:broken-foreign failed:broken-foreign", left, left), [])

    def test_what_its_owner_had_not_dropped_whole_may_be_missing(self):
        left = {"spool/incoming/.ticketed.stl": b"", "spool/incoming/ticketed.json": TICKETED.items[0][".json"]}
        self.assertEqual(broken([TICKETED], "", left, left), [])

    def test_a_lost_job_is_found(self):
        self.assert_told("lost", [TICKETED], "in:ticketed", {}, {})

    def test_a_job_that_is_there_twice_is_found(self):
        left = done(TICKETED) | done(TICKETED, "ticketed-2")
        self.assert_told("2 times", [TICKETED], "in:ticketed", lying(TICKETED, "incoming"), left)

    def test_a_copy_that_is_printed_and_its_original_too_is_found(self):
        left = lying(FOREIGN, "incoming") | failed(FOREIGN) | done(FOREIGN, "foreign-2")
        self.assert_told("2 times", [FOREIGN], "in:foreign", lying(FOREIGN, "incoming"), left)

    def test_a_job_that_stays_is_found(self):
        for folder in ("incoming", "printing"):
            self.assert_told(f"stayed in {folder}", [TICKETED], "", lying(TICKETED, folder), lying(TICKETED, folder))

    def test_a_model_whose_end_is_missing_is_found(self):
        left = done(TICKETED)
        left["spool/done/ticketed.stl"] = left["spool/done/ticketed.stl"][:4096]
        self.assert_told("lost", [TICKETED], "in:ticketed", done(TICKETED), left)
        self.assert_told("belongs to no job", [TICKETED], "in:ticketed", done(TICKETED), left)

    def test_a_ticket_that_did_not_come_along_is_found(self):
        left = done(TICKETED)
        del left["spool/done/ticketed.json"]
        self.assert_told("is not there", [TICKETED], "in:ticketed", lying(TICKETED, "incoming"), left)

    def test_a_plate_of_which_a_file_is_not_whole_is_found(self):
        left = done(PLATE) | {"spool/done/plate/b.stl": b""}
        self.assert_told("not what was dropped", [PLATE], "", lying(PLATE, "incoming"), left)

    def test_a_print_that_was_told_to_be_done_and_is_not_found_there(self):
        for folder in ("printing", "incoming"):
            self.assert_told("it was done", [TICKETED], "done:ticketed", lying(TICKETED, folder), done(TICKETED))

    def test_a_refusal_that_was_told_and_is_not_found(self):
        self.assert_told("it was failed", [BROKEN], "failed:broken", lying(BROKEN, "incoming"), failed(BROKEN, b"wrong"))

    def test_a_report_that_is_not_there_or_not_whole_is_found(self):
        without = lying(TICKETED, "done")
        self.assert_told("report is not there", [TICKETED], "done:ticketed", without, without)
        for text in (b"", b'{"job": "tick', report("ticketed", "failed"), report("other")):
            left = lying(TICKETED, "done", report=text)
            self.assert_told("not whole", [TICKETED], "done:ticketed", left, left)

    def test_a_failure_without_a_reason_is_found(self):
        self.assert_told("no reason", [BROKEN], "", lying(BROKEN, "incoming"), failed(BROKEN, b"\n"))

    def test_a_print_that_begins_anew_is_found(self):
        self.assert_told("had begun", [TICKETED], "begun:ticketed", lying(TICKETED, "incoming"), done(TICKETED))

    def test_an_interruption_that_is_not_told_or_does_not_hold_the_queue_is_found(self):
        found, held = lying(TICKETED, "printing"), {"held": "see to the printer"}
        self.assert_told("went to", [TICKETED], "", found, done(TICKETED), status=held)
        self.assert_told("its reason is", [TICKETED], "", found, failed(TICKETED, b"wrong"), status=held)
        self.assert_told("not held", [TICKETED], "", found, failed(TICKETED))

    def test_a_print_that_ended_goes_by_its_record(self):
        found = lying(TICKETED, "printing") | {"state/ended-print": report("ticketed")}
        self.assertEqual(broken([TICKETED], "", found, lying(TICKETED, "done")), [])
        self.assert_told("went to", [TICKETED], "", found, failed(TICKETED), status={"held": "see to the printer"})

    def test_what_belongs_to_nobody_is_found(self):
        for path in ("spool/failed/broken.reason.txt", "spool/done/.contourd-0.new", "spool/printing/.copies/a", "state/x"):
            self.assert_told(f"{path} belongs", [BROKEN], "", {}, {path: b""})
        self.assert_told("is empty", [BROKEN], "", {}, {}, empty=["spool/done/part.preview.png"])

    def test_the_history_is_the_daemons_and_one_that_was_put_aside_is_found(self):
        history = {f"state/history.sqlite{suffix}": b"SQLite" for suffix in ("", "-wal", "-shm")}
        self.assertEqual(broken([TICKETED], "", {}, history, empty=["state/history.sqlite-wal"]), [])
        self.assert_told("history.sqlite is empty", [TICKETED], "", {}, history, empty=["state/history.sqlite"])
        self.assert_told("state/history.sqlite.damaged-1 belongs", [TICKETED], "", {}, {"state/history.sqlite.damaged-1": b"SQLite"})

    def test_a_plate_that_is_forgotten_or_not_cleared_is_found(self):
        self.assert_told("the plate holds", [TICKETED], "occupied:ticketed", {}, {}, status={"plate_job": None})
        marks = "occupied:ticketed clearing:ticketed cleared:ticketed"
        self.assert_told("was cleared", [TICKETED], marks, {}, {}, status={"plate_job": "ticketed"})

    def test_what_the_daemon_says_is_found(self):
        self.assert_told("ended with 1", [BROKEN], "", {}, {}, exit_code=1)
        self.assert_told("cannot write", [BROKEN], "", {}, {}, log="12:00:00.000 error   cannot write")
        log = "12:00:00.000 error   broken: line 2\n12:00:00.000 error   plain: contourd did not end this print (power cut)"
        self.assertEqual(broken([BROKEN], "", {}, {}, log=log), [])
        self.assert_told("waited in vain", [BROKEN], "", {}, {}, trouble="waited in vain for the queue to be empty")
