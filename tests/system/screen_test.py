"""The picture on the display: the mask of a print, pictures of the user, and who may show and see them."""

import base64
import os
import random
import signal
import struct
import subprocess
import unittest
import zlib

from harness import (
    BAD_DATA, BAD_USAGE, CANNOT_CREATE, CONTOURCTL, ENDLESS, FAILED, NIMBLE_RESIN, NO_INPUT, OK, REALTIME, SANITIZED, SMALL, UNAVAILABLE, Daemon,
    FolderTest, Picture, contents, contourctl, read_png, wait_until,
)  # fmt: skip

BLACK = "nothing is shown: the screen is black"


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width, height, rows, depth=8, colour=0, more=b""):
    """Returns a PNG file with these rows of bytes; `more` are chunks before the pixels."""
    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows), 1)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + more + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


class ScreenTest(FolderTest):
    def start(self, resin=None, masks=False):
        self.daemon = Daemon(self, REALTIME, resin or NIMBLE_RESIN, masks=masks).start()
        display = self.daemon.config["display"]
        self.width, self.height = display["width_px"], display["height_px"]
        return self.daemon

    def noise(self, seed=1):
        chance = random.Random(seed)
        return [chance.randbytes(self.width) for _ in range(self.height)]

    def whole(self, client, reply):
        """Gets all pieces of a picture, and returns the picture."""
        result = reply["result"]
        data = base64.b64decode(result["data"])
        while len(data) < result["bytes"]:
            piece = client.call("mask", picture=result["picture"], **{"from": len(data)})["result"]
            self.assertEqual((piece["from"], piece["picture"]), (len(data), result["picture"]))
            data += base64.b64decode(piece["data"])
        return read_png(self.write("whole.png", data))

    def upload(self, client, data):
        for at in range(0, len(data), 5000):
            reply = client.call("upload", **{"from": at, "data": base64.b64encode(data[at : at + 5000]).decode()})
            self.assertEqual(reply["result"]["bytes"], min(at + 5000, len(data)))

    def refusal(self, reply):
        return reply["error"]["message"]

    def show(self, *words):
        process = subprocess.Popen([CONTOURCTL, "show", *words, "--socket", self.daemon.socket_path], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process


class Mask(ScreenTest):
    def test_the_mask_of_the_current_layer_is_the_one_that_the_display_was_given(self):
        daemon = self.start({**NIMBLE_RESIN, **ENDLESS}, masks=True)
        self.assertEqual(self.refusal(daemon.rpc("mask")), BLACK)
        daemon.begin("part.stl", SMALL)
        client = daemon.client()
        reply = client.call("mask")
        result = reply["result"]
        self.assertEqual((result["name"], result["layer"], result["on_screen"]), ("part", 1, True))
        self.assertAlmostEqual(result["cut_at_mm"], 0.025, 9)
        seen = self.whole(client, reply)
        kept = [os.path.join(folder, name) for folder, _, names in os.walk(self.path("masks")) for name in names if name.endswith(".png")]
        self.assertEqual(len(kept), 1, kept)
        self.assertEqual(seen, read_png(kept[0]))
        self.assertTrue(seen.lit_box())
        daemon.cancel("part")
        self.assertEqual(self.refusal(daemon.rpc("mask")), BLACK)
        # A picture with another number is not available.
        self.assertIn("no longer kept", self.refusal(daemon.rpc("mask", picture=999)))

    def test_while_the_screen_is_dark_the_last_mask_is_marked_as_not_on_screen(self):
        daemon = self.start({**NIMBLE_RESIN, "rest_ms": 60000})
        daemon.drop("part.stl", SMALL)
        daemon.wait_state("resting")
        result = daemon.rpc("mask")["result"]
        self.assertEqual((result["layer"], result["on_screen"]), (1, False))

    def test_wrong_parameters_are_refused(self):
        daemon = self.start()
        for wrong in ({"picture": -1}, {"picture": "1"}, {"from": 5}, {"picture": 1.5}, {"piece": 1}):
            self.assertIn("error", daemon.rpc("mask", **wrong), wrong)

    def test_all_clients_that_ask_at_once_get_the_same_mask(self):
        daemon = self.start({**NIMBLE_RESIN, **ENDLESS})
        daemon.begin("part.stl", SMALL)
        clients = [daemon.client() for _ in range(8)]
        for client in clients:
            client.send(b'{"jsonrpc":"2.0","method":"mask","id":"all"}\n')
        answers = [client.wait_for(lambda m: m.get("id") == "all", "the mask")["result"] for client in clients]
        for answer in answers:
            self.assertEqual(answer, answers[0])


class Command(ScreenTest):
    def test_the_mask_is_written_or_drawn_with_its_layer(self):
        daemon = self.start({**NIMBLE_RESIN, **ENDLESS}, masks=True)
        for output in ((), ("-o", self.path("none.png"))):
            result = daemon.ctl("mask", *output)
            self.assert_refusal(result, FAILED, BLACK)
        self.assertFalse(os.path.exists(self.path("none.png")))
        daemon.begin("pa\x1brt.stl", SMALL)
        result = daemon.ctl("mask", "-o", self.path("mask.png"))
        self.assertEqual((result.returncode, result.stdout, result.stderr), (OK, b"", b""))
        kept = [os.path.join(folder, name) for folder, _, names in os.walk(self.path("masks")) for name in names if name.endswith(".png")]
        self.assertEqual(read_png(self.path("mask.png")), read_png(kept[0]))
        drawn = daemon.ctl("mask", env={**os.environ, "COLUMNS": "60"})
        self.assertEqual((drawn.returncode, drawn.stderr), (OK, b""))
        text = drawn.stdout.decode()
        self.assertIn("layer 1, cut at 0.025 mm; on the screen", text)
        self.assertIn("\u2588", text)
        self.assertNotIn("\x1b", text)
        whole = daemon.ctl("mask", "-o", "-")
        self.assertEqual(whole.stdout, contents(self.path("mask.png")))

    def test_a_mask_that_cannot_be_written_is_an_error(self):
        daemon = self.start()
        daemon.client().call("show", pattern="grid")
        os.mkdir(self.path("folder"))
        for wrong, code in ((("-o", self.path("folder")), CANNOT_CREATE), (("-o", self.path("no/mask.png")), CANNOT_CREATE), (("-o", ""), BAD_USAGE)):
            result = daemon.ctl("mask", *wrong)
            self.assertEqual((result.returncode, result.stdout), (code, b""), result)
        result = contourctl("mask", "--socket", self.path("none"))
        self.assert_refusal(result, UNAVAILABLE)
        self.assertIn("grid; on the screen", daemon.ctl("mask").stdout.decode())


class Show(ScreenTest):
    def test_a_picture_is_shown_pixel_by_pixel_and_ends_with_its_client(self):
        daemon = self.start()
        rows = self.noise()
        file = self.write("noise.png", png(self.width, self.height, rows))
        process = self.show(file)
        self.assertEqual(process.stdout.readline(), b"picture is shown; Ctrl-C stops it\n")
        client = daemon.client()
        reply = client.call("mask")
        self.assertEqual((reply["result"]["name"], reply["result"]["layer"], reply["result"]["on_screen"]), ("picture", None, True))
        self.assertGreater(reply["result"]["bytes"], 100_000)  # many pieces
        self.assertEqual(self.whole(client, reply), Picture(self.width, self.height, rows))
        self.assertEqual(daemon.status()["manual"]["picture"], "picture")
        process.send_signal(signal.SIGKILL)
        wait_until(lambda: daemon.status()["manual"]["picture"] is None, "the picture to be removed")
        self.assertEqual(self.refusal(daemon.rpc("mask")), BLACK)

    def test_pictures_of_other_formats_are_shown_in_grey(self):
        daemon = self.start()
        width, height = self.width, self.height
        white, half = b"\xff\xff\xff", b"\xff\xff\xff\x00"
        kinds = {
            "colour": png(width, height, [white * width] * height, colour=2),
            "transparent": png(width, height, [half * width] * height, colour=6),
            "16 bits": png(width, height, [b"\xff\xff" * width] * height, depth=16),
            "1 bit": png(width, height, [b"\xff" * ((width + 7) // 8)] * height, depth=1),
        }
        for kind, data in kinds.items():
            with self.subTest(kind):
                process = self.show(self.write("some.png", data))
                self.assertIn(b"shown", process.stdout.readline())
                client = daemon.client()
                self.assertEqual(self.whole(client, client.call("mask")).values(), {0 if kind == "transparent" else 255})
                process.kill()
                wait_until(lambda: daemon.status()["manual"]["picture"] is None, "the picture to be removed")

    def test_a_file_that_is_no_picture_of_the_display_s_size_is_refused(self):
        daemon = self.start()
        good = png(self.width, self.height, self.noise())
        wrong = {
            "small.png": (png(2, 1, [b"\1\2"]), FAILED, "2x1 pixels, the display"),
            "cut.png": (good[:5000], BAD_DATA, "cannot be read"),
            "text.png": (b"no picture", BAD_DATA, "not a PNG file"),
            "empty.png": (b"", BAD_DATA, "not a PNG file"),
            "huge.png": (png(1 << 30, 1 << 30, [b"\0"]), BAD_DATA, ""),
        }
        for name, (data, code, words) in wrong.items():
            with self.subTest(name):
                result = daemon.ctl("show", self.write(name, data))
                self.assert_refusal(result, code, words)
        os.mkfifo(self.path("pipe.png"))
        self.assertEqual(daemon.ctl("show", self.path("pipe.png")).returncode, BAD_DATA)
        self.assertEqual(daemon.ctl("show", self.path("none.png")).returncode, NO_INPUT)
        self.assertEqual(contourctl("show", self.write("good.png", good), "--socket", self.path("none")).returncode, UNAVAILABLE)
        self.assertEqual(self.refusal(daemon.rpc("mask")), BLACK)

    def test_a_models_mask_at_a_height_is_shown_as_a_print_would_expose_it(self):
        daemon = self.start(masks=True)
        model = self.write("part.stl", SMALL)
        process = self.show(model, "--at-z", "0.075", "--printer", daemon.config_path)
        self.assertIn(b"shown", process.stdout.readline())
        client = daemon.client()
        seen = self.whole(client, client.call("mask"))
        process.kill()
        wait_until(lambda: daemon.status()["manual"]["picture"] is None, "the picture to be removed")
        daemon.printed("part.stl", SMALL)
        kept = sorted(os.path.join(folder, name) for folder, _, names in os.walk(self.path("masks")) for name in names
                      if name.endswith(".png") and folder.endswith("part"))  # fmt: skip
        self.assertEqual(len(kept), 4, kept)
        self.assertEqual(seen, read_png(kept[1]))
        for wrong, code, words in ((("--at-z", "0.3"), BAD_USAGE, "from 0 to 0.2 mm"), (("--at-z", "-1"), BAD_USAGE, "from 0"),
                                   (("--at-z", "nan"), BAD_USAGE, "from 0"), (("--at-z", "0.1", "--ticket", "x"), BAD_DATA, "no such file")):  # fmt: skip
            result = daemon.ctl("show", model, *wrong, "--printer", daemon.config_path)
            self.assert_refusal(result, code, words)
        self.assertEqual(daemon.ctl("show", model).returncode, BAD_DATA)

    def test_no_picture_is_shown_while_a_job_prints(self):
        daemon = self.start({**NIMBLE_RESIN, **ENDLESS})
        client = daemon.client()
        self.upload(client, png(self.width, self.height, self.noise()))
        daemon.begin("part.stl", SMALL)
        before = daemon.rpc("mask")["result"]
        self.assertIn("part is being printed", self.refusal(client.call("show", uploaded=True)))
        self.assertEqual(daemon.rpc("mask")["result"], before)


class Upload(ScreenTest):
    def test_a_piece_that_does_not_continue_an_upload_is_refused(self):
        daemon = self.start()
        client, other = daemon.client(), daemon.client()
        self.assertIn("start again at 0", self.refusal(client.call("upload", **{"from": 3, "data": "AAAA"})))
        self.upload(client, bytes(6000))
        self.assertIn("which has 6000 bytes so far", self.refusal(client.call("upload", **{"from": 5999, "data": "AAAA"})))
        self.assertIn("start again at 0", self.refusal(other.call("upload", **{"from": 6000, "data": "AAAA"})))
        self.upload(other, bytes(10))
        self.assertIn("another connection's upload replaced it", self.refusal(client.call("show", uploaded=True)))
        self.assertIn("not a PNG file", self.refusal(other.call("show", uploaded=True)))
        self.assertIn("no picture was uploaded", self.refusal(other.call("show", uploaded=True)))
        for wrong in ({"data": "AAAA"}, {"from": -1, "data": "AAAA"}):
            self.assertIn("from must be a whole number", self.refusal(client.call("upload", **wrong)), wrong)
        for wrong in ({"from": 0}, {"from": 0, "data": "A"}, {"from": 0, "data": "AA=A"}, {"from": 0, "data": ""},
                      {"from": 0, "data": "AAB="}, {"from": 0, "data": "\u00e4AAA"}):  # fmt: skip
            self.assertIn("Base64", self.refusal(client.call("upload", **wrong)), wrong)

    def test_a_picture_that_exceeds_the_limit_is_discarded(self):
        daemon = self.start()
        limit = self.width * self.height * 9 // 8 + 65536
        client = daemon.client()
        piece = base64.b64encode(bytes(5700)).decode()
        at = 0
        while "result" in (reply := client.call("upload", **{"from": at, "data": piece})):
            at += 5700
        self.assertIn(f"at most {limit} bytes", self.refusal(reply))
        self.assertLessEqual(at, limit)
        self.assertIn("no picture was uploaded", self.refusal(client.call("show", uploaded=True)))
        self.assertEqual(daemon.status()["state"], "idle")

    @unittest.skipIf(SANITIZED, "memory use is not measured with AddressSanitizer")
    def test_texts_in_a_picture_take_no_memory(self):
        daemon = self.start()
        client = daemon.client()

        def peak_mb():
            with open(f"/proc/{daemon.process.pid}/status", encoding="ascii") as file:
                return next(int(line.split()[1]) // 1024 for line in file if line.startswith("VmHWM"))

        before = peak_mb()
        text = zlib.compress(b"a" * 7_900_000)  # the most of one text that libpng itself unpacks
        texts = (chunk(b"zTXt", b"Title\0\0" + text) + chunk(b"iTXt", b"Title\0\1\0\0\0" + text)) * 10
        self.upload(client, png(self.width, self.height, [bytes(self.width)] * self.height, more=texts))
        self.assertIn("result", client.call("show", uploaded=True, seconds=60))
        self.assertLess(peak_mb() - before, 60, "the texts are 158 MB")

    def test_an_uploaded_picture_and_a_pattern_exclude_each_other(self):
        daemon = self.start()
        client = daemon.client()
        self.upload(client, png(self.width, self.height, self.noise()))
        self.assertIn("either", self.refusal(client.call("show", uploaded=True, pattern="grid")))
        self.assertIn("result", client.call("show", uploaded=True, seconds=60))
        self.assertIn("result", client.call("show", pattern="grid"))
        self.assertEqual(daemon.status()["manual"]["picture"], "grid")

    @unittest.skipUnless(os.geteuid() == 0, "only root can become another user")
    def test_only_users_with_service_rights_may_upload_and_show(self):
        daemon = self.start()
        os.chmod(self.folder, 0o755)
        os.chmod(daemon.socket_path, 0o777)
        code = (
            "import json,socket,sys\n"
            "s=socket.socket(socket.AF_UNIX); s.connect(sys.argv[1])\n"
            "for m,p in (('upload',{'from':0,'data':'AAAA'}),('show',{'uploaded':True}),('mask',{})):\n"
            "    s.sendall((json.dumps({'jsonrpc':'2.0','method':m,'params':p,'id':1})+'\\n').encode())\n"
            "    print(s.makefile().readline().strip())\n"
        )
        result = subprocess.run(["python3", "-c", code, daemon.socket_path], user=65534, group=65534, extra_groups=[],
                                capture_output=True, text=True, check=True)  # fmt: skip
        upload, show, mask = result.stdout.splitlines()
        self.assertIn("contourd-service", upload)
        self.assertIn("contourd-service", show)
        self.assertIn(BLACK, mask)
