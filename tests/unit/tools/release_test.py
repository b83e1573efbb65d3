"""Tests of the release's parts: licences of Debian packages, the bill of materials, archives of the same bytes."""
import copy
import os
import stat
import tempfile
import unittest
import zipfile

from packaging_tools import archive, debian, spdx

COPYRIGHT = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/

Files: *
License: Expat or GPL-2+

Files: third/*
License: house-rules
 Do as you are told.
"""


def document(debian_version="1.0-1"):
    bill = spdx.Document("thing-1", "https://example.org/thing-1", 1700000000, "test")
    licence, texts = debian.of_copyright("libthing++1", COPYRIGHT)
    root = bill.package(spdx.identifier("thing"), "thing", "1", "Apache-2.0")
    inner = bill.package(spdx.identifier("debian", "libthing++1"), "libthing++1", debian_version, licence, texts)
    bill.relate("SPDXRef-DOCUMENT", "DESCRIBES", root)
    bill.relate(root, "DYNAMIC_LINK", inner)
    return bill.json()


class Licences(unittest.TestCase):
    def test_names_become_expressions_and_other_texts_are_kept(self):
        expression, texts = debian.of_copyright("thing", COPYRIGHT)
        self.assertEqual(expression, "(MIT OR GPL-2.0-or-later) AND LicenseRef-debian-thing-house-rules")
        self.assertEqual(texts, {"LicenseRef-debian-thing-house-rules": "Do as you are told."})

    def test_prose_is_kept_whole(self):
        expression, texts = debian.of_copyright("thing", "This may be copied.\n")
        self.assertEqual(texts, {expression: "This may be copied.\n"})


class BillOfMaterials(unittest.TestCase):
    def test_document_is_well_formed_and_dated(self):
        self.assertEqual(list(spdx.faults(document())), [])
        self.assertEqual(document()["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        self.assertEqual(document(), document())

    def test_other_contents_have_another_namespace(self):
        self.assertNotEqual(document("1.0-1")["documentNamespace"], document("1.0-2")["documentNamespace"])

    def test_each_fault_is_named(self):
        def broken(change):
            copied = copy.deepcopy(document())
            change(copied)
            return " ".join(spdx.faults(copied))
        self.assertIn("is no element", broken(lambda it: it["relationships"][0].update(relatedSpdxElement="SPDXRef-none")))
        self.assertIn("not unique", broken(lambda it: it["packages"].append(it["packages"][0])))
        self.assertIn("has no text", broken(lambda it: it["hasExtractedLicensingInfos"].clear()))
        self.assertIn("no licence expression", broken(lambda it: it["packages"][0].update(licenseDeclared="MIT or so")))
        self.assertIn("versionInfo is missing", broken(lambda it: it["packages"][0].pop("versionInfo")))
        self.assertIn("describes nothing", broken(lambda it: it["relationships"].clear()))
        self.assertIn("creationInfo.created", broken(lambda it: it["creationInfo"].update(created="today")))
        self.assertIn("spdxVersion", broken(lambda it: it.update(spdxVersion="SPDX-1.2")))


class Archives(unittest.TestCase):
    def test_order_dates_and_modes_of_the_input_do_not_matter(self):
        def written(folder, name, entries, year, mode):
            path = os.path.join(folder, name)
            with zipfile.ZipFile(path, "w") as file:
                for entry in entries:
                    info = zipfile.ZipInfo(entry, (year, 5, 4, 3, 2, 2))
                    info.external_attr = (mode | (0o111 if entry.endswith("run") else 0)) << 16
                    file.writestr(info, entry * 100)
            archive.normalise(path, 1700000000)
            with open(path, "rb") as file:
                return path, file.read()
        names = ["b/run", "a.py", "x.dist-info/RECORD", "x.dist-info/METADATA"]
        with tempfile.TemporaryDirectory() as folder:
            path, first = written(folder, "1.whl", names, 2001, 0o100640)
            _, second = written(folder, "2.whl", names[::-1], 2020, 0o100664)
            self.assertEqual(first, second)
            with zipfile.ZipFile(path) as file:
                self.assertEqual(file.namelist(), ["a.py", "b/run", "x.dist-info/METADATA", "x.dist-info/RECORD"])
                self.assertEqual([stat.S_IMODE(each.external_attr >> 16) for each in file.infolist()], [0o644, 0o755, 0o644, 0o644])
                self.assertEqual(file.read("a.py"), b"a.py" * 100)


if __name__ == "__main__":
    unittest.main()
