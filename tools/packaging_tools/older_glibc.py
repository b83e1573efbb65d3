"""Carried libraries for an older glibc than they were linked with.

Debian's LLVM and Expat need glibc 2.36 for arc4random and arc4random_buf alone. A small library defines both; the requirement of the version
becomes a weak one, which the dynamic linker passes over where it is not met.
"""
import os
import re
import struct

from packaging_tools.elf import run

NAME = "libfire3dv-arc4random.so"
VERSION = "GLIBC_2.36"
SOURCE = """
#include <errno.h>
#include <stdlib.h>
#include <sys/random.h>
void arc4random_buf(void* bytes, size_t count) {
  for (size_t done = 0; done < count;) {
    const ssize_t got = getrandom((char*)bytes + done, count - done, 0);
    if (got < 0 && errno != EINTR) abort();
    if (got > 0) done += (size_t)got;
  }
}
unsigned arc4random(void) {
  unsigned value;
  arc4random_buf(&value, sizeof value);
  return value;
}
"""
DEFINED = {"arc4random", "arc4random_buf"}
WEAK = 2  # VER_FLG_WEAK


def _hash(name):
    """ELF hash of a version's name."""
    value = 0
    for byte in name.encode():
        value = (value << 4) + byte
        high = value & 0xf0000000
        value = (value ^ high >> 24) & ~high
    return value


def _make_weak(path):
    """Marks the file's requirement of VERSION as weak."""
    [(count, offset)] = re.findall(r"'\.gnu\.version_r' contains (\d+) entr[^\n]*\n.*?Offset: (0x[0-9a-f]+)", run("readelf", "-VW", path))
    with open(path, "r+b") as file:
        data = bytearray(file.read())
        need = int(offset, 16)
        for _ in range(int(count)):
            _, auxiliaries, _, first, following = struct.unpack_from("<HHIII", data, need)
            entry = need + first
            for _ in range(auxiliaries):
                digest, flags, _, _, step = struct.unpack_from("<IHHII", data, entry)
                if digest == _hash(VERSION):
                    struct.pack_into("<H", data, entry + 4, flags | WEAK)
                entry += step
            need += following
        file.seek(0)
        file.write(data)


def lower(files, folder):
    """Lets the files, libraries of a folder, do with a glibc before VERSION, where only DEFINED stands in the way."""
    lowered = False
    for path in files:
        symbols = set(re.findall(rf"(\w+)@{re.escape(VERSION)}\b", run("readelf", "--dyn-syms", "-W", path)))
        if not symbols or not symbols <= DEFINED:
            continue
        for name in sorted(symbols):
            run("patchelf", "--clear-symbol-version", name, path)
        run("patchelf", "--add-needed", NAME, path)
        _make_weak(path)
        lowered = True
    if lowered:
        source = os.path.join(folder, "arc4random.c")
        with open(source, "w", encoding="ascii") as file:
            file.write(SOURCE)
        run("cc", "-shared", "-fPIC", "-O2", "-s", "-Wl,-soname," + NAME, "-o", os.path.join(folder, NAME), source)
        os.remove(source)
