"""The steps of contourd-usb@.service without systemd: a loop device in the place of a stick is mounted, and an unprivileged user
reads it."""

import hashlib
import os
import shutil
import stat
import subprocess
import tempfile

from harness import BAD_DATA, CONTOURCTL, FAILED, NO_INPUT, OK, SMALL, SOURCE, FolderTest, binary_stl, box, contents, skip_file

WITH_USB_STICK = os.path.join(SOURCE, "systemd", "with-usb-stick")
LARGE = binary_stl(box((0, 0, 0), (10, 5, 0.2)) * 5000)
USER, GROUP = 64123, 64124
# The users exist only in this mount namespace, not on the rest of the machine.
RUN = """
set -e
mount --bind "$0/passwd" /etc/passwd
mount --bind "$0/group" /etc/group
exec "$@"
"""


def loop_device(image):
    """Returns a new loop device, or None if none can be made, such as in a container."""
    made = subprocess.run(["losetup", "--find", "--show", image], capture_output=True, text=True, check=False)
    return made.stdout.strip() if made.returncode == 0 else None


def can_mount():
    if os.geteuid() != 0 or not all(shutil.which(program) for program in ("losetup", "mke2fs", "blkid", "setpriv", "unshare")):
        return False
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "image")
        subprocess.run(["mke2fs", "-q", "-t", "ext4", image, "4M"], check=True, capture_output=True)
        device = loop_device(image)
        if not device:
            return False
        mounted = subprocess.run(["unshare", "--mount", "mount", "-o", "ro", device, folder], capture_output=True, check=False)
        subprocess.run(["losetup", "--detach", device], check=True)
        return mounted.returncode == 0


