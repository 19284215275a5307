"""`contourd --check-hardware` with all supported devices. arm64, in deterministic time."""

from bed import guests
from bed.architecture import ARM64
from bed.qemu import run_scenario
from bed.registry import vm_test

_SECOND_SWITCH = 25
# The only questions that an Optoma that is on may get.
_QUESTIONS = [r"~00124 1\x0d", r"~00108 1\x0d"]

_FINDINGS = """\
ok   step            line 17 of {chip} (zplant), an input, free
ok   direction       line 27 of {chip} (zplant), an input, free
ok   enable          line 22 of {chip} (zplant), an input, free
ok   limit switch    line 23 of {chip} (zplant), an input, free; it is open
ok   second switch   line 25 of {chip} (zplant), an input, free; it is closed
ok   emergency stop  line 5 of {chip} (zplant), an input, free; it is not pressed
ok   lid             line 6 of {chip} (zplant), an input, free; it is closed
ok   encoder A       line 20 of {chip} (zplant), an input, free; it is inactive
ok   encoder B       line 21 of {chip} (zplant), an input, free; it is active
ok   step thread     2400 steps/s needed (3 mm/s); {lateness}
ok   light           line 24 of {chip} (zplant), an input, free
ok   display         HDMI-A-1 of /dev/dri/card0 (zproj): 1920x1080 at 60.00 Hz, atomic; formats: XR24 RG16 R8
ok   projector       Optoma at /dev/ttyZ0, on, lamp 1234 h
"""

_SCENARIO = f"""\
. /lib.sh
load_devices start_pos=2006 enc_a={guests.ENCODER_A} enc_b={guests.ENCODER_B} limit2={_SECOND_SWITCH} limit2_pos=2006
fake-projector /dev/ttyZ1 9600 /out/projector '~00124 1\\r=>Ok1\\r' '~00108 1\\r=>Ok1234\\r' &
mkdir -p $SPOOL/done $SPOOL/failed $SPOOL/incoming $SPOOL/printing
contourd --config /etc/contourd/contourd.json --check-hardware >/out/said 2>&1
echo $? >/out/ended_with
keep_logs
"""


def _config():
    line = lambda number: {"chip": "zplant", "line": number}  # noqa: E731
    encoder = {"a": line(guests.ENCODER_A), "b": line(guests.ENCODER_B), "counts_per_mm": 200}
    # A rate that the emulator can keep: its one processor also hashes the screen's pictures.
    speeds = {f"{name}_speed_mm_s": 3 for name in ("homing", "travel", "top")}
    axis = {"encoder": encoder, "second_switch": {**line(_SECOND_SWITCH), "active_low": True}, **speeds}
    return guests.real_config(z_axis=axis, projector={"table": "optoma"})


@vm_test("full")
def check_hardware():
    """Every device is found and listed with its state; nothing moves, lights up or is shown, and the projector is only
    asked for its state."""
    guest = guests.printer_guest(ARM64, _config())
    guest.add_text("/scenario", _SCENARIO)
    with guests.written(guest) as initramfs:
        results = run_scenario(ARM64, initramfs)
    said = results.text("said")
    assert results.text("ended_with") == "0\n", said
    chip = said.split(" of ", 1)[1].split()[0]
    # The threads' latency depends on this computer, not on the check.
    lateness = said.split("(3 mm/s); ", 1)[1].splitlines()[0]
    assert "this computer sustains" in lateness, said
    assert said == _FINDINGS.format(chip=chip, lateness=lateness), said
    assert not results.bytes("edges"), "levels of the axis' lines changed"
    assert not results.text("frames"), results.text("frames")
    asked = [line.split(" ", 1)[1] for line in results.text("projector").splitlines()]
    assert asked == _QUESTIONS, asked
    return said.splitlines()[-1]
