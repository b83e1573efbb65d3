"""Sphinx configuration of the site. Nothing comes from the network: theme, search and fonts are local."""
import json
import os

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "navigation.json"), encoding="utf-8") as file:
    navigation = json.load(file)

project = "FIRE-3DV"
extensions = ["myst_parser"]
html_theme = "theme"
html_theme_path = ["."]
html_title = "FIRE-3DV"
html_copy_source = False
html_use_index = False
html_context = {"navigation": navigation}
highlight_language = "none"
smartquotes = False  # options such as --listen stay as they are typed
myst_heading_anchors = 6
myst_enable_extensions = ["deflist"]  # options of manual pages
suppress_warnings = ["myst.header"]
exclude_patterns = ["theme"]


def mark_pages(app, pagename, templatename, context, doctree):
    context["has_markdown"] = doctree is not None  # not the search page


def setup(app):
    app.connect("html-page-context", mark_pages)
