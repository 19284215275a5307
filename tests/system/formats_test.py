"""Models in other files than STL: compressed, in archives, and as 3MF."""

import gzip
import io
import json
import os
import time
import zipfile

from harness import BAD_DATA, OK, SLAB, SpoolTest, binary_stl, box, contents, contourctl

PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
MODEL = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
WEDGE = [((0, 0, 0), (0, 4, 0), (6, 0, 0)), ((0, 0, 0), (6, 0, 0), (1, 1, 3.3)), ((6, 0, 0), (0, 4, 0), (1, 1, 3.3)),
         ((0, 4, 0), (0, 0, 0), (1, 1, 3.3))]  # fmt: skip


def zipped(files, method=zipfile.ZIP_DEFLATED):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return packed.getvalue()


def threemf(objects, items='<item objectid="1"/>'):
    return zipped({
        "[Content_Types].xml": "<Types/>",
        "_rels/.rels": f'<Relationships xmlns="{PACKAGE}"><Relationship Id="r" Target="/3D/3dmodel.model" Type="{MODEL}"/></Relationships>',
        "3D/3dmodel.model": f'<model unit="millimeter" xmlns="{CORE}"><resources>{objects}</resources><build>{items}</build></model>',
    })  # fmt: skip


def mesh(facets, number=1):
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for facet in facets for x, y, z in facet)
    triangles = "".join(f'<triangle v1="{3 * i}" v2="{3 * i + 1}" v3="{3 * i + 2}"/>' for i in range(len(facets)))
    return f'<object id="{number}"><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>'


def amf(facets):
    vertices = "".join(f"<vertex><coordinates><x>{x}</x><y>{y}</y><z>{z}</z></coordinates></vertex>" for facet in facets for x, y, z in facet)
    triangles = "".join(f"<triangle><v1>{3 * i}</v1><v2>{3 * i + 1}</v2><v3>{3 * i + 2}</v3></triangle>" for i in range(len(facets)))
    return f'<amf unit="millimeter"><object id="1"><mesh><vertices>{vertices}</vertices><volume>{triangles}</volume></mesh></object></amf>'.encode()


def doubled(facets, times):
    """Returns objects of which each contains the one before twice."""
    objects = mesh(facets)
    for number in range(2, times + 2):
        objects += f'<object id="{number}"><components>' + f'<component objectid="{number - 1}"/>' * 2 + "</components></object>"
    return objects


