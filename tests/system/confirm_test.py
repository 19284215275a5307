"""Jobs that their tickets have wait until the user accepts them, changes of a waiting job's ticket, its picture, and the list of resins."""

import base64
import json
import os

from harness import ENDLESS, SLAB, SMALL, Daemon, FolderTest, binary_stl, box, read_png, realtime, wait_until

TALL = binary_stl(box((0, 0, 0), (2, 2, 8)))
CONFIRM = {"confirm": True}
INVALID_PARAMETERS, REFUSED = -32602, -32000


class ConfirmTest(FolderTest):
    def refused(self, daemon, method, code=REFUSED, **parameters):
        answer = daemon.client().call(method, **parameters)
        self.assertEqual(answer.get("error", {}).get("code"), code, answer)
        self.assertNotIn("\n", answer["error"]["message"])
        return answer["error"]["message"]

    def png(self, daemon, job):
        """Returns the picture of the job, received in pieces, and the number of pieces."""
        data, pieces, reply = b"", 0, None
        while reply is None or len(data) < reply["bytes"]:
            more = {"picture": reply["picture"], "from": len(data)} if reply else {}
            reply = daemon.rpc("preview", job=job, **more)["result"]
            self.assertEqual(reply["from"], len(data))
            data += base64.b64decode(reply["data"])
            pieces += 1
        self.assertEqual(len(data), reply["bytes"])
        with open(self.path("preview.png"), "wb") as file:
            file.write(data)
        return data, pieces

    def test_a_job_to_be_confirmed_waits_with_its_outlook_on_an_idle_printer(self):
        daemon = Daemon(self).start()
        daemon.drop("part.stl", SLAB, CONFIRM)
        job = daemon.wait_job("part")
        self.assertEqual((job["asks"], job["layers"]), (["to_be_confirmed"], 20))
        self.assertAlmostEqual(job["resin_ml"], 0.05, delta=0.005)  # 10 x 5 x 1 mm
        daemon.printed("other.stl", SMALL)
        self.assertEqual(daemon.job("part")["state"], "unaccepted")
        self.assertIn('part.stl waits: to be confirmed; run "contourctl accept part"', daemon.log())
        daemon.rpc("accept", job="part")
        daemon.wait_done("part")

    def test_a_job_whose_profile_changes_after_the_forecast_has_to_be_accepted_again(self):
        daemon = Daemon(self).start()
        daemon.drop("part.stl", SLAB, CONFIRM)
        self.assertEqual(daemon.wait_job("part")["layers"], 20)
        daemon.write_resin("standard", {"layer_height_um": 100})
        daemon.rpc("accept", job="part")
        wait_until(lambda: (daemon.job("part") or {}).get("layers") == 10, "the new forecast")
        self.assertEqual(daemon.wait_job("part")["asks"], ["to_be_confirmed"])
        self.assertIn("part.stl: its files or the resin's profile have changed since it was accepted", daemon.log())
        daemon.rpc("accept", job="part")
        daemon.wait_done("part")
        self.assertEqual(daemon.report("part")["layers_exposed"], 10)

    def test_a_plate_can_wait_to_be_confirmed(self):
        daemon = Daemon(self).start()
        daemon.drop_plate("plate", {"models": [{"file": "a.stl"}], **CONFIRM}, {"a.stl": SMALL})
        self.assertEqual(daemon.wait_job("plate")["asks"], ["to_be_confirmed"])
        for method, parameters in (("ticket", {}), ("queue_ticket", {"ticket": {}})):
            self.assertIn("plate.json", self.refused(daemon, method, job="plate", **parameters))
        daemon.rpc("accept", job="plate")
        daemon.wait_done("plate")

    def test_a_new_ticket_gives_a_new_outlook_and_has_to_be_accepted_again(self):
        daemon = Daemon(self, realtime(), ENDLESS).start()
        daemon.begin("first.stl", SMALL)
        daemon.drop("part.stl", SLAB, CONFIRM)
        self.assertEqual(daemon.wait_job("part")["layers"], 20)
        self.assertEqual(daemon.rpc("ticket", job="part")["result"], {"file": "part.stl", "ticket": CONFIRM})
        daemon.rpc("accept", job="part")
        self.assertEqual(daemon.job("part")["asks"], [])
        ticket = {"confirm": True, "layer_height_um": 100, "copies": 2, "up": {"y": 1}}
        self.assertEqual(daemon.rpc("queue_ticket", job="part", ticket=ticket)["result"]["ticket"], ticket)
        wait_until(lambda: daemon.job("part")["layers"] == 50 and daemon.job("part")["state"] == "unaccepted", "the new outlook")
        self.assertEqual(daemon.job("part")["parts"], 2)
        self.assertEqual(json.loads(daemon.read("incoming", "part.json")), ticket)
        self.assertEqual(os.stat(daemon.file("incoming", "part.json")).st_mode & 0o040, 0o040)
        # Without a wish to confirm it, it is the next one.
        daemon.rpc("queue_ticket", job="part", ticket={"copies": 3})
        wait_until(lambda: daemon.job("part")["state"] == "ready" and daemon.job("part")["parts"] == 3, "the job to be ready")

    def test_a_ticket_that_would_be_refused_changes_nothing(self):
        daemon = Daemon(self, realtime(), {**ENDLESS, "ticket_limits": {"lift_mm": [1, 3]}}).start()
        daemon.begin("first.stl", SMALL)
        daemon.drop("part.stl", SLAB, CONFIRM)
        daemon.wait_job("part")
        for ticket, word in (({"copiess": 2}, "copiess"), ({"copies": 0}, "copies"), ({"resin": "../standard"}, "resin"), ({"resin": "none"}, "no"),
                             ({"lift_mm": 9}, "lift_mm"), ({"layer_height_um": "thin"}, "layer_height_um"), ({"confirm": 1}, "confirm"), ({"": {}}, "ticket"),
                             ({"layer_height_um": 2}, "um"), ({"copies": 100}, "there is room for"), ({"scale": 50}, "50.00 mm high"), ({"model": "no.stl"}, "no.stl")):  # fmt: skip
            self.assertIn(word, self.refused(daemon, "queue_ticket", job="part", ticket=ticket))
        for ticket in ([], "{}", 1, None, True):
            self.refused(daemon, "queue_ticket", INVALID_PARAMETERS, job="part", ticket=ticket)
        self.refused(daemon, "queue_ticket", INVALID_PARAMETERS, job="part")
        nested = {}
        for _ in range(500):
            nested = {"a": nested}
        self.refused(daemon, "queue_ticket", job="part", ticket=nested)
        for job in ("../part", "../../web.json", "first", "part.json", "no such job"):
            self.assertIn(job.split(".")[0], self.refused(daemon, "queue_ticket", job=job, ticket={}))
            self.refused(daemon, "ticket", job=job)
            self.refused(daemon, "preview", job=job)
        self.assertEqual(json.loads(daemon.read("incoming", "part.json")), CONFIRM)
        self.assertEqual(sorted(os.listdir(daemon.file("incoming"))), ["part.json", "part.stl"])

    def test_a_ticket_of_two_models_is_left_alone(self):
        daemon = Daemon(self, realtime(), ENDLESS).start()
        daemon.begin("first.stl", SMALL)
        daemon.drop("part.stl", SMALL)
        daemon.drop("part.STL", SMALL)
        wait_until(lambda: len(daemon.rpc("queue")["result"]["jobs"]) == 2, "both jobs")
        self.assertIn("another model", self.refused(daemon, "queue_ticket", job="part.stl", ticket={}))

    def test_the_picture_shows_the_job_as_its_ticket_has_it(self):
        daemon = Daemon(self, realtime(), ENDLESS).start()
        daemon.begin("first.stl", SMALL)
        daemon.drop("part.stl", TALL, CONFIRM)
        daemon.wait_job("part")
        standing, _ = self.png(daemon, "part")
        picture = read_png(self.path("preview.png"))
        self.assertEqual((picture.width, picture.height), (720, 720))
        left, top, right, bottom = picture.lit_box(40)
        self.assertGreater(bottom - top, 2 * (right - left))
        self.assertEqual(self.png(daemon, "part")[0], standing)  # kept
        daemon.rpc("queue_ticket", job="part", ticket={"confirm": True, "up": {"x": 1}})
        wait_until(lambda: daemon.job("part")["state"] == "unaccepted" and daemon.job("part")["height_mm"] == 2, "the new outlook")
        self.png(daemon, "part")
        left, top, right, bottom = read_png(self.path("preview.png")).lit_box(40)
        self.assertGreater(right - left, bottom - top)
        self.assertIn("no longer kept", self.refused(daemon, "preview", job="part", picture=1))
        self.refused(daemon, "preview", INVALID_PARAMETERS, job="part", **{"from": 4})
        reply = daemon.rpc("preview", job="part")["result"]
        self.refused(daemon, "preview", INVALID_PARAMETERS, job="part", picture=reply["picture"], **{"from": reply["bytes"]})
        self.assertEqual(daemon.status()["state"], "exposing")

    def test_the_resins_are_listed_with_what_is_wrong_with_one(self):
        daemon = Daemon(self)
        daemon.write_resin("grey", {"layer_height_um": 40})
        daemon.write_resin("bad", {"layer_height_um": 4000})
        daemon.start()
        reply = daemon.rpc("resins")["result"]
        resins = {each["resin"]: each for each in reply["resins"]}
        self.assertEqual(sorted(resins), ["bad", "grey", "standard"])
        self.assertEqual((resins["grey"]["layer_height_um"], resins["grey"]["is_default"], resins["grey"]["trouble"]), (40, False, None))
        self.assertTrue(resins["standard"]["is_default"])
        self.assertIn("layer_height_um", resins["bad"]["trouble"])
        self.assertIsNone(resins["bad"]["exposure_ms"])
