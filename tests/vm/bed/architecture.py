"""The differences between amd64 and arm64 guests, and the bed's folders for each."""

import os
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
BED = Path(os.environ.get("CONTOURD_VM", SOURCE / "build" / "vm"))
VM = SOURCE / "tests" / "vm"


def host_debian():
    """Returns the name of this machine's Debian release, such as "bookworm"."""
    release = dict(line.split("=", 1) for line in Path("/etc/os-release").read_text().splitlines() if "=" in line)
    return release["VERSION_CODENAME"]


def other_debian():
    return "bookworm" if host_debian() == "trixie" else "trixie"


def root_image(debian=None):
    return BED / f"root-{debian or host_debian()}.ext4"


@dataclass(frozen=True)
class Architecture:
    name: str
    qemu: str
    machine: str
    cpu: str
    console: str
    loader: str  # the path at which programs expect the dynamic linker
    libraries: tuple  # folders

    @property
    def kernel_folder(self):
        return BED / f"kernel-{self.name}"

    @property
    def kernel_version(self):
        return (self.kernel_folder / "version").read_text().strip()

    @property
    def kernel(self):
        unpacked = self.kernel_folder / "vmlinux"
        return unpacked if unpacked.exists() else self.kernel_folder / "boot" / f"vmlinuz-{self.kernel_version}"

    @property
    def kernel_modules(self):
        return self.kernel_folder / "lib" / "modules" / self.kernel_version

    @property
    def our_modules(self):
        return BED / f"modules-{self.name}"

    def program(self, name):
        """Returns the path of a program of contourd's or of the guest's own."""
        own = BED / f"programs-{self.name}" / name
        contourd = SOURCE / "build" if self.name == "amd64" else BED / "contourd-arm64"
        return own if own.exists() else contourd / "bin" / name


AMD64 = Architecture(
    name="amd64",
    qemu="qemu-system-x86_64",
    machine="q35",
    # These instructions give random numbers of the host, so that no two runs would be identical.
    cpu="max,-rdrand,-rdseed",
    console="ttyS0",
    loader="/lib64/ld-linux-x86-64.so.2",
    libraries=("/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu"),
)

ARM64 = Architecture(
    name="arm64",
    qemu="qemu-system-aarch64",
    machine="virt",
    cpu="cortex-a53",
    console="ttyAMA0",
    loader="/lib/ld-linux-aarch64.so.1",
    libraries=("/lib/aarch64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/aarch64-linux-gnu/lib"),
)

ALL = {arch.name: arch for arch in (AMD64, ARM64)}
