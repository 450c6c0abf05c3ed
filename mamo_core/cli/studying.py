"""The work behind ``mamo study``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from mamo_core.atomic import check_folder, check_writable
from mamo_core.cli.output import print_json, print_table, progress, warn_of_broken_plugins
from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.study.run import StudyOrder, run_study
from mamo_core.study.split import Split
from mamo_core.study.status import status_of
from mamo_core.study.store import Store, open_store

_COUNTS = ("total", "done", "pending", "failed", "solved", "verified")


def run_run(order: StudyOrder, *, as_json: bool) -> None:
    """Do what is left, then print the status."""
    warn_of_broken_plugins(discover())
    with progress() as tell:
        status = run_study(order, tell)
    _print_status("study run", status, as_json=as_json)


def run_status(path: Path, *, as_json: bool) -> None:
    """Print how far it is."""
    with open_store(path) as store:
        _print_status("study status", status_of(store), as_json=as_json)


def _print_status(command: str, status: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        print_json(command, status)
        return
    lines = [*status["by_recipe"], {"recipe": "all", **status}]
    print_table(
        f"{status['study']}: {status['store']}",
        ("recipe", *_COUNTS),
        ([line["recipe"], *(str(line[name]) for name in _COUNTS)] for line in lines),
    )


def run_report(
    path: Path,
    output: Path | None,
    page: Path | None,
    against: tuple[str, ...],
    split: tuple[str | None, float | None],
    *,
    as_json: bool,
) -> None:
    """Print the report, or write it."""
    from mamo_core.study.report import check_ending, report_data, report_text, write_report

    chosen = _split(*split)
    if output is not None:
        check_ending(output)
        check_writable(output)
    if page is not None:
        check_folder(page)
    with open_store(path) as store:
        data = report_data(store, against, chosen)
        if page is not None:
            _write_page(store, page, data)
    if output is not None:
        write_report(data, output)
    if as_json:
        print_json("study report", data)
    elif output is None and page is None:
        sys.stdout.write(report_text(data, ".md"))


def _split(recipe: str | None, seconds: float | None) -> Split | None:
    """What ``--split-by`` and ``--seconds`` ask for."""
    if recipe is not None:
        return Split(recipe) if seconds is None else Split(recipe, seconds)
    if seconds is not None:
        raise InputError(f"--seconds {seconds:g}: is for --split-by, which is not given")
    return None


def _write_page(store: Store, page: Path, data: dict[str, Any]) -> None:
    from mamo_core.study.page import write_page

    with progress() as tell:
        write_page(store, page, data, tell)


def run_export(path: Path, output: Path | None, plans: Path | None) -> None:
    """Write the rows, or the plans, or both."""
    from mamo_core.study.export import write_plans, write_rows, writer_of

    if output is None and plans is None:
        raise InputError("nothing to export: expected -o FILE or --plans FOLDER")
    if output is not None:
        writer_of(output)
        check_writable(output)
    with open_store(path) as store:
        if output is not None:
            print(f"{write_rows(store, output)} rows in {output}")
        if plans is not None:
            print(f"{write_plans(store, plans)} plans in {plans}")
