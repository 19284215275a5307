"""Builds a guest's initial file system: busybox, kernel modules in the order in which they are loaded, and programs with
the libraries that they need. The result is a cpio archive (newc), see the kernel's
Documentation/driver-api/early-userspace."""

import gzip
import lzma
import os
import re
import stat
import subprocess
from pathlib import Path

from bed.architecture import VM


def _module_name(path):
    return re.sub(r"\.ko.*", "", os.path.basename(path)).replace("-", "_")


class Initramfs:
    def __init__(self, arch):
        self._arch = arch
        self._files = {}  # path without its leading slash: (mode, bytes)
        self._loaded_modules = []
        self._libraries = set()
        self.add_file("/bin/busybox", arch.kernel_folder / "bin" / "busybox", mode=0o755)

    def add_bytes(self, path, data, mode=0o644):
        self._files[path.lstrip("/")] = (mode, data)

    def add_text(self, path, text, mode=0o644):
        self.add_bytes(path, text.encode(), mode)

    def add_file(self, path, source, mode=None):
        source = Path(source)
        self.add_bytes(path, source.read_bytes(), source.stat().st_mode & 0o777 if mode is None else mode)

    def add_folder(self, path, source):
        for file in sorted(Path(source).rglob("*")):
            if file.is_file():
                self.add_file(f"{path}/{file.relative_to(source)}", file)

    def add_program(self, name, path=None):
        source = self._arch.program(name)
        self.add_file(path or f"/bin/{name}", source, mode=0o755)
        self._add_libraries(source)

    def _add_libraries(self, program):
        listed = subprocess.run(["readelf", "-d", program], capture_output=True, text=True, check=True).stdout
        for name in re.findall(r"NEEDED.*\[(.*)\]", listed):
            if name in self._libraries:
                continue
            self._libraries.add(name)
            found = [Path(folder, name) for folder in self._arch.libraries if Path(folder, name).exists()]
            if not found:
                raise FileNotFoundError(f"{program} needs {name}, which is not installed for {self._arch.name}")
            self.add_file(self._arch.loader if name == Path(self._arch.loader).name else f"/lib/{name}", found[0], 0o755)
            self._add_libraries(found[0])

    def add_kernel_modules(self, *names):
        """Adds modules of the kernel with their dependencies; the guest's init loads them."""
        folder = self._arch.kernel_modules
        needs, paths = {}, {}
        for line in (folder / "modules.dep").read_text().splitlines():
            path, needed = line.split(":")
            needs[path] = needed.split()
            paths[_module_name(path)] = path
        builtin = {_module_name(line) for line in (folder / "modules.builtin").read_text().splitlines()}
        for name in names:
            if name in builtin:
                continue
            for path in [*reversed(needs[paths[name]]), paths[name]]:
                self._add_kernel_module(folder / path)

    def _add_kernel_module(self, path):
        name = re.sub(r"\.(xz|zst)$", "", path.name)
        if name in self._loaded_modules:
            return
        data = path.read_bytes()
        if path.suffix == ".xz":
            data = lzma.decompress(data)
        elif path.suffix == ".zst":
            data = subprocess.run(["zstd", "-dc", path], capture_output=True, check=True).stdout
        self.add_bytes(f"/mod/{name}", data)
        self._loaded_modules.append(name)

    def add_our_modules(self):
        """Adds zplant, zproj and zserial in /mod; the guest loads them when needed, with their parameters."""
        for module in sorted(self._arch.our_modules.glob("*.ko")):
            self.add_file(f"/mod/{module.name}", module)

    def write(self, path):
        self.add_text("/etc/modules", "".join(f"{name}\n" for name in self._loaded_modules))
        if "init" not in self._files:
            self.add_file("/init", VM / "guest" / "init", mode=0o755)
        archive = _CpioArchive()
        for folder in sorted(self._folders()):
            archive.add(folder, stat.S_IFDIR | 0o755)
        archive.add("dev/console", stat.S_IFCHR | 0o600, device=(5, 1))
        for name, (mode, data) in self._files.items():
            archive.add(name, stat.S_IFREG | mode, data)
        Path(path).write_bytes(gzip.compress(archive.end(), 1, mtime=0))

    def _folders(self):
        folders = {"proc", "sys", "dev", "tmp", "mnt", "run", "sbin", "root", "out", "var"}
        for name in self._files:
            folders.update(str(parent) for parent in Path(name).parents if str(parent) != ".")
        return folders


class _CpioArchive:
    def __init__(self):
        self._bytes = bytearray()
        self._inode = 0

    def add(self, name, mode, data=b"", device=(0, 0)):
        self._inode += 1
        path = name.encode() + b"\0"
        fields = (self._inode, mode, 0, 0, 1, 0, len(data), 0, 0, *device, len(path), 0)
        self._append(b"070701" + "".join(f"{field:08X}" for field in fields).encode() + path)
        self._append(data)

    def _append(self, data):
        self._bytes += data + b"\0" * (-len(data) % 4)

    def end(self):
        self.add("TRAILER!!!", 0)
        return bytes(self._bytes)
