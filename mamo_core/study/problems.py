"""The problems of a study, before and after they are loaded."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mamo_core.errors import InputError, suggestion
from mamo_core.problems import problem_document
from mamo_core.problems.files import read_entries
from mamo_core.problems.layouts import LAYOUTS
from mamo_core.problems.published import published_scenes
from mamo_core.study.schema import (
    FileSource,
    GeneratedSource,
    Generation,
    WorkspaceGeneration,
    WorkspaceSource,
)
from mamo_core.types.problem import Problem

_PUBLISHED = "scenes/"

DOCUMENT = "document"
"""The kind of fact under which a store keeps the problems of its tasks, by their hash."""


@dataclass(frozen=True)
class Picked:
    """A problem of a set, not yet loaded."""

    set_name: str
    id: str
    load: Callable[[], tuple[Problem, list[str]]]

    @property
    def key(self) -> tuple[str, str]:
        """Set and id."""
        return self.set_name, self.id


@dataclass(frozen=True)
class StudyProblem:
    """A problem of a set as plain data, known by the ``hash`` of its content."""

    set_name: str
    id: str
    document: dict[str, Any]
    hash: str


def pick(sets: Sequence[Path], every: int = 1, limit: int | None = None) -> list[Picked]:
    """Problems of files: of each set every k-th, and of those so many."""
    return [
        Picked(path.name.split(".")[0], entry.id, entry.load)
        for path in sets
        for entry in read_entries(path)[::every][:limit]
    ]


def pick_source(source: FileSource, folder: Path) -> list[Picked]:
    """The problems of a source, classes and limit not yet regarded.

    Raises:
        InputError: no such file or id.
    """
    path = _path(source.file, folder)
    name = source.set if source.set is not None else path.name.split(".")[0]
    picked = [Picked(name, entry.id, entry.load) for entry in read_entries(path)]
    if source.ids is not None:
        picked = _with_ids(picked, [str(ident) for ident in source.ids], path)
    return picked[source.offset :: source.every]


def _path(file: str, folder: Path) -> Path:
    if file.startswith(_PUBLISHED):
        return published_scenes(file.removeprefix(_PUBLISHED))
    return folder / file


def _with_ids(picked: list[Picked], ids: list[str], path: Path) -> list[Picked]:
    known = {entry.id: entry for entry in picked}
    for ident in ids:
        if ident not in known:
            hint = suggestion(ident, known).split(" (valid:")[0]
            raise InputError(f"{path}: no problem {ident!r}{hint} ({len(known)} in all)")
    return [known[ident] for ident in ids]


def study_problem(set_name: str, ident: str, document: dict[str, Any]) -> StudyProblem:
    """The problem with the hash of its content."""
    return StudyProblem(set_name, ident, document, content_hash(document))


def loaded(picked: Picked) -> StudyProblem:
    """The problem as plain data.

    Raises:
        InputError: it is not a valid problem.
    """
    return study_problem(picked.set_name, picked.id, problem_document(picked.load()[0]))


@dataclass(frozen=True)
class Wanted:
    """A problem that is to be generated.

    ``function`` of ``tasks.Work`` makes it from ``arguments``; ``subject`` names it in the store.
    """

    set_name: str
    subject: str
    function: str
    arguments: dict[str, Any]


def wanted(source: GeneratedSource | WorkspaceSource) -> Iterator[Wanted]:
    """What is to be generated, in order."""
    if isinstance(source, GeneratedSource):
        return _shelves(source.generate)
    return _reaches(source.generate, source.set)


def _shelves(generation: Generation) -> Iterator[Wanted]:
    for movables in generation.movables:
        for level in generation.levels:
            for seed in range(generation.seed, generation.seed + generation.count):
                yield Wanted(
                    f"shelf_{movables}",
                    f"{level}/{movables}/{seed}",
                    "generate",
                    {"level": level, "movables": movables, "seed": seed},
                )


def _reaches(generation: WorkspaceGeneration, set_name: str | None) -> Iterator[Wanted]:
    layout = LAYOUTS[generation.workspace]
    numbers = {
        "movables": layout.movables if generation.movables is None else generation.movables,
        "immovables": layout.immovables if generation.immovables is None else generation.immovables,
    }
    for seed in range(generation.seed, generation.seed + generation.count):
        yield Wanted(
            generation.workspace if set_name is None else set_name,
            "/".join(map(str, (generation.workspace, *numbers.values(), seed))),
            "generate_workspace",
            {"workspace": generation.workspace, **numbers, "seed": seed},
        )


def content_hash(data: Any) -> str:
    """A hash of plain data, the order of keys aside."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:32]
