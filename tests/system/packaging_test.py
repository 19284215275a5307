"""What holds the four Debian packages together, and what they let systemd do."""
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


class UnitsTest(unittest.TestCase):
    @unittest.skipUnless(shutil.which("systemd-analyze"), "there is no systemd-analyze")
    def test_systemd_finds_little_open(self):
        folder = os.path.join(SOURCE, "systemd")
        for unit in ("contourd.service", "contourd-job-ended@.service"):
            command = ["systemd-analyze", "security", "--no-pager", "--offline=true", "--threshold=15", os.path.join(folder, unit)]
            # Its own folder first, so that the unit's drop-ins are found.
            looked = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "SYSTEMD_UNIT_PATH": folder})
            self.assertEqual(looked.returncode, 0, looked.stdout + looked.stderr)

    def test_needrestart_leaves_contourd_alone(self):
        """By the file that the package puts into its configuration; read in Perl, as needrestart does."""
        program = r"""our %nrconf = (override_rc => {}); do shift; die $@ if $@;
            for my $unit (@ARGV) {
              my @told = map { $nrconf{override_rc}{$_} } grep { $unit =~ /$_/ } keys %{$nrconf{override_rc}};
              print "$unit=@told\n";
            }"""
        units = ("contourd.service", "contourd-job-ended@1-2.service", "contourd-other.service", "a-contourd.service")
        read = subprocess.run(["perl", "-e", program, os.path.join(PACKAGING, "debian/contourd.needrestart"), *units],
                              capture_output=True, text=True, check=True)  # fmt: skip
        self.assertEqual(read.stdout.splitlines(), ["contourd.service=0", "contourd-job-ended@1-2.service=0",
                                                    "contourd-other.service=", "a-contourd.service="])  # fmt: skip


if __name__ == "__main__":
    main()
