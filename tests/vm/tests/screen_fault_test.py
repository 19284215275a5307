"""Faults between the daemon and the display's driver: page flips that are not confirmed, a display that takes long to
report its modes, irrelevant announcements of the kernel. arm64, in deterministic time."""

import re
from itertools import islice

from bed import guests
from bed.registry import vm_test
from tests.fault_test import run

_OVERDUE = r"HDMI-A-1 of /dev/dri/card0 \(zproj\) did not confirm a picture within \d+ ms"
_BACK = "the display is back: HDMI-A-1"
_EXPOSURE_NS = 2_000_000_000
# A tolerance for the guest's one processor, which also hashes the pictures.
_BUSY_NS = 20_000_000


def _exposed_as_asked(outcome, parts=(1, 1, 1, 1)):
    """Checks that every layer has had its light, in this many parts."""
    lit = iter(outcome.edges.active(outcome.edges.lines.light))
    for layer, count in enumerate(parts, 1):
        given = sum(end - start for start, end in islice(lit, count))
        assert abs(given - _EXPOSURE_NS) < _BUSY_NS, f"layer {layer} had light for {given} ns"
    assert not list(lit), "there was additional light"


def _told_and_back(outcome):
    said = re.search(_OVERDUE, outcome.log)
    assert said and _BACK in outcome.log, outcome.log
    assert outcome.log.index(said.group()) < outcome.log.index(_BACK)
    return said.group()


_RESUME_WHEN_BACK = f"""
wait_for 5 "the display to be back" grep -q '{_BACK}' /out/daemon.log
sleep 1
contourctl resume || fail "the print cannot be resumed"
"""


@vm_test("full")
def lost_flip_of_a_mask():
    """The kernel does not confirm a mask: the mask gets no light; the display is set again, and the print finishes after
    it is resumed."""
    outcome = run(
        during=f"""wait_for 300 "layer 1" exposed 1
echo lose >$SCREEN/ctl
wait_for 300 "the report of the loss" grep -q 'did not confirm a picture' /out/daemon.log
light_is_off || fail "light on a mask that was not confirmed"
[ "$(lit_pictures)" = 2 ] || fail "there was no mask"
{_RESUME_WHEN_BACK}"""
    )
    outcome.is_printed()
    _exposed_as_asked(outcome)
    return _told_and_back(outcome)


@vm_test("full")
def lost_flip_of_black():
    """The kernel does not confirm the black picture after an exposure, which has had all its light: the layer is not
    exposed again."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
echo lose >$SCREEN/ctl
{_RESUME_WHEN_BACK}"""
    )
    outcome.is_printed()
    _exposed_as_asked(outcome)
    assert len(outcome.frames.lit_pictures()) == 4
    return _told_and_back(outcome)


@vm_test("full")
def lost_flip_of_black_at_once():
    """The kernel does not confirm the black picture after the lid was opened, which no call waits for: the next print
    needs no restart."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
sleep 0.5
echo lose >$SCREEN/ctl
echo in {guests.LID} 1 >$PLANT/ctl
wait_for 5 "the report of the loss" grep -q 'did not confirm a picture' /out/daemon.log
echo in {guests.LID} 0 >$PLANT/ctl
{_RESUME_WHEN_BACK}"""
    )
    outcome.is_printed()
    _exposed_as_asked(outcome, (1, 2, 1, 1))
    return _told_and_back(outcome)


@vm_test("full")
def lost_flip_without_atomic_calls():
    """The kernel does not confirm a mask, and the driver has only the legacy calls: the display is set again and the
    print finishes."""
    outcome = run(
        devices="ZPROJ=atomic=0 load_devices",
        during=f"""wait_for 300 "layer 2" exposing 2
echo lose >$SCREEN/ctl
{_RESUME_WHEN_BACK}""",
    )
    outcome.is_printed()
    _exposed_as_asked(outcome)
    return _told_and_back(outcome)


