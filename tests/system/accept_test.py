"""Jobs that may fail wait until the user accepts them: the key ask_before, and contourctl accept."""

import json
import os
import subprocess

from harness import (
    BAD_USAGE, CONTOURCTL, ENDLESS, FAILED, ISLAND, NIMBLE_RESIN, OK, REALTIME, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, wait_until,
)  # fmt: skip

SOUND = binary_stl(box((0, 0, 0), (10, 5, 0.2)))
# A plate on a foot with 1 % of the plate's area.
ON_A_FOOT = binary_stl([*box((4, 2, 0), (5, 2.5, 0.05)), *box((0, 0, 0.05), (10, 5, 0.2))])
OPEN = binary_stl(box((0, 0, 0), (10, 5, 0.2))[1:])
# A box without its sides of y = 0 and x = 0.
HALF = binary_stl([facet for facet in box((0, 0, 0), (10, 5, 0.2)) if not any(all(v[axis] == 0 for v in facet) for axis in (0, 1))])
ASKS = {"ask_before": ["islands", "tiny_first_layer", "cracks", "not_watertight"]}


class Accept(FolderTest):
    def daemon(self, **config):
        return Daemon(self, {**ASKS, **config}).start()

    def wait_unaccepted(self, daemon, *names):
        for name in names:
            daemon.wait_job(name, "unaccepted")

    def refused(self, daemon, *words, code=FAILED):
        result = daemon.ctl("accept", *words)
        self.assertEqual(result.returncode, code, result)
        self.assertEqual(result.stdout, b"")
        return result.stderr.decode()

    def accept(self, daemon, name):
        result = daemon.ctl("accept", name)
        self.assertEqual((result.returncode, result.stderr), (OK, b""))
        return result.stdout.decode()

    def test_a_job_with_a_finding_waits_and_other_jobs_are_printed(self):
        daemon = self.daemon()
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        daemon.printed("sound.stl", SOUND)
        self.assertEqual(daemon.status()["state"], "idle")
        job = daemon.job("odd")
        self.assertEqual((job["number"], job["asks"]), (1, ["islands"]))
        for command in (["queue"], ["queue", "show", "odd"], ["status"]):
            result = daemon.ctl(*command).stdout.decode()
            self.assertIn('islands; run "contourctl accept odd" to print it anyway', result, command)
        shown = daemon.ctl("queue", "show", "odd").stdout.decode()
        self.assertRegex(shown, r"(?m)^state     waits to be accepted$")
        self.assertRegex(shown, r"(?m)^warning   1 island begins with nothing under it: layer 3 ")
        self.assertIn('odd.stl waits: islands; run "contourctl accept odd"', daemon.log())
        self.assertIn("odd: accepted", self.accept(daemon, "odd"))
        daemon.wait_done("odd")
        self.assertRegex(daemon.log(), r"odd\.stl: accepted by user \S+ \(\d+\) with islands")

    def test_a_waiting_job_lists_its_findings_by_name(self):
        daemon = self.daemon()
        for name, model in (("foot", ON_A_FOOT), ("open", OPEN)):
            daemon.drop(f"{name}.stl", model)
        self.wait_unaccepted(daemon, "foot", "open")
        self.assertEqual(daemon.job("foot")["asks"], ["tiny_first_layer"])
        self.assertIn("not_watertight", daemon.job("open")["asks"])
        self.assertTrue(any("layer 1 is tiny" in each for each in daemon.job("foot")["warnings"]))

    def test_without_ask_before_no_job_waits(self):
        daemon = Daemon(self).start()
        daemon.printed("odd.stl", ISLAND)
        daemon.drop("later.stl", ISLAND)
        self.refused(daemon, "later")

    def test_a_model_that_lacks_much_of_its_surface_waits_to_be_accepted(self):
        self.check_half("auto")

    def test_such_a_model_waits_without_supports_too_even_if_the_printer_is_idle(self):
        self.check_half("off")

    def test_a_copy_that_broke_off_after_a_whole_facet_waits_to_be_accepted(self):
        daemon = Daemon(self).start()
        both = binary_stl([*box((0, 0, 0), (5, 5, 0.2)), *box((8, 0, 0), (12, 5, 0.2))])
        one = both[: 84 + 12 * 50]  # without the second box; the first is whole
        daemon.drop("copy.stl", one)
        self.wait_unaccepted(daemon, "copy")
        job = daemon.job("copy")
        self.assertEqual(job["asks"], ["wide_gaps"])
        self.assertTrue(any("has fewer facets than its header says" in each for each in job["warnings"]), job)
        self.accept(daemon, "copy")
        daemon.wait_done("copy")
        daemon.printed("repair.stl", one, {"cracks": "repair"})
        # A program that does not know the number beforehand.
        daemon.printed("unknown.stl", one[:80] + b"\xff" * 4 + one[84:])
        daemon.printed("zero.stl", one[:80] + bytes(4) + one[84:])

    def check_half(self, supports):
        daemon = Daemon(self, {"supports": supports}).start()
        model = self.write("half.stl", HALF)
        submitted = daemon.ctl("submit", "--yes", "--printer", daemon.config_path, model).stdout.decode()
        self.assertIn("the printer will ask before it prints this: wide gaps", submitted)
        self.assertNotIn("refuse", submitted)
        self.wait_unaccepted(daemon, "half")
        job = daemon.job("half")
        self.assertEqual(job["asks"], ["wide_gaps"])
        self.assertTrue(any(each.startswith("much of the surface of the model is missing: in 100 % of") for each in job["warnings"]), job)
        daemon.printed("sound.stl", SOUND)
        self.accept(daemon, "half")
        daemon.wait_done("half")
        # A ticket that asks for the repair has accepted the gaps.
        daemon.printed("repair.stl", HALF, {"cracks": "repair"})

    def test_submit_wait_reports_that_the_job_waits_to_be_accepted(self):
        daemon = self.daemon()
        model = self.write("odd.stl", ISLAND)
        command = [CONTOURCTL, "submit", "--socket", daemon.socket_path, "--yes", "--wait", model]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as waiting:
            for line in waiting.stdout:
                if "contourctl accept" in line:
                    break
            self.assertEqual(line, 'odd: waits: islands; run "contourctl accept odd" to print it anyway\n')
            self.accept(daemon, "odd")
            self.assertEqual(waiting.stdout.read().splitlines()[-1], "odd: done")
        self.assertEqual(waiting.returncode, OK)

    def test_a_job_does_not_wait_for_a_finding_that_ask_before_does_not_name(self):
        daemon = self.daemon(ask_before=["empty_layers"])
        daemon.printed("odd.stl", ISLAND)

    def test_waiting_and_acceptance_survive_a_kill(self):
        config = {**ASKS, **REALTIME, "wait_for_plate_cleared": True}
        daemon = Daemon(self, config, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.begin("part.stl", SOUND)
        daemon.drop("yes.stl", ISLAND)
        daemon.drop("no.stl", ISLAND)
        self.wait_unaccepted(daemon, "yes", "no")
        self.accept(daemon, "yes")
        record = os.path.join(daemon.state_folder, "accepted")
        wait_until(lambda: os.path.exists(record), "the record of accepted jobs")
        daemon.kill()
        daemon = Daemon(self, config, NIMBLE_RESIN).start()
        daemon.wait_job("yes", "ready")
        self.wait_unaccepted(daemon, "no")
        daemon.rpc("plate_cleared")
        daemon.wait_done("yes")
        daemon.rpc("plate_cleared")
        wait_until(lambda: not os.path.exists(record), "the record to be deleted")
        self.assertIn("contourctl accept no", daemon.status()["waiting_for"])

    def test_an_accepted_job_waits_again_when_its_files_are_replaced(self):
        daemon = Daemon(self, {**ASKS, **REALTIME}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.begin("part.stl", SOUND)
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        self.accept(daemon, "odd")
        self.assertEqual(daemon.job("odd")["state"], "ready")
        daemon.drop("odd.stl", ISLAND, {"copies": 2})
        self.wait_unaccepted(daemon, "odd")
        # The new model has no finding.
        daemon.drop("odd.stl", SOUND)
        daemon.wait_job("odd", "ready")

    def test_a_job_that_waits_to_be_accepted_can_be_moved_and_removed(self):
        daemon = self.daemon()
        daemon.drop("one.stl", ISLAND)
        daemon.drop("two.stl", ISLAND)
        self.wait_unaccepted(daemon, "one", "two")
        self.assertEqual(daemon.ctl("queue", "move", "two", "--first").returncode, OK)
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], ["two.stl", "one.stl"])
        self.assertEqual(daemon.ctl("queue", "remove", "two").returncode, OK)
        self.assertEqual(daemon.wait_ended("two")["outcome"], "cancelled")
        self.assertEqual(daemon.status()["unaccepted"].keys(), {"one.stl"})

    def test_accepting_a_wrong_job_reports_why_and_changes_nothing(self):
        daemon = Daemon(self, {**ASKS, **REALTIME}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.begin("part.stl", SOUND)
        self.assertIn("its turn has come", self.refused(daemon, "part"))
        daemon.drop("sound.stl", SOUND)
        daemon.wait_job("sound", "ready")
        self.assertIn("does not wait to be accepted", self.refused(daemon, "sound"))
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        self.assertEqual(self.refused(daemon, "od"), 'contourctl: no job "od" waits; jobs that wait to be accepted: "odd"\n')
        for words in ([], [""], ["odd", "sound"]):
            self.assertNotEqual(self.refused(daemon, *words, code=BAD_USAGE), "")
        self.assertEqual(daemon.rpc("accept")["error"]["code"], -32602)
        self.assertEqual(daemon.job("odd")["state"], "unaccepted")
        self.assertIn("result", json.loads(daemon.ctl("accept", "odd", "--json").stdout))
        daemon.kill()
        self.refused(daemon, "odd", code=UNAVAILABLE)
