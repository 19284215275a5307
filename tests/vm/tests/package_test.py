"""contourd's package with apt and systemd: from installation to purge, with upgrades in all states in between."""

import re

from bed import guests, models
from bed.architecture import other_debian, root_image
from bed.qemu import disk_over
from bed.registry import vm_test
from bed.service import SPOOL, booted, journal, submit, unit_property

_UPGRADES = 4
_CONFIG = "/etc/contourd/contourd.json"
_LAYERS = 4


def _apt(machine, *arguments):
    """Runs apt-get and returns its output."""
    return machine.run(f"DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a apt-get -y -q {' '.join(arguments)} </dev/null 2>&1", limit_s=900)


def _upgrade(machine, number):
    said = _apt(machine, "install", f"/root/upgrade-{number}.deb")
    assert machine.run("dpkg-query -W -f '${Version}' contourd").endswith(f".{number}"), said
    return said


def _process(machine):
    return unit_property(machine, "MainPID")


def _is_installed_and_prints(machine):
    """Checks a new installation, with no file edited."""
    _apt(machine, "install", "/root/contourd.deb")
    assert unit_property(machine, "ActiveState") == "active" and unit_property(machine, "UnitFileState") == "enabled"
    submit(machine, "first")
    machine.wait_for(f"test -e {SPOOL}/done/first.stl", limit_s=400, pause_s=1)
    assert [entry["JOB_ID"] for entry in journal(machine, "layer")] == ["first"]


def _is_upgraded_while_idle(machine):
    """Checks an upgrade while a submitted job waits because the plate is not clear; the job still waits afterwards."""
    machine.run(f"sed -i 's/\"name\": .*/\"name\": \"mine\",/' {_CONFIG} && cp /root/quick.json /etc/contourd/resins/standard.json")
    machine.run(f"cp {_CONFIG} /root/mine.json && cp /root/tall.stl /root/part.stl")
    submit(machine, "second")
    machine.wait_for("contourctl queue | grep -q second")
    before = _process(machine)
    _upgrade(machine, 1)
    machine.wait_for(f"test $(systemctl show -P MainPID contourd) -gt 0 && test $(systemctl show -P MainPID contourd) != {before}")
    machine.wait_for("systemctl is-active contourd && contourctl queue | grep -q second")
    machine.run(f"cmp {_CONFIG} /root/mine.json && cmp /root/quick.json /etc/contourd/resins/standard.json")
    machine.run(f"cmp /root/tall.stl {SPOOL}/incoming/second.stl")
    assert "mine" in journal(machine, "ready")[-1]["MESSAGE"]


def _is_upgraded_in_a_print(machine):
    machine.run("contourctl plate-cleared")
    machine.wait_for("contourctl status --json | grep -q '\"layer\"'", limit_s=120)
    before = _process(machine)
    said = _upgrade(machine, 2)
    # apt calls needrestart, which restarts services that run an old program, but not this one.
    assert re.search(r"(?s)Service restarts being deferred:.* systemctl restart\b.* contourd\.service", said), said
    machine.run("contourctl status --json | grep -q '\"layer\"'")
    assert _process(machine) == before, "contourd was restarted during a print"
    machine.wait_for(f"test -e {SPOOL}/done/second.stl", limit_s=200)
    machine.wait_for(f"test $(systemctl show -P MainPID contourd) != {before} && systemctl is-active contourd")
    machine.run("case $(readlink /proc/$(systemctl show -P MainPID contourd)/exe) in *deleted*) false ;; esac")
    layers = [entry["LAYER"] for entry in journal(machine, "layer") if entry["JOB_ID"] == "second"]
    assert layers == [str(i) for i in range(1, _LAYERS + 1)], layers
    machine.run(f"test -z \"$(ls {SPOOL}/failed)\"")


def _keeps_running_with_a_wrong_configuration(machine):
    """Checks that a wrong configuration is reported at once, and that a daemon started with it exits without a
    restart."""
    machine.run(f"echo '{{' >{_CONFIG}")
    before = _process(machine)
    said = _upgrade(machine, 3)
    assert _CONFIG in said and "contourd cannot start with it" in said, said
    assert _process(machine) == before and unit_property(machine, "ActiveState") == "active"
    machine.run("contourctl status")
    machine.run("! systemctl restart contourd")
    machine.wait_for("systemctl is-failed contourd")
    assert unit_property(machine, "NRestarts") == "0" and unit_property(machine, "ExecMainStatus") == "78"
    machine.run(f"cp /root/mine.json {_CONFIG} && systemctl reload-or-restart contourd && systemctl is-active contourd")


def _is_not_started_for_one_who_stopped_it(machine):
    machine.run("systemctl stop contourd")
    said = _upgrade(machine, 4)
    assert "the service is stopped" in said, said
    assert unit_property(machine, "ActiveState") == "inactive"
    machine.run("systemctl start contourd")


def _is_removed_and_purged(machine):
    _apt(machine, "remove", "contourd")
    machine.run("test ! -e /usr/bin/contourd && ! grep -sqx 'contourd.*' /proc/[0-9]*/comm")
    machine.run(f"cmp {_CONFIG} /root/mine.json && test -e {SPOOL}/done/first.stl")
    said = _apt(machine, "purge", "contourd")
    assert f"{SPOOL} is kept" in said, said
    machine.run(f"test -e {SPOOL}/done/first.stl && cmp /root/tall.stl {SPOOL}/done/second.stl")
    kept = r"^(/proc|/sys|/root|/install|/var/log|/var/cache|/var/spool/contourd|/run/systemd/transient)(/|$)"
    left = machine.run(f"find / -xdev -iname '*contour*' | grep -vE '{kept}'", check=False)
    assert left == "", f"files were left: {left}"
    machine.run("! systemctl cat contourd && test -z \"$(systemctl list-units --failed --no-legend)\"")


def _run(debian=None):
    guest = guests.package_guest(_UPGRADES, debian)
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(0.05)))
    guest.add_bytes("/install/root/tall.stl", models.binary_stl(models.twisted_star(0.05 * _LAYERS)))
    slow = {**guests.QUICK_RESIN, "exposure_ms": 8000, "bottom_exposure_ms": 8000}
    guest.add_text("/install/root/quick.json", guests.resin_profile(slow))
    with guests.written(guest) as initramfs, disk_over(root_image(debian)) as disk:
        with booted(initramfs, disk) as machine:
            _is_installed_and_prints(machine)
            _is_upgraded_while_idle(machine)
            _is_upgraded_in_a_print(machine)
            _keeps_running_with_a_wrong_configuration(machine)
            _is_not_started_for_one_who_stopped_it(machine)
            _is_removed_and_purged(machine)
            machine.power_off()


@vm_test("full")
def package():
    """The package is installed by apt and prints without an edit; it is upgraded while idle with a queue and an edited
    configuration, in a print, with a wrong configuration, and while stopped; removing and purging it keeps the parts."""
    _run()


@vm_test("full", other_debian=True)
def package_on_the_other_debian():
    """The package for the other Debian release passes the same test there: trixie if this is bookworm."""
    _run(other_debian())