@vm_test("full")
def hung_flip():
    """The driver hangs in a flip, for which the kernel itself waits 10 s or more: the daemon keeps answering and refuses
    to resume the print; a very late confirmation does no harm."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
echo hold >$SCREEN/ctl
wait_for 5 "the report of the loss" grep -q 'did not confirm a picture' /out/daemon.log
light_is_off || fail "light while the driver hangs"
for second in 1 2 3 4 5; do
  before=$(uptime_s)
  contourctl status --json >/out/status || fail "the daemon does not answer"
  contourctl resume && fail "the print was resumed without a display"
  echo "$before $(uptime_s)" >>/out/answers
  sleep 1
done
grep -q '{_BACK}' /out/daemon.log && fail "it was back before the kernel gave up"
sleep 15
wait_for 30 "the display to be back" grep -q '{_BACK}' /out/daemon.log
contourctl resume || fail "the print cannot be resumed"
wait_for 300 "layer 3" exposing 3
echo free >$SCREEN/ctl"""
    )
    outcome.is_printed()
    _exposed_as_asked(outcome)
    _told_and_back(outcome)
    took = [float(after) - float(before) for before, after in map(str.split, outcome.results.text("answers").splitlines())]
    assert max(took) < 1, f"the daemon took {max(took)} s to answer"
    assert "did not confirm a picture" in outcome.results.text("status"), outcome.results.text("status")
    return f"two answers took {max(took) * 1000:.0f} ms at most"


@vm_test("full")
def slow_display_in_an_exposure():
    """The kernel keeps announcing changes, and the display takes 300 ms to report its modes: every exposure has its
    requested length, in one piece."""
    outcome = run(
        devices="ZPROJ=edid_ms=300 load_devices",
        during="""wait_for 300 "layer 2" exposing 2
while exposing 2; do
  echo announce >$SCREEN/ctl
  sleep 0.1
done""",
    )
    outcome.is_printed()
    lit = [end - start for start, end in outcome.edges.active(outcome.edges.lines.light)]
    assert len(lit) == 4, f"the light was on {len(lit)} times"
    beyond = [ns - _EXPOSURE_NS for ns in lit]
    assert all(abs(ns) < 5_000_000 for ns in beyond), f"{beyond} ns more than was requested"
    return f"light {max(beyond) / 1e6:.1f} ms more than was requested at most"


@vm_test("full")
def slow_display_unplugged_in_an_exposure():
    """A slow display is unplugged while it is being asked for its modes: the light goes off as soon as it has been asked
    again."""
    outcome = run(
        devices="ZPROJ=edid_ms=300 load_devices",
        during="""wait_for 300 "layer 2" exposing 2
sleep 0.5
echo announce >$SCREEN/ctl
sleep 0.05
echo unplug >$SCREEN/ctl
wait_for 5 "the light to go off" light_is_off
sleep 5
echo plug >$SCREEN/ctl
sleep 2
contourctl resume || fail "the print cannot be resumed" """,
    )
    outcome.is_printed()
    _exposed_as_asked(outcome, (1, 2, 1, 1))
    unplugged = outcome.frames.times("UNPLUG")[0]
    off = [end for _, end in outcome.edges.active(outcome.edges.lines.light) if end > unplugged][0]
    assert off - unplugged < 350_000_000, f"the light went off {off - unplugged} ns after the display was unplugged"
    return f"light off {(off - unplugged) / 1e6:.0f} ms after the display was unplugged"


def _neutral(parameters):
    outcome = run(devices=f"ZPROJ='gamma=1 {parameters}' load_devices", during="cat $SCREEN/color >/out/color")
    outcome.is_printed()
    assert outcome.results.text("color") == "gamma 0000 8080 ffff range Full\n", outcome.results.text("color")
    assert "255" not in outcome.log, outcome.log


@vm_test("full")
def neutral_colors():
    """Another program has left a gamma table, and the driver chooses the range: both are corrected before anything is
    shown."""
    _neutral("")


@vm_test("full")
def neutral_colors_without_atomic_calls():
    """A gamma table and the driver's range are corrected with a driver that has only the legacy calls."""
    _neutral("atomic=0")


@vm_test("full")
def colors_that_stay():
    """With a gamma table that cannot be changed and a driver without a setting for the range, the log states the
    consequences."""
    outcome = run(devices="ZPROJ='gamma=2 range=0' load_devices")
    outcome.is_printed()
    said = re.search("HDMI-A-1 .* keeps a gamma table.*", outcome.log)
    assert said and re.search('has no "Broadcast RGB".*16 of 255.*6 %', outcome.log), outcome.log
    return said.group()
