"""What holds the four Debian packages together."""
import os
import pathlib
import shutil
import subprocess
import unittest

from harness import SOURCE, FolderTest, main

PACKAGING = os.path.join(SOURCE, "packaging")


@unittest.skipUnless(shutil.which("dpkg-deb"), "there is no dpkg-deb")
class AlikeTest(FolderTest):
    def package(self, name, files):
        """A package with these files: path to mode."""
        tree = pathlib.Path(self.path(name))
        for path, mode in files.items():
            file = tree / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(name, encoding="utf-8")
            file.chmod(mode)
        (tree / "DEBIAN").mkdir()
        (tree / "DEBIAN/control").write_text(f"Package: p\nVersion: 1\nArchitecture: {name}\nMaintainer: m\nDescription: d\n", encoding="utf-8")
        deb = self.path(f"{name}.deb")
        subprocess.run(["dpkg-deb", "--root-owner-group", "--build", tree, deb], check=True, capture_output=True)
        return deb

    def told(self, *packages):
        compared = subprocess.run([os.path.join(PACKAGING, "alike"), *packages], capture_output=True, text=True, check=False)
        return compared.returncode, compared.stdout + compared.stderr

    def test_the_same_files_are_alike_wherever_units_are(self):
        first = self.package("amd64", {"usr/bin/p": 0o755, "lib/systemd/system/p.service": 0o644})
        second = self.package("arm64", {"usr/bin/p": 0o755, "usr/lib/systemd/system/p.service": 0o644})
        self.assertEqual(self.told(first, second), (0, ""))

    def test_a_file_that_one_lacks_or_whose_rights_differ_is_named(self):
        first = self.package("amd64", {"usr/bin/p": 0o755, "usr/share/p/a b": 0o644})
        without = self.package("arm64", {"usr/bin/p": 0o755})
        status, told = self.told(first, first, without)
        self.assertEqual(status, 1)
        self.assertIn("./usr/share/p/a b", told)
        other_rights = self.package("armhf", {"usr/bin/p": 0o700, "usr/share/p/a b": 0o644})
        status, told = self.told(first, other_rights)
        self.assertEqual(status, 1)
        self.assertIn("-rwx------ root/root ./usr/bin/p", told)


if __name__ == "__main__":
    main()
