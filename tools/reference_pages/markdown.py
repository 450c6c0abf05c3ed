"""Pieces of Markdown."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from typing import Any

NOTE = "*Written by `make reference` from the code; edit that instead.*"


def page(title: str, *parts: str) -> str:
    """A page that says that it is generated."""
    return "\n\n".join([f"# {title}", NOTE, *parts]) + "\n"


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; bars within cells are escaped."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(map(_cell, line))} |".replace("|  |", "| |") for line in lines)


def prose(text: str) -> str:
    """A docstring's text as Markdown."""
    return re.sub(r"``([^`]+)``", r"`\1`", text)


def summary(thing: Any) -> str:
    """The first paragraph of a docstring, on one line."""
    return prose(" ".join((inspect.getdoc(thing) or "").partition("\n\n")[0].split()))


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
