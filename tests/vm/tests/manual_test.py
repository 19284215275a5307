"""Manual control with a real kernel's devices: heights, light and pictures as the devices recorded them, and their end
when the client is killed. arm64, in deterministic time."""

import json

from bed import guests
from bed.architecture import ARM64
from bed.edge_log import LOST, EdgeLog
from bed.frame_log import FrameLog
from bed.qemu import run_scenario
from bed.registry import vm_test

_SCENARIO = """\
. /lib.sh
load_devices
fake-projector /dev/ttyZ1 9600 /out/projector %(acer)s &
start_daemon
killed() {
  sleep 1
  uptime_s >"/out/killed_$1"
  kill -9 "$2"
  sleep 2
}
contourctl move --by 5 --unhomed && fail "too long a move from an unknown position"
uptime_s >/out/nudged
contourctl move --by 2 --unhomed || fail "a short move from an unknown position"
uptime_s >/out/nudge_over
contourctl move --to 5 && fail "a move from an unknown position"
contourctl home || fail "home"
contourctl move --to 5 || fail "move"
contourctl home | grep -q "found [01][.][0-9] um" || fail "home did not report the switch's shift"
contourctl move --to 5 || fail "move"
contourctl show grid &
SHOWS=$!
sleep 1
contourctl light on --seconds 2 --confirm --in-resin || fail "light on"
contourctl light on --seconds 2 --confirm && fail "light in the resin"
killed show $SHOWS
contourctl light on --seconds 20 --confirm --in-resin &
LIGHTS=$!
wait_for 60 "light" light_is_on
contourctl move --to 6 && fail "a move while the light is on"
killed light $LIGHTS
contourctl move --to 9 --speed 1 &
killed move $!
contourctl move --to 9 || fail "move"
contourctl home &
killed home $!
contourctl home || fail "home"
contourctl motor off || fail "motor off"
contourctl move --to 1 && fail "a move from an unknown position"
contourctl switches --once --json >/out/switches || fail "switches"
keep_logs
stop_daemon || fail "the daemon ended with $?"
"""

_WITHIN_NS = 100_000_000
_UPTIME_NS = 10_000_000  # the resolution of /proc/uptime
_STEPS_A_MM = 800
_WIDTH, _HEIGHT, _CELL_PX = 1920, 1080, 100  # 5 mm of 50 um


def _lit_by_grid():
    """Returns lines of one pixel every 5 mm from the centre; the two lines through the centre are three pixels wide."""
    def lines(side):
        return {side // 2 - 1, side // 2 + 1, *range(side // 2 % _CELL_PX, side, _CELL_PX)}
    return _WIDTH * _HEIGHT - (_WIDTH - len(lines(_WIDTH))) * (_HEIGHT - len(lines(_HEIGHT)))


def _run():
    guest = guests.printer_guest(ARM64, guests.real_config())
    guest.add_text("/scenario", _SCENARIO % {"acer": guests.ACER})
    with guests.written(guest) as initramfs:
        results = run_scenario(ARM64, initramfs)
    assert results.text("exit_code") == "0\n", results.text("output") + results.text("daemon.log")
    return results


@vm_test("full")
def by_hand():
    """Home, move, light and a test pattern by manual control match the devices' records; when the client is killed the
    picture and the light go off within 100 ms, and a motion slows down to rest at once."""
    results = _run()
    edges, frames = EdgeLog(results.bytes("edges")), FrameLog(results.text("frames"))

    def second(file):
        return round(float(results.text(file)) * 1e9)

    def killed(what):
        return second(f"killed_{what}")

    light = edges.active(edges.lines.light)
    assert len(light) == 2, f"the light was on {len(light)} times"
    asked = light[0][1] - light[0][0]
    assert abs(asked - 2_000_000_000) < 20_000_000, f"light for {asked} ns"
    late = light[1][1] - killed("light")
    assert late < _WITHIN_NS + _UPTIME_NS, f"light off {late} ns after its client was killed"
    for start, end in light:
        moved = [time for time in edges.steps()["time_ns"] if start <= time <= end]
        assert not moved, f"{len(moved)} steps in the light"
        assert edges.position_at(start) == 5 * _STEPS_A_MM, edges.position_at(start)

    pictures = frames.lit_pictures()
    assert [picture.lit for picture in pictures] == [_lit_by_grid()], [picture.lit for picture in pictures]
    assert pictures[0].start_ns < light[0][0] and light[0][1] < pictures[0].end_ns, "the grid was not shown in the light"
    gone = pictures[0].end_ns - killed("show")
    assert gone < _WITHIN_NS + _UPTIME_NS, f"the picture was gone {gone} ns after its client was killed"

    times = edges.steps()["time_ns"]
    nudged = times[(times > second("nudged")) & (times < second("nudge_over") + _UPTIME_NS)]
    assert len(nudged) == 2 * _STEPS_A_MM, f"{len(nudged)} steps from an unknown position"
    assert edges.position_at(int(nudged[-1])) - edges.position_at(int(nudged[0]) - 1) == 2 * _STEPS_A_MM, "the plate did not go up"
    # The profile of contourd.json: 25 mm/s2. A stop at 1 mm/s takes 40 ms, one at 5 mm/s 200 ms.
    for what, speed in (("move", 1), ("home", 5)):
        at = killed(what)
        last = int(times[(times > at) & (times < at + 1_500_000_000)][-1]) - at
        assert last < _WITHIN_NS + _UPTIME_NS + speed / 25 * 1e9, f"{what}: the last step came {last} ns after the kill"
    assert not (edges.events["flags"] & LOST).any(), "steps were lost"
    enabled = edges.edges(edges.lines.enable)
    assert int(enabled["value"][-1]) == 1, "the motor is still enabled"  # active low
    (limit,) = [each for each in json.loads(results.text("switches")) if each["name"] == "limit switch"]
    recorded = edges.edges(edges.lines.limit)
    assert limit["active"] and limit["edges"] == len(recorded), f"{limit}, and {len(recorded)} edges were recorded"
    return f"light off {late / 1e6:.1f} ms, black {gone / 1e6:.1f} ms after the kill"
