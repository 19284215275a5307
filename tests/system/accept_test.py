#!/usr/bin/env python3
"""A printer that asks before it prints what may fail: ask_before, and contourctl accept."""

import json
import os
import subprocess

from harness import BAD_USAGE, CONTOURCTL, ENDLESS, FAILED, NIMBLE_RESIN, OK, REALTIME, UNAVAILABLE, Daemon, FolderTest, binary_stl, box, main, wait_until

SOUND = binary_stl(box((0, 0, 0), (10, 5, 0.2)))
# One part begins in the third layer, with nothing under it.
ISLAND = binary_stl([*box((0, 0, 0), (10, 5, 0.2)), *box((15, 0, 0.1), (20, 5, 0.2))])
# Stands on a foot of 1 % of what it carries.
ON_A_FOOT = binary_stl([*box((4, 2, 0), (5, 2.5, 0.05)), *box((0, 0, 0.05), (10, 5, 0.2))])
OPEN = binary_stl(box((0, 0, 0), (10, 5, 0.2))[1:])
ASKS = {"ask_before": ["islands", "tiny_first_layer", "cracks", "not_watertight"]}


class Accept(FolderTest):
    def daemon(self, **config):
        return Daemon(self, {**ASKS, **config}).start()

    def job(self, daemon, name):
        jobs = daemon.rpc("queue")["result"]["jobs"]
        return next((job for job in jobs if job["job"] == name), None)

    def wait_unaccepted(self, daemon, *names):
        for name in names:
            wait_until(lambda name=name: (self.job(daemon, name) or {}).get("state") == "unaccepted", f"{name} to ask")

    def refused(self, daemon, *words, code=FAILED):
        told = daemon.ctl("accept", *words)
        self.assertEqual(told.returncode, code, told)
        self.assertEqual(told.stdout, b"")
        return told.stderr.decode()

    def accept(self, daemon, name):
        told = daemon.ctl("accept", name)
        self.assertEqual((told.returncode, told.stderr), (OK, b""))
        return told.stdout.decode()

    def test_a_job_with_a_finding_waits_and_the_others_go_on(self):
        daemon = self.daemon()
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        daemon.drop("sound.stl", SOUND)
        daemon.wait_done("sound")
        self.assertEqual(daemon.status()["state"], "idle")
        job = self.job(daemon, "odd")
        self.assertEqual((job["number"], job["asks"]), (1, ["islands"]))
        for command in (["queue"], ["queue", "show", "odd"], ["status"]):
            told = daemon.ctl(*command).stdout.decode()
            self.assertIn('islands; "contourctl accept odd" has it printed as it is', told, command)
        shown = daemon.ctl("queue", "show", "odd").stdout.decode()
        self.assertRegex(shown, r"(?m)^state     waits to be accepted$")
        self.assertRegex(shown, r"(?m)^warning   1 island begins with nothing under it: layer 3 ")
        self.assertIn('odd.stl waits: islands; "contourctl accept odd"', daemon.log())
        self.assertIn("odd: accepted", self.accept(daemon, "odd"))
        daemon.wait_done("odd")
        self.assertRegex(daemon.log(), r"odd\.stl: user \S+ \(\d+\) accepts it with islands")
        daemon.stop()

    def test_each_finding_is_asked_about_by_its_name(self):
        daemon = self.daemon()
        for name, model in (("foot", ON_A_FOOT), ("open", OPEN)):
            daemon.drop(f"{name}.stl", model)
        self.wait_unaccepted(daemon, "foot", "open")
        self.assertEqual(self.job(daemon, "foot")["asks"], ["tiny_first_layer"])
        self.assertIn("not_watertight", self.job(daemon, "open")["asks"])
        self.assertTrue(any("layer 1 is tiny" in each for each in self.job(daemon, "foot")["warnings"]))
        daemon.stop()

    def test_without_the_key_nothing_waits(self):
        daemon = Daemon(self).start()
        daemon.drop("odd.stl", ISLAND)
        daemon.wait_done("odd")
        daemon.drop("later.stl", ISLAND)
        self.refused(daemon, "later")
        daemon.stop()

    def test_who_waits_for_a_job_that_asks_is_told_so(self):
        daemon = self.daemon()
        model = self.write("odd.stl", ISLAND)
        command = [CONTOURCTL, "submit", "--socket", daemon.socket_path, "--yes", "--wait", model]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as waiting:
            for line in waiting.stdout:
                if "contourctl accept" in line:
                    break
            self.assertEqual(line, 'odd: waits: islands; "contourctl accept odd" has it printed as it is\n')
            self.accept(daemon, "odd")
            self.assertEqual(waiting.stdout.read().splitlines()[-1], "odd: done")
        self.assertEqual(waiting.returncode, OK)
        daemon.stop()

    def test_a_finding_that_is_not_named_is_no_reason_to_wait(self):
        daemon = self.daemon(ask_before=["empty_layers"])
        daemon.drop("odd.stl", ISLAND)
        daemon.wait_done("odd")
        daemon.stop()

    def test_waiting_and_acceptance_survive_a_kill(self):
        config = {**ASKS, **REALTIME, "wait_for_plate_cleared": True}
        daemon = Daemon(self, config, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.drop("part.stl", SOUND)
        daemon.wait_state("exposing")
        daemon.drop("yes.stl", ISLAND)
        daemon.drop("no.stl", ISLAND)
        self.wait_unaccepted(daemon, "yes", "no")
        self.accept(daemon, "yes")
        record = os.path.join(daemon.state_folder, "accepted")
        wait_until(lambda: os.path.exists(record), "the record")
        daemon.kill()
        daemon = Daemon(self, config, NIMBLE_RESIN).start()
        wait_until(lambda: (self.job(daemon, "yes") or {}).get("state") == "ready", "the accepted job")
        self.wait_unaccepted(daemon, "no")
        daemon.rpc("plate_cleared")
        daemon.wait_done("yes")
        daemon.rpc("plate_cleared")
        wait_until(lambda: not os.path.exists(record), "its end")
        self.assertIn("contourctl accept no", daemon.status()["waiting_for"])
        daemon.stop()

    def test_a_job_that_is_written_again_asks_again(self):
        daemon = Daemon(self, {**ASKS, **REALTIME}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.drop("part.stl", SOUND)
        daemon.wait_state("exposing")
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        self.accept(daemon, "odd")
        self.assertEqual(self.job(daemon, "odd")["state"], "ready")
        daemon.drop("odd.stl", ISLAND, {"copies": 2})
        self.wait_unaccepted(daemon, "odd")
        # What lies there now has nothing to accept.
        daemon.drop("odd.stl", SOUND)
        wait_until(lambda: self.job(daemon, "odd")["state"] == "ready", "a sound one")
        daemon.stop()

    def test_a_job_that_asks_is_removed_and_moved_as_any(self):
        daemon = self.daemon()
        daemon.drop("one.stl", ISLAND)
        daemon.drop("two.stl", ISLAND)
        self.wait_unaccepted(daemon, "one", "two")
        self.assertEqual(daemon.ctl("queue", "move", "two", "--first").returncode, OK)
        self.assertEqual(daemon.rpc("queue")["result"]["queue"], ["two.stl", "one.stl"])
        self.assertEqual(daemon.ctl("queue", "remove", "two").returncode, OK)
        self.assertEqual(daemon.wait_ended("two")["outcome"], "cancelled")
        self.assertEqual(daemon.status()["unaccepted"].keys(), {"one.stl"})
        daemon.stop()

    def test_what_is_wrong_gets_one_sentence_and_changes_nothing(self):
        daemon = Daemon(self, {**ASKS, **REALTIME}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.drop("part.stl", SOUND)
        daemon.wait_state("exposing")
        self.assertIn("its turn has come", self.refused(daemon, "part"))
        daemon.drop("sound.stl", SOUND)
        wait_until(lambda: (self.job(daemon, "sound") or {}).get("state") == "ready", "its look")
        self.assertIn("waits for nobody's word", self.refused(daemon, "sound"))
        daemon.drop("odd.stl", ISLAND)
        self.wait_unaccepted(daemon, "odd")
        self.assertEqual(self.refused(daemon, "od"), 'contourctl: no job "od" waits; to be accepted there is "odd"\n')
        for words in ([], [""], ["odd", "sound"]):
            self.assertNotEqual(self.refused(daemon, *words, code=BAD_USAGE), "")
        self.assertEqual(daemon.rpc("accept")["error"]["code"], -32602)
        self.assertEqual(self.job(daemon, "odd")["state"], "unaccepted")
        self.assertIn("result", json.loads(daemon.ctl("accept", "odd", "--json").stdout))
        daemon.kill()
        self.refused(daemon, "odd", code=UNAVAILABLE)


if __name__ == "__main__":
    main()
