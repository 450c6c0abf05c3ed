"""The rows of a study for other programs: CSV, Parquet, OMPL's benchmark logs, plan files."""

from __future__ import annotations

import csv
import re
import zlib
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mamo_core.atomic import atomic_path
from mamo_core.errors import InputError, PluginError
from mamo_core.study.ompl_log import ompl_log
from mamo_core.study.rows import COLUMNS, Row, to_columns
from mamo_core.study.store import Store

_NAMES = {"set_name": "set", "problem_id": "id", "level": "class"}


def write_rows(store: Store, path: Path) -> int:
    """Write the finished rows in the format the ending tells; how many there are.

    Raises:
        InputError: another ending, or it cannot be written.
        PluginError: Parquet, and pyarrow is not installed.
    """
    write = writer_of(path)
    rows = store.rows()
    with atomic_path(path) as work:
        write(rows, store.about("study") or "", work)
    return len(rows)


def writer_of(path: Path) -> Callable[[Sequence[Row], str, Path], None]:
    """The function that writes such a file."""
    if path.suffix not in _WRITERS:
        raise InputError(f"{path}: ending {path.suffix!r} (valid: {', '.join(_WRITERS)})")
    if path.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise PluginError(f"{path}: Parquet needs pyarrow; install it with: pip install pyarrow")
    return _WRITERS[path.suffix]


def write_plans(store: Store, folder: Path) -> int:
    """Write the plans of the finished rows as plan files; how many there are."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = dict(store.plans())
    count = 0
    for row in store.rows():
        if row.key in texts:
            with atomic_path(folder / f"{file_name(row)}.json") as work:
                work.write_bytes(zlib.decompress(texts[row.key]))
            count += 1
    return count


def file_name(row: Row) -> str:
    """A name without ending that tells the row from all others of a study."""
    words = (row.set_name, row.problem_id, row.recipe, row.engine, f"seed{row.seed}")
    return re.sub(r"[^\w.=-]+", "_", "__".join(words))


def _named(row: Row) -> dict[str, Any]:
    """A line of a table; parts, counts and causes are JSON."""
    return {_NAMES.get(name, name): value for name, value in to_columns(row).items()}


def _csv(rows: Sequence[Row], study: str, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [_NAMES.get(name, name) for name in COLUMNS])
        writer.writeheader()
        writer.writerows(_named(row) for row in rows)


def _parquet(rows: Sequence[Row], study: str, path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    lines = [{**_named(row), "verified": row.verified} for row in rows]
    parquet.write_table(pyarrow.Table.from_pylist(lines), path)


def _log(rows: Sequence[Row], study: str, path: Path) -> None:
    path.write_text(ompl_log(study, rows), encoding="utf-8")


_WRITERS = {".csv": _csv, ".parquet": _parquet, ".log": _log}
