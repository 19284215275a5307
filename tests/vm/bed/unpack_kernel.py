"""Takes the ELF file out of an amd64 bzImage: unpack_kernel.py VMLINUZ VMLINUX (Documentation/arch/x86/boot.rst)."""

import struct
import subprocess
import sys


def unpack(image):
    setup_sectors = image[0x1F1]
    offset, length = struct.unpack_from("<II", image, 0x248)  # payload_offset, payload_length
    payload = image[(setup_sectors + 1) * 512 + offset :][:length]
    zstd = payload[:4] == b"\x28\xb5\x2f\xfd"
    command = ["zstd", "-dc"] if zstd else ["xz", "-dc", "--single-stream"]
    # The kernel's length follows the payload, which the programs take for rubbish at the end.
    return subprocess.run(command, input=payload, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout


if __name__ == "__main__":
    source, target = sys.argv[1:]
    with open(source, "rb") as file:
        kernel = unpack(file.read())
    if kernel[:4] != b"\x7fELF":
        sys.exit(f"{source}: no kernel could be unpacked")
    with open(target, "wb") as file:
        file.write(kernel)
