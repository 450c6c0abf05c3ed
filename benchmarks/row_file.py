"""Rows of a benchmark, kept in a file after every problem."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from mamo_core.atomic import atomic_path, check_writable
from mamo_core.errors import InputError
from mamo_core.plan_file import package_versions
from mamo_core.recipes import LoadedRecipe
from mamo_core.study.code import code_version

Row = dict[str, Any]
SCHEMA_VERSION = 1


def identity(recipe: LoadedRecipe, budget: float, seed: int) -> dict[str, Any]:
    """What must be the same for two rows to belong into one table."""
    return {"recipe": recipe.data, "budget_s": budget, "seed": seed}


class RowFile:
    """Rows in memory and, with a path, in a JSON file that is always complete."""

    def __init__(self, path: Path | None, arguments: dict[str, Any]) -> None:
        self._path, self._arguments = path, arguments
        self._code = code_version()
        self.rows: list[Row] = []

    def load(self, *, fresh: bool = False) -> None:
        """Take over the rows of an interrupted run with the same arguments.

        Raises:
            InputError: the file holds something else, or cannot be written.
        """
        if self._path is None:
            return
        check_writable(self._path)
        if fresh or not self._path.exists():
            return
        try:
            document = json.loads(self._path.read_text(encoding="utf-8"))
            arguments, rows = document["arguments"], document["rows"]
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{self._path}: not a result of this benchmark") from error
        if arguments != self._arguments:
            raise InputError(
                f"{self._path}: holds rows of another recipe, budget or seed; "
                "choose another file or add --fresh"
            )
        self.rows = list(rows)
        self._tell_kept()

    def _tell_kept(self) -> None:
        print(f"{len(self.rows)} finished rows kept from {self._path}", file=sys.stderr)
        others = {row["code"] for row in self.rows} - {self._code}
        if others:
            print(f"warning: some are of other code: {', '.join(sorted(others))}", file=sys.stderr)

    def find(self, key: tuple[str, str]) -> Row | None:
        """The row of a problem, given as set and id."""
        return next((row for row in self.rows if (row["set"], row["id"]) == key), None)

    def add(self, row: Row) -> None:
        """Append a row and write the file."""
        self.rows.append({**row, "code": self._code})
        if self._path is None:
            return
        document = {
            "schema_version": SCHEMA_VERSION,
            "arguments": self._arguments,
            "versions": package_versions(),
            "rows": self.rows,
        }
        with atomic_path(self._path) as work:
            work.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
