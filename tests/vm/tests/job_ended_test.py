"""The units for jobs that have ended: systemd runs the user's command for each; and the metrics file outside the
sandbox."""

import re

from bed import guests, models
from bed.architecture import root_image
from bed.qemu import disk_over
from bed.registry import vm_test
from bed.service import SPOOL, booted, install, submit

_SAID = "journalctl -t contourd-job-ended -o cat --no-pager"
_COMMAND = """#!/bin/sh
echo "$(id -u) hears of $CONTOURD_JOB: $CONTOURD_OUTCOME, $CONTOURD_REASON, $(test -r "$CONTOURD_REPORT_HTML" && echo report)"
touch /var/spool/contourd/incoming/evil.stl && echo "and wrote into the spool"
case $CONTOURD_JOB in hangs*) exec sleep 1000000 ;; esac
"""
_METRICS = "/run/contourd-metrics/contourd.prom"


def _guest():
    guest = guests.systemd_guest(guests.simulated_config(metrics_file=_METRICS), resin=guests.QUICK_RESIN)
    guest.add_bytes("/install/root/part.stl", models.binary_stl(models.twisted_star(0.1)))
    guest.add_text("/install/root/job-ended", _COMMAND)
    return guest


def _submit_nonsense(machine, name):
    machine.run(f"echo nonsense >{SPOOL}/.bad && mv {SPOOL}/.bad '{SPOOL}/incoming/{name}.stl'")
    machine.wait_for(f"test -e '{SPOOL}/failed/{name}.stl'")


def _is_silent_as_installed(machine):
    submit(machine, "silent")
    machine.wait_for(f"test -e {SPOOL}/done/silent.stl", limit_s=120)
    machine.run("test ! -e /run/contourd-job-ended.socket")
    assert machine.run("systemctl is-enabled contourd-job-ended.socket", check=False) == "disabled"


def _tells(machine):
    machine.run("install -m 755 /root/job-ended /etc/contourd/job-ended && systemctl enable --now contourd-job-ended.socket")
    submit(machine, "part")
    machine.wait_for(f"{_SAID} | grep -q 'hears of part: done'", limit_s=120)
    _submit_nonsense(machine, "$(reboot) --x")
    machine.wait_for(f"{_SAID} | grep -qF 'hears of $(reboot) --x: failed'")
    said = machine.run(_SAID)
    user = re.search(r"(?m)^(\d+) hears of part: done, , report$", said)
    assert user and user[1] not in ("0", machine.run("id -u contourd")), said
    assert "wrote into the spool" not in said and "silent" not in said, said
    # Only the daemon's user can connect.
    machine.run("setpriv --reuid nobody --regid contourd --clear-groups sh -c 'test ! -w /run/contourd-job-ended.socket'")


def _ends_one_that_hangs(machine):
    machine.run("mkdir -p /etc/systemd/system/contourd-job-ended@.service.d")
    machine.run("printf '[Service]\\nTimeoutStartSec=20\\n' >/etc/systemd/system/contourd-job-ended@.service.d/short.conf")
    machine.run("systemctl daemon-reload")
    for number in range(6):
        _submit_nonsense(machine, f"hangs{number}")
    submit(machine, "meanwhile")
    machine.wait_for(f"test -e {SPOOL}/done/meanwhile.stl", limit_s=120)
    machine.wait_for(f"{_SAID} | grep -q 'hears of meanwhile: done'", limit_s=200)
    said = machine.run(_SAID)
    assert all(f"hears of hangs{number}: failed" in said for number in range(6)), said
    # No instance remains, neither as a process nor as a failed unit.
    machine.wait_for("test -z \"$(systemctl list-units --all --no-legend 'contourd-job-ended@*')\"", limit_s=120)
    machine.run("systemctl is-active contourd contourd-job-ended.socket")


def _tells_of_a_stop(machine):
    submit(machine, "stopped")
    machine.wait_for("contourctl status --json | grep -q '\"layer\"'", limit_s=60)
    machine.run("systemctl stop contourd")
    machine.wait_for(f"{_SAID} | grep -q 'hears of stopped: failed'")
    machine.run("systemctl start contourd && contourctl resume")


def _lets_out_who_is_to_write(machine):
    """Sets another user and removes the sandbox, as docs/connections.md describes in "After a job"."""
    folder = "/etc/systemd/system/contourd-job-ended@.service.d"
    machine.run("install -d -o games /var/tmp/told && printf '#!/bin/sh\\ntouch /var/tmp/told/wrote\\n' >/etc/contourd/job-ended")
    machine.run(f"printf '[Service]\\nDynamicUser=no\\nUser=games\\n' >{folder}/override.conf && systemctl daemon-reload")
    _submit_nonsense(machine, "within")
    machine.wait_for(f"{_SAID} | grep -q 'touch: .*wrote'")
    machine.run(f"ln -s /dev/null {folder}/sandbox.conf && systemctl daemon-reload")
    _submit_nonsense(machine, "let-out")
    machine.wait_for("test $(stat -c %U /var/tmp/told/wrote) = games")


def _gives_figures(machine):
    machine.wait_for(f"setpriv --reuid nobody --regid nogroup --clear-groups grep -q '^# EOF$' {_METRICS}")
    machine.run("systemctl stop contourd")
    machine.run(f"test ! -e {_METRICS}")
    machine.run("systemctl start contourd")


@vm_test("full")
def job_ended():
    """Once the socket is enabled, the user's command runs for each job that has ended, as a separate user, whatever the
    job's name; commands that hang are killed and delay no print; a command that needs to write can run without the
    sandbox; without the socket no command is started. The metrics file is readable by all users, and is removed with the
    daemon."""
    with guests.written(_guest()) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            install(machine)
            _gives_figures(machine)
            _is_silent_as_installed(machine)
            _tells(machine)
            _ends_one_that_hangs(machine)
            _tells_of_a_stop(machine)
            _lets_out_who_is_to_write(machine)
            machine.run("systemctl disable --now contourd-job-ended.socket && test ! -e /run/contourd-job-ended.socket")
            machine.power_off()