class UsbStick(FolderTest):
    def setUp(self):
        super().setUp()
        os.chmod(self.folder, 0o755)
        for folder in ("files", "mounted", "spool", "spool/incoming", "spool/done", "spool/printing", "spool/failed", "record"):
            os.mkdir(self.path(folder))
        os.chown(self.path("spool", "incoming"), 0, GROUP)
        os.chmod(self.path("spool", "incoming"), 0o2775)
        os.chown(self.path("record"), USER, GROUP)
        self.write("passwd", f"root:x:0:0::/root:/bin/sh\ncontourd-usb:x:{USER}:{USER}::/:/usr/sbin/nologin\n")
        self.write("group", f"root:x:0:\ncontourd-usb:x:{USER}:\ncontourd:x:{GROUP}:\n")
        self.contourctl = self.reachable(CONTOURCTL)

    def put(self, name, data=SMALL):
        return self.write(os.path.join("files", name), data)

    def image(self):
        """Makes a file system with the files. Its superblock asks for a panic in case of errors, which contourd-usb must override."""
        image = self.path("image")
        subprocess.run(["mke2fs", "-q", "-t", "ext4", "-e", "panic", "-d", self.path("files"), image, "16M"], check=True,
                       capture_output=True)  # fmt: skip
        return image

    def device(self, image):
        device = loop_device(image)
        self.addCleanup(subprocess.run, ["losetup", "--detach", device], check=True)
        return device

    def offer(self, device, *before):
        """`before` is a command that executes its last arguments, which are contourctl's call."""
        command = ["unshare", "--mount", "sh", "-c", RUN, self.folder, WITH_USB_STICK, device, self.path("mounted"), *before,
                   self.contourctl, "offer", "--once", self.path("record", "taken"), "--spool", self.path("spool")]  # fmt: skip
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(os.listdir(self.path("mounted")), [])
        return result

    def incoming(self):
        return sorted(os.listdir(self.path("spool", "incoming")))

    def test_an_unprivileged_user_takes_models_once_and_the_stick_is_not_changed(self):
        self.put("part.stl")
        self.put("part.json", b'{"copies": 2}')
        image = self.image()
        before = hashlib.sha256(contents(image)).digest()
        device = self.device(image)
        result = self.offer(device)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (OK, "part.stl: job part\n", ""))
        status = os.stat(self.path("spool", "incoming", "part.stl"))
        self.assertEqual((status.st_uid, status.st_gid, stat.S_IMODE(status.st_mode) & 0o640), (USER, GROUP, 0o640))
        result = self.offer(device)
        self.assertEqual((result.returncode, result.stdout), (OK, "nothing to take; 1 were taken before\n"))
        self.assertEqual(self.incoming(), ["part.json", "part.stl"])
        self.assertEqual(hashlib.sha256(contents(image)).digest(), before)

    def test_the_same_file_on_another_stick_is_another_model(self):
        self.put("part.stl")
        for _ in range(2):
            result = self.offer(self.device(self.image()))
            self.assertEqual(result.returncode, OK, result)
            os.unlink(self.path("image"))
        self.assertEqual(self.incoming(), ["part-2.stl", "part.stl"])

    def test_links_devices_and_unreadable_files_are_reported(self):
        self.put("good.stl")
        os.chmod(self.put("secret.stl"), 0)
        os.symlink("/etc/shadow", self.path("files", "shadow.stl"))
        os.mkfifo(self.path("files", "fifo.stl"))
        os.mkdir(self.path("files", "closed"), 0)
        os.mknod(self.path("files", "device.stl"), 0o666 | stat.S_IFBLK, os.makedev(7, 0))
        result = self.offer(self.device(self.image()))
        self.assertEqual((result.returncode, result.stdout), (BAD_DATA, "good.stl: job good\n"))
        for name in ("secret", "shadow", "fifo", "device"):
            self.assertIn(f'contourctl: "{name}.stl" is not taken: ', result.stderr)
        self.assertIn("contourctl: folders that cannot be read: 1\n", result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 5)
        self.assertEqual(self.incoming(), ["good.stl"])

    def test_an_unreadable_stick_is_an_error(self):
        self.put("part.stl")
        image = self.image()
        subprocess.run(["debugfs", "-w", "-R", "set_inode_field / mode 040700", image], check=True, capture_output=True)
        result = self.offer(self.device(image))
        self.assertEqual((result.returncode, result.stdout), (NO_INPUT, ""), result)
        self.assertIn("Permission denied", result.stderr)

    def test_a_stick_that_is_removed_while_it_is_read_leaves_no_partial_model(self):
        self.put("large.stl", LARGE)
        image = self.image()
        middle = contents(image).index(LARGE[: 1 << 16]) + len(LARGE) // 2
        os.chmod(image, 0o666)
        # The device keeps its length, but the end of the file cannot be read once the device is mounted.
        result = self.offer(self.device(image), "sh", "-c", f'truncate --size={middle // 4096 * 4096} {image} && exec "$@"', "sh")
        self.assertEqual((result.returncode, result.stdout), (BAD_DATA, ""), result)
        self.assertIn('"large.stl" is not taken: Input/output error', result.stderr)
        self.assertEqual(os.listdir(self.path("spool", "incoming")), [])
        # The model is not recorded as taken.
        self.assertFalse(os.path.exists(self.path("record", "taken")))

    def test_a_broken_unknown_or_mounted_stick_is_left_alone(self):
        self.put("part.stl")
        image = self.image()
        with open(image, "r+b") as file:
            file.seek(4096)
            file.write(b"\xff" * (1 << 20))
        result = self.offer(self.device(image))
        self.assertEqual(result.returncode, FAILED, result)
        self.assertIn("cannot be read: its file system (ext4) is broken", result.stderr)
        result = self.offer(self.device(self.write("nothing", b"\0" * (1 << 20))))
        self.assertEqual(result.returncode, FAILED, result)
        self.assertIn("contourd reads sticks with FAT, exFAT or ext4; this one has an unknown file system", result.stderr)
        used = self.device(self.image())
        os.mkdir(self.path("used"))
        subprocess.run(["mount", "-o", "ro", used, self.path("used")], check=True)
        self.addCleanup(subprocess.run, ["umount", self.path("used")], check=True)
        result = self.offer(used)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (OK, f"{used} is mounted already and is ignored\n", ""))
        self.assertEqual(self.incoming(), [])


if not can_mount():
    skip_file("no loop device can be mounted here")
