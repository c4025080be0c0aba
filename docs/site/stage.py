#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sphinx's source folder: stage.py REPOSITORY OUT. Copies the documents of docs/ and of the repository's root, and writes a page
for every header of formulas. Links between them are made to fit; links to other files of the repository become text.
Fails where a public header is on no page of docs/api. Standard library only.
"""
import os
import re
import shutil
import sys
from pathlib import Path

ROOT_PAGES = {"ARCHITECTURE.md": "architecture.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
PICTURES = {".png", ".jpg", ".svg"}


def stage(repository, out):
    docs = repository / "docs"
    pages = {repository / name: Path(page) for name, page in ROOT_PAGES.items()}
    pages[repository / "README.md"] = Path("index.md")
    pages.update({p: p.relative_to(docs) for p in sorted(docs.rglob("*")) if p.suffix in PICTURES | {".md"}})
    places = {str(path): place for path, place in pages.items()}

    def fitted(document, text):
        def link(match):
            whole, before, label, target = match[0], match[1], match[2], match[3]
            path, _, anchor = target.partition("#")
            if not path or re.match(r"\w+:", target):
                return whole
            place = places.get(os.path.normpath(document.parent / path))
            if place is None:
                return label if not before else ""
            relative = os.path.relpath(place, pages[document].parent)
            return f"{before}[{label}]({relative}{'#' + anchor if anchor else ''})"

        # Fenced blocks and spans of code stay as they are.
        parts = re.split(r"(^```.*?^```|`[^`\n]*`(?![^\[\]\n]*\]\())", text, flags=re.S | re.M)
        return "".join(part if i % 2 else re.sub(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)", link, part)
                       for i, part in enumerate(parts))

    if out.exists():
        shutil.rmtree(out)
    for document, place in pages.items():
        if document.name == "README.md":
            continue  # docs/index.md takes its place
        (out / place).parent.mkdir(parents=True, exist_ok=True)
        if document.suffix == ".md":
            (out / place).write_text(fitted(document, document.read_text(encoding="utf-8")), encoding="utf-8")
        else:
            shutil.copy(document, out / place)

    # A page that its index does not list is still found.
    for index in (out / "index.md", out / "design" / "index.md"):
        listed = set(index.read_text(encoding="utf-8").split())
        others = [p.stem for p in sorted(index.parent.glob("*.md")) if p.stem not in listed | {"index"}]
        if others:
            with index.open("a", encoding="utf-8") as file:
                file.write("\n```{toctree}\n:caption: More\n:maxdepth: 1\n\n" + "\n".join(others) + "\n```\n")

    include = repository / "include" / "meltsim"
    formulas = out / "api" / "physics"
    names = [p.name for p in sorted((include / "physics").glob("*.hpp"))]
    for name in names:
        (formulas / f"{name[:-4]}.md").write_text(
            f"# {name}\n\n`#include \"meltsim/physics/{name}\"`\n\n```{{doxygengroup}} {name[:-4]}\n:members:\n```\n")
    with (formulas / "index.md").open("a", encoding="utf-8") as index:
        index.write("\n```{toctree}\n:maxdepth: 1\n\n" + "\n".join(name[:-4] for name in names) + "\n```\n")

    shown = "".join(p.read_text(encoding="utf-8") for p in (docs / "api").glob("*.md"))
    missing = [p.name for p in sorted(include.glob("*.hpp")) if f"doxygengroup}} {p.stem}\n" not in shown
               and p.name not in ("meltsim.hpp", "export.hpp", "version.hpp")]
    if missing:
        sys.exit(f"no page of docs/api shows {', '.join(missing)}")


stage(Path(sys.argv[1]).resolve(), Path(sys.argv[2]))
