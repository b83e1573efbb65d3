"""Strict parser of the Prometheus text format 0.0.4: it accepts only pages that Prometheus accepts."""
import math
import re
import time
import urllib.request

from harness import wait_until
from image_reader import check

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
LABEL = r'[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\\\|\\"|\\n)*"'
SAMPLE = re.compile(rf"({NAME})(?:\{{({LABEL}(?:,{LABEL})*)\}})? (\S+)")
SUFFIXES = {"counter": ("",), "gauge": ("",), "summary": ("_sum", "_count"), "histogram": ("_bucket", "_sum", "_count")}


def unescape(text):
    return re.sub(r"\\(.)", lambda m: "\n" if m.group(1) == "n" else m.group(1), text)


def number(text):
    if text in ("+Inf", "-Inf", "NaN"):
        return float(text)
    check(re.fullmatch(r"-?[0-9]+(\.[0-9]+)?(e[+-][0-9]+)?", text), f"{text!r} is no number")
    return float(text)


class Page:
    """samples: {(name, frozenset of label pairs): value}; kinds: {family: type}."""

    def __init__(self, text):
        check(text.endswith("\n") and "\r" not in text, "the page's lines do not end as they should")
        self.samples, self.kinds = {}, {}
        family, helped = None, set()
        for line in text.splitlines():
            if line.startswith("# HELP "):
                match = re.fullmatch(rf"# HELP ({NAME}) (.+)", line)
                check(match and match.group(1) not in helped, f"bad line: {line}")
                helped.add(match.group(1))
            elif line.startswith("#"):
                match = re.fullmatch(rf"# TYPE ({NAME}) (counter|gauge|histogram|summary)", line)
                check(match and match.group(1) in helped and match.group(1) not in self.kinds, f"bad line: {line}")
                family = match.group(1)
                self.kinds[family] = match.group(2)
            else:
                self._sample(family, line)
        self._check_histograms()

    def _sample(self, family, line):
        match = SAMPLE.fullmatch(line)
        check(match, f"bad line: {line}")
        check(family and any(match.group(1) == family + s for s in SUFFIXES[self.kinds[family]]),
              f"{line} stands in family {family}")
        check(self.kinds[family] != "counter" or family.endswith("_total"), f"the counter {family} has no _total")
        labels = re.findall(LABEL, match.group(2) or "")
        pairs = [(label.split("=", 1)[0], unescape(label.split("=", 1)[1][1:-1])) for label in labels]
        check(len({name for name, _ in pairs}) == len(pairs), f"a label twice: {line}")
        key = (match.group(1), frozenset(pairs))
        check(key not in self.samples, f"twice: {line}")
        value = number(match.group(3))
        check(self.kinds[family] == "gauge" or value >= 0, f"counts below zero: {line}")
        self.samples[key] = value

    def _check_histograms(self):
        for family, kind in self.kinds.items():
            if kind != "histogram":
                continue
            series = {}
            for (name, labels), value in self.samples.items():
                if name == family + "_bucket":
                    rest = frozenset(pair for pair in labels if pair[0] != "le")
                    series.setdefault(rest, []).append((number(dict(labels)["le"]), value))
            for rest, buckets in series.items():
                buckets.sort()
                check(all(a[1] <= b[1] for a, b in zip(buckets, buckets[1:])), f"{family} {dict(rest)} falls")
                check(buckets[-1][0] == math.inf and buckets[-1][1] == self.samples[family + "_count", rest],
                      f"{family} {dict(rest)}: the last bucket is not the count")

    def get(self, name, **labels):
        """Returns the one sample with at least these labels."""
        found = self.all(name, **labels)
        check(len(found) == 1, f"{len(found)} samples of {name} {labels}")
        return found[0]

    def all(self, name, **labels):
        return [value for (n, pairs), value in self.samples.items() if n == name and set(labels.items()) <= pairs]

    def total(self, name, **labels):
        return sum(self.all(name, **labels))

    def counts(self):
        """Returns all monotonic samples."""
        return {key: value for key, value in self.samples.items()
                if key[0].endswith(("_total", "_count", "_bucket", "_sum"))}


def scrape(url, timeout_s=60):
    with urllib.request.urlopen(url, timeout=timeout_s) as answer:
        check(answer.headers["Content-Type"].startswith("text/plain; version=0.0.4"), str(answer.headers))
        return Page(answer.read().decode())


def url_of(renderer):
    return renderer.wait_err(r"metrics at (http://\S+/metrics)$").group(1)


def images_of(url):
    """Number of images that a renderer has drawn."""
    return scrape(url).total("fire3dv_images_total")


def settled(url):
    """Waits until no image is drawn for a second; returns the number of images."""
    last = [-1]

    def look():
        before, last[0] = last[0], images_of(url)
        if last[0] == before:
            return True
        time.sleep(1)
        return False
    wait_until(lambda: f"the renderer to be idle; it has drawn {last[0]} images", look)
    return last[0]
