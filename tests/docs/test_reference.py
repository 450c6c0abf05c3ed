"""The generated pages say what the code says."""

import re

import pytest

from mamo_core.cli import main, plan_report
from mamo_core.errors import InputError, PluginError, WorkerCrashedError


@pytest.fixture(scope="module")
def reference():
    import reference

    return reference


def test_committed_pages_are_up_to_date(reference, tmp_path):
    reference.write_pages(tmp_path)
    written = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()}
    committed = {p.name: p.read_text(encoding="utf-8") for p in reference.FOLDER.iterdir()}
    assert written == committed, "run: make reference"


def test_nothing_is_left_without_a_meaning(reference):
    for name in ("options.md", "files.md"):
        assert not re.findall(r"^\| `.*\| \|$", reference.PAGES[name](), re.MULTILINE), name


def test_a_new_option_appears(reference, monkeypatch):
    """The pages are made from what is registered, not from a list of their own."""
    from pydantic import Field
    from reference_pages import options

    from mamo_core.hookspecs import Component, Options, hookimpl
    from mamo_core.plugins import make_registry

    class Inner(Options):
        depth: float = Field(0.5, gt=0.0, description="how deep, m")

    class Shown(Options):
        inner: Inner | None = Field(None, description="more ``of it``")

    class Plugin:
        @hookimpl
        def mamo_actions(self):
            return [
                Component(
                    "nudge", lambda context, options: None, Shown, "nudges | and more", extra="view"
                )
            ]

    registry = make_registry([("own", Plugin)])
    monkeypatch.setattr(options, "own_registry", lambda: registry)
    page = options.options_page()
    assert "### `nudge`\n\nNudges | and more. Installed by `pip install 'mamo[view]'`." in page
    assert "| `inner` | mapping or null | `null` | more `of it` |" in page
    assert "| `inner.depth` | number > 0 | `0.5` | how deep, m |" in page


def test_exit_codes_are_those_of_the_code(reference):
    page = (reference.FOLDER.parent / "reference_cli.md").read_text(encoding="utf-8")
    told = {int(code) for code in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)}
    assert told == {
        0,
        main.INTERNAL_ERROR,
        main.INTERRUPTED,
        plan_report.NO_PLAN,
        plan_report.NOT_VERIFIED,
        *(error.exit_code for error in (InputError, PluginError, WorkerCrashedError)),
    }
