"""Results go to stdout; progress and warnings go to stderr."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mamo_core.interfaces.search_strategy import ProgressCallback
    from mamo_core.plugins import Registry

SCHEMA_VERSION = 1


def print_json(command: str, result: Mapping[str, Any]) -> None:
    """The one JSON document of a command."""
    document = {"schema_version": SCHEMA_VERSION, "command": command, **result}
    sys.stdout.write(json.dumps(document, indent=2, allow_nan=False) + "\n")


def print_table(
    title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], *, right: int | None = None
) -> None:
    """A table on stdout; ``right``: the column with numbers, aligned right."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", box=None, pad_edge=False, padding=(0, 2))
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i == right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))  # Text: brackets in names are no markup
    width = None if sys.stdout.isatty() else 200
    Console(file=sys.stdout, width=width, highlight=False).print(table)


def warn(text: str) -> None:
    """A line on stderr that something is not as it should be."""
    print(f"warning: {text}", file=sys.stderr)


def warn_of_broken_plugins(registry: Registry) -> None:
    """A line for every plugin that is disabled."""
    for broken in registry.problems:
        warn(str(broken))


@contextmanager
def progress() -> Iterator[ProgressCallback]:
    """Shows what is being done: one live line on a terminal, a line each otherwise."""
    started = time.monotonic()
    if not sys.stderr.isatty():
        yield lambda text: print(f"[{time.monotonic() - started:6.1f} s] {text}", file=sys.stderr)
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("starting") as status:
        yield lambda text: status.update(f"{time.monotonic() - started:5.1f} s  {escape(text)}")
