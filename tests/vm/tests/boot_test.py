"""Tests of the bed itself: the daemon, built for each architecture, runs on its kernel together with our devices."""

from bed import guests
from bed.architecture import AMD64, ARM64
from bed.qemu import run_scenario
from bed.registry import vm_test

SCENARIO = """\
. /lib.sh
insmod /mod/zplant.ko
insmod /mod/zproj.ko
insmod /mod/zserial.ko
for device in /dev/gpiochip0 /dev/dri/card0 /dev/ttyZ0 /dev/ttyZ1; do
  [ -e $device ] || fail "no $device"
done
start_daemon
print_model
wait_for_print
keep_logs
stop_daemon || fail "the daemon ended with $?"
"""


def _boot_and_print(arch):
    guest = guests.printer_guest(arch, guests.simulated_config(), resin=guests.QUICK_RESIN)
    guest.add_text("/scenario", SCENARIO)
    with guests.written(guest) as initramfs:
        results = run_scenario(arch, initramfs)
    assert results.text("exit_code") == "0\n", results.text("output") + results.text("daemon.log")
    assert "spool/done/part.report.json" in results, f"not printed: {results.names()}\n{results.text('daemon.log')}"
    assert "spool/failed/part.stl" not in results
    for trouble in ("BUG:", "WARNING:", "Oops"):
        assert trouble not in results.text("dmesg"), results.text("dmesg")


@vm_test("quick")
def boot_arm64():
    """contourd prints with simulated hardware on arm64; our devices exist and the kernel reports no problem."""
    _boot_and_print(ARM64)


@vm_test("quick")
def boot_amd64():
    """contourd prints with simulated hardware on amd64; our devices exist and the kernel reports no problem."""
    _boot_and_print(AMD64)
