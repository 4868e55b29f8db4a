"""Configuration of Sphinx for this documentation."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import geodesic_toolkit as gt

project = "Geodesic Toolkit"
author = "The geodesic-toolkit developers"
copyright = author
version = release = gt.__version__

extensions = [
    "constants",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "command_help",
    "mathml",
]
exclude_patterns = ["_build", "_tables", "examples", "**/*.part.md"]
nitpicky = True
# References into other projects stay plain text unless their inventories are there: see below.
nitpick_ignore_regex = [("py:.*", r"(?!geodesic_toolkit).*")]

# Other projects' inventories are on the network, and a build must not depend on that.
if os.environ.get("GEODESIC_DOCS_INTERSPHINX"):
    extensions.append("sphinx.ext.intersphinx")
    intersphinx_mapping = {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
    }

# -- the API -----------------------------------------------------------------------------------

autosummary_generate = True
autosummary_ignore_module_all = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings say it for people, signatures in the source for tools
autodoc_preserve_defaults = True
numpydoc_show_class_members = False  # the class template lists them
numpydoc_class_members_toctree = False

# -- pages -------------------------------------------------------------------------------------

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
html_math_renderer = "mathml"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# -- the gallery: scripts that are executed, and whose failure fails the build --------------------

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"plot_",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "capture_repr": (),
    "show_signature": False,
    "min_reported_time": 3600,
    "write_computation_times": False,
    "remove_config_comments": True,
    "image_srcset": ["2x"],
    "backreferences_dir": None,
}

# -- how it looks ------------------------------------------------------------------------------

templates_path = ["_templates"]
html_theme = "pydata_sphinx_theme"
html_title = "Geodesic Toolkit"
html_static_path = ["_static"]
html_css_files = ["calm.css"]
html_show_sourcelink = False
html_sidebars = {
    "getting_started": [],
    "why": [],
    "choosing": [],
    "faq": [],
    "glossary": [],
    "reliability": [],
    "mathematics": [],
    "accuracy": [],
    "performance": [],
    "study": [],
    "changelog": [],
}
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "pygments_light_style": "tango",
    "pygments_dark_style": "monokai",
}


# -- bases of a class: pages link public ones, and list the members of the others ----------------

PUBLIC = {
    getattr(space, name): f"geodesic_toolkit.{prefix}{name}"
    for space, prefix in ((gt, ""), (gt.errors, "errors."))
    for name in space.__all__
    if isinstance(getattr(space, name), type)
}


def public_bases(kind):
    """Return the bases of a class that have a page of their own."""
    return [base for base in kind.__bases__ if base in PUBLIC]


def has_private_bases(kind):
    """Return whether members of a class are defined in a base of this package without a page."""
    home = [base for base in kind.__mro__[1:] if base.__module__.startswith("geodesic_toolkit.")]
    return any(
        base not in PUBLIC and "geodesic_toolkit.core." not in base.__module__ for base in home
    )


def show_public_bases(_app, _name, kind, _options, bases):
    """Leave the other bases out of the line that names them."""
    bases[:] = public_bases(kind)


autosummary_context = {
    "derived": [name for kind, name in PUBLIC.items() if public_bases(kind)],
    "composed": [name for kind, name in PUBLIC.items() if has_private_bases(kind)],
}


def setup(app):
    """Connect to Sphinx."""
    app.connect("autodoc-process-bases", show_public_bases)
