"""Completion of contourctl's arguments in bash, fish and zsh."""

import os
import shutil
import subprocess
import unittest

from harness import BIN, ENDLESS, NIMBLE_RESIN, REALTIME, SMALL, SOURCE, Daemon, FolderTest, binary_stl, box, wait_until

FOLDER = os.path.join(SOURCE, "daemon/ctl/completions")
BASH = r"""
source "$0"
COMP_WORDS=(contourctl "$@")
COMP_CWORD=$#
_contourctl
printf '%s\n' "${COMPREPLY[@]}"
"""


class Completion(FolderTest):
    def environment(self, **more):
        return {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", **more}

    def bash(self, *words, **environment):
        result = subprocess.run(["bash", "-c", BASH, os.path.join(FOLDER, "contourctl.bash"), *words], capture_output=True,
                                text=True, check=True, env=self.environment(**environment))  # fmt: skip
        self.assertEqual(result.stderr, "")
        return result.stdout.splitlines() if result.stdout.strip() else []

    def test_bash_offers_commands_and_their_options(self):
        self.assertEqual(self.bash("s"), ["submit", "status", "set", "support", "slice", "stop", "show", "switches", "setup"])
        self.assertIn("plate-cleared", self.bash(""))
        self.assertIn("--copies", self.bash("submit", "--"))
        self.assertEqual(self.bash("light", "o"), ["on", "off"])
        self.assertEqual(self.bash("light", "on", "--sec"), ["--seconds"])
        self.assertEqual(self.bash("show", "g"), ["grid"])
        self.assertEqual(self.bash("replaced", ""), ["lamp", "film", "vat"])
        self.assertEqual(self.bash("queue", ""), ["show", "remove", "move"])
        self.assertEqual(self.bash("config", "s"), ["show", "schema"])
        self.assertEqual(self.bash("config", "schema", "pr"), ["printer", "projector"])
        self.assertEqual(self.bash("queue", "move", "a", "--f"), ["--first"])
        self.assertEqual(self.bash("slice", "--unif"), ["--uniformity-mask"])
        self.assertEqual(self.bash("slice", "--aa", "o"), ["on", "off"])
        self.assertEqual(self.bash("history", "--outcome", ""), ["done", "failed", "cancelled"])
        self.assertEqual(self.bash("help", "s"), ["submit", "status", "set", "support", "slice", "stop", "show", "switches", "setup"])
        self.assertEqual(self.bash("offer", "--o"), ["--once"])
        self.assertEqual(self.bash("submit", "--up", "f"), ["fast"])
        # An option's value is no command, and the option after it is completed as usual.
        self.assertEqual(self.bash("light", "on", "--seconds", "3", "--con"), ["--confirm"])
        self.assertEqual(self.bash("slice", "--force", "--aa", ""), ["on", "off"])
        # Commands for programs are not offered.
        self.assertEqual(self.bash("comp"), [])
        # The shell itself completes file names.
        self.assertEqual(self.bash("submit", "part"), [])

    def test_bash_offers_the_names_of_jobs_and_never_runs_them(self):
        daemon = Daemon(self, REALTIME, {**NIMBLE_RESIN, **ENDLESS}).start()
        harm = self.path("harm")
        daemon.begin("part.stl", SMALL)
        names = ["two words", f"$(touch {os.path.basename(harm)})", "`touch harm`", "a.b"]
        for name in names:
            daemon.drop(name + ".stl", SMALL)
        daemon.wait_status("queued", len(names))
        offered = self.bash("watch", "--job", "", CONTOURD_SOCKET=daemon.socket_path)
        self.assertEqual(offered, ["part", *names])
        self.assertEqual(self.bash("watch", "--job", "tw", CONTOURD_SOCKET=daemon.socket_path), ["two words"])
        self.assertEqual(self.bash("queue", "show", "", CONTOURD_SOCKET=daemon.socket_path), names)
        self.assertFalse(os.path.exists("harm"))

    def test_accept_completes_the_jobs_that_wait_to_be_accepted(self):
        daemon = Daemon(self, {**REALTIME, "ask_before": ["islands"]}, {**NIMBLE_RESIN, **ENDLESS}).start()
        daemon.begin("part.stl", SMALL)
        island = binary_stl([*box((0, 0, 0), (10, 5, 0.2)), *box((15, 0, 0.1), (20, 5, 0.2))])
        for name, model in (("two words", island), ("sound", SMALL), ("$(touch harm)", island)):
            daemon.drop(name + ".stl", model)
        wait_until(lambda: [job["state"] for job in daemon.rpc("queue")["result"]["jobs"]] == ["unaccepted", "ready", "unaccepted"], "the jobs to be checked")
        self.assertEqual(self.bash("accept", "", CONTOURD_SOCKET=daemon.socket_path), ["two words", "$(touch harm)"])
        self.assertEqual(self.bash("accept", "--j"), ["--json"])
        self.assertFalse(os.path.exists("harm"))

    def test_preview_completes_queued_and_printed_jobs_and_model_files(self):
        daemon = Daemon(self, {"wait_for_plate_cleared": True}).start()
        daemon.printed("done: it.stl", SMALL)
        daemon.drop("waits.stl", SMALL)
        daemon.wait_status("queued", 1)
        os.mkdir(self.path("here"))
        os.mkdir(self.path("here", "models"))
        models = ["B.STL", "b.3mf", "b.obj.gz", "b.zip", "my part.stl"]
        for name in (*models, "notes.txt", "b.gz"):
            self.write(os.path.join("here", name), b"")
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        os.chdir(self.path("here"))
        offered = self.bash("preview", "", CONTOURD_SOCKET=daemon.socket_path)
        self.assertEqual(sorted(offered), sorted([*models, "done: it", "models", "waits"]))
        self.assertEqual(self.bash("preview", "wai", CONTOURD_SOCKET=daemon.socket_path), ["waits"])
        self.assertEqual(self.bash("preview", "--la"), ["--layer"])
        self.assertEqual(self.bash("preview", "waits", "--pri"), ["--printer"])

    def test_without_a_daemon_no_job_is_offered_and_nothing_is_printed(self):
        self.assertEqual(self.bash("watch", "--job", "", CONTOURD_SOCKET=self.path("none")), [])

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish_offers_the_same_as_bash(self):
        def fish(line):
            result = subprocess.run(["fish", "--no-config", "-c", f'source {FOLDER}/contourctl.fish; complete -C "{line}"'],
                                    capture_output=True, text=True, check=True, env=self.environment(HOME=self.path()))  # fmt: skip
            return [each.split("\t")[0] for each in result.stdout.splitlines()]

        self.assertEqual(sorted(fish("contourctl s")), sorted(self.bash("s")))
        self.assertEqual(sorted(fish("contourctl submit --")), sorted(self.bash("submit", "--")))
        self.assertEqual(fish("contourctl slice --aa o"), ["off", "on"])
        self.assertEqual(fish("contourctl history --outcome d"), ["done"])
        self.assertEqual(sorted(fish("contourctl light o")), ["off", "on"])
        self.assertEqual(fish("contourctl light on --sec"), ["--seconds"])
        self.assertEqual(fish("contourctl help anal"), ["analyze"])
        self.assertEqual(fish("contourctl preview --la"), ["--layer"])
        model = self.write("fishy.stl", b"")
        self.assertEqual(fish(f"contourctl preview {os.fsdecode(model)[:-6]}"), [os.fsdecode(model)])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh_parses_its_completion_file(self):
        subprocess.run(["zsh", "-n", os.path.join(FOLDER, "_contourctl")], check=True)
