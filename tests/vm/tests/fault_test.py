"""Faults of a real printer, one per guest: each ends as documented, with a sentence in the log and beside the job, the
light off and the screen dark. arm64, in deterministic time."""

import json
import re

from bed import edid, exposure_checks, guests
from bed.architecture import ARM64
from bed.edge_log import EdgeLog
from bed.frame_log import FrameLog
from bed.qemu import run_scenario
from bed.registry import check, vm_test

_MODEL_MM = 0.2  # four layers
_RESIN = {**guests.QUICK_RESIN, "exposure_ms": 2000}

_PROJECTOR = f"fake-projector /dev/ttyZ1 9600 /out/projector {guests.ACER} &"

_SCENARIO = """\
. /lib.sh
{devices}
{projector}
{before}
start_daemon
print_model
{during}
wait_for_print
sleep 1
keep_logs
stop_daemon || fail "the daemon ended with $?"
"""


class Outcome:
    def __init__(self, results):
        self.results = results
        self.edges, self.frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))
        self.log = results.text("daemon.log") if "daemon.log" in results else ""

    @property
    def reason(self):
        name = "spool/failed/part.reason.txt"
        return self.results.text(name).strip() if name in self.results else None

    def was_dark(self):
        """Checks that nothing was lit outside exposures and nothing is lit at the end."""
        check(exposure_checks.light_only_on_masks(self.frames, self.edges))
        check(exposure_checks.dark_at_the_end(self.frames, self.edges))

    def failed_with(self, pattern, layers=None):
        """Checks that the job is in failed/ with a matching reason, which is also in the log, after this many layers.
        Returns the reason."""
        assert self.reason is not None, f"it did not fail\n{self.log}"
        assert re.search(pattern, self.reason), f"the reason is {self.reason!r}"
        sentence = re.search(pattern, self.reason).group()
        assert sentence in self.log, f"the log does not say so:\n{self.log}"
        self.was_dark()
        if layers is not None:
            lit = len(self.frames.lit_pictures())
            assert lit == layers, f"{lit} masks were shown, {layers} expected"
        return self.reason

    def is_printed(self):
        assert "spool/done/part.report.json" in self.results, f"not printed: {self.reason}\n{self.log}"
        self.was_dark()


def run(before="", during="", devices="load_devices", projector=_PROJECTOR, config=None, scenario=_SCENARIO):
    guest = guests.printer_guest(ARM64, config or guests.real_config(), _MODEL_MM, _RESIN)
    guest.add_bytes("/edid-1080", edid.edid(edid.FULL_HD))
    guest.add_bytes("/edid-720", edid.edid(edid.HD))
    text = scenario.format(devices=devices, projector=projector, before=before, during=during)
    guest.add_text("/scenario", text)
    with guests.written(guest) as initramfs:
        results = run_scenario(ARM64, initramfs)
    assert results.text("exit_code") == "0\n", results.text("output") + (results.text("daemon.log") if "daemon.log" in results else "")
    for trouble in ("BUG:", "WARNING:", "Oops"):
        assert trouble not in results.text("dmesg"), results.text("dmesg")
    return Outcome(results)


# --- The axis


@vm_test("full")
def switch_stuck_open():
    """The limit switch never closes: homing ends at the end of the travel and reports that."""
    return run(before="echo limit 1 >$PLANT/ctl").failed_with("did not trigger after the full travel", layers=0)


@vm_test("full")
def switch_stuck_closed():
    """The limit switch stays closed: homing reports that after backing off."""
    return run(before="echo limit 0 >$PLANT/ctl").failed_with("still closed after backing off", layers=0)


def _encoder(policy):
    line = lambda number: {"chip": "zplant", "line": number}  # noqa: E731
    encoder = {"a": line(guests.ENCODER_A), "b": line(guests.ENCODER_B), "counts_per_mm": 200, "reversed": True, "policy": policy}
    return guests.real_config(z_axis={"encoder": encoder})


# One count per four steps.
_WITH_ENCODER = f"load_devices enc_a={guests.ENCODER_A} enc_b={guests.ENCODER_B}"


@vm_test("full")
def dead_motor():
    """The motor stops turning after the first layer: the encoder detects that and the print fails."""
    outcome = run(
        devices=_WITH_ENCODER,
        config=_encoder("fault"),
        during='wait_for 300 "layer 1" exposed 1\necho motor 0 >$PLANT/ctl',
    )
    return outcome.failed_with("encoder", layers=1)


