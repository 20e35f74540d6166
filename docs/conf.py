"""How Sphinx builds the documentation: ``python tools/check.py docs``."""

from __future__ import annotations

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

project = "graphnav"
author = "the graphnav authors"
copyright = author  # noqa: A001  # the name that Sphinx reads

extensions = ["myst_parser", "sphinx_external_toc"]
external_toc_path = "_toc.yml"
exclude_patterns = ["_build"]

myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]

html_theme = "furo"
html_title = "graphnav"
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_copy_source = False
html_math_renderer = "mathml"


def setup(app: Sphinx) -> None:
    """Write equations as MathML, which browsers show without a script from the network."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(convert(node.astext().replace(r"\tag", r"\qquad\tag"), display="block"))
    raise nodes.SkipNode
