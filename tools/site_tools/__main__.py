"""Builds the site: stages the pages, runs Sphinx, adds Markdown pages and llms.txt. Use tools/site.sh.

    python3 -m site_tools OUT       an empty or new folder, or one with a site
    python3 -m site_tools --check   builds into a temporary folder; warnings and broken links are errors
    python3 -m site_tools --links   links of all Markdown files, groups and references alone; needs no Sphinx
"""
import os
import shutil
import subprocess
import sys
import tempfile

from .c_reference import ReferenceFault
from .html_links import faults_of_site
from .source_links import faults_of_tree
from .stage import Stage

HERE = os.path.dirname(os.path.abspath(__file__))
MARK = ".fire3dv-site"  # an output folder with this file may be replaced


def fail(*sentences):
    for sentence in sentences:
        print(f"site.sh: {sentence}", file=sys.stderr)
    sys.exit(1)


def staged():
    try:
        stage = Stage()
    except ReferenceFault as fault:
        fail(str(fault))
    faults = stage.faults or faults_of_tree(stage.files, stage.folders)
    if faults:
        fail(*faults)
    return stage


def build(out):
    from pygments.formatters import HtmlFormatter  # comes with Sphinx
    stage = staged()
    with tempfile.TemporaryDirectory(prefix="fire3dv-site-") as folder:
        source, html = os.path.join(folder, "source"), os.path.join(folder, "html")
        stage.write(source)
        shutil.copy(os.path.join(HERE, "conf.py"), source)
        shutil.copytree(os.path.join(HERE, "theme"), os.path.join(source, "theme"))
        sphinx = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-j", "2", "-d",
                                 os.path.join(folder, "doctrees"), source, html], capture_output=True, text=True, check=False)
        if sphinx.returncode != 0:
            fail(*sphinx.stderr.replace(source + "/", "").strip().splitlines())
        for name in ("objects.inv", ".buildinfo"):  # for builds and sites that refer to this one: there are none
            if os.path.exists(os.path.join(html, name)):
                os.remove(os.path.join(html, name))
        with open(os.path.join(html, "_static", "pygments.css"), "a", encoding="utf-8") as file:
            file.write(HtmlFormatter(style="monokai").get_style_defs(':root[data-theme="dark"] .highlight'))
        stage.write_markdown(html)
        shutil.copytree(html, out, dirs_exist_ok=True)
        open(os.path.join(out, MARK), "w", encoding="utf-8").close()
    return stage


def main():
    arguments = sys.argv[1:]
    if len(arguments) != 1 or arguments[0].startswith("-") and arguments[0] not in ("--check", "--links"):
        print(__doc__, file=sys.stderr)
        return 2
    if arguments[0] == "--links":
        print(f"site.sh: {len(staged().pages)} pages, all links lead somewhere")
        return 0
    if arguments[0] == "--check":
        with tempfile.TemporaryDirectory(prefix="fire3dv-site-") as out:
            stage = build(out)
            faults = faults_of_site(out)
            if faults:
                fail(*faults)
            print(f"site.sh: {len(stage.pages)} pages, no broken links")
        return 0
    out = os.path.abspath(arguments[0])
    if os.path.isdir(out) and os.listdir(out):
        if not os.path.exists(os.path.join(out, MARK)):
            fail(f"{out} holds other files: name an empty or new folder")
        shutil.rmtree(out)
    stage = build(out)
    print(f"site.sh: {len(stage.pages)} pages in {out}; open {out}/index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