@vm_test("full")
def lost_steps_are_made_good():
    """A hundred steps are lost in a lift: with the policy "correct", every mask is still at its height."""
    outcome = run(
        devices=_WITH_ENCODER,
        config=_encoder("correct"),
        during='wait_for 300 "layer 1" exposed 1\necho skip 100 >$PLANT/ctl',
    )
    outcome.is_printed()
    # One count of the encoder is four steps, which limits the precision of a height.
    for number, picture in enumerate(outcome.frames.lit_pictures(), 1):
        off = outcome.edges.position_at(picture.start_ns) - 40 * number
        assert abs(off) <= 40, f"layer {number} was {off} steps off"


# The time from a safety input's edge until the input thread has cut the light's line.
_CUT_NS = 5_000_000


@vm_test("full")
def stopped_in_a_move():
    """The daemon is stopped for two seconds while the plate moves at full speed: the motor stops dead and may have lost
    steps; no step follows, the position is unknown, and the print fails with that reason."""
    outcome = run(
        # At half of this speed the motor can stop dead without loss; the lift of 1 mm is faster and takes 0.7 s.
        config=guests.real_config(z_axis={"homing_speed_mm_s": 1}),
        during="""wait_for 300 "layer 1" exposed 1
sleep 0.3
uptime_s >/out/stopped
kill -STOP $DAEMON
sleep 2
kill -CONT $DAEMON""",
    )
    reason = outcome.failed_with("may lose steps", layers=1)
    stopped = round(float(outcome.results.text("stopped")) * 1e9)
    late = outcome.edges.steps()["time_ns"]
    late = late[late > stopped + _NOTED_NS]
    assert len(late) == 0, f"{len(late)} steps after the stop, the last {int(late[-1]) - stopped} ns"
    return reason


@vm_test("full")
def emergency_stop_in_a_move():
    """The emergency stop is pressed while the plate moves: the next step is not made, and the print fails."""
    pressed = f'wait_for 300 "layer 1" exposed 1\nsleep 0.5\necho in {guests.EMERGENCY_STOP} 1 >$PLANT/ctl'
    outcome = run(during=pressed)
    reason = outcome.failed_with("emergency stop", layers=1)
    at = int(outcome.edges.edges(guests.EMERGENCY_STOP)["time_ns"][0])
    late = outcome.edges.steps()["time_ns"]
    late = late[late > at]
    # Steps may be due until the event reaches the thread. The debounce time of 5 ms does not delay a stop.
    assert len(late) == 0 or int(late[-1]) - at < 10_000_000, f"steps until {int(late[-1]) - at} ns after the stop"
    return reason


@vm_test("full")
def emergency_stop_in_an_exposure():
    """The emergency stop is pressed in an exposure: the light goes off, and the print fails."""
    outcome = run(during=f'wait_for 300 "layer 2" exposing 2\necho in {guests.EMERGENCY_STOP} 1 >$PLANT/ctl')
    reason = outcome.failed_with("emergency stop", layers=2)
    at = int(outcome.edges.edges(guests.EMERGENCY_STOP)["time_ns"][0])
    off = outcome.edges.active(outcome.edges.lines.light)[-1][1]
    assert off - at <= _CUT_NS, f"the light went off {off - at} ns after the stop"
    return f"{reason}; light off {(off - at) / 1e6:.2f} ms after the edge"


@vm_test("full")
def chattering_emergency_stop_in_an_exposure():
    """The emergency stop chatters 250 times in an exposure while other programs keep the processor busy: the light goes
    off at the first edge and stays off, and the print fails."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
for program in 1 2 3; do sh -c 'while :; do :; done' & busy="$busy $!"; done
sleep 0.2
for i in $(seq 250); do
  echo in {guests.EMERGENCY_STOP} 1 >$PLANT/ctl
  sleep 0.004
  echo in {guests.EMERGENCY_STOP} 0 >$PLANT/ctl
  sleep 0.004
done
kill $busy"""
    )
    reason = outcome.failed_with("emergency stop", layers=2)
    at = int(outcome.edges.edges(guests.EMERGENCY_STOP)["time_ns"][0])
    light = outcome.edges.active(outcome.edges.lines.light)
    assert len(light) == 2, f"the light was on {len(light)} times"
    off = light[-1][1]
    assert off - at <= _CUT_NS, f"the light went off {off - at} ns after the first edge"
    return f"{reason}; light off {(off - at) / 1e6:.2f} ms after the first edge"


