"""Reports of a store: Markdown, HTML or JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mamo_core.atomic import atomic_path
from mamo_core.errors import InputError, suggestion
from mamo_core.study.analysis import Subject, analyse
from mamo_core.study.report_markdown import markdown_report
from mamo_core.study.split import Split, split_by_time
from mamo_core.study.store import Store

ENDINGS = (".md", ".html", ".json")


def report_data(
    store: Store, against: Sequence[str] = (), split: Split | None = None
) -> dict[str, Any]:
    """Everything a report says; recipes are compared with those of ``against``.

    With none of these, with the study's baseline. ``split``: classes by the time a recipe took.

    Raises:
        InputError: nothing is finished, or there is no such recipe.
    """
    rows = store.rows()
    if not rows:
        raise InputError(f"{store.path}: no task is finished yet")
    recipes = dict.fromkeys(row.recipe for row in rows)
    asked = [("--against", name) for name in against]
    for option, name in [*asked, *([("--split-by", split.recipe)] if split else [])]:
        if name not in recipes:
            raise InputError(f"{option}: no recipe {name!r}{suggestion(name, recipes)}")
    if split is not None:
        rows = split_by_time(rows, split)
    subject = Subject(
        study=store.about("study") or "",
        total=len(store.tasks()),
        budget=float(store.about("budget") or 0.0),
        baselines=tuple(against) or (store.about("baseline") or "",),
    )
    return analyse(subject, rows)


def check_ending(path: Path) -> None:
    """Refuse a file whose format is not known."""
    if path.suffix not in ENDINGS:
        raise InputError(f"{path}: ending {path.suffix!r} (valid: {', '.join(ENDINGS)})")


def write_report(data: Mapping[str, Any], path: Path) -> None:
    """Write the report in the format its ending tells."""
    check_ending(path)
    with atomic_path(path) as work:
        work.write_text(report_text(data, path.suffix), encoding="utf-8")


def report_text(data: Mapping[str, Any], ending: str) -> str:
    """The report in the format of an ending."""
    if ending == ".json":
        return json.dumps({"schema_version": 1, **data}, indent=1, allow_nan=False) + "\n"
    if ending == ".html":
        from mamo_core.study.report_html import html_report

        return html_report(data)
    return markdown_report(data)
