"""The user's camera: pictures at chosen layers, and a time lapse. The print waits for no command."""

import base64
import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import threading
import time
import unittest

from harness import NIMBLE_RESIN, SOURCE, Daemon, FolderTest, SLAB, contents, realtime, source_json, wait_until

WITH_CAMERA = os.path.join(SOURCE, "systemd", "with-camera")
# As far as contourd and browsers look at them; no decoder sees them.
JPEG, MP4 = rb"\377\330\377\340picture", rb"\000\000\000\020ftypisom"
SNAPSHOT = f"""printf '{JPEG.decode()} of layer %s' "$CONTOURD_LAYER" >"$CONTOURD_FILE" """
# A print of 20 layers that takes seconds, and a picture of every fifth.
SLOW = {**NIMBLE_RESIN, "exposure_ms": 150, "bottom_exposure_ms": 150}


class CameraService:
    """Runs with-camera for each connection, as contourd-camera.socket does."""

    def __init__(self, test, path, commands):
        self.commands, self.started, self.log_path = commands, [], test.path("camera.log")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.bind(path)
        self.socket.listen(8)
        threading.Thread(target=self._accept, daemon=True).start()
        test.addCleanup(self.close)

    def _accept(self):
        while True:
            try:
                connection, _ = self.socket.accept()
            except OSError:
                return
            with connection, open(self.log_path, "ab") as log:
                self.started.append(subprocess.Popen([WITH_CAMERA, self.commands], stdin=connection, stdout=connection, stderr=log,
                                                     env={"PATH": os.environ["PATH"]}, start_new_session=True))  # fmt: skip

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()
        for process in self.started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


