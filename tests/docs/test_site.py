"""The site builds without a warning, and needs nothing from elsewhere to be read."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going"]
    cache = ["-d", str(folder / "cache")]
    done = subprocess.run(
        [*build, *cache, str(ROOT / "docs"), str(folder / "site")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "site"


def test_every_page_is_built_and_in_the_table_of_contents(site):
    start = (site / "index.html").read_text(encoding="utf-8")
    linked = set(re.findall(r'<a class="reference internal" href="([^"#]+)"', start))
    for page in (ROOT / "docs").rglob("*.md"):
        name = page.relative_to(ROOT / "docs").with_suffix(".html").as_posix()
        assert (site / name).is_file()
        assert name in linked or name == "index.html"


def test_nothing_is_loaded_from_elsewhere(site):
    loaded = r'<(?:script|img|iframe)[^>]+src="(?:https?:)?//|<link[^>]+href="(?:https?:)?//'
    for page in site.rglob("*.html"):
        assert not re.search(loaded, page.read_text(encoding="utf-8")), page
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(?:url\(['\"]?|@import ['\"])(?:https?:)?//", text), style
