"""A report as a folder: a page whose problems lead to pictures and plans."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from mamo_core.atomic import atomic_path
from mamo_core.plan_file import read_plan
from mamo_core.problems import problem_from_document
from mamo_core.robots import load_arm
from mamo_core.study.analysis import by, ending, namer
from mamo_core.study.export import file_name
from mamo_core.study.problems import DOCUMENT
from mamo_core.study.report_html import html_report
from mamo_core.study.rows import Row
from mamo_core.study.store import Store
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Plan
from mamo_core.view.swept import with_region
from mamo_core.view.topdown import draw

Tell = Callable[[str], None]
_INDEX, _PLANS, _PICTURES = "index.html", "plans", "pictures"


def write_page(store: Store, folder: Path, data: Mapping[str, Any], tell: Tell) -> None:
    """Write ``index.html`` with plans and pictures beside it.

    What an earlier call wrote and is still right is not drawn again.

    Raises:
        InputError: the folder cannot be written.
    """
    for name in (_PLANS, _PICTURES):
        (folder / name).mkdir(parents=True, exist_ok=True)
    rows = store.rows()
    links = _Linker(store, folder, tell).links(rows)
    with atomic_path(folder / _INDEX) as work:
        work.write_text(html_report(data, _problems(rows, links)), encoding="utf-8")


@dataclass(frozen=True)
class Links:
    """Files of a row, relative to the page; None where there is none."""

    picture: str | None
    plan: str | None


class _Linker:
    """Writes the files of rows."""

    def __init__(self, store: Store, folder: Path, tell: Tell) -> None:
        self._store, self._folder, self._tell = store, folder, tell
        self._plans = dict(store.plans())

    def links(self, rows: Sequence[Row]) -> dict[str, Links]:
        """The files of each row, by its key."""
        found = {}
        for number, row in enumerate(rows, 1):
            self._tell(f"plan and picture {number} of {len(rows)}: {row.set_name}#{row.problem_id}")
            found[row.key] = self._links(row)
        return found

    def _links(self, row: Row) -> Links:
        if row.key not in self._plans:
            return Links(self._problem(row), None)
        plan = f"{_PLANS}/{file_name(row)}.json"
        picture = f"{_PICTURES}/{file_name(row)}.png"
        is_new = self._write(plan, zlib.decompress(self._plans[row.key]))
        if is_new or not (self._folder / picture).exists():
            document = read_plan(self._folder / plan)
            problem = document.problem
            drawn = with_region(problem, document.plan, load_arm(problem.scene.robot))
            self._draw(picture, problem, drawn)
        return Links(picture, plan)

    def _problem(self, row: Row) -> str | None:
        """A picture of the problem alone, named by its content."""
        picture = f"{_PICTURES}/problem_{row.problem[:16]}.png"
        if not (self._folder / picture).exists():
            document = self._store.fact(DOCUMENT, row.problem)
            if document is None:  # the store is older than this page
                return None
            self._draw(picture, problem_from_document(document, row.problem_id), None)
        return picture

    def _draw(self, picture: str, problem: Problem, plan: Plan | None) -> None:
        with atomic_path(self._folder / picture) as work:
            draw(problem, work, plan=plan)

    def _write(self, name: str, text: bytes) -> bool:
        """Whether the file was not there like that already."""
        path = self._folder / name
        if path.exists() and path.read_bytes() == text:
            return False
        with atomic_path(path) as work:
            work.write_bytes(text)
        return True


def _problems(rows: Sequence[Row], links: Mapping[str, Links]) -> str:
    """A table: a line for each problem and seed, a column for each planner."""
    planner_of = namer(rows)
    planners = list(by(rows, planner_of))
    several = len({row.seed for row in rows}) > 1
    head = "".join(f"<th>{escape(name)}</th>" for name in ("problem", "class", *planners))
    lines = []
    for of in by(rows, lambda row: f"{row.set_name}#{row.problem_id} {row.seed}").values():
        first = of[0]
        name = f"{first.set_name}#{first.problem_id}" + (f", seed {first.seed}" if several else "")
        cells = {planner_of(row): _cell(row, links[row.key]) for row in of}
        shown = "".join(f"<td>{cells.get(planner, '')}</td>" for planner in planners)
        lines.append(f"<tr><td>{escape(name)}</td><td>{escape(first.level)}</td>{shown}</tr>")
    words = "Seconds lead to the picture; <i>plan</i> is a file for <code>mamo view</code>."
    body = "\n".join(lines)
    return f"<h2>Problems</h2>\n<p>{words}</p>\n<table><tr>{head}</tr>\n{body}</table>"


def _cell(row: Row, links: Links) -> str:
    """Seconds, or how it ended, and where to look."""
    words = f"{row.cpu_s:.2f} s" if row.succeeded else ending(row).replace("_", " ")
    kind = "good" if row.succeeded else "bad"
    shown = f'<span class="{kind}">{escape(words)}</span>'
    if links.picture is not None:
        hint = escape(_hint(row), quote=True)
        shown = f'<a href="{escape(links.picture, quote=True)}" title="{hint}">{shown}</a>'
    if links.plan is not None:
        shown += f' <a href="{escape(links.plan, quote=True)}"><i>plan</i></a>'
    return shown


def _hint(row: Row) -> str:
    """What a reader wants to know before following the link."""
    if row.succeeded:
        return f"{row.actions} actions, {row.rollouts} rollouts"
    most = sorted(row.causes.items(), key=lambda item: (-item[1], item[0]))[:3]
    return "; ".join(_words(row.reason, most))


def _words(reason: str, causes: Iterable[tuple[str, int]]) -> Iterable[str]:
    if reason:
        yield reason
    yield from (f"{cause}: {times}" for cause, times in causes)
