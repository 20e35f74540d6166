"""How Sphinx builds the documentation: ``python tools/check.py docs``."""


project = "graphnav"
author = "the graphnav authors"
copyright = author  # noqa: A001  # the name that Sphinx reads

extensions = ["myst_parser", "sphinx_external_toc"]
external_toc_path = "_toc.yml"
exclude_patterns = ["_build", "notebook.ipynb"]
suppress_warnings = ["etoc.toctree"]
nitpicky = True

myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_links_external_new_tab = False

html_theme = "furo"
html_title = "graphnav"
html_copy_source = False
html_show_sphinx = False
