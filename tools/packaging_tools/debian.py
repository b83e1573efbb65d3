"""Debian packages of this machine: owners of files, versions, and licences by their copyright files, as SPDX expressions."""
import functools
import glob
import os
import re
import subprocess
from typing import NamedTuple

COPYRIGHT = "/usr/share/doc/{}/copyright"
# Short names of Debian's copyright files (lower case): identifiers of SPDX. Others become a LicenseRef with their text.
SPDX = {
    "apache-2": "Apache-2.0", "apache-2.0": "Apache-2.0", "boost-1.0": "BSL-1.0", "bsd-1-clause": "BSD-1-Clause",
    "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause", "bsl-1": "BSL-1.0", "bsl-1.0": "BSL-1.0", "cc-by-4.0": "CC-BY-4.0", "cc0": "CC0-1.0",
    "cc0-1.0": "CC0-1.0",
    "edl-1.0": "BSD-3-Clause", "epl-2": "EPL-2.0", "epl-2.0": "EPL-2.0", "expat": "MIT", "gpl-1+": "GPL-1.0-or-later", "gpl-2": "GPL-2.0-only",
    "gpl-2+": "GPL-2.0-or-later", "gpl-2.0+": "GPL-2.0-or-later", "gpl-3": "GPL-3.0-only", "gpl-3+": "GPL-3.0-or-later",
    "isc": "ISC", "lgpl-2": "LGPL-2.0-only", "lgpl-2+": "LGPL-2.0-or-later", "lgpl-2.0+": "LGPL-2.0-or-later",
    "lgpl-2.1": "LGPL-2.1-only", "lgpl-2.1+": "LGPL-2.1-or-later", "lgpl-3": "LGPL-3.0-only", "lgpl-3+": "LGPL-3.0-or-later",
    "mit": "MIT", "mpl-2.0": "MPL-2.0", "unlicense": "Unlicense", "x11": "X11", "zlib": "Zlib",
}


class Package(NamedTuple):
    name: str
    version: str
    source: str
    architecture: str


@functools.lru_cache(maxsize=None)
def _owners():
    """Package of each file; the system's /lib is a link to /usr/lib, and packages name either."""
    owners = {}
    for path in glob.glob("/var/lib/dpkg/info/*.list"):
        name = os.path.basename(path)[:-len(".list")].split(":")[0]
        with open(path, encoding="utf-8") as file:
            for line in file:
                owners.setdefault(re.sub("^/(?=lib)", "/usr/", line.rstrip("\n")), name)
    return owners


def owner(path):
    """Name of the package that the file, or what it links to, is from; "" if it is from none."""
    for each in (path, os.path.realpath(path)):
        name = _owners().get(re.sub("^/(?=lib)", "/usr/", os.path.normpath(each)))
        if name:
            return name
    return ""


@functools.lru_cache(maxsize=None)
def _installed():
    listing = subprocess.run(("dpkg-query", "-W", "-f", "${Package}\\t${Version}\\t${source:Package}\\t${Architecture}\\n"),
                             check=True, text=True, capture_output=True).stdout
    return {line.split("\t")[0]: Package(*line.split("\t")) for line in listing.splitlines()}


def package(name):
    return _installed()[name]


def licences(name):
    """SPDX expression of all licences that the copyright file names, and the texts of those that SPDX does not number."""
    path = COPYRIGHT.format(name)
    if not os.path.exists(path):
        return "NOASSERTION", {}
    with open(path, encoding="utf-8", errors="replace") as file:
        return of_copyright(name, file.read())


def of_copyright(name, text):
    if not text.lstrip().startswith("Format"):
        reference = _reference(name, "copyright")
        return reference, {reference: text}
    found = re.findall(r"(?m)^License:[ \t]*(\S.*)$((?:\n[ \t].*)*)", text)
    terms, texts = set(), {}
    for short, body in found:
        words = re.split(r"\s*,?\s+(and|or)\s+|,\s*", short.strip())
        known = [SPDX.get(word.lower()) for word in words[::2]]
        if all(known) and None not in words[1::2]:
            joined = " ".join(known[0:1] + [f"{operator.upper()} {term}" for operator, term in zip(words[1::2], known[1:])])
            terms.add(f"({joined})" if len(known) > 1 else joined)
        else:
            reference = _reference(name, short)
            terms.add(reference)
            text_of = "\n".join(line.strip() for line in body.strip().splitlines())
            texts[reference] = text_of or texts.get(reference) or f'Licence "{short}" of {COPYRIGHT.format(name)}'
    return " AND ".join(sorted(terms)) or "NOASSERTION", texts


def _reference(name, short):
    return "LicenseRef-debian-" + re.sub(r"[^A-Za-z0-9.]+", "-", f"{name}-{short}").strip("-")
