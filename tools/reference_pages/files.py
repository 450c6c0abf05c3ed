"""The page of file formats."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from inspect import getdoc
from pathlib import Path

from mamo_core.plan_schema import PlanFile
from mamo_core.problems.schema import ProblemDocument
from mamo_core.recipes import Recipe
from mamo_core.recording import write_recording
from mamo_core.study.rows import Row
from mamo_core.study.schema import StudyFile
from mamo_core.study.store import create_store
from mamo_core.types.recording import RecordedExecution, Recording
from reference_pages.fields import sections
from reference_pages.markdown import page, prose, table

INTRODUCTION = """\
Files that people write are YAML 1.2 or JSON; unknown keys are refused. `mamo schema` prints the
same as JSON schemas, which editors understand."""

PART = """\
A part is the name of a component, or a mapping of `name` and its [options](options.md)."""

RECORDING = """\
What `mamo view -o` and `mamo compare --trace` write, to be read by
`mamo_core.recording.read_recording` or by NumPy alone."""

STORE = """\
What `mamo study run` writes: one SQLite file with these tables. [How to run a
study](../studies.md#the-store) tells what a row depends on; `mamo study export` writes rows for
other programs."""


def files_page() -> str:
    """Every kind of file."""
    return page(
        "File formats",
        INTRODUCTION,
        *("## Recipe", sections(Recipe), PART),
        *("## Problem", sections(ProblemDocument)),
        *("## Study", sections(StudyFile)),
        *("## Plan", sections(PlanFile)),
        *("## Recording", RECORDING, _text(write_recording).partition("\n\nRaises:")[0]),
        *(_text(thing) for thing in (Recording, RecordedExecution)),
        *("## Store of a study", STORE, table(("table", "columns"), _tables())),
        *("A row of `results` is:", _text(Row)),
    )


def _text(thing: object) -> str:
    return prose(getdoc(thing) or "")


def _tables() -> Iterator[tuple[str, str]]:
    """The tables of a new store."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "new.db"
        with create_store(path):
            pass
        with closing(sqlite3.connect(path)) as connection:
            found = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
            for (name,) in found.fetchall():
                columns = connection.execute(f"PRAGMA table_info({name})").fetchall()
                yield f"`{name}`", ", ".join(f"`{column[1]}`" for column in columns)
