"""The Debian packages: all four have the same files, upgrades keep a printer running, and the units have limits."""
import os
import pathlib
import shutil
import subprocess
import unittest

from harness import SOURCE, FolderTest, text_of

PACKAGING = os.path.join(SOURCE, "packaging")


@unittest.skipUnless(shutil.which("dpkg-deb"), "dpkg-deb is not installed")
class AlikeTest(FolderTest):
    def package(self, name, files):
        """Builds a package with these files, a dictionary from path to mode, and returns its path."""
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

    def compare(self, *packages):
        compared = subprocess.run([os.path.join(PACKAGING, "alike"), *packages], capture_output=True, text=True, check=False)
        return compared.returncode, compared.stdout + compared.stderr

    def test_the_same_files_are_alike_even_if_units_are_in_another_folder(self):
        first = self.package("amd64", {"usr/bin/p": 0o755, "lib/systemd/system/p.service": 0o644})
        second = self.package("arm64", {"usr/bin/p": 0o755, "usr/lib/systemd/system/p.service": 0o644})
        self.assertEqual(self.compare(first, second), (0, ""))

    def test_a_missing_file_or_different_permissions_are_reported(self):
        first = self.package("amd64", {"usr/bin/p": 0o755, "usr/share/p/a b": 0o644})
        without = self.package("arm64", {"usr/bin/p": 0o755})
        status, output = self.compare(first, first, without)
        self.assertEqual(status, 1)
        self.assertIn("./usr/share/p/a b", output)
        other_rights = self.package("armhf", {"usr/bin/p": 0o700, "usr/share/p/a b": 0o644})
        status, output = self.compare(first, other_rights)
        self.assertEqual(status, 1)
        self.assertIn("-rwx------ root/root ./usr/bin/p", output)


class UpgradeTest(FolderTest):
    """The package's postinst with a contourd that runs or not. Scripts in the place of systemctl and other programs record their
    calls; tests/vm tests the package with the real programs."""

    def upgraded(self, configuration_is_good, runs, from_version="0.2.0"):
        """Returns the output of postinst, and those of its calls that change something."""
        calls = self.path("calls")
        with open(calls, "w", encoding="utf-8"):
            pass
        for name in ("systemctl", "deb-systemd-invoke", "udevadm", "contourd"):
            answer = {"systemctl": f'case "$*" in *is-active*) exit {0 if runs else 3} ;; esac',
                      "contourd": "" if configuration_is_good else "echo 'contourd.json: line 1: it is no JSON' >&2; exit 78"}.get(name, "")  # fmt: skip
            program = self.write(name, f'#!/bin/sh\necho "{name} $*" >>{calls}\n{answer}\n'.encode())
            os.chmod(program, 0o755)
        function = text_of(os.path.join(PACKAGING, "debian/contourd.postinst")).split("start_or_reload() {")[1].split("\n}\n")[0]
        script = f'set -e\nstart_or_reload() {{{function}\n}}\nstart_or_reload "$1"\n'
        result = subprocess.run(["sh", "-c", script, "postinst", from_version], capture_output=True, text=True, check=True,
                              env={"PATH": f"{self.folder}:/usr/bin:/bin"})  # fmt: skip
        with open(calls, encoding="utf-8") as file:
            calls_made = [line.strip() for line in file if any(word in line for word in (" reload contourd", " start ", "restart"))]
        return result.stderr, calls_made

    def test_with_a_wrong_configuration_the_old_contourd_keeps_running_and_none_is_started(self):
        for runs in (True, False):
            for from_version in ("0.2.0", ""):
                with self.subTest(runs=runs, from_version=from_version):
                    output, calls = self.upgraded(False, runs, from_version)
                    self.assertEqual(calls, [])
                    self.assertIn("contourd.json: line 1", output)
                    self.assertIn("contourd cannot start with it. Correct it, then run: systemctl reload-or-restart contourd", output)

    def test_a_running_contourd_is_reloaded_and_a_stopped_one_stays_stopped(self):
        self.assertEqual(self.upgraded(True, True), ("", ["systemctl reload contourd.service"]))
        self.assertEqual(self.upgraded(True, False, ""), ("", ["deb-systemd-invoke start contourd.service"]))
        output, calls = self.upgraded(True, False)
        self.assertEqual(calls, [])
        self.assertIn("the service is stopped and stays stopped", output)


class UnitsTest(unittest.TestCase):
    def test_permanent_errors_cause_no_restart(self):
        """64 and 78 of sysexits.h stand for a wrong command line and a wrong configuration. Other repeated failures reach the
        start limit."""
        with open(os.path.join(SOURCE, "systemd/contourd.service"), encoding="utf-8") as file:
            unit = dict(line.strip().split("=", 1) for line in file if "=" in line and not line.startswith("#"))
        self.assertEqual(set(unit["RestartPreventExitStatus"].split()), {"64", "78"})
        self.assertLess(int(unit["StartLimitBurst"]) * int(unit["RestartSec"]), int(unit["StartLimitIntervalSec"]))

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed")
    def test_systemd_rates_the_exposure_of_the_units_as_low(self):
        folder = os.path.join(SOURCE, "systemd")
        for unit in ("contourd.service", "contourd-job-ended@.service", "contourd-camera@.service", "contourd-web.service"):
            command = ["systemd-analyze", "security", "--no-pager", "--offline=true", "--threshold=15", os.path.join(folder, unit)]
            # The unit's own folder, so that its drop-ins are found.
            looked = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "SYSTEMD_UNIT_PATH": folder})
            self.assertEqual(looked.returncode, 0, looked.stdout + looked.stderr)

    def test_needrestart_does_not_restart_contourd(self):
        """The package installs a file into needrestart's configuration. It is read by Perl, as needrestart reads it."""
        program = r"""our %nrconf = (override_rc => {}); do shift; die $@ if $@;
            for my $unit (@ARGV) {
              my @found = map { $nrconf{override_rc}{$_} } grep { $unit =~ /$_/ } keys %{$nrconf{override_rc}};
              print "$unit=@found\n";
            }"""
        units = ("contourd.service", "contourd-job-ended@1-2.service", "contourd-other.service", "a-contourd.service")
        read = subprocess.run(["perl", "-e", program, os.path.join(PACKAGING, "debian/contourd.needrestart"), *units],
                              capture_output=True, text=True, check=True)  # fmt: skip
        self.assertEqual(read.stdout.splitlines(), ["contourd.service=0", "contourd-job-ended@1-2.service=0",
                                                    "contourd-other.service=", "a-contourd.service="])  # fmt: skip
