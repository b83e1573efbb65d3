"""Links of a built site: each relative link leads to a file and an anchor of it, and nothing is loaded from elsewhere."""
import os
import re
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

LOADED = {"link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src"}


class Page(HTMLParser):
    """Anchors and links of one page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        for key in ("id", "name"):
            if values.get(key):
                self.anchors.add(values[key])
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        elif values.get(LOADED.get(tag)):
            self.loaded.append(values[LOADED[tag]])


def faults_of_site(folder):
    """Sentences on links that lead nowhere, and on what a page would load from the network."""
    pages, faults = {}, []
    for below, _, files in os.walk(folder):
        for name in files:
            path = os.path.join(below, name)
            if name.endswith((".html", ".css")):
                with open(path, encoding="utf-8") as file:
                    text = file.read()
            if name.endswith(".html"):
                pages[path] = Page(text)
            elif name.endswith(".css"):
                faults += [f"{os.path.relpath(path, folder)} loads {each}" for each in
                           re.findall(r"""(?:url\(|@import)\s*["']?((?:[a-z]+:)?/[^"')]*)""", text)]
    for path, page in sorted(pages.items()):
        shown = os.path.relpath(path, folder)
        faults += [f"{shown} loads {each} from the network" for each in page.loaded if urlsplit(each).scheme not in ("", "data")
                   or each.startswith("//")]
        for link in page.links + page.loaded:
            parts = urlsplit(link)
            if parts.scheme or link.startswith("//"):
                continue
            target = os.path.normpath(os.path.join(os.path.dirname(path), unquote(parts.path))) if parts.path else path
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            if not os.path.exists(target):
                faults.append(f"{shown}: {link} leads nowhere")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                faults.append(f"{shown}: {link}: that page has no such anchor")
    return faults
