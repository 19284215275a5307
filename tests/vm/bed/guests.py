"""The guests that the tests boot: the content of their initial file systems."""

import json
import os
import re
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

from bed import models
from bed.architecture import AMD64, BED, SOURCE, VM, host_debian
from bed.edge_log import Lines
from bed.initramfs import Initramfs

LINES = Lines()
_SCREEN_MODULES = ("drm_kms_helper", "drm_shmem_helper")
_VIRTIO_MODULES = ("virtio_pci", "virtio_blk", "virtio_console")


def printer_guest(arch, config, model_height_mm=0.2, resin=None, model=models.twisted_star):
    """Returns a guest with contourd, its configuration, a model of that height and our devices' modules."""
    guest = Initramfs(arch)
    guest.add_kernel_modules(*_SCREEN_MODULES, *_VIRTIO_MODULES)
    guest.add_our_modules()
    for program in ("contourd", "contourctl", "fake-projector", "take-master"):
        guest.add_program(program)
    guest.add_text("/etc/contourd/contourd.json", json.dumps(config, indent=1))
    guest.add_folder("/etc/contourd/projectors", SOURCE / "config" / "projectors")
    guest.add_text("/etc/contourd/resins/standard.json", resin_profile(resin))
    guest.add_bytes("/model.stl", models.binary_stl(model(model_height_mm)))
    guest.add_file("/lib.sh", VM / "guest" / "lib.sh")
    return guest


@contextmanager
def _installed(debian):
    """Gives the folder in which contourd is installed, as built for that Debian or for this one."""
    if debian and debian != host_debian():
        yield BED / f"contourd-{debian}"
        return
    with tempfile.TemporaryDirectory(dir=BED) as folder:
        environment = {**os.environ, "DESTDIR": folder}
        command = ["cmake", "--install", str(SOURCE / "build"), "--prefix", "/usr"]
        subprocess.run(command, check=True, capture_output=True, env=environment)
        yield folder


def _debian_guest(our_modules=()):
    """Returns the initial file system for a guest with a root image. `our_modules` are lines such as "zplant
    bounce_us=300"."""
    guest = Initramfs(AMD64)
    guest.add_kernel_modules("crc32c_generic", "ext4", *_SCREEN_MODULES, *_VIRTIO_MODULES)
    guest.add_our_modules()
    loads = [line.split(" ", 1) for line in our_modules]
    guest.add_text("/etc/our_modules", "".join(f"{name}.ko {' '.join(parameters)}\n" for name, *parameters in loads))
    guest.add_file("/init", VM / "guest" / "init-root", mode=0o755)
    return guest


def systemd_guest(config, resin=None, our_modules=(), debian=None):
    """Returns a Debian guest with contourd installed as by a package, and a printer's configuration."""
    guest = _debian_guest(our_modules)
    with _installed(debian) as folder:
        # /lib is a link to /usr/lib in the image.
        if Path(folder, "lib").exists():
            guest.add_folder("/install/usr/lib", Path(folder, "lib"))
        for part in ("etc", "usr"):
            guest.add_folder(f"/install/{part}", Path(folder, part))
    guest.add_text("/install/etc/contourd/contourd.json", json.dumps(config, indent=1))
    guest.add_text("/install/etc/contourd/resins/standard.json", resin_profile(resin))
    guest.add_file("/install/root/lib.sh", VM / "guest" / "lib.sh")
    guest.add_file("/install/usr/local/bin/fake-projector", AMD64.program("fake-projector"))
    return guest


