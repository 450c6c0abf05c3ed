"""How Sphinx builds the site: ``make docs``."""

from typing import Any

project = "mamo"
extensions = ["myst_parser"]
exclude_patterns = ["conf.py"]
nitpicky = True

myst_heading_anchors = 4  # as on GitHub

html_theme = "furo"
html_title = "mamo"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_copyright = False
pygments_dark_style = "monokai"

NAVIGATION = {
    "Tutorials": ("start", "write_a_plugin"),
    "How to": (
        *("look_at_plans", "compose_a_planner", "write_a_backend", "compare_engines", "studies"),
        "when_no_plan_is_found",
    ),
    "Reference": (
        *("reference_cli", "planners", "workspaces", "conventions"),
        *("reference/options", "reference/files", "reference/hooks", "reference/interfaces"),
    ),
    "Explanation": ("how_a_plan_comes_about", "relation_to_the_thesis", "architecture"),
    "Results": ("benchmarks", "backends", "results/*"),
    "Decisions": ("decisions/*",),
}


def add_navigation(app: Any, page: str, source: list[str]) -> None:
    """Put the table of contents below the start page; in its file GitHub would show raw text."""
    if page == "index":
        source[0] += "".join(map(_toctree, NAVIGATION.items()))


def _toctree(part: tuple[str, tuple[str, ...]]) -> str:
    caption, pages = part
    lines = "\n".join(pages)
    return f"\n```{{toctree}}\n:hidden:\n:glob:\n:caption: {caption}\n\n{lines}\n```\n"


def setup(app: Any) -> None:
    app.connect("source-read", add_navigation)