@vm_test("full")
def lid_opened_in_an_exposure():
    """The lid is opened in an exposure: the light goes off; after closing and resuming, the layer gets the rest of its
    light."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
sleep 1
echo in {guests.LID} 1 >$PLANT/ctl
wait_for 5 "the light to go off" light_is_off
sleep 3
light_is_off || fail "light with the lid open"
echo in {guests.LID} 0 >$PLANT/ctl
sleep 1
contourctl resume || true"""
    )
    outcome.is_printed()
    lit = [end - start for start, end in outcome.edges.active(outcome.edges.lines.light)]
    assert len(lit) == 5, f"the light was on {len(lit)} times"
    whole = lit[1] + lit[2]
    assert abs(whole - 2_000_000_000) < 20_000_000, f"layer 2 had light for {whole} ns in two parts"
    at = int(outcome.edges.edges(guests.LID)["time_ns"][0])
    off = outcome.edges.active(outcome.edges.lines.light)[1][1]
    assert off - at <= _CUT_NS, f"the light went off {off - at} ns after the lid's edge"
    return f"light off {(off - at) / 1e6:.2f} ms after the edge"


_POWER_FAIL = 7
_RECORDED = 8  # the scenario sets it when the record has changed, for the time in the axis' log
_WRITTEN_NS = 500_000_000  # from the edge until the state is on the disk, which is in memory here; stated in docs/printing.md


def _input(line):
    return {"chip": "zplant", "line": line}


@vm_test("full")
def power_fails_in_an_exposure():
    """The power-fail line becomes active in an exposure: the light is off and the print's state is written within the stated times, so
    that after the cut the next start knows the layer and the light that it has had."""
    outcome = run(
        config=guests.real_config(z_axis={"power_fail": _input(_POWER_FAIL)}),
        scenario=_SCENARIO.replace("wait_for_print\n", "").replace("sleep 1\nkeep_logs", "keep_logs"),
        during=f"""wait_for 300 "layer 2" exposing 2
sleep 1
record=$(find $SPOOL -name print-progress)
cp $record /before
echo in {_POWER_FAIL} 1 >$PLANT/ctl
while cmp -s $record /before; do :; done
echo in {_RECORDED} 1 >$PLANT/ctl
kill -KILL $DAEMON
sleep 2
echo in {_POWER_FAIL} 0 >$PLANT/ctl
rm -f /run/contourd/control.sock
start_daemon
contourctl status --json >/out/status""",
    )
    edges = outcome.edges
    failed, recorded = (int(edges.edges(line)["time_ns"][0]) for line in (_POWER_FAIL, _RECORDED))
    on, off = edges.active(edges.lines.light)[-1]
    assert 0 <= off - failed <= _CUT_NS, f"the light went off {off - failed} ns after the edge"
    assert off <= recorded <= failed + _WRITTEN_NS, f"the state was written {recorded - failed} ns after the edge"
    interrupted = json.loads(outcome.results.text("status"))["result"]["interrupted"]
    assert (interrupted["job"], interrupted["layer"]) == ("part", 2), interrupted
    assert abs(interrupted["light_s"] - (off - on) / 1e9) < 0.02, f"{interrupted}, and the light was on for {off - on} ns"
    outcome.was_dark()
    return f"light off {(off - failed) / 1e6:.2f} ms and state written {(recorded - failed) / 1e6:.1f} ms after the edge"


# --- The display

_UNPLUG, _PLUG = "echo unplug >$SCREEN/ctl", "echo plug >$SCREEN/ctl"


@vm_test("full")
def display_unplugged_before_the_print():
    """The display is unplugged before a print begins: the job waits, the log says why, and the job is printed when the
    display is back."""
    outcome = run(
        scenario=_SCENARIO.replace("print_model", f"{_UNPLUG}\nsleep 1\nprint_model"),
        during=f"""sleep 60
[ $(lit_pictures) = 0 ] || fail "a mask was shown on a display that is not there"
{_PLUG}""",
    )
    outcome.is_printed()
    assert re.search("part.stl waits: HDMI-A-1 .* was unplugged", outcome.log), outcome.log


@vm_test("full")
def display_unplugged_between_exposures():
    """The display is unplugged while the plate moves: the print waits, and finishes after the display is back and the
    print is resumed."""
    outcome = run(
        during=f"""wait_for 300 "layer 1" exposed 1
sleep 0.5
{_UNPLUG}
sleep 20
[ $(lit_pictures) = 1 ] || fail "a mask was shown on a display that is not there"
{_PLUG}
sleep 2
contourctl resume || true"""
    )
    outcome.is_printed()
    assert "HDMI-A-1" in outcome.log