class Formats(SpoolTest):
    def masks(self, name, data):
        """Returns the bytes of all masks of a model."""
        path, folder = self.write(name, data), self.path("masks-" + name)
        contourctl("slice", path, "--layer-height-um", "100", "--masks", folder, expect=OK)
        return [contents(os.path.join(folder, file)) for file in sorted(os.listdir(folder)) if file.endswith(".png")]

    def test_the_masks_of_a_model_do_not_depend_on_its_file(self):
        stl = binary_stl(WEDGE)
        expected = self.masks("part.stl", stl)
        self.assertEqual(len(expected), 33)
        obj = "".join(f"v {x} {y} {z}\n" for facet in WEDGE for x, y, z in facet) + "f -12 -11 -10\n"
        obj += "".join(f"f {i} {i + 1} {i + 2}\n" for i in (4, 7, 10))
        for name, data in (("part.obj", obj.encode()), ("packed.zip", zipped({"part.obj": obj})), ("part.stl.gz", gzip.compress(stl)), ("part.zip", zipped({"folder/part.stl": stl})),
                           ("stored.zip", zipped({"part.stl": stl}, zipfile.ZIP_STORED)), ("part.3mf", threemf(mesh(WEDGE))),
                           ("part.amf", amf(WEDGE)), ("zipped.amf", zipped({"part.amf": amf(WEDGE)}))):  # fmt: skip
            self.assertEqual(self.masks(name, data), expected, name)

    def test_each_file_is_printed_with_the_ticket_beside_it_and_ends_in_done(self):
        daemon = self.daemon().start()
        slab = box((0, 0, 0), (10, 20, 1))
        files = {"one.stl.gz": gzip.compress(SLAB), "two.ZIP": zipped({"a/slab.stl": SLAB, "__MACOSX/a/._slab.stl": b"x"}),
                 "three.3mf": threemf(mesh(slab))}  # fmt: skip
        for name, data in files.items():
            job = name.split(".")[0]
            daemon.drop(name, data, {"copies": 2})
            report = daemon.wait_done(job)
            self.assertEqual((report["outcome"], report["model"]["copies"]), ("done", 2))
            self.assertIn(name.lower(), [file.lower() for file in daemon.names_in("done")])
            self.assertTrue(daemon.has("done", job + ".json"))

    def test_an_obj_model_stands_on_its_flat_base_unless_the_ticket_says_which_way_is_up(self):
        daemon = self.daemon().start()
        # A pyramid whose only level face is its base, at the lowest y.
        obj = "v 0 0 0\nv 10 0 0\nv 10 0 20\nv 0 0 20\nv 3 2 8\n" + "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n"
        report = daemon.printed("lying.obj", obj.replace("v 0 0 0", "v 0 0 1").encode())
        self.assertEqual((report["model"]["format"], report["model"]["size_mm"][2]), ("obj", 2))
        self.assertIn("y is up", json.dumps(report))
        report = daemon.printed("told.obj", obj.replace("v 0 0 0", "v 0 0 1").encode(), {"up": {"x": 0, "y": 0, "z": 1}, "scale": 0.1})
        self.assertEqual(report["model"]["size_mm"][2], 2)
        self.assertAlmostEqual(report["model"]["size_mm"][1], 0.2, 6)

    def test_every_command_that_reads_an_obj_model_says_that_y_is_up(self):
        # A flat part whose only level face is its base, at the lowest y.
        faces = "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n"
        flat = self.write("flat.obj", ("v 0 0 1\nv 10 0 0\nv 10 0 20\nv 0 0 20\nv 3 2 8\n" + faces).encode())
        standing = self.write("standing.obj", ("v 0 -1 0\nv 10 0 0\nv 10 -20 0\nv 0 -20 0\nv 3 -8 2\n" + faces).encode())
        for command in (("inspect",), ("slice", "--z", "1"), ("support",), ("orient",), ("preview", "-o", self.path("flat.png"))):
            with self.subTest(command=command[0]):
                result = contourctl(command[0], flat, *command[1:], expect=OK)
                self.assertIn(b"y is up", result.stderr + result.stdout)
        contourctl("preview", "-o", self.path("standing.png"), standing, expect=OK)
        self.assertEqual(contents(self.path("flat.png")), contents(self.path("standing.png")))

    def test_the_ticket_names_the_model_of_an_archive(self):
        daemon = self.daemon().start()
        archive = zipped({"Supported/part.stl": binary_stl(WEDGE), "Unsupported/part.stl": SLAB})
        report = daemon.printed("both.zip", archive)
        self.assertEqual(report["model"]["file"], "Supported/part.stl")
        self.assert_words(json.dumps(report["model"]["warnings"]), "with supports and without", "Unsupported/part.stl")
        self.assertEqual(daemon.printed("chosen.zip", archive, {"model": "Unsupported/part.stl"})["layers"], 20)
        self.assertEqual(daemon.printed("folder.zip", archive, {"model": ["Unsupported"]})["layers"], 20)

    def test_several_models_of_an_archive_are_a_plate(self):
        daemon = self.daemon(masks=True).start()
        cube, bar = binary_stl(box((0, 0, 0), (10, 10, 1))), binary_stl(box((0, 0, 0), (4, 8, 2)))
        report = daemon.printed("pack.zip", zipped({"a/cube.stl": cube, "b/bar.3mf": threemf(mesh(box((0, 0, 0), (4, 8, 2))))}))
        self.assertEqual([model["file"] for model in report["models"]], ["a/cube.stl", "b/bar.3mf"])
        daemon.drop_plate("plate", json.dumps({"models": [{"file": "cube.stl"}, {"file": "bar.stl"}]}), {"cube.stl": cube, "bar.stl": bar})
        folders = [each["masks_folder"] for each in (report, daemon.wait_done("plate"))]
        shown = [[contents(os.path.join(folder, name)) for name in sorted(os.listdir(folder)) if name.endswith(".png")] for folder in folders]
        self.assertEqual(len(shown[0]), 40)
        self.assertEqual(*shown)

    def test_an_archive_that_does_not_fit_on_one_plate_waits_and_is_printed_in_part_when_accepted(self):
        daemon = self.daemon().start()
        wide = binary_stl(box((0, 0, 0), (90, 30, 1)))
        path = self.write("wide.zip", zipped({"a.stl": wide, "b.stl": wide}))
        daemon.ctl("submit", path, "--yes", expect=OK)
        daemon.wait_job("wide", "unaccepted")
        self.assertEqual(daemon.job("wide")["asks"], ["left_out_models"])
        self.assert_words(json.dumps(daemon.job("wide")["warnings"]), "1 of the 2 models of the archive", "no room on the plate", "b.stl")
        daemon.ctl("accept", "wide", expect=OK)
        self.assertEqual([model["file"] for model in daemon.wait_done("wide")["models"]], ["a.stl"])
        daemon.ctl("submit", path, "--yes", "--model", "b.stl", expect=OK)
        self.assertEqual(daemon.wait_done("wide-2")["model"]["file"], "b.stl")

    def test_bombs_are_refused_in_a_sentence_while_contourd_answers(self):
        daemon = self.daemon().start()
        zeros = bytes(100_000_000)
        entities = '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;">]>'
        bombs = {
            "ratio.zip": (zipped({"a.stl": zeros}), "more than 200 times"),
            "packed.stl.gz": (gzip.compress(zeros), "more than 200 times"),
            "entries.zip": (zipped({f"{i}.txt": b"" for i in range(10_001)}), "10001 entries"),
            "entities.3mf": (zipped({"[Content_Types].xml": "", "_rels/.rels": entities + "<m>&b;</m>"}), "document type declaration"),
            "doubled.3mf": (threemf(doubled(WEDGE, 30), '<item objectid="31"/>'), "4294967296 facets"),
            "empty.3mf": (threemf(doubled([], 30), '<item objectid="31"/>'), "more than 1000000 objects"),
        }  # fmt: skip
        for name, (data, words) in bombs.items():
            daemon.drop(name, data)
            start = time.monotonic()
            self.assertEqual(daemon.status()["state"], "idle")
            self.assertLess(time.monotonic() - start, 5)
            self.assert_words(daemon.wait_refused(name.split(".")[0]), words)

    def test_submit_and_offer_take_them(self):
        daemon = self.daemon().start()
        path = self.write("part.3mf", threemf(mesh(box((0, 0, 0), (10, 20, 1)))))
        daemon.ctl("submit", path, "--yes", expect=OK)
        daemon.wait_done("part")
        os.mkdir(self.path("stick"))
        self.write("stick/packed.zip", zipped({"a.stl": SLAB, "b.stl": SLAB}))
        self.write("stick/packed.json", json.dumps({"model": "b.stl"}))
        daemon.ctl("offer", self.path("stick"), expect=OK)
        daemon.wait_done("packed")
        bad = self.write("bad.zip", zipped({"notes.txt": b"x"}))
        result = daemon.ctl("submit", bad, expect=BAD_DATA)
        self.assertIn(b"the archive holds no model", result.stderr)
