"""Problem files: one document, a set of documents, or the thesis' scenes in their own formats."""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mamo_core.config import Located, load_text, validated
from mamo_core.errors import InputError, suggestion
from mamo_core.problems.checks import complaints
from mamo_core.problems.documents import problem_document, problem_from_located
from mamo_core.problems.importers import problem_from_thesis
from mamo_core.problems.text import read_text, yaml_text
from mamo_core.problems.thesis import ThesisScene, looks_raw, parse_raw
from mamo_core.types.problem import Problem

_SHOWN_IDS = 12
_ENDINGS = (".json", ".jsonl", ".jsonl.gz", ".yaml", ".yml")


@dataclass(frozen=True)
class Entry:
    """A problem of a file: its id, and how to make it together with the importer's warnings."""

    id: str
    load: Callable[[], tuple[Problem, list[str]]]


def load_problem(spec: str | Path) -> Problem:
    """The problem in ``PATH`` or, from a set, ``PATH#id``; the format is told by the content.

    Raises:
        InputError: the file or the id is missing, or the content is not a valid problem.
    """
    path, ident = _split(str(spec))
    entries = read_entries(path)
    if ident is not None:
        return _chosen(entries, ident, path).load()[0]
    if len(entries) != 1:
        raise InputError(
            f"{path}: holds {len(entries)} problems, pick one with '#id' "
            f"(valid: {_abbreviated(entry.id for entry in entries)})"
        )
    return entries[0].load()[0]


def import_file(path: str | Path) -> tuple[list[Problem], list[str]]:
    """All problems of a file, and in words what had to be changed to make them.

    Raises:
        InputError: the file is missing or holds something that is not a valid problem.
    """
    problems: list[Problem] = []
    warnings: list[str] = []
    for entry in read_entries(Path(path)):
        problem, notes = entry.load()
        problems.append(problem)
        warnings.extend(notes)
    return problems, warnings


def problem_ids(path: str | Path) -> list[str]:
    """The ids that ``PATH#id`` accepts, in the order of the file."""
    return [entry.id for entry in read_entries(Path(path))]


def read_entries(path: Path) -> list[Entry]:
    """What a file holds, read but not yet validated; ids are unique.

    Raises:
        InputError: unreadable, cut short, an id is missing or twice.
    """
    text = read_text(path)
    if looks_raw(text):
        return [_raw_entry(text, path)]
    lines = _set_lines(text, path)
    return _set_entries(lines, path) if lines else [_document_entry(text, path)]


def _split(spec: str) -> tuple[Path, str | None]:
    """Path and id; a file whose own name holds '#' is found too."""
    if "#" not in spec or Path(spec).is_file():
        return Path(spec), None
    path, _, ident = spec.rpartition("#")
    return Path(path), ident


def _chosen(entries: list[Entry], ident: str, path: Path) -> Entry:
    for entry in entries:
        if entry.id == ident:
            return entry
    ids = [entry.id for entry in entries]
    hint = suggestion(ident, ids).split(" (valid:")[0]
    raise InputError(f"{path}: no problem {ident!r}{hint} (valid: {_abbreviated(ids)})")


def _abbreviated(ids: Iterable[str]) -> str:
    names = list(ids)
    if len(names) <= _SHOWN_IDS:
        return ", ".join(names) or "none"
    head, tail = names[: _SHOWN_IDS - 2], names[-1]
    return f"{', '.join(head)}, ... {tail}; {len(names)} in all"


def _raw_entry(text: str, path: Path) -> Entry:
    digits = re.search(r"\d+", path.name)
    number = int(digits.group()) if digits else 0
    return Entry(str(number), lambda: _imported(parse_raw(text, number, str(path)), str(path)))


def _imported(record: ThesisScene, where: str) -> tuple[Problem, list[str]]:
    """The problem of a published scene, if it passes the checks our own documents pass."""
    try:
        problem, notes = problem_from_thesis(record)
    except ValueError as error:
        raise InputError(f"{where}: {error}") from error
    found = complaints(problem)
    if found:
        raise InputError("\n".join(f"{where}: {complaint.message}" for complaint in found))
    return problem, notes


def _set_lines(text: str, path: Path) -> list[tuple[int, str]]:
    """Numbered lines, if the file is a set: named so, or its first line is a whole document."""
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    if re.search(r"\.jsonl(\.gz)?$", path.name):
        if not lines:
            raise InputError(f"{path}: the set is empty")
        return lines
    first = lines[0][1].strip() if lines else ""
    whole = first.startswith("{") and first.endswith("}") and '"id"' in first
    return lines if whole else []


def _set_entries(lines: list[tuple[int, str]], path: Path) -> list[Entry]:
    entries: dict[str, Entry] = {}
    for number, line in lines:
        entry = _line_entry(load_text(line, str(path), first_line=number))
        if entry.id in entries:
            raise InputError(f"{path}:{number}: id {entry.id!r} stands twice")
        entries[entry.id] = entry
    return list(entries.values())


def _line_entry(located: Located) -> Entry:
    data = located.data
    if not isinstance(data, dict) or not isinstance(data.get("id"), str | int):
        raise located.error("every line of a set is a mapping with an 'id' (text or number)")
    if "ooi" in data:
        where = f"{located.source}:{located.first_line}"
        return Entry(str(data["id"]), lambda: _imported(validated(ThesisScene, located), where))
    return Entry(str(data["id"]), lambda: (problem_from_located(located.without("id")), []))


def _document_entry(text: str, path: Path) -> Entry:
    located = load_text(text, str(path))
    name = located.data.get("name") if isinstance(located.data, dict) else None
    return Entry(str(name), lambda: (problem_from_located(located), []))


def save_problems(problems: Sequence[Problem], path: str | Path) -> None:
    """Write problems: ``.jsonl`` and ``.jsonl.gz`` hold any number, ids are their names;
    ``.json``, ``.yaml`` and ``.yml`` hold one.

    Raises:
        InputError: another ending, a name twice, or several problems for one document.
    """
    target = Path(path)
    documents = [problem_document(problem) for problem in problems]
    if re.search(r"\.jsonl(\.gz)?$", target.name):
        text = _set_text(documents, target)
    else:
        text = _document_text(documents, target)
    data = text.encode("utf-8")
    # mtime 0: the same problems make the same bytes.
    target.write_bytes(gzip.compress(data, mtime=0) if target.suffix == ".gz" else data)


def _set_text(documents: list[dict[str, Any]], path: Path) -> str:
    names = [document["name"] for document in documents]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{path}: problem names stand twice: {', '.join(twice)}")
    lines = [json.dumps({"id": d["name"], **d}, separators=(",", ":")) for d in documents]
    return "".join(f"{line}\n" for line in lines)


def _document_text(documents: list[dict[str, Any]], path: Path) -> str:
    if len(documents) != 1:
        raise InputError(
            f"{path}: {len(documents)} problems, but such a file holds one; "
            "use .jsonl or .jsonl.gz for a set"
        )
    if path.suffix == ".json":
        return json.dumps(documents[0], indent=1) + "\n"
    if path.suffix in (".yaml", ".yml"):
        return yaml_text(documents[0])
    raise InputError(f"{path}: ending {path.suffix!r} (valid: {', '.join(_ENDINGS)})")
