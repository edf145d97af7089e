"""Configuration of the documentation site; `python -m sphinx -W --keep-going -b html docs build/docs` builds it."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The extensions of the site, the package and the environments are read from this checkout.
sys.path[:0] = [str(ROOT / "docs" / "_ext"), str(ROOT), str(ROOT / "envs")]

import sjasim  # noqa: E402

project = "sjasim"
author = "The sjasim developers"
copyright = "The sjasim developers, Apache-2.0"
release = version = sjasim.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "command_help",
    "native_math",
    "room_pages",
]
exclude_patterns = ["_ext", "examples"]
# Two modules may define the same private name; a link in a signature then leads to the first.
suppress_warnings = ["ref.python"]

html_theme = "furo"
html_math_renderer = "mathml"
html_title = f"sjasim {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}

myst_enable_extensions = ["deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

# Names between single backticks in docstrings become links where the name is known, and stay code elsewhere.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
# The short names of array types say more than what they stand for.
autodoc_type_aliases = {name: name for name in ("Array", "BoolArray", "IntArray")}
python_maximum_signature_line_length = 88
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
