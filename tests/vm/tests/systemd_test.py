"""contourd as a service of a real Debian system, installed as its README describes, with simulated hardware."""

from bed import guests, models
from bed.architecture import root_image
from bed.qemu import disk_over
from bed.registry import vm_test
from bed.service import SPOOL, booted, install, journal, submit, unit_property

_LAYERS = 4
_MODEL_MM = 0.2
def _guest(**resin):
    guest = guests.systemd_guest(guests.simulated_config(), resin={**guests.QUICK_RESIN, **resin})
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(_MODEL_MM)))
    return guest


def _starts_and_prints(machine):
    install(machine)
    assert unit_property(machine, "Type") == "notify" and unit_property(machine, "ActiveState") == "active"
    assert unit_property(machine, "User") == "contourd"
    assert len(journal(machine, "ready")) == 1
    submit(machine)
    machine.wait_for(f"test -e {SPOOL}/done/part.stl", limit_s=120)
    layers = journal(machine, "layer")
    assert [entry["LAYER"] for entry in layers] == [str(i) for i in range(1, _LAYERS + 1)], layers
    assert [entry["Z_NM"] for entry in layers] == [str(50_000 * i) for i in range(1, _LAYERS + 1)], layers
    assert all(entry["JOB_ID"] == "part" and entry["_SYSTEMD_UNIT"] == "contourd.service" for entry in layers)


def _stops_cleanly(machine):
    machine.run("systemctl stop contourd")
    assert unit_property(machine, "Result") == "success" and unit_property(machine, "ActiveState") == "inactive"
    assert len(journal(machine, "stopped")) == 1
    machine.run("test ! -e /run/contourd")


def _is_restarted_when_it_stalls(machine):
    machine.run("systemctl start contourd")
    submit(machine, "stalled")
    machine.wait_for("contourctl status --json | grep -q '\"layer\"'")
    machine.run("kill -STOP $(systemctl show -P MainPID contourd)")
    machine.wait_for("test $(systemctl show -P NRestarts contourd) = 1", limit_s=60)
    machine.wait_for("systemctl is-active contourd")
    machine.wait_for(f"test -e {SPOOL}/failed/stalled.stl")
    reason = machine.run(f"cat {SPOOL}/failed/stalled.reason.txt")
    assert reason.strip(), "no reason"
    assert "Watchdog timeout" in machine.run("journalctl -u contourd --no-pager")
    return reason


@vm_test("quick")
def systemd():
    """The unit starts and is ready, a print's journal entries have their fields, the service stops cleanly, and if it
    stalls in a print systemd's watchdog restarts it: the job is filed as failed with its reason, and nothing else is
    lost."""
    with guests.written(_guest()) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            _starts_and_prints(machine)
            _stops_cleanly(machine)
            _is_restarted_when_it_stalls(machine)
            machine.run(f"cmp /root/part.stl {SPOOL}/done/part.stl && cmp /root/part.stl {SPOOL}/failed/stalled.stl")
            assert len(journal(machine, "layer")) >= _LAYERS, "the journal lost entries"
            machine.power_off()


@vm_test("full")
def power_cut():
    """The power fails in a print: after the next boot the job is in failed/ with its reason, complete; the next job waits
    for the operator and is printed, and a job that was done is still there."""
    with guests.written(_guest(exposure_ms=3000, bottom_exposure_ms=3000)) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            install(machine)
            submit(machine, "first")
            machine.wait_for(f"test -e {SPOOL}/done/first.stl", limit_s=120)
            submit(machine, "cut")
            machine.wait_for("contourctl status --json | grep -q '\"layer\"'")
            submit(machine, "waiting")
            # The user synchronizes copied files; the daemon is responsible for claimed ones.
            machine.run(f"sync {SPOOL}/incoming/waiting.stl")
            machine.wait_for("contourctl status --json | grep -q waiting")
            machine.kill()
        with booted(initramfs, disk) as machine:
            machine.wait_for("systemctl is-active contourd")
            machine.wait_for("contourctl status | grep -q 'the queue is held: cut was interrupted'")
            machine.run(f"test -e {SPOOL}/incoming/waiting.stl")
            machine.run("contourctl plate-cleared")
            machine.wait_for(f"test -e {SPOOL}/done/waiting.stl", limit_s=120)
            reason = machine.run(f"cat {SPOOL}/failed/cut.reason.txt")
            for file in ("done/first", "failed/cut", "done/waiting"):
                machine.run(f"cmp /root/part.stl {SPOOL}/{file}.stl")
            assert machine.run(f"ls -A {SPOOL}/printing {SPOOL}/incoming").count(".stl") == 0
            machine.power_off()
    return reason.strip()


@vm_test("full")
def reload():
    """systemctl reload in a print: the print ends undisturbed, then a new process takes over with the waiting jobs. A
    wrong configuration is reported, and the running contourd continues."""
    with guests.written(_guest(exposure_ms=2000, bottom_exposure_ms=2000)) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            install(machine)
            submit(machine, "first")
            machine.wait_for("contourctl status --json | grep -q '\"layer\"'", limit_s=60)
            before = unit_property(machine, "MainPID")
            machine.run("systemctl reload contourd")
            submit(machine, "second")
            machine.run("contourctl status --json | grep -q '\"name\":\"first\"'")
            assert unit_property(machine, "MainPID") == before, "contourd was restarted during a print"
            machine.wait_for(f"test -e {SPOOL}/done/first.stl", limit_s=120)
            machine.wait_for(f"test $(systemctl show -P MainPID contourd) != {before}", limit_s=60)
            machine.wait_for(f"test -e {SPOOL}/done/second.stl", limit_s=120)
            layers = [(entry["JOB_ID"], entry["LAYER"]) for entry in journal(machine, "layer")]
            assert layers == [(job, str(i)) for job in ("first", "second") for i in range(1, _LAYERS + 1)], layers
            machine.run(f"test -z \"$(ls -A {SPOOL}/failed {SPOOL}/printing | grep stl)\"")
            now = unit_property(machine, "MainPID")
            machine.run("cp /etc/contourd/contourd.json /root/good.json && echo '{' >/etc/contourd/contourd.json")
            machine.run("! systemctl reload contourd")
            machine.run("cp /root/good.json /etc/contourd/contourd.json")
            submit(machine, "third")
            machine.wait_for(f"test -e {SPOOL}/done/third.stl", limit_s=120)
            assert unit_property(machine, "MainPID") == now, "contourd was restarted with a wrong configuration"
            machine.power_off()
