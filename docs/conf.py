"""The site: ``make docs`` builds pages and reference into build/site, warnings being errors."""

import importlib.metadata
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = PROJECT["name"]
author = project_copyright = "the balance-rope authors"
release = version = PROJECT["version"]
highlight_language = "none"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
]
exclude_patterns = ["data/**", "drawings/**", "duties/**", "studies/**"]

# links between pages and to headings are those of GitHub, and checked
myst_heading_anchors = 4
nitpicky = True

# mathematics: MathJax (Apache-2.0) is a file of the site, so that pages render without network
myst_enable_extensions = ["dollarmath", "amsmath"]
numfig = True  # equations are numbered by chapter
MATHJAX = importlib.metadata.distribution("sphinx-mathjax-offline")
mathjax_path = "tex-svg-full.js"
mathjax3_config = {"options": {"enableMenu": False}}

#: types in annotations that have no page
nitpick_ignore_regex = [
    (
        "py:.*",
        r"(pathlib|collections|numpy|np|scipy|typing|casadi|ca|abc|enum|fmu_src|hoist_demo)\b.*",
    ),
    ("py:.*", r"[A-Z]\w*"),
    (
        "py:.*",
        r"rope_model\.(analysis|codegen|engine|physics|rules|parameters|solver_parameters|parameter_table)\..*",
    ),
]

# docstrings follow numpydoc
numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "show-inheritance": True}

html_theme = "furo"
html_static_path = [
    "_static",
    str(MATHJAX.locate_file(f"sphinx-mathjax-offline/static/mathjax/{mathjax_path}")),
]
html_css_files = ["site.css"]
html_title = f"{project} {release}"
html_copy_source = False
html_show_sourcelink = False
