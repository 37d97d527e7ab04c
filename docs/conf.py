"""The site: `make docs` builds these pages and the reference from docstrings into build/site, warnings being errors."""

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
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "sphinx.ext.viewcode"]
exclude_patterns = ["data/**", "duties/**", "studies/**"]

# links between pages and to headings are those of GitHub, and checked
myst_heading_anchors = 4
nitpicky = True
#: what annotations name without a page of its own
nitpick_ignore_regex = [
    ("py:.*", r"(pathlib|collections|numpy|np|typing|casadi|ca|abc|enum|fmu_src|hoist_demo)\b.*"),
    ("py:.*", r"(Path|Array|NDArray|Any|Iterable|Form|Level|Fidelity|FidelityChoice|MeshKind|SwivelMode)"),
    ("py:.*", r"rope_model\.(simulation|native|numerics|physics|parameters)\..*"),
]

# docstrings follow numpydoc
numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True, "show-inheritance": True}

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"{project} {release}"
html_copy_source = False
html_show_sourcelink = False
