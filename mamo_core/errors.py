"""Errors a user can mend; the command line prints their text alone and exits with their code."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class MamoError(Exception):
    """Base of all expected failures."""

    exit_code = 1


class InputError(MamoError):
    """Bad usage or input: names the place, the value and the valid set."""

    exit_code = 2


class PluginError(MamoError):
    """A plugin or engine that is needed is missing or broken."""

    exit_code = 5


class WorkerCrashedError(MamoError):
    """A worker process ended before it gave what cannot be done without."""

    exit_code = 6


def suggestion(word: str, valid: Iterable[str]) -> str:
    """``; did you mean 'x'?`` if something in ``valid`` is close, then the valid set."""
    names = sorted(valid)
    close = difflib.get_close_matches(word, names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{hint} (valid: {', '.join(names) or 'none'})"