@vm_test("full")
def display_unplugged_in_an_exposure():
    """The display is unplugged in an exposure: the light goes off; after the display is back and the print is resumed,
    the layer gets the rest of its light."""
    outcome = run(
        during=f"""wait_for 300 "layer 2" exposing 2
sleep 1
{_UNPLUG}
wait_for 5 "the light to go off" light_is_off
sleep 5
light_is_off || fail "light without a display"
{_PLUG}
sleep 2
contourctl resume || true"""
    )
    outcome.is_printed()
    unplugged = outcome.frames.times("UNPLUG")[0]
    off = [end for _, end in outcome.edges.active(outcome.edges.lines.light) if end > unplugged][0]
    assert off - unplugged < 100_000_000, f"the light went off {off - unplugged} ns after the display was unplugged"


def _light_lost_after(outcome, moment):
    """Checks that the light of layer 2 went off soon after this time and that the layer got the rest of its light later.
    Returns the delay in ns."""
    at = round(float(outcome.results.text(moment)) * 1e9)
    lit = outcome.edges.active(outcome.edges.lines.light)
    off = [end for _, end in lit if end > at][0]
    assert off - at < 100_000_000, f"the light went off {off - at} ns after its cause"
    whole = sum(end - start for start, end in lit[1:3])
    assert abs(whole - 2_000_000_000) < 20_000_000, f"layer 2 had light for {whole} ns in two parts"
    return off - at


@vm_test("full")
def mode_lost_in_an_exposure():
    """The display loses its mode in an exposure and has only a smaller one: light and screen go off; after the mode is
    back and the print is resumed, the layer gets the rest of its light."""
    outcome = run(
        before="cat /edid-1080 >$SCREEN/edid",
        during=f"""wait_for 300 "layer 2" exposing 2
sleep 1
uptime_s >/out/changed
cat /edid-720 >$SCREEN/edid
wait_for 5 "the light to go off" light_is_off
sleep 5
light_is_off || fail "light on a display of another size"
[ $(lit_pictures) = 2 ] || fail "a mask was shown on a display of another size"
tail -n 1 $SCREEN/log | grep -q OFF || fail "the screen is not off"
cat /edid-1080 >$SCREEN/edid
sleep 2
contourctl resume || true""",
    )
    outcome.is_printed()
    said = re.search("HDMI-A-1 .* no longer has its mode 1920x1080 at 60.00 Hz; modes: 1280x720 at 60.00 Hz", outcome.log)
    assert said, outcome.log
    _light_lost_after(outcome, "changed")
    return said.group()


@vm_test("full")
def card_taken_between_exposures():
    """Another program takes the display's card while the plate moves: the next mask cannot be shown, so there is no
    light, and the log names the program; after it has dropped the card and the print is resumed, the print finishes."""
    outcome = run(
        during="""wait_for 300 "layer 1" exposed 1
sleep 0.5
take-master $DAEMON /dev/dri/card0 &
taker=$!
sleep 20
[ $(lit_pictures) = 1 ] || fail "a mask was shown on a card that is another's"
light_is_off || fail "light without a mask"
kill $taker
# The daemon probes for the display every 5 s.
sleep 6
contourctl resume || true""",
    )
    outcome.is_printed()
    said = re.search(r"another program took over HDMI-A-1 .*: take-master \(process \d+\) is its DRM master", outcome.log)
    assert said and "the display is back" in outcome.log, outcome.log
    assert len(outcome.frames.lit_pictures()) == 4
    return said.group()


@vm_test("full")
def card_taken_in_an_exposure():
    """Another program takes the display's card in an exposure and may show anything: the light goes off."""
    outcome = run(
        during="""wait_for 300 "layer 2" exposing 2
sleep 0.5
take-master $DAEMON /dev/dri/card0 &
taker=$!
uptime_s >/out/taken
sleep 5
light_is_off || fail "light on a card that is another's"
kill $taker
# The daemon probes for the display every 5 s.
sleep 6
contourctl resume || true""",
    )
    outcome.is_printed()
    off_ns = _light_lost_after(outcome, "taken")
    return f"light off {off_ns / 1e6:.0f} ms after the card was taken"


# --- The projector


def _projector(options, baud=9600):
    return f"fake-projector /dev/ttyZ1 {baud} /out/projector {options} {guests.ACER} &"


@vm_test("full")
def silent_projector():
    """The projector never answers: the print fails after the table's retries."""
    return run(projector=_projector("--silent-after 0")).failed_with("/dev/ttyZ0|answer", layers=0)


@vm_test("full")
def projector_silent_in_the_print():
    """A projector whose light is switched by a line stops answering once it is warm: the print fails before its end."""
    outcome = run(projector=_projector("--silent-after 3"))
    outcome.failed_with('did not answer "power"')
    return outcome.reason


