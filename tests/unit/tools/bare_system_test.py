"""Tests of tools/bare_system.sh: which folders are taken for minimal systems, and what an interrupted start leaves behind."""
import os
import subprocess
import tempfile
import unittest

TOOLS = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../tools"))
MAKE = ('set -euo pipefail; say() { :; }; die() { echo "$*" >&2; exit 1; }; . "$1/bare_system.sh"; directory=$(bare_directory "$2"); '
        'make_bare_system bookworm "$directory" http://mirror')
STAND_IN = """#!/bin/sh
mkdir -p "$3/etc/apt/sources.list.d" && echo made > "$3/etc/debian_version"
! [ -e "$(dirname "$0")/fail" ]
"""


class BareSystem(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = held.name
        self.system = os.path.join(held.name, "system")
        os.mkdir(os.path.join(held.name, "bin"))
        with open(os.path.join(held.name, "bin/debootstrap"), "w", opener=lambda *open_: os.open(*open_, 0o755), encoding="ascii") as file:
            file.write(STAND_IN)

    def make(self, directory):
        return subprocess.run(("bash", "-c", MAKE, "bash", TOOLS, directory), text=True, capture_output=True, check=False, timeout=60,
                              env={**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"})

    def assert_refused(self, directory):
        done = self.make(directory)
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("name a folder that does not exist yet", done.stderr)

    def test_folders_of_others_are_refused(self):
        os.makedirs(os.path.join(self.system, "usr/bin"))
        os.symlink("/", os.path.join(self.folder, "link"))
        for directory in ("/", "//", "/usr/..", self.system, self.system + "/", os.path.join(self.folder, "link"),
                          os.path.join(self.folder, "link/")):
            with self.subTest(directory):
                self.assert_refused(directory)
        self.assertEqual(os.listdir(self.system), ["usr"])

    def test_programs_refuse_them_before_anything_else(self):
        for program in ("bare_packages.sh", "bare_machine.sh"):
            done = subprocess.run((os.path.join(TOOLS, program), "bookworm", self.folder + "/", "demo"), text=True, capture_output=True,
                                  check=False, timeout=60)
            self.assertEqual(done.returncode, 1, done)
            self.assertIn(f"{self.folder} is no system", done.stderr)

    def test_half_made_system_is_made_again(self):
        stop = os.path.join(self.folder, "bin/fail")
        open(stop, "w", encoding="ascii").close()
        self.assertEqual(self.make(self.system + "/").returncode, 1)
        self.assertFalse(os.path.exists(self.system))
        os.remove(stop)
        for _ in range(2):  # the second finds it made
            self.assertEqual(self.make(self.system + "/").returncode, 0)
            self.assertTrue(os.path.exists(self.system + "/etc/debian_version"))
        self.assertFalse(os.path.exists(self.system + ".new"))

    def test_folder_of_another_beside_it_stays(self):
        os.makedirs(self.system + ".new/mine")
        self.assert_refused(self.system)
        self.assertTrue(os.path.exists(self.system + ".new/mine"))


if __name__ == "__main__":
    unittest.main()
