"""Prints that a power cut ends, for the tests of what the next start knows and does. A kill stands for the cut."""

from harness import NIMBLE_RESIN, SpoolTest, binary_stl, realtime, wait_until, wedge

PHASES = ("lowering", "before the light", "lit", "lifting", "raising", "paused", "parking")
# Layers of some hundredths of a second, of which each phase takes a part.
QUICK = {**NIMBLE_RESIN, "exposure_ms": 20, "bottom_exposure_ms": 20, "settle_ms": 10, "rest_ms": 10, "lift_mm": 1}
# Layers whose light lasts for seconds, after a wait in which even a slow disk takes the record.
SLOW = {**QUICK, "exposure_ms": 3000, "bottom_exposure_ms": 3000, "settle_ms": 500}
# A part whose masks differ from layer to layer: 20 layers.
RAMP = binary_stl(wedge(10, 5, 1))
SWITCH_AT_THE_TOP = {"homes_upwards": True, "switch_height_mm": 12}


class PowerCutTest(SpoolTest):
    def wait_layer(self, daemon, layer, state):
        wait_until(lambda: (s := daemon.status())["job"] and s["job"].get("layer", 0) == layer and s["state"] == state,
                   f"layer {layer}, {state}")  # fmt: skip

    def cut(self, daemon):
        daemon.kill()
        daemon.start()
        return daemon.status()

    def assert_still(self, daemon):
        status = daemon.status()
        self.assertEqual((status["state"], status["dark"], status["job"]), ("idle", True, None))
        self.assertIsNone(status["manual"]["height_mm"], "the plate was moved")

    def cut_in_layer_2(self, job="part", masks=False, model=RAMP, **config):
        """Returns a daemon that was started again after a cut in the light of the job's second layer. Its machine is as fast as
        it can be."""
        daemon = self.daemon(realtime(**config), SLOW, masks=masks).start()
        daemon.begin(job + ".stl", model)
        self.wait_layer(daemon, 2, "exposing")
        daemon.kill()
        return daemon.start("--pace", "fast")