def package_guest(upgrades, debian=None):
    """Returns a Debian guest without contourd. /root/contourd.deb and /root/contourd-web.deb are the packages of this tree
    for that Debian; /root/upgrade-1.deb and so on are contourd's package with increasing versions."""
    guest = _debian_guest()
    packages = BED / (f"packages-{debian}" if debian else "packages")
    (package,) = packages.glob("contourd_*_amd64.deb")
    (web_package,) = packages.glob("contourd-web_*_amd64.deb")
    guest.add_file("/install/root/contourd.deb", package)
    guest.add_file("/install/root/contourd-web.deb", web_package)
    with tempfile.TemporaryDirectory(dir=BED) as folder:
        subprocess.run(["dpkg-deb", "--raw-extract", package, f"{folder}/tree"], check=True)
        control = Path(folder, "tree/DEBIAN/control")
        text = control.read_text()
        for number in range(1, upgrades + 1):
            control.write_text(re.sub(r"(?m)^Version: .*", rf"\g<0>.{number}", text))
            command = ["dpkg-deb", "--root-owner-group", "--build", "-Zgzip", "-z1", f"{folder}/tree", f"{folder}/upgrade.deb"]
            subprocess.run(command, check=True, capture_output=True)
            guest.add_file(f"/install/root/upgrade-{number}.deb", Path(folder, "upgrade.deb"))
    return guest


def resin_profile(changes):
    """Returns the shipped profile's text with changes; None removes a key."""
    profile = json.loads((SOURCE / "config" / "resins" / "standard.json").read_text())
    profile.pop("$schema")
    profile.pop("viscosity_mpa_s")  # the first layer would wait a minute until the plate has pressed out the resin
    return json.dumps({key: value for key, value in {**profile, **(changes or {})}.items() if value is not None})


@contextmanager
def written(guest):
    """Writes the guest's initramfs to a file that exists as long as the context."""
    with tempfile.NamedTemporaryFile(prefix="initramfs.", dir=BED) as file:
        guest.write(Path(file.name))
        yield Path(file.name)


def simulated_config(**changes):
    config = json.loads((SOURCE / "config" / "contourd.json").read_text())
    config.pop("$schema")
    config["projector"]["warm_up_s"] = 1
    # A short axis, so that tests do not have to wait for homing and parking.
    config["z_axis"]["travel_mm"] = 10
    config["simulation"]["start_height_mm"] = 2.5
    config["wait_for_plate_cleared"] = False
    config["min_free_disk_mb"] = 0
    # No supports, since the pictures are compared with sections of the model alone.
    config["supports"] = "off"
    return {**config, **changes}


def _line(number, active_low=False):
    return {"chip": "zplant", "line": number, "active_low": active_low}


def real_config(**changes):
    """Returns the configuration of a printer with our devices: zplant's lines, zproj's output, zserial's port. `changes`
    maps sections to changed keys (None removes a key)."""
    config = simulated_config()
    config["hardware"] = "real"
    config["z_axis"] |= {
        "top_speed_mm_s": 10,
        "step": _line(LINES.step),
        "direction": _line(LINES.direction),
        "enable": _line(LINES.enable, active_low=True),
        "limit_switch": _line(LINES.limit, active_low=True),
        "emergency_stop": _line(EMERGENCY_STOP),
        "lid": _line(LID),
    }
    config["display"]["card"] = "zproj"
    config["projector"] |= {"port": "/dev/ttyZ0", "table": "acer", "light": _line(LINES.light)}
    for section, values in changes.items():
        config[section] |= values
        config[section] = {key: value for key, value in config[section].items() if value is not None}
    return config


# Lines of zplant without a fixed function; the encoder's lines are parameters of the module.
EMERGENCY_STOP, LID, ENCODER_A, ENCODER_B = 5, 6, 20, 21

# The answers to the acer table's commands; the lamp is off at first.
ACER = r"'* 0 IR 001\r=>*001\r' '* 0 IR 002\r=>*001\r' '* 0 Lamp ?\r=>Lamp 0\r' '* 0 Lamp ?\r=>Lamp 1\r'"

# A resin for short prints, whose layers have all parts of a normal layer.
QUICK_RESIN = {
    "exposure_ms": 1000,
    "bottom_exposure_ms": 2000,
    "bottom_layers": 1,
    "fade_layers": 0,
    "lift_mm": 0.6,
    "second_lift_mm": 0.4,
    "settle_ms": 200,
    "rest_ms": 100,
}
