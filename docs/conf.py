"""Sphinx: the documentation as a site. `make docs` builds it into docs/_build/html; warnings are errors."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from write_examples import write_examples  # noqa: E402
from write_reference import write_reference  # noqa: E402

write_reference(Path(__file__).parent / "reference" / "generated")
write_examples(Path(__file__).parent / "tutorial" / "generated")  # runs them: 20 s

project, author = "updamp", "updamp contributors"
version = release = version_of("updamp")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
# Links into the repository are checked by tests/test_docs.py; diagrams (mermaid) are shown as text here.
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
html_theme = "pydata_sphinx_theme"
html_title = "updamp"
html_theme_options = {"navigation_with_keys": False, "show_prev_next": True, "secondary_sidebar_items": ["page-toc"]}


def as_they_stand(app, kind, name, thing, options, lines):  # noqa: ARG001
    """Docstrings of this project: a first paragraph, then lines of "name: what it is", which keep their line ends."""
    end = lines.index("") if "" in lines else len(lines)
    if any(line.startswith(" ") for line in lines[:end]):  # there is none but lines
        end = 0
    lines[end:] = [f"| {line}" if line.strip() else "" for line in lines[end:]]


def setup(app):
    app.connect("autodoc-process-docstring", as_they_stand)
