"""contourd-web as a service of a real Debian system: its package, its units and its sandbox."""

import base64
import re

from bed import guests, models
from bed.architecture import root_image
from bed.qemu import disk_over
from bed.registry import vm_test
from bed.service import SPOOL, booted

_PASSWORD = "correct horse"
_LAYERS = 4


def _http(machine, method, path, body=b"", **headers):
    """Sends a request from within the machine. Returns the status and the body of the reply; status 0 if no service listens."""
    lines = [f"{method} {path} HTTP/1.1", "Host: 127.0.0.1:8080", "Connection: close", f"Content-Length: {len(body)}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    request = "\r\n".join(lines).encode() + b"\r\n\r\n" + body
    machine.run(": >/run/request")
    encoded = base64.b64encode(request).decode()
    for begin in range(0, len(encoded), 3000):  # a terminal's line has at most 4,095 characters
        machine.run(f"echo {encoded[begin : begin + 3000]} >>/run/request")
    reply = machine.run("bash -c 'exec 3<>/dev/tcp/127.0.0.1/8080 && base64 -d /run/request >&3 && base64 -w 0 <&3' 2>/dev/null", check=False)
    if not reply:
        return 0, b""
    head, _, rest = base64.b64decode(reply.splitlines()[-1]).partition(b"\r\n\r\n")
    return int(head.split()[1]), rest


def _form(name, model):
    """Returns the body of a form with a file, and its headers."""
    body = f'--edge\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n'.encode() + model + b"\r\n--edge--\r\n"
    return {"body": body, "Content_Type": "multipart/form-data; boundary=edge"}


def _is_off_after_the_installation(machine):
    machine.run("DEBIAN_FRONTEND=noninteractive apt-get -y -q install /root/contourd.deb /root/contourd-web.deb </dev/null 2>&1", limit_s=900)
    assert _http(machine, "GET", "/") == (0, b""), "the page answers before a password is set"
    machine.run("! systemctl is-active contourd-web.socket && ! systemctl is-active contourd-web.service")


def _is_switched_on_as_the_command_says(machine):
    """Sets the password and gives the commands that are printed. Returns the key for slicers."""
    said = machine.run(f"echo '{_PASSWORD}' | contourctl web password 2>&1")
    commands = re.findall(r"(?m)^ +(systemctl .*)$", said)
    assert len(commands) == 3, said
    for command in commands:
        machine.run(command)
    machine.run("stat -c '%U:%G %a' /etc/contourd/web-password | grep -qx 'root:root 600'")
    return re.search(r"\b[0-9a-f]{32}\b", said)[0]


def _serves_the_page_from_its_sandbox(machine, key):
    machine.run("! systemctl is-active contourd-web.service")
    status, page = _http(machine, "GET", "/")
    assert status == 200 and b"<title>" in page, (status, page)
    machine.run("systemctl is-active contourd-web.service")  # the socket has started it
    assert _http(machine, "GET", "/api/status")[0] == 401
    assert _http(machine, "GET", "/api/version", X_Api_Key="0" * 32)[0] == 401
    assert _http(machine, "GET", "/api/version", X_Api_Key=key)[0] == 200
    process = machine.run("systemctl show -P MainPID contourd-web")
    assert machine.run(f"stat -c %U /proc/{process}") == "contourd-web"
    machine.run(f"test $(readlink /proc/{process}/ns/net) != $(readlink /proc/1/ns/net)")
    machine.run(f"test -e /dev/vda && ! nsenter -t {process} -m test -e /dev/vda")
    machine.run("systemd-analyze security --no-pager --threshold=15 contourd-web.service >/run/security || { cat /run/security; false; }")


# A broker that accepts a client and notes its messages.
_BROKER = r"""use IO::Socket::INET;
my $listener = IO::Socket::INET->new(LocalAddr => "127.0.0.1", LocalPort => 1883, Listen => 5, ReuseAddr => 1) or die;
while (my $client = $listener->accept) {
  $client->sysread(my $data, 4096);
  $client->syswrite("\x20\x02\0\0");
  open(my $notes, ">>", "/run/messages");
  syswrite($notes, $data) while $client->sysread($data, 65536);
}
"""


def _reports_to_a_broker(machine):
    """Sets a broker, which the service can then reach by its name from its sandbox; checks that the settings are root's."""
    machine.run("echo 127.0.0.1 broker.lan >>/etc/hosts")
    machine.run("systemd-run --quiet --unit=broker perl /root/broker.pl")
    said = machine.run("contourctl web mqtt broker.lan 2>&1")
    commands = re.findall(r"(?m)^ +(systemctl .*)$", said)
    assert len(commands) == 3, said
    for command in commands:
        machine.run(command)
    machine.run("stat -c '%U:%G %a' /etc/contourd/web-mqtt | grep -qx 'root:root 600'")
    machine.wait_for("grep -aq homeassistant/device/contourd_ /run/messages && grep -aq '\"state\":\"idle\"' /run/messages || "
                     "{ journalctl -b -u broker -u contourd-web --no-pager | tail -8; false; }")
    machine.run("journalctl -u contourd-web --no-pager | grep -q 'connected to the MQTT broker broker.lan:1883'")
    process = machine.run("systemctl show -P MainPID contourd-web")
    assert machine.run(f"stat -c %U /proc/{process}") == "contourd-web"
    machine.run(f"test $(readlink /proc/{process}/ns/net) = $(readlink /proc/1/ns/net)")
    machine.run("systemd-analyze security --no-pager --threshold=20 contourd-web.service >/run/security || { cat /run/security; false; }")


def _reports_from_the_start_until_it_is_off(machine):
    """Checks that the service starts with the machine if it has a broker, and has no network again when it has none."""
    machine.wait_for("systemctl is-active contourd-web.service")
    machine.wait_for("journalctl -b -u contourd-web --no-pager | grep -q 'cannot connect to the MQTT broker broker.lan:1883: Connection refused'")
    for command in re.findall(r"(?m)^ +(systemctl .*)$", machine.run("contourctl web mqtt --off 2>&1")):
        machine.run(command)
    machine.run("test ! -e /etc/contourd/web-mqtt && ! systemctl is-enabled contourd-web.service")
    process = machine.run("systemctl show -P MainPID contourd-web")
    machine.run(f"test $(readlink /proc/{process}/ns/net) != $(readlink /proc/1/ns/net)")


def _prints_an_upload(machine, key, model):
    status, reply = _http(machine, "POST", "/api/files/local", **_form("sent.stl", model), X_Api_Key=key)
    assert status == 201, (status, reply)
    machine.wait_for(f"test -e {SPOOL}/done/sent.stl", limit_s=400, pause_s=1)
    assert base64.b64decode(machine.run(f"base64 -w 0 {SPOOL}/done/sent.stl")) == model


def _can_be_killed_in_a_print(machine, key, model):
    machine.run("contourctl plate-cleared && cp /root/slow.json /etc/contourd/resins/standard.json")
    assert _http(machine, "POST", "/api/files/local", **_form("second.stl", model), X_Api_Key=key)[0] == 201
    machine.wait_for("contourctl status --json | grep -q '\"layer\"'", limit_s=120)
    before = machine.run("systemctl show -P MainPID contourd-web")
    machine.run(f"kill -KILL {before}")
    machine.wait_for(f"test $(systemctl show -P MainPID contourd-web) -gt 0 && test $(systemctl show -P MainPID contourd-web) != {before}")
    assert _http(machine, "GET", "/api/version", X_Api_Key=key)[0] == 200
    machine.wait_for(f"test -e {SPOOL}/done/second.stl", limit_s=200)


def _reports_a_wrong_configuration(machine, key):
    """Checks that a service with a wrong configuration ends with a sentence and is not restarted for ever."""
    machine.run("echo '{\"sesion_hours\": 1}' >/etc/contourd/web.json && systemctl stop contourd-web.service")
    _http(machine, "GET", "/")
    machine.wait_for("systemctl show -P ExecMainStatus contourd-web | grep -qx 78")
    assert "session_hours" in machine.run("journalctl -u contourd-web --no-pager | tail -20")
    machine.run("rm /etc/contourd/web.json; systemctl reset-failed; systemctl restart contourd-web.socket")
    assert _http(machine, "GET", "/api/version", X_Api_Key=key)[0] == 200


def _is_on_after_a_restart(machine, key):
    machine.run("systemctl is-enabled contourd-web.socket && systemctl is-active contourd-web.socket")
    assert _http(machine, "GET", "/api/version", X_Api_Key=key)[0] == 200


def _is_removed_and_purged(machine):
    machine.run("DEBIAN_FRONTEND=noninteractive apt-get -y -q purge contourd-web </dev/null 2>&1", limit_s=300)
    assert _http(machine, "GET", "/") == (0, b"")
    machine.run("test ! -e /etc/contourd/web-mqtt && test ! -e /etc/systemd/system/contourd-web.service.d")
    machine.run("test ! -e /etc/contourd/web-password && test ! -e /usr/bin/contourd-web && systemctl is-active contourd")
    machine.run("test -z \"$(systemctl list-units --failed --no-legend)\"")


@vm_test("full")
def web():
    """contourd-web is installed by apt and off; with a password it serves the page from a sandbox without network and
    devices, prints an upload, is started again when it is killed, ends with a sentence for a wrong setting, is on after a
    restart of the machine, and leaves nothing behind."""
    guest = guests.package_guest(0)
    model = models.binary_stl(models.twisted_star(0.05 * _LAYERS))
    guest.add_text("/install/root/slow.json", guests.resin_profile({**guests.QUICK_RESIN, "exposure_ms": 4000, "bottom_exposure_ms": 4000}))
    with guests.written(guest) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            _is_off_after_the_installation(machine)
            key = _is_switched_on_as_the_command_says(machine)
            _serves_the_page_from_its_sandbox(machine, key)
            _prints_an_upload(machine, key, model)
            _can_be_killed_in_a_print(machine, key, model)
            _reports_a_wrong_configuration(machine, key)
            machine.power_off()
        with booted(initramfs, disk) as machine:
            machine.wait_for("systemctl is-active contourd")
            _is_on_after_a_restart(machine, key)
            _is_removed_and_purged(machine)
            machine.power_off()


@vm_test("full")
def web_mqtt():
    """contourd-web reaches an MQTT broker by its name from its sandbox, from the start of the machine on, opens no port, and has
    no network again when it has no broker."""
    guest = guests.package_guest(0)
    guest.add_text("/install/root/broker.pl", _BROKER)
    with guests.written(guest) as initramfs, disk_over(root_image()) as disk:
        with booted(initramfs, disk) as machine:
            _is_off_after_the_installation(machine)
            _is_switched_on_as_the_command_says(machine)
            _reports_to_a_broker(machine)
            machine.power_off()
        with booted(initramfs, disk) as machine:
            _reports_from_the_start_until_it_is_off(machine)
            _is_removed_and_purged(machine)
            machine.power_off()
