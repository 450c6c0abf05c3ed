"""The site builds without a warning, and needs nothing from elsewhere to be read."""

import re
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_the_site_is_whole_and_stands_alone(tmp_path):
    site = tmp_path / "site"
    build = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going"]
    done = subprocess.run(
        [*build, "-d", str(tmp_path / "cache"), str(DOCS), str(site)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert pages_that_are_missing(site) == []
    assert pages_that_load_from_elsewhere(site) == []


def pages_that_are_missing(site):
    """Not built, or not in the table of contents."""
    start = (site / "index.html").read_text(encoding="utf-8")
    listed = {"index.html", *re.findall(r'<a class="reference internal" href="([^"#]+)"', start)}
    names = [page.relative_to(DOCS).with_suffix(".html").as_posix() for page in DOCS.rglob("*.md")]
    return [name for name in names if name not in listed or not (site / name).is_file()]


def pages_that_load_from_elsewhere(site):
    """Those with scripts, styles, fonts or pictures of other machines; links are no loads."""
    page = r'<(?:script|img|iframe)[^>]+src="(?:https?:)?//|<link[^>]+href="(?:https?:)?//'
    style = r"""(?:url\(["']?|@import ["'])(?:https?:)?//"""
    return [
        path.name
        for pattern, ending in ((page, "*.html"), (style, "*.css"))
        for path in site.rglob(ending)
        if re.search(pattern, path.read_text(encoding="utf-8"))
    ]
