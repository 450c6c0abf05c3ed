"""The reader behind ``config``: YAML 1.2 and JSON as plain data with the place of everything."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NoReturn

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)
from ruamel.yaml.reader import ReaderError

from mamo_core.errors import InputError

MAX_DEPTH = 40

DataPath = tuple[str | int, ...]
"""Keys and list positions from the root of a document to a value."""


@dataclass(frozen=True)
class Places:
    """Line and column (from 1) of every value and of every mapping key."""

    values: Mapping[DataPath, tuple[int, int]] = field(default_factory=dict)
    keys: Mapping[DataPath, tuple[int, int]] = field(default_factory=dict)


def read_data(text: str, source: str, first_line: int) -> Any:
    """Plain data of one document.

    Raises:
        InputError: broken syntax, duplicate keys, aliases, anchors, tags, or too deep.
    """
    try:
        return _fast_json(text)
    except (ValueError, RecursionError):  # YAML, or broken: the slow reader knows the place
        return _Reader(source, first_line).document(text)


@lru_cache(maxsize=8)
def read_places(text: str, source: str, first_line: int) -> Places:
    """Where everything stands in a document that ``read_data`` accepts.

    Every part of a recipe asks for it, and reading YAML is slow.
    """
    reader = _Reader(source, first_line)
    reader.document(text)
    return Places(reader.values, reader.keys)


def _fast_json(text: str) -> Any:
    """JSON as plain data; ValueError if it is anything but clean, shallow JSON."""
    if not text.lstrip().startswith(("{", "[")):
        raise ValueError("not JSON")
    data = json.loads(text, object_pairs_hook=_unique, parse_constant=_no_constant)
    if _depth(data) > MAX_DEPTH:
        raise ValueError("too deep")
    return data


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        raise ValueError("duplicate key")
    return data


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


def _depth(data: Any) -> int:
    if not isinstance(data, dict | list):
        return 0
    children = data.values() if isinstance(data, dict) else data
    return 1 + max((_depth(child) for child in children), default=0)


_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -float("inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


def _plain_scalar(word: str) -> Any:
    """An unquoted scalar by the core schema of YAML 1.2 (so ``yes`` and dates are text)."""
    if word in _WORDS:
        return _WORDS[word]
    if _INTEGER.fullmatch(word):
        return int(word, 10 if word[:2] not in ("0o", "0x") else 0)
    return float(word) if _FLOAT.fullmatch(word) else word


class _Reader:
    """Builds data and positions from parser events, refusing what makes documents ambiguous."""

    def __init__(self, source: str, first_line: int) -> None:
        self.source = source
        self.first_line = first_line
        self.values: dict[DataPath, tuple[int, int]] = {}
        self.keys: dict[DataPath, tuple[int, int]] = {}

    def document(self, text: str) -> Any:
        """The data of the only document in ``text``."""
        try:
            events = self._content(text)
            first = next(events, None)
            if first is None:
                raise InputError(f"{self.source}:{self.first_line}:1: the document is empty")
            data = self._value(first, events, ())
            for extra in events:
                raise self._error(extra, "a second document, expected only one")
        except MarkedYAMLError as error:
            raise self._broken(error) from None
        except ReaderError as error:
            raise InputError(self._bad_character(text, error)) from None
        except YAMLError as error:
            raise InputError(f"{self.source}: cannot be read: {error}") from None
        return data

    def _content(self, text: str) -> Iterator[Event]:
        for event in YAML(typ="safe", pure=True).parse(text):
            ends = isinstance(event, SequenceEndEvent | MappingEndEvent)
            if ends or isinstance(event, NodeEvent | DocumentStartEvent):
                if isinstance(event, DocumentStartEvent):
                    if event.version is None and event.tags is None:
                        continue
                    raise self._error(event, "directives are not allowed")
                yield event

    def _value(self, event: Event, events: Iterator[Event], path: DataPath) -> Any:
        self._refuse(event, path)
        self.values[path] = self._place(event)
        if isinstance(event, MappingStartEvent):
            return self._mapping(events, path)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(events, path)
        return self._scalar(event)

    def _mapping(self, events: Iterator[Event], path: DataPath) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for event in events:
            if isinstance(event, MappingEndEvent):
                break
            self._refuse(event, path)
            if not isinstance(event, ScalarEvent):
                raise self._error(event, "a key that is a list or mapping, expected text")
            key = event.value
            if key in data:
                first = self.keys[(*path, key)]
                raise self._error(event, f"duplicate key {key!r}, first on line {first[0]}")
            self.keys[(*path, key)] = self._place(event)
            data[key] = self._value(next(events), events, (*path, key))
        return data

    def _sequence(self, events: Iterator[Event], path: DataPath) -> list[Any]:
        data: list[Any] = []
        for event in events:
            if isinstance(event, SequenceEndEvent):
                break
            data.append(self._value(event, events, (*path, len(data))))
        return data

    def _scalar(self, event: Any) -> Any:
        if not event.implicit[0]:
            return event.value
        try:
            return _plain_scalar(event.value)
        except ValueError:  # Python refuses integers of more than 4300 digits
            raise self._error(event, "a number with too many digits") from None

    def _refuse(self, event: Any, path: DataPath) -> None:
        if isinstance(event, AliasEvent):
            raise self._error(event, f"alias '*{event.anchor}': aliases are not allowed")
        if event.anchor is not None:
            raise self._error(event, f"anchor '&{event.anchor}': anchors are not allowed")
        if event.tag is not None:
            tag = str(event.tag).replace("tag:yaml.org,2002:", "!!")
            raise self._error(event, f"tag '{tag}': tags are not allowed")
        nested = isinstance(event, MappingStartEvent | SequenceStartEvent)
        if nested and len(path) >= MAX_DEPTH:
            raise self._error(event, f"nested deeper than {MAX_DEPTH} levels")

    def _place(self, event: Event) -> tuple[int, int]:
        mark = event.start_mark
        return mark.line + self.first_line, mark.column + 1

    def _error(self, event: Event, message: str) -> InputError:
        line, column = self._place(event)
        return InputError(f"{self.source}:{line}:{column}: {message}")

    def _broken(self, error: MarkedYAMLError) -> InputError:
        mark = error.problem_mark or error.context_mark
        text = ": ".join(str(part) for part in (error.context, error.problem) if part)
        text = text.replace("'<stream end>'", "the end of the file")
        place = f":{mark.line + self.first_line}:{mark.column + 1}" if mark else ""
        return InputError(f"{self.source}{place}: not valid YAML or JSON: {text}")

    def _bad_character(self, text: str, error: ReaderError) -> str:
        start = text[: error.position]
        line = start.count("\n") + self.first_line
        column = error.position - start.rfind("\n")
        return f"{self.source}:{line}:{column}: character {error.character!r} is not allowed"