class CameraTest(FolderTest):
    def camera(self, snapshot=SNAPSHOT, time_lapse=None):
        """Installs the commands, given as shell scripts."""
        for name, body in (("snapshot", snapshot), ("time-lapse", time_lapse)):
            if body is not None:
                os.chmod(self.write(f"camera-{name}", f"#!/bin/sh\nset -e\n{body}\n"), 0o755)
        return CameraService(self, self.path("camera.socket"), self.path("camera"))

    def start(self, every_layers=5, resin=None, **camera):
        camera = {"socket": "camera.socket", "every_layers": every_layers, **camera}
        self.daemon = Daemon(self, realtime(camera=camera), {**SLOW, **(resin or {})}).start()
        return self.daemon

    def print(self, name="part"):
        """Prints a part, and returns its log when the pictures are filed."""
        self.daemon.printed(f"{name}.stl", SLAB)
        wait_until(lambda: not os.path.isdir(self.daemon.file("pictures", name)), "the pictures to be filed")
        return [line for line in self.daemon.log().splitlines() if "picture" in line or "time lapse" in line]

    def told(self, text):
        wait_until(lambda: text in self.daemon.log(), f"the log: {text}")

    def pictures(self, name="part"):
        return self.daemon.rpc("pictures", job=name)

    def file(self, method, **parameters):
        """Returns a file that contourd sends in pieces."""
        data, version = b"", {}
        while True:
            piece = self.daemon.rpc(method, **{"from": len(data)} if data else {}, **version, **parameters)["result"]
            data += base64.b64decode(piece["data"])
            version = {"version": piece["version"]}
            if len(data) >= piece["bytes"]:
                return data

    def test_pictures_are_taken_at_chosen_layers_and_joined_to_a_time_lapse(self):
        self.camera(time_lapse=f"""printf '{MP4.decode()}' >"$CONTOURD_FILE"; ls "$CONTOURD_PICTURES" >>"$CONTOURD_FILE"; echo "$CONTOURD_COUNT" >>"$CONTOURD_FILE" """)
        self.start()
        log = self.print()
        self.assertEqual(self.pictures()["result"], {"job": "part", "layers": [5, 10, 15, 20], "time_lapse": True}, log)
        folder = self.daemon.file("done", "part.pictures")
        self.assertEqual(sorted(os.listdir(folder)), ["00005.jpg", "00010.jpg", "00015.jpg", "00020.jpg", "time-lapse.mp4"])
        self.assertEqual(os.stat(folder).st_mode & 0o777, 0o775)
        self.assertEqual(self.file("picture", job="part", layer=10), b"\xff\xd8\xff\xe0picture of layer 10")
        self.assertEqual(self.file("picture", job="part"), b"\xff\xd8\xff\xe0picture of layer 20")
        self.assertEqual(self.file("time_lapse", job="part"), b"\0\0\0\x10ftypisom00005.jpg\n00010.jpg\n00015.jpg\n00020.jpg\n4\n")
        camera = self.daemon.status()["camera"]
        self.assertEqual(camera, {"job": "part", "pictures": 4, "last_layer": 20, "failed": 0, "skipped": 0, "trouble": None})
        self.told("part: 4 pictures, 0 failed, 0 skipped")
        self.told("part: a time lapse of 4 pictures")
        # A job of the same name has other pictures.
        self.print("part-2")
        self.assertEqual(self.pictures("part-2")["result"]["layers"], [5, 10, 15, 20])

    def test_the_command_knows_the_print(self):
        self.camera('env | grep ^CONTOURD_ | sort >"' + self.path("known") + '"; ' + SNAPSHOT)
        self.start(every_layers=20)
        self.print("$(touch pwned)")
        known = dict(line.split("=", 1) for line in contents(self.path("known")).decode().splitlines())
        self.assertTrue(known.pop("CONTOURD_FILE").endswith("/picture.jpg"))
        self.assertEqual(known, {"CONTOURD_CAMERA": "snapshot", "CONTOURD_PRINTER": self.daemon.config["name"], "CONTOURD_JOB": "$(touch pwned)", "CONTOURD_LAYER": "20",
                                 "CONTOURD_LAYERS": "20", "CONTOURD_HEIGHT_MM": "1.000", "CONTOURD_TIME_LIMIT_S": "20"})  # fmt: skip

    def fails(self, snapshot, told, **options):
        """Prints with a command that makes no picture, which is logged once; the print is as without a camera."""
        self.camera(snapshot)
        self.start(**options)
        log = self.print()
        self.assertEqual(len([line for line in log if "no picture of layer" in line]), 1, log)
        self.assertIn(told, "\n".join(log))
        self.assertIn("error", self.pictures())
        camera = self.daemon.status()["camera"]
        self.assertEqual(camera["pictures"], 0)
        self.assertEqual(camera["failed"] + camera["skipped"], 20 // options.get("every_layers", 5))
        self.assertEqual(json.loads(contents(self.daemon.file("done", "part.report.json")))["outcome"], "done")

    def test_a_command_that_fails(self):
        self.fails("exit 7", "part: no picture of layer 5: the command ended with status 7; the print goes on")

    def test_a_command_that_writes_nothing(self):
        self.fails("true", "no picture of layer 5: the command wrote no file")

    def test_a_command_that_writes_no_jpeg(self):
        self.fails('echo text >"$CONTOURD_FILE"', "no picture of layer 5: its command has made no JPEG picture")

    def test_a_command_that_writes_a_gigabyte(self):
        self.fails('head -c 1000000000 /dev/zero >"$CONTOURD_FILE"', "no picture of layer 5: the command ended with status")

    def test_a_command_that_does_not_exist(self):
        self.fails(None, "camera-snapshot does not exist, or is not executable")

    def test_a_command_that_hangs_is_ended_with_all_that_it_has_started(self):
        pids = self.path("pids")
        self.fails(f"sleep 1000000 & echo $! >>{pids}; trap '' TERM; sleep 1000001 & echo $! >>{pids}; wait", "the command ran longer than 1 s and was ended", time_limit_s=1, every_layers=2)
        self.assertGreater(self.daemon.status()["camera"]["skipped"], 0)
        self.assert_ended(pids)

    def test_a_child_that_stays_delays_no_picture_and_is_ended(self):
        pids = self.path("pids")
        self.camera(f"sleep 1000000 & echo $! >>{pids}; {SNAPSHOT}")
        self.start()
        self.print()
        self.assertEqual(self.pictures()["result"]["layers"], [5, 10, 15, 20])
        self.assert_ended(pids)

    def assert_ended(self, pids):
        def all_ended():
            for pid in contents(pids).split():
                with contextlib.suppress(FileNotFoundError), open(f"/proc/{int(pid)}/stat", encoding="ascii") as file:
                    if file.read().split()[2] != "Z":
                        return False
            return True
        wait_until(all_ended, "the end of all processes of the commands")

    def test_without_a_service_one_sentence_says_how_to_enable_it(self):
        self.start()
        log = self.print()
        self.assertEqual(len([line for line in log if 'enable it with "systemctl enable --now contourd-camera.socket"' in line]), 1, log)

    def test_a_service_that_answers_without_end_is_left(self):
        """with-camera lets no such answer through."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
            listener.bind(self.path("camera.socket"))
            listener.listen(8)

            def flood():
                with contextlib.suppress(OSError):
                    while True:
                        connection, _ = listener.accept()
                        with connection, contextlib.suppress(OSError):
                            while True:
                                connection.sendall(bytes(1 << 20))
            thread = threading.Thread(target=flood, daemon=True)
            thread.start()
            self.start()
            self.print()
            self.told("its command has sent more than 8 MiB")
            listener.shutdown(socket.SHUT_RDWR)
            thread.join()

    def test_a_time_lapse_that_fails_leaves_the_pictures(self):
        self.camera(time_lapse="exit 3")
        self.start()
        self.print()
        self.told("part: no time lapse: the command ended with status 3")
        self.assertEqual(self.pictures()["result"], {"job": "part", "layers": [5, 10, 15, 20], "time_lapse": False})

    def test_a_stop_waits_for_no_command_and_the_next_start_files_the_pictures(self):
        self.camera(time_lapse="sleep 1000000")
        self.start()
        self.daemon.printed("part.stl", SLAB)
        wait_until(lambda: os.path.exists(self.path("camera.log")) and len(os.listdir(self.daemon.file("pictures", "part"))) == 4, "the pictures")
        began = time.monotonic()
        self.daemon.stop()
        self.assertLess(time.monotonic() - began, 5)  # of the ten minutes that the time lapse may take
        self.daemon.start()
        wait_until(lambda: self.daemon.has("done", "part.pictures"), "the pictures beside the job")
        self.assertEqual(self.pictures()["result"]["layers"], [5, 10, 15, 20])

    def test_pictures_go_with_a_cancelled_job_and_those_of_a_job_that_is_gone_are_removed(self):
        self.camera()
        self.start(every_layers=1, resin={"exposure_ms": 400, "bottom_exposure_ms": 400})
        os.makedirs(self.daemon.file("pictures", "gone"))
        self.daemon.begin("part.stl", SLAB)
        wait_until(lambda: (self.daemon.status()["camera"]["last_layer"] or 0) >= 3, "some pictures")
        self.daemon.cancel("part")
        wait_until(lambda: self.daemon.has("failed", "part.pictures"), "the pictures beside the job")
        wait_until(lambda: not self.daemon.has("pictures", "gone"), "the end of the pictures of no job")

    def test_no_name_leads_out_of_the_folders(self):
        self.camera()
        self.start(every_layers=20)
        self.print()
        os.makedirs(self.daemon.file("done", "linked.pictures"))
        os.symlink(self.daemon.config_path, self.daemon.file("done", "linked.pictures", "00001.jpg"))
        for parameters in ({"job": "../done/part"}, {"job": ""}, {"job": ".."}, {"job": "linked"}, {"job": "part", "layer": 3}):
            self.assertIn("error", self.daemon.rpc("picture", **parameters), parameters)

    def test_a_camera_changes_no_light(self):
        """A command that takes all the time and more than it may: the light of each layer stays what was asked for."""
        self.camera("yes >/dev/null & sleep 3")
        self.start(every_layers=1, time_limit_s=1)
        self.print()
        layers = json.loads(contents(self.daemon.file("done", "part.report.json")))["layer_records"]
        late = [layer["exposure_most_ms"] - layer["exposure_asked_ms"] for layer in layers]
        self.assertLess(sorted(late)[len(late) // 2], 20, late)  # ms, the median; a refresh is 17 ms


class UnitsTest(unittest.TestCase):
    def unit(self, name):
        with open(os.path.join(SOURCE, "systemd", name), encoding="utf-8") as file:
            settings = {}
            for key, value in re.findall(r"^(\w+)=(.*)$", file.read(), re.MULTILINE):
                settings.setdefault(key, []).append(value)
            return settings

    def test_only_the_daemon_can_use_the_socket_and_its_path_is_the_default(self):
        settings = self.unit("contourd-camera.socket")
        self.assertEqual(settings["ListenStream"], [source_json("contourd.schema.json")["properties"]["camera"]["properties"]["socket"]["default"]])
        self.assertEqual((settings["SocketUser"], settings["SocketMode"]), (["contourd"], ["0600"]))

    def test_the_commands_may_use_cameras_but_none_of_the_printer_s_devices(self):
        settings = self.unit("contourd-camera@.service")
        self.assertEqual(settings["DevicePolicy"], ["closed"])
        self.assertEqual({allowed.split()[0] for allowed in settings["DeviceAllow"]}, {"char-video4linux", "char-media", "char-dma_heap"})
        self.assertEqual((settings["DynamicUser"], settings["SupplementaryGroups"]), (["yes"], ["video"]))
        for limit in ("TimeoutStartSec", "MemoryMax", "TasksMax", "LimitFSIZE", "LogRateLimitBurst"):
            self.assertIn(limit, settings)
        self.assertNotIn("KillMode", settings)  # by default the whole control group ends


class ExamplesTest(FolderTest):
    def run_example(self, name, variable, **environment):
        path = self.write("program", f"#!/bin/sh\nprintf '%s\\0' \"$@\" >{self.folder}/arguments\n")
        os.chmod(path, 0o755)
        subprocess.run([os.path.join(SOURCE, "config", "examples", name)], check=True, stdin=subprocess.DEVNULL,
                       env={**os.environ, **environment, variable: os.fsdecode(path)})  # fmt: skip
        return contents(self.path("arguments")).decode().split("\0")[:-1]

    def test_the_snapshot_writes_the_file(self):
        self.assertEqual(self.run_example("camera-snapshot", "RPICAM_STILL", CONTOURD_FILE="/tmp/a b.jpg")[-2:], ["--output", "/tmp/a b.jpg"])

    def test_the_time_lapse_reads_the_pictures_and_writes_the_file(self):
        arguments = self.run_example("camera-time-lapse", "FFMPEG", CONTOURD_FILE="/tmp/film.mp4", CONTOURD_PICTURES="/spool/a b")
        self.assertIn("/spool/a b/*.jpg", arguments)
        self.assertEqual(arguments[-1], "/tmp/film.mp4")
