"""What was gathered: JSON lines that a run which was ended anywhere goes on with.

The first line holds the settings. Then comes, for every problem, a line that says how many
rearrangements were found, and one for each of these.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any

from mamo_core.errors import InputError
from mamo_planners.search.features import Features

SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Settings:
    """What decides which rearrangements are gathered, and how they are labelled.

    Problem i is generated with seed ``seed`` + i; ``movables`` and ``levels`` take turns.
    ``expansions`` of a vertex and ``visits`` of a graph: work of the breadth-first search.
    ``attempt``: visits of the depth-first search that says whether a rearrangement is solvable.
    ``budget``: CPU seconds, after which any search is stopped.
    """

    seed: int
    movables: tuple[int, ...]
    levels: tuple[str, ...]
    expansions: int
    visits: int
    attempt: int
    budget: float


@dataclass(frozen=True)
class Explored:
    """A problem, by its seed; ``vertices``: how many rearrangements were found.

    ``cut``: its budget, and not its work, was used up. ``left_out``: why it could not be generated.
    """

    problem: int
    name: str
    vertices: int
    cut: bool = False
    left_out: str = ""


@dataclass(frozen=True)
class Point:
    """A rearrangement: number ``vertex`` of the graph of a ``problem`` (its seed).

    ``actions``: how many led to it. ``solved``: whether the depth-first search found a plan from
    it. ``cut``: it did not, because its budget, and not its work, was used up.
    """

    problem: int
    vertex: int
    actions: int
    features: Features
    solved: bool
    cut: bool = False


@dataclass
class Data:
    """What a file holds; what is added is written at once."""

    path: Path
    explored: dict[int, Explored] = field(default_factory=dict)
    points: dict[tuple[int, int], Point] = field(default_factory=dict)
    _file: IO[bytes] | None = None

    def complete(self, problem: int) -> bool:
        """Whether nothing is left to do for a problem."""
        known = self.explored.get(problem)
        return known is not None and known.vertices == len(self.points_of(problem))

    def points_of(self, problem: int) -> list[Point]:
        """The rearrangements of a problem that are labelled."""
        return [point for key, point in self.points.items() if key[0] == problem]

    def add(self, item: Explored | Point) -> None:
        """Keep a line.

        Raises:
            ValueError: there is one of the same key.
        """
        self._keep(item)
        kind = "problem" if isinstance(item, Explored) else "point"
        self._write({"kind": kind, **_flat(item)})

    def _keep(self, item: Explored | Point) -> None:
        if isinstance(item, Explored):
            _once(self.explored, item.problem, item)
        else:
            _once(self.points, (item.problem, item.vertex), item)

    def _write(self, line: Mapping[str, Any]) -> None:
        assert self._file is not None, "opened to write"
        self._file.write(json.dumps(line, allow_nan=False).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())


@contextmanager
def open_data(path: Path, settings: Settings) -> Iterator[Data]:
    """The data in a file, to go on with; made if it is not there.

    Raises:
        InputError: it holds something else, was gathered with other settings, or another process
            is writing to it.
    """
    with open(path, "a+b") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{path}: another process is writing to it") from None
        data = Data(path, _file=file)
        head, *lines = _whole_lines(file) or [b""]
        if head:
            _check_settings(_parsed(head, path, 1), settings, path)
        else:
            data._write({"schema_version": SCHEMA_VERSION, "kind": "settings", **asdict(settings)})
        for number, line in enumerate(lines, start=2):
            content = _parsed(line, path, number)
            try:
                data._keep(_item(content))
            except (KeyError, TypeError, ValueError) as error:
                raise InputError(f"{path}:{number}: {error!r} in {content}") from None
        yield data


def _whole_lines(file: IO[bytes]) -> list[bytes]:
    """All lines; one that was being written when a run ended is cut off."""
    file.seek(0)
    text = file.read()
    end = text.rfind(b"\n") + 1
    file.truncate(end)
    return text[:end].splitlines()


def _parsed(line: bytes, path: Path, number: int) -> dict[str, Any]:
    try:
        content = json.loads(line)
    except ValueError:
        content = None
    if not isinstance(content, dict):
        raise InputError(f"{path}:{number}: is not a line of gathered data")
    return content


def _check_settings(found: Mapping[str, Any], settings: Settings, path: Path) -> None:
    if (found.get("kind"), found.get("schema_version")) != ("settings", SCHEMA_VERSION):
        raise InputError(f"{path}: holds no data of this version (expected {SCHEMA_VERSION})")
    for name, value in json.loads(json.dumps(asdict(settings))).items():
        if found.get(name) != value:
            raise InputError(
                f"{path}: was gathered with {name} {found.get(name)}, not {value}; "
                "expected the same settings or another file"
            )


def _item(content: Mapping[str, Any]) -> Explored | Point:
    values = {name: value for name, value in content.items() if name != "kind"}
    if content["kind"] == "problem":
        return Explored(**values)
    if content["kind"] != "point":
        raise ValueError(f"kind {content['kind']!r}")
    efforts = tuple(float(effort) for effort in values.pop("efforts"))
    occupied, count = float(values.pop("occupied")), int(values.pop("count"))
    return Point(features=Features(occupied, count, efforts), **values)


def _flat(item: Explored | Point) -> dict[str, Any]:
    content = asdict(item)
    return content | content.pop("features", {})


def _once(kept: dict[Any, Any], key: Any, item: Any) -> None:
    if key in kept:
        raise ValueError(f"{key} twice")
    kept[key] = item
