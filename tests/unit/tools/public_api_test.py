"""Tests of tools/public_api.py: what it notices, and what it asks for."""
import os
import tempfile
import unittest

import public_api
from api_tools import c_header, python_package

HEADER = """
#define THING_H
#define FIRE3DV_LIMIT 4u /* of one stream */
enum { FIRE3DV_A = -1, FIRE3DV_B };
typedef struct fire3dv_x {
  size_t struct_size; /* first; always */
  const char
      *name;
} fire3dv_x;
FIRE3DV_API int fire3dv_f(fire3dv_x **x,
                          const float pose[12]);
"""


class PublicApi(unittest.TestCase):
    def test_declarations_are_normalised(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "thing.h")
            with open(path, "w", encoding="utf-8") as file:
                file.write(HEADER)
            self.assertEqual(list(c_header.declarations(path)), [
                "define FIRE3DV_LIMIT 4u", "enum FIRE3DV_A = -1", "enum FIRE3DV_B = 0", "struct fire3dv_x[0] size_t struct_size",
                "struct fire3dv_x[1] const char* name", "function int fire3dv_f(fire3dv_x** x, const float pose[12])"])

    def test_text_that_is_no_declaration_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "thing.h")
            with open(path, "w", encoding="utf-8") as file:
                file.write("int fire3dv_hidden(void);\n")
            with self.assertRaisesRegex(ValueError, "fire3dv_hidden"):
                list(c_header.declarations(path))

    def test_change_of_a_released_function_needs_a_note(self):
        before = [("function int fire3dv_f(int a)", "0.2", "")]
        after = public_api.updated(before, ["function int fire3dv_f(long a)"], "0.3", False)
        self.assertEqual(after, [("function int fire3dv_f(long a)", "0.3", ""), ("function int fire3dv_f(int a)", "0.2", "0.3")])
        without_note = list(public_api.differences(after, after, c_header.name_of, "nothing"))
        self.assertEqual(len(without_note), 1)
        self.assertIn("does not mention fire3dv_f", without_note[0])
        self.assertEqual(list(public_api.differences(after, after, c_header.name_of, "`fire3dv_f` takes a long")), [])
        self.assertIn("new: function int fire3dv_f(long a)", list(public_api.differences(before, after, c_header.name_of, "fire3dv_f")))

    def test_change_before_the_release_is_noticed_and_leaves_no_trace(self):
        before = [("fire3dv.f(a)", "0.3", "")]
        after = public_api.updated(before, ["fire3dv.f(b)"], "0.3", False)
        self.assertEqual(after, [("fire3dv.f(b)", "0.3", "")])
        self.assertEqual(list(public_api.differences(before, after, python_package.name_of, "")),
                         ["new: fire3dv.f(b)", "gone, was never released: fire3dv.f(a)"])

    def test_change_between_two_patch_releases_keeps_its_line(self):
        after = public_api.updated([("fire3dv.f(a)", "0.3", "")], ["fire3dv.f(b)"], "0.3", True)
        self.assertEqual(after, [("fire3dv.f(b)", "0.3", ""), ("fire3dv.f(a)", "0.3", "0.3")])
        self.assertIn("does not mention fire3dv.f", "".join(public_api.differences(after, after, python_package.name_of, "")))


if __name__ == "__main__":
    unittest.main()
