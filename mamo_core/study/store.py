"""The store of a study: one SQLite file, written by one process, complete at every moment.

A finished task is one transaction; its key is the primary key, so that no task counts twice.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from mamo_core.errors import InputError
from mamo_core.study.lock import StoreLock
from mamo_core.study.rows import COLUMNS, FAILED, Row, from_columns, to_columns
from mamo_core.study.tasks import Task

APPLICATION = 0x6D616D6F  # "mamo"
VERSION = 1
_TASK = tuple(item.name for item in fields(Task))
_SCHEMA = f"""
CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE facts (kind TEXT, subject TEXT, code TEXT, value TEXT, PRIMARY KEY (kind, subject));
CREATE TABLE tasks (place INTEGER PRIMARY KEY, {", ".join(_TASK)});
CREATE TABLE results (key TEXT PRIMARY KEY, {", ".join(COLUMNS[1:])});
CREATE TABLE attempts (key TEXT, status TEXT, finished TEXT, retry INTEGER);
CREATE TABLE plans (key TEXT PRIMARY KEY, text BLOB NOT NULL);
CREATE INDEX results_by_subject ON results (subject);
PRAGMA application_id = {APPLICATION};
PRAGMA user_version = {VERSION};
"""


class Store:
    """Reads, and if opened for it writes, the file of a study."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection, self.path = connection, path
        connection.row_factory = sqlite3.Row

    def about(self, name: str) -> str | None:
        """A remark on the study as a whole."""
        found = self._one("SELECT value FROM about WHERE name = ?", name)
        return None if found is None else str(found)

    def set_about(self, **remarks: str) -> None:
        with self._connection:
            self._connection.executemany("REPLACE INTO about VALUES (?, ?)", remarks.items())

    def fact(self, kind: str, subject: str, code: str | None = None) -> Any:
        """What was found out about something, with that code if one is given; None if nothing."""
        words = "SELECT value FROM facts WHERE kind = ? AND subject = ?"
        if code is not None:
            found = self._one(f"{words} AND code = ?", kind, subject, code)
        else:
            found = self._one(words, kind, subject)
        return None if found is None else json.loads(found)

    def set_fact(self, kind: str, subject: str, code: str, value: Any) -> None:
        with self._connection:
            self._connection.execute(
                "REPLACE INTO facts VALUES (?, ?, ?, ?)", (kind, subject, code, json.dumps(value))
            )

    def set_tasks(self, tasks: Iterable[Task]) -> None:
        """Replace the list of tasks; finished rows stay."""
        with self._connection:
            self._connection.execute("DELETE FROM tasks")
            marks = ", ".join("?" * len(_TASK))
            self._connection.executemany(
                f"INSERT INTO tasks ({', '.join(_TASK)}) VALUES ({marks})",
                (astuple(task) for task in tasks),
            )

    def tasks(self) -> list[Task]:
        """The list of tasks, in order."""
        found = self._connection.execute(f"SELECT {', '.join(_TASK)} FROM tasks ORDER BY place")
        return [Task(**dict(item)) for item in found]

    def finish(self, row: Row, plan: bytes | None, *, retry: bool) -> None:
        """Add a row and its plan; with ``retry`` it takes the place of a failed one."""
        data = to_columns(row)
        verb = "REPLACE" if retry else "INSERT OR IGNORE"
        marks = ", ".join(f":{name}" for name in COLUMNS)
        with self._connection:
            self._connection.execute(
                f"{verb} INTO results ({', '.join(COLUMNS)}) VALUES ({marks})", data
            )
            self._connection.execute(
                "INSERT INTO attempts VALUES (:key, :status, :finished, :retry)",
                {**data, "retry": int(retry)},
            )
            if plan is not None:
                self._connection.execute("REPLACE INTO plans VALUES (?, ?)", (row.key, plan))

    def finished(self) -> dict[str, str]:
        """Status by key of all rows."""
        found = self._connection.execute("SELECT key, status FROM results")
        return {item["key"]: item["status"] for item in found}

    def key_of_subject(self, subject: str) -> str | None:
        """The newest row of the same subject, whatever its code."""
        words = "SELECT key FROM results WHERE subject = ? ORDER BY finished DESC LIMIT 1"
        found = self._one(words, subject)
        return None if found is None else str(found)

    def rows(self) -> list[Row]:
        """The finished rows of the list of tasks, in its order and under its names."""
        named = [name for name in _TASK if name not in ("key", "subject")]
        columns = ", ".join(f"{'tasks' if c in named else 'results'}.{c} AS {c}" for c in COLUMNS)
        found = self._connection.execute(
            f"SELECT {columns} FROM tasks JOIN results USING (key) ORDER BY place"
        )
        return [from_columns(dict(item)) for item in found]

    def plans(self) -> Iterator[tuple[str, bytes]]:
        """Key and compressed text of the plans."""
        for item in self._connection.execute("SELECT key, text FROM plans"):
            yield item["key"], item["text"]

    def duplicates(self) -> int:
        """How many tasks were done again although they were finished."""
        words = """
            SELECT coalesce(sum(times - 1), 0) FROM
            (SELECT count(*) AS times FROM attempts WHERE NOT retry GROUP BY key)
        """
        return int(self._one(words))

    def _one(self, words: str, *values: Any) -> Any:
        found = self._connection.execute(words, values).fetchone()
        return None if found is None else found[0]


@contextmanager
def open_store(path: Path) -> Iterator[Store]:
    """The store in a file, to read.

    Raises:
        InputError: no such file, or it is something else.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such store of a study")
    with closing(sqlite3.connect(path)) as connection:
        _check(connection, path)
        connection.execute("PRAGMA query_only = ON")
        yield Store(connection, path)


@contextmanager
def create_store(path: Path) -> Iterator[Store]:
    """The store in a file, to write; made if it is not there. No other process may write to it.

    Raises:
        InputError: another process has it open, the file is something else, or cannot be written.
    """
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"{path}: expected a file in a folder that exists")
    with StoreLock(path), closing(_connect(path)) as connection:
        if _is_new(connection):
            connection.executescript(f"BEGIN; {_SCHEMA} COMMIT;")
        _check(connection, path)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        yield Store(connection, path)


def _connect(path: Path) -> sqlite3.Connection:
    try:
        path.touch()
        return sqlite3.connect(path)
    except (OSError, sqlite3.Error) as error:
        raise InputError(f"{path}: cannot be written: {error}") from None


def _is_new(connection: sqlite3.Connection) -> bool:
    """Whether nothing is in it, be it that an earlier run ended before it wrote anything."""
    try:
        return not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    except sqlite3.DatabaseError:
        return False


def _check(connection: sqlite3.Connection, path: Path) -> None:
    try:
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        version = connection.execute("PRAGMA user_version").fetchone()[0]
    except sqlite3.DatabaseError:
        application, version = 0, 0
    if application != APPLICATION:
        raise InputError(f"{path}: is not the store of a study")
    if version != VERSION:
        raise InputError(f"{path}: store of version {version}, expected {VERSION}")


def is_failed(status: str | None) -> bool:
    """Whether a finished task may be tried again."""
    return status in FAILED
