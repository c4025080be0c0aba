# SPDX-License-Identifier: Apache-2.0
"""Sphinx's configuration; the target `docs` sets the environment (docs/CMakeLists.txt)."""
import importlib.util
import os

project = "meltsim"
author = "the authors of meltsim"
copyright = author
version = release = os.environ.get("MELTSIM_DOCS_VERSION", "")

extensions = ["breathe", "myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"
language = "en"

breathe_projects = {"meltsim": os.environ.get("MELTSIM_DOCS_XML", "xml")}
breathe_default_project = "meltsim"
breathe_show_include = False
breathe_domain_by_extension = {"hpp": "cpp"}
primary_domain = "cpp"
highlight_language = "none"

myst_heading_anchors = 4
# docs/performance.md: sections whose headings benchmarks write.
suppress_warnings = ["myst.header"]

# furo where it is installed; alabaster comes with Sphinx.
html_theme = "furo" if importlib.util.find_spec("furo") else "alabaster"
html_title = f"meltsim {release}"
html_show_sourcelink = False
html_copy_source = False
