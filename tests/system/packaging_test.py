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


class UpgradeTest(FolderTest):
    """What the package's postinst does with a contourd that runs or not, by programs that note how they are called. With the real
    ones: tests/vm, package."""

    def upgraded(self, configuration_is_good, runs, from_version="0.1.0"):
        """What it said, and the calls that change something."""
        calls = self.path("calls")
        with open(calls, "w", encoding="utf-8"):
            pass
        for name in ("systemctl", "deb-systemd-invoke", "udevadm", "contourd"):
            answer = {"systemctl": f'case "$*" in *is-active*) exit {0 if runs else 3} ;; esac',
                      "contourd": "" if configuration_is_good else "echo 'contourd.json: line 1: it is no JSON' >&2; exit 78"}.get(name, "")  # fmt: skip
            program = self.write(name, f'#!/bin/sh\necho "{name} $*" >>{calls}\n{answer}\n'.encode())
            os.chmod(program, 0o755)
        with open(os.path.join(PACKAGING, "debian/contourd.postinst"), encoding="utf-8") as file:
            function = file.read().split("start_or_reload() {")[1].split("\n}\n")[0]
        script = f'set -e\nstart_or_reload() {{{function}\n}}\nstart_or_reload "$1"\n'
        told = subprocess.run(["sh", "-c", script, "postinst", from_version], capture_output=True, text=True, check=True,
                              env={"PATH": f"{self.folder}:/usr/bin:/bin"})  # fmt: skip
        with open(calls, encoding="utf-8") as file:
            does = [line.strip() for line in file if any(word in line for word in (" reload contourd", " start ", "restart"))]
        return told.stderr, does

    def test_with_a_wrong_configuration_the_old_contourd_runs_on_and_none_is_started(self):
        for runs in (True, False):
            for from_version in ("0.1.0", ""):
                with self.subTest(runs=runs, from_version=from_version):
                    told, does = self.upgraded(False, runs, from_version)
                    self.assertEqual(does, [])
                    self.assertIn("contourd.json: line 1", told)
                    self.assertIn("contourd cannot start with it. Correct it, then run: systemctl reload-or-restart contourd", told)

    def test_one_that_runs_takes_the_new_program_over_and_one_that_was_stopped_stays_so(self):
        self.assertEqual(self.upgraded(True, True), ("", ["systemctl reload contourd.service"]))
        self.assertEqual(self.upgraded(True, False, ""), ("", ["deb-systemd-invoke start contourd.service"]))
        told, does = self.upgraded(True, False)
        self.assertEqual(does, [])
        self.assertIn("the service is stopped and stays stopped", told)


class UnitsTest(unittest.TestCase):
    def test_what_is_wrong_for_good_is_not_started_again(self):
        """64 and 78 of sysexits.h: a wrong command line or configuration. What else ends at every start is given up, too."""
        with open(os.path.join(SOURCE, "systemd/contourd.service"), encoding="utf-8") as file:
            unit = dict(line.strip().split("=", 1) for line in file if "=" in line and not line.startswith("#"))
        self.assertEqual(set(unit["RestartPreventExitStatus"].split()), {"64", "78"})
        self.assertLess(int(unit["StartLimitBurst"]) * int(unit["RestartSec"]), int(unit["StartLimitIntervalSec"]))

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