@vm_test("full")
def projector_at_another_baud():
    """The projector uses another baud rate: the replies are garbage, and the print fails."""
    return run(projector=_projector("", baud=19200)).failed_with("/dev/ttyZ0|answer", layers=0)


@vm_test("full")
def garbling_projector():
    """The projector's replies are damaged: the print fails."""
    return run(projector=_projector("--garble")).failed_with("/dev/ttyZ0|answer", layers=0)


@vm_test("full")
def slow_projector():
    """The projector takes nine tenths of the timeout to answer: the print succeeds."""
    run(projector=_projector("--delay-ms 900")).is_printed()


# --- A light that is switched by the projector's commands

_LIGHT_ON, _LIGHT_OFF = r"~0002 0\x0d", r"~0002 1\x0d"
_OPTOMA = (
    r"fake-projector /dev/ttyZ1 9600 /out/projector '~0000 1\r=>P\r' '~0000 0\r=>P\r' '~0002 0\r=>P\r' '~0002 1\r=>P\r' "
    r"'~00124 1\r=>Ok0\r' '~00124 1\r=>Ok1\r' &"
)
# The time of eight plus two bytes at 9600 baud; and the time that the guest's one processor may be busy hashing pictures before
# the kernel's worker for the line runs, and again before the program that reads the line runs.
_BUSY_NS = 3_000_000
_COMMAND_NS, _REPLY_NS = (8 * 10 * 1_000_000_000 // 9600 + 2 * _BUSY_NS, 2 * 10 * 1_000_000_000 // 9600 + 2 * _BUSY_NS)
_GAP_NS = 100_000_000  # gap_ms of the table
_LIT_BY_SERIAL = r"""
lit_by_serial() {
  still_printing && [ "$(lit_pictures)" -ge "$1" ] && grep '~0002' /out/projector | tail -n 1 | grep -q '~0002 0'
}
"""


def _light_by_serial():
    return guests.real_config(projector={"table": "optoma", "light": None})


def _commanded_light(outcome):
    """Returns [(on_ns, off_ns)] as commanded to the projector, at the commands' last bytes."""
    intervals, on = [], None
    for line in outcome.results.text("projector").splitlines():
        time_ns, request = line.split(" ", 1)
        if request == _LIGHT_ON and on is None:
            on = int(time_ns)
        elif request == _LIGHT_OFF and on is not None:
            intervals.append((on, int(time_ns)))
            on = None
    return intervals if on is None else [*intervals, (on, None)]


@vm_test("full")
def light_by_serial():
    """The projector's light is switched by commands: it is on once per layer, with the layer's mask on the screen and the
    plate at rest, and off at the end."""
    outcome = run(projector=_OPTOMA, config=_light_by_serial())
    outcome.is_printed()
    light = _commanded_light(outcome)
    assert len(light) == 4, f"the light was on {len(light)} times"
    check(exposure_checks.light_only_on_masks(outcome.frames, outcome.edges, light, _COMMAND_NS))
    # The times from first byte to first byte, and from last to last, do not depend on the replies' duration.
    beyond = [off - on - 2_000_000_000 for on, off in light]
    assert all(abs(ns) <= 2 * _BUSY_NS for ns in beyond), f"{beyond} ns more than was requested"
    return f"light {max(beyond) / 1e6:.1f} ms more than was requested at most"


@vm_test("full")
def reply_lost():
    """The reply to the second layer's light on is lost: light on is not sent again, the light goes off after the timeout,
    and the print waits for the operator, with the bounds of the exposure in the report."""
    outcome = run(
        projector=_OPTOMA.replace(r"'~0002 0\r=>P\r'", r"'~0002 0\r=>P\r' '~0002 0\r=>' '~0002 0\r=>P\r'"),
        config=_light_by_serial(),
        # The log is polled, because asking the daemon costs the emulator more than the print.
        during='wait_for 300 "the interruption" grep -q "did not answer .light on" /out/daemon.log\ncontourctl resume',
    )
    outcome.is_printed()
    light = _commanded_light(outcome)
    assert len(light) == 5, f"the light was on {len(light)} times"
    check(exposure_checks.light_only_on_masks(outcome.frames, outcome.edges, light, _COMMAND_NS))
    record = json.loads(outcome.results.text("spool/done/part.report.json"))["layer_records"][1]
    given = sum(off - on for on, off in light[1:3]) / 1e6
    assert record["exposure_parts"] == 2, record
    slack = 2 * _BUSY_NS / 1e6
    assert record["exposure_least_ms"] - slack <= given <= record["exposure_most_ms"] + slack, (record, given)
    return f"{given:.1f} ms given, {record['exposure_least_ms']:.1f} to {record['exposure_most_ms']:.1f} recorded"


@vm_test("full")
def lid_opened_in_an_exposure_by_serial():
    """The lid is opened in an exposure with a light that is switched by commands, while other programs keep the processor
    busy: light off is sent within the table's gap, the command in progress and one command's time on the wire."""
    outcome = run(
        projector=_OPTOMA,
        config=_light_by_serial(),
        before=_LIT_BY_SERIAL,
        during=f"""wait_for 300 "layer 2" lit_by_serial 2
for program in 1 2 3; do sh -c 'while :; do :; done' & busy="$busy $!"; done
sleep 0.5
echo in {guests.LID} 1 >$PLANT/ctl
sleep 2
echo in {guests.LID} 0 >$PLANT/ctl
kill $busy
sleep 1
contourctl resume || true""",
    )
    outcome.is_printed()
    at = int(outcome.edges.edges(guests.LID)["time_ns"][0])
    off = [off for on, off in _commanded_light(outcome) if on < at < off]
    assert len(off) == 1, f"the light was {_commanded_light(outcome)}, and the edge at {at} ns"
    late, most = off[0] - at, _GAP_NS + 2 * _COMMAND_NS
    assert late <= most, f"light off came {late} ns after the lid's edge; {most} ns are allowed"
    return f"light off {late / 1e6:.1f} ms after the edge"


@vm_test("full")
def stopped_in_the_warm_up():
    """The daemon is stopped while the projector warms up and refuses all commands: the unit's clean-up repeats light off
    until it is accepted."""
    refusals = r"'~0002 1\r=>F\r' " * 12
    outcome = run(
        projector=_OPTOMA.replace(r"'~0002 1\r=>P\r'", refusals + r"'~0002 1\r=>P\r'").replace(
            r"'~0000 0\r=>P\r'", r"'~0000 0\r=>F\r'").replace(
            r"'~00124 1\r=>Ok0\r' ", r"'~00124 1\r=>Ok0\r' " * 3),
        config=_light_by_serial(),
        scenario="""\
. /lib.sh
{devices}
{projector}
start_daemon
print_model
wait_for 60 "power on" grep -q '~0000 1' /out/projector
stop_daemon
contourd --config /etc/contourd/contourd.json --light-off >/out/light_off 2>&1 || fail "light off ended with $?"
keep_logs
""",
    )
    asked = [line.split(" ", 1)[1] for line in outcome.results.text("projector").splitlines()]
    assert asked.count(_LIGHT_OFF) == 13, asked
    assert "has not confirmed that its light is off" in outcome.log, outcome.log
    assert "light off, motor still" not in outcome.log, outcome.log


# --- Devices that the daemon cannot open

_REFUSED = """\
. /lib.sh
{devices}
{projector}
mkdir -p $SPOOL /run/contourd
chmod 777 $SPOOL /run/contourd
{before}
keep_logs
"""


@vm_test("full")
def line_busy():
    """Another program holds the step line: the daemon reports the line and the program, and that it cannot print."""
    outcome = run(
        scenario=_REFUSED,
        before="""
for chip in /sys/class/gpio/gpiochip*; do
  [ "$(cat $chip/label)" != zplant ] || base=$(cat $chip/base)
done
echo $((base + 17)) >/sys/class/gpio/export
timeout 10 contourd --config /etc/contourd/contourd.json 2>/out/daemon.log
mkdir -p $SPOOL/done $SPOOL/failed $SPOOL/incoming $SPOOL/printing""",
    )
    said = re.search('the printer cannot print: line 17 of .*zplant.* is used by "sysfs"', outcome.log)
    assert said, outcome.log
    return said.group()


@vm_test("full")
def no_permission():
    """The daemon's user may not open the GPIO chip: the daemon reports that with the device's name, and that it cannot
    print."""
    outcome = run(
        scenario=_REFUSED,
        before="""
echo nobody:x:65534:65534::/:/bin/sh >/etc/passwd
chmod 600 /dev/gpiochip*
mkdir /tmp/state
chown 65534 /tmp/state
STATE_DIRECTORY=/tmp/state su nobody -s /bin/sh -c "LD_LIBRARY_PATH=/lib timeout 10 contourd --config /etc/contourd/contourd.json" 2>/tmp/log
cp /tmp/log /out/daemon.log
mkdir -p $SPOOL/done $SPOOL/failed $SPOOL/incoming $SPOOL/printing""",
    )
    said = re.search("the printer cannot print: .*gpiochip[0-9].*[Pp]ermission denied.*", outcome.log)
    assert said, outcome.log
    return said.group()


# --- The daemon itself

# The light watchdog's time: 200 ms of silence after the daemon's last sign of life, and 50 ms for the wake-up.
_WATCHDOG_NS = 250_000_000
# The time from the scenario's note until the signal is sent: the clock's resolution of 10 ms, and the start of a program.
_NOTED_NS = 30_000_000


def _off_after(outcome, light, moment):
    """Checks that the light went off within the light watchdog's time after this time. Returns the delay in ns."""
    at = round(float(outcome.results.text(moment)) * 1e9)
    off = [end for start, end in light if start < at and (end is None or end > at)]
    assert len(off) == 1 and off[0] is not None, f"the light was {light}, and the moment {at} ns"
    late = off[0] - at
    assert late <= _WATCHDOG_NS + _NOTED_NS, f"the light went off {late} ns after its cause"
    return late


_STOPPED = """wait_for 300 "layer 2" {exposing} 2
sleep 1
uptime_s >/out/stopped
kill -STOP $DAEMON
sleep 20
kill -CONT $DAEMON
sleep 5
{dark} || fail "light after the daemon went on"
contourctl resume || true"""


@vm_test("full")
def stopped_in_an_exposure():
    """The daemon is stopped for 20 s in an exposure: the light watchdog turns the light off, which is reported; after
    resuming, the layer gets the rest of its light."""
    outcome = run(during=_STOPPED.format(exposing="exposing", dark="light_is_off"))
    outcome.is_printed()
    light = outcome.edges.active(outcome.edges.lines.light)
    late = _off_after(outcome, light, "stopped")
    assert "the light watchdog has turned the light off" in outcome.log, outcome.log
    # The watchdog reports when it turned the line off.
    whole = sum(end - start for start, end in light[1:3])
    assert abs(whole - 2_000_000_000) < 20_000_000, f"layer 2 had light for {whole} ns in two parts"
    return f"light off {late / 1e6:.0f} ms after the stop"


@vm_test("full")
def stopped_in_an_exposure_by_serial():
    """The daemon is stopped in an exposure with a light that is switched by commands: the light watchdog sends light
    off."""
    outcome = run(
        projector=_OPTOMA,
        config=_light_by_serial(),
        before=_LIT_BY_SERIAL,
        during=_STOPPED.format(exposing="lit_by_serial", dark="! lit_by_serial 1"),
    )
    late = _off_after(outcome, _commanded_light(outcome), "stopped")
    assert "the light watchdog has turned the light off" in outcome.log, outcome.log
    outcome.is_printed()
    return f"light off {late / 1e6:.0f} ms after the stop"


_KILLED = """wait_for 300 "layer 2" {exposing} 2
sleep 1
uptime_s >/out/killed
kill -KILL $DAEMON
sleep 3
cp $PLANT/state /out/after
rm /run/contourd/control.sock
start_daemon
uptime_s >/out/restarted
wait_for_print"""


@vm_test("full")
def killed_in_an_exposure():
    """The daemon is killed in an exposure: the light watchdog turns the light off and exits; at the next start the job is
    filed as failed with its reason."""
    outcome = run(during=_KILLED.format(exposing="exposing"))
    assert "light 0" in outcome.results.text("after"), outcome.results.text("after")
    assert outcome.reason, outcome.log
    late = _off_after(outcome, outcome.edges.active(outcome.edges.lines.light), "killed")
    check(exposure_checks.dark_at_the_end(outcome.frames, outcome.edges))
    return f"light off {late / 1e6:.0f} ms after the kill"


@vm_test("full")
def killed_in_an_exposure_by_serial():
    """The daemon is killed in an exposure with a light that is switched by commands: light off is sent three times."""
    outcome = run(
        projector=_OPTOMA,
        config=_light_by_serial(),
        before=_LIT_BY_SERIAL,
        during=_KILLED.format(exposing="lit_by_serial"),
    )
    late = _off_after(outcome, _commanded_light(outcome), "killed")
    restarted = float(outcome.results.text("restarted")) * 1e9
    told = [line.split(" ", 1) for line in outcome.results.text("projector").splitlines()]
    before = [request for time_ns, request in told if int(time_ns) < restarted - 500_000_000]
    assert before[-3:] == [_LIGHT_OFF] * 3, f"the projector got {before[-5:]}"
    assert outcome.reason, outcome.log
    check(exposure_checks.dark_at_the_end(outcome.frames, outcome.edges))
    return f"light off {late / 1e6:.0f} ms after the kill"


# Kills both at once, so that the watchdog cannot react.
_KILL_BOTH = r"""
kill_both() {
  both=$DAEMON
  for process in /proc/[0-9]*; do
    [ "$(cat "$process/comm" 2>/dev/null)" != contourd-light ] || both="$both ${process#/proc/}"
  done
  kill -STOP $both
  kill -KILL $both
}
"""
_KILLED_BOTH = """wait_for 300 "layer 2" exposing 2
kill_both
uptime_s >/out/killed
sleep 1
cp $PLANT/state /out/after
rm /run/contourd/control.sock
start_daemon
wait_for_print"""


@vm_test("full")
def killed_with_its_watchdog():
    """The daemon and its light watchdog are killed in an exposure, on a chip whose lines keep their level: the light goes
    off when the daemon is started again, and the job is filed as failed with its reason."""
    outcome = run(before=_KILL_BOTH, during=_KILLED_BOTH)
    assert "light 1" in outcome.results.text("after"), "the light was off already, so this test shows nothing"
    assert outcome.reason, outcome.log
    check(exposure_checks.dark_at_the_end(outcome.frames, outcome.edges))


@vm_test("full")
def killed_with_its_watchdog_lines_fall_back():
    """The daemon and its light watchdog are killed in an exposure, on a chip whose released lines become inputs, as the
    Raspberry Pi's do: the light goes off at once."""
    outcome = run(before=_KILL_BOTH, during=_KILLED_BOTH, devices="load_devices free_input=1")
    assert "light 0" in outcome.results.text("after"), outcome.results.text("after")
    assert outcome.reason, outcome.log
    check(exposure_checks.dark_at_the_end(outcome.frames, outcome.edges))


@vm_test("full")
def killed_with_its_watchdog_by_serial():
    """The daemon and its light watchdog are killed in an exposure with a light that is switched by commands: the kernel
    turns the screen off at once, the unit's clean-up turns the light off, and the daemon's next start turns the lamp
    off."""
    outcome = run(
        projector=_OPTOMA,
        config=_light_by_serial(),
        scenario="""\
. /lib.sh
{devices}
{projector}
{before}
start_daemon
print_model
wait_for 300 "layer 2" lit_by_serial 2
kill_both
uptime_s >/out/killed
wait_for 5 "the screen to go dark" screen_is_off
uptime_s >/out/dark
# The command of the unit's ExecStopPost.
contourd --config /etc/contourd/contourd.json --light-off >/out/light_off 2>&1 || fail "light off ended with $?"
uptime_s >/out/cleaned_up
start_daemon
wait_for 10 "the lamp to be turned off" grep -q '~0000 0' /out/projector
keep_logs
""",
        before=_LIT_BY_SERIAL + _KILL_BOTH + 'screen_is_off() { tail -n 1 $SCREEN/log | grep -q OFF; }',
    )
    killed, cleaned_up = (round(float(outcome.results.text(name)) * 1e9) for name in ("killed", "cleaned_up"))
    outcome.was_dark()
    light = _commanded_light(outcome)
    assert len(light) == 2, f"the light was on {len(light)} times"
    on, off = light[-1]
    assert on < killed, "the light was not on when the daemon was killed"
    assert off is not None, "the projector got no command to turn its light off"
    # /proc/uptime has a resolution of 10 ms.
    assert killed - 10_000_000 <= off <= cleaned_up + 10_000_000, f"light off came {off - killed} ns after the kill"
    return f"light off {(off - killed) / 1e6:.0f} ms after the kill"


@vm_test("full")
def watchdog_killed_in_an_exposure():
    """The light watchdog is killed in an exposure: the light goes off, the print is interrupted, another watchdog is
    started, and the print finishes after it is resumed."""
    outcome = run(
        during="""wait_for 300 "layer 2" exposing 2
sleep 1
uptime_s >/out/killed
for process in /proc/[0-9]*; do
  [ "$(cat "$process/comm" 2>/dev/null)" != contourd-light ] || kill -KILL "${process#/proc/}"
done
wait_for 5 "the light to go off" light_is_off
sleep 5
light_is_off || fail "light without a watchdog"
contourctl resume || true"""
    )
    outcome.is_printed()
    late = _off_after(outcome, outcome.edges.active(outcome.edges.lines.light), "killed")
    assert "the light watchdog has died" in outcome.log, outcome.log
    return f"light off {late / 1e6:.0f} ms after the watchdog's death"
