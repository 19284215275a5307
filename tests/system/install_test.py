"""What cmake --install puts where, and what it leaves alone."""
import os
import pathlib
import subprocess
import unittest

from harness import BIN, FolderTest

BUILD = pathlib.Path(BIN).parent


class Install(FolderTest):
    def setUp(self):
        super().setUp()
        self.root = pathlib.Path(self.path("root"))
        self.etc = self.root / "etc/contourd"
        self.shipped = self.root / "usr/share/contourd"
        # Root's, where root has installed from this build: it could not be written.
        (BUILD / "install_manifest.txt").unlink(missing_ok=True)

    def cmake(self, *arguments):
        return subprocess.run(["cmake", *arguments], check=True, capture_output=True, text=True,
                              env={**os.environ, "DESTDIR": str(self.root)}).stdout  # fmt: skip

    def install(self):
        return self.cmake("--install", str(BUILD), "--prefix", "/usr")

    def test_an_owner_finds_a_configuration_that_contourd_takes(self):
        self.install()
        checked = subprocess.run([self.root / "usr/bin/contourd", "--check-config", self.etc / "contourd.json"], capture_output=True, text=True, check=False)
        self.assertEqual((checked.returncode, checked.stderr), (0, ""))
        self.assertEqual(sorted(path.relative_to(self.etc) for path in self.etc.rglob("*.json") if not path.is_symlink()),
                         sorted(path.relative_to(self.shipped) for path in self.shipped.rglob("*.json")
                                if not path.name.startswith("raspberry-pi-") and not path.name.endswith(".schema.json")))  # fmt: skip

    def test_schemas_in_etc_are_the_installed_programs(self):
        self.install()
        for schema in self.shipped.glob("*.schema.json"):
            self.assertEqual(os.readlink(self.etc / schema.name), f"/usr/share/contourd/{schema.name}")

    def test_what_the_owner_has_edited_or_put_there_stays(self):
        self.install()
        own = {"contourd.json": '{"mine": 1}', "resins/standard.json": "my resin", "projectors/optoma.json": "my table",
               "resins/tough.json": "one more", "ticket.schema.json": "a schema of before"}  # fmt: skip
        for name, text in own.items():
            (self.etc / name).unlink(missing_ok=True)
            (self.etc / name).write_text(text, encoding="utf-8")
        (self.etc / "projectors/acer.json").unlink()
        told = self.install()
        self.assertEqual({name: (self.etc / name).read_text(encoding="utf-8") for name in own}, own)
        self.assertIn(f"Keeping: {self.etc}/contourd.json", told)
        self.assertEqual((self.etc / "projectors/acer.json").read_bytes(), (self.shipped / "projectors/acer.json").read_bytes())

    def test_a_link_of_the_owners_is_not_written_through(self):
        self.etc.mkdir(parents=True)
        elsewhere = self.root / "elsewhere.json"
        (self.etc / "contourd.json").symlink_to(elsewhere)
        self.install()
        self.assertFalse(elsewhere.exists())
        self.assertTrue((self.etc / "contourd.json").is_symlink())

    def test_uninstalling_removes_the_program_and_keeps_what_is_the_owners(self):
        self.install()
        self.cmake("--build", str(BUILD), "--target", "uninstall")
        self.assertEqual([path for path in self.root.rglob("*") if not path.is_dir() and self.etc not in path.parents], [])
        self.assertTrue((self.etc / "contourd.json").is_file())
        self.assertTrue((self.etc / "resins/standard.json").is_file())

    def test_uninstalling_leaves_no_folder_but_what_something_else_is_in(self):
        self.install()
        kept = self.shipped / "resins/of-another-program.json"
        kept.write_text("{}", encoding="utf-8")
        self.cmake("--build", str(BUILD), "--target", "uninstall")
        left = [path for path in self.root.rglob("*") if "contour" in path.name and self.etc not in (path, *path.parents)]
        self.assertEqual(left, [self.shipped])
        self.assertTrue(kept.is_file())


if __name__ == "__main__":
    unittest.main()
