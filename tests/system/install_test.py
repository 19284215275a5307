"""cmake --install: the files that it installs, and the files that it leaves alone."""
import os
import pathlib
import subprocess

from harness import BIN, FolderTest

BUILD = pathlib.Path(BIN).parent


class Install(FolderTest):
    def setUp(self):
        super().setUp()
        self.root = pathlib.Path(self.path("root"))
        self.etc = self.root / "etc/contourd"
        self.shipped = self.root / "usr/share/contourd"
        # If root has installed from this build, the manifest is root's and could not be written.
        (BUILD / "install_manifest.txt").unlink(missing_ok=True)

    def cmake(self, *arguments):
        return subprocess.run(["cmake", *arguments], check=True, capture_output=True, text=True,
                              env={**os.environ, "DESTDIR": str(self.root)}).stdout  # fmt: skip

    def install(self):
        return self.cmake("--install", str(BUILD), "--prefix", "/usr")

    def test_the_installed_configuration_is_valid_and_complete(self):
        self.install()
        checked = subprocess.run([self.root / "usr/bin/contourd", "--check-config", self.etc / "contourd.json"], capture_output=True, text=True, check=False)
        self.assertEqual((checked.returncode, checked.stderr), (0, ""))
        self.assertEqual(sorted(path.relative_to(self.etc) for path in self.etc.rglob("*.json") if not path.is_symlink()),
                         sorted(path.relative_to(self.shipped) for path in self.shipped.rglob("*.json")
                                if not path.name.startswith("raspberry-pi-") and not path.name.endswith(".schema.json")))  # fmt: skip

    def test_schemas_in_etc_are_links_to_the_installed_ones(self):
        self.install()
        for schema in self.shipped.glob("*.schema.json"):
            self.assertEqual(os.readlink(self.etc / schema.name), f"/usr/share/contourd/{schema.name}")

    def test_files_that_the_user_edited_or_added_are_kept(self):
        self.install()
        own = {"contourd.json": '{"mine": 1}', "resins/standard.json": "my resin", "projectors/optoma.json": "my table",
               "resins/tough.json": "one more", "ticket.schema.json": "a schema of before"}  # fmt: skip
        for name, text in own.items():
            (self.etc / name).unlink(missing_ok=True)
            (self.etc / name).write_text(text, encoding="utf-8")
        (self.etc / "projectors/acer.json").unlink()
        printed = self.install()
        self.assertEqual({name: (self.etc / name).read_text(encoding="utf-8") for name in own}, own)
        self.assertIn(f"Keeping: {self.etc}/contourd.json", printed)
        self.assertEqual((self.etc / "projectors/acer.json").read_bytes(), (self.shipped / "projectors/acer.json").read_bytes())

    def test_a_link_of_the_user_is_not_followed(self):
        self.etc.mkdir(parents=True)
        elsewhere = self.root / "elsewhere.json"
        (self.etc / "contourd.json").symlink_to(elsewhere)
        self.install()
        self.assertFalse(elsewhere.exists())
        self.assertTrue((self.etc / "contourd.json").is_symlink())

    def test_uninstalling_removes_the_program_and_keeps_the_configuration(self):
        self.install()
        self.cmake("--build", str(BUILD), "--target", "uninstall")
        self.assertEqual([path for path in self.root.rglob("*") if not path.is_dir() and self.etc not in path.parents], [])
        self.assertTrue((self.etc / "contourd.json").is_file())
        self.assertTrue((self.etc / "resins/standard.json").is_file())

    def test_uninstalling_removes_all_folders_without_other_files(self):
        self.install()
        kept = self.shipped / "resins/of-another-program.json"
        kept.write_text("{}", encoding="utf-8")
        self.cmake("--build", str(BUILD), "--target", "uninstall")
        left = [path for path in self.root.rglob("*") if "contour" in path.name and self.etc not in (path, *path.parents)]
        self.assertEqual(left, [self.shipped])
        self.assertTrue(kept.is_file())
