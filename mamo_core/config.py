"""Strict YAML and JSON documents: every complaint names the file, line, column, key and value.

``load_text``/``load_file`` read plain data and know where every key and value stands;
``validated`` turns the data into a pydantic model or raises an ``InputError`` with one short
sentence per mistake.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from mamo_core.config_mistakes import find_mistakes
from mamo_core.config_reader import DataPath, Places, read_data, read_places
from mamo_core.errors import InputError

MAX_BYTES = 256 * 1024

Model = TypeVar("Model", bound=BaseModel)


@dataclass(frozen=True, eq=False)
class Located:
    """Plain data and where it stands.

    ``base`` is the path of ``data`` in the document. ``said_by``: values that do not come from the
    document, for example from the command line, and what to call their origin. Without ``text``
    only ``source`` is named.
    """

    data: Any
    source: str
    text: str | None = None
    first_line: int = 1
    base: DataPath = ()
    said_by: Mapping[DataPath, str] = field(default_factory=dict)

    @cached_property
    def places(self) -> Places:
        """Positions, found when the first complaint needs them."""
        if self.text is None:
            return Places()
        return read_places(self.text, self.source, self.first_line)

    def at(self, *keys: str | int) -> Located:
        """The part of the document under ``keys``.

        Raises:
            KeyError: no such part (IndexError in a list).
        """
        data = self.data
        for key in keys:
            data = data[key]
        return replace(self, data=data, base=(*self.base, *keys))

    def without(self, key: str) -> Located:
        """The same mapping but for one key."""
        return replace(self, data={k: v for k, v in self.data.items() if k != key})

    def where(self, path: DataPath = (), *, key: bool = False) -> str:
        """``file:line:column`` of the value (or key) at ``path``, or of what encloses it."""
        whole = (*self.base, *path)
        for length in range(len(whole), -1, -1):
            prefix = whole[:length]
            if prefix in self.said_by:
                return self.said_by[prefix]
            places = self.places.keys if key and length == len(whole) else self.places.values
            if prefix in places:
                line, column = places[prefix]
                return f"{self.source}:{line}:{column}"
        return self.source

    def dotted(self, path: DataPath = ()) -> str:
        """The path from the root of the document as text: ``objects.0.mass``."""
        return ".".join(str(key) for key in (*self.base, *path))

    def error(self, message: str, path: DataPath = (), *, key: bool = False) -> InputError:
        """The complaint ``message`` about the value at ``path``, to be raised by the caller."""
        return InputError(f"{self.where(path, key=key)}: {message}")


def load_text(
    text: str, source: str, *, first_line: int = 1, max_bytes: int = MAX_BYTES
) -> Located:
    """Read one YAML 1.2 or JSON document; ``first_line`` is its first line in ``source``.

    Raises:
        InputError: broken syntax, duplicate keys, aliases, anchors, tags, too deep or too large.
    """
    size = len(text.encode("utf-8", errors="surrogatepass"))
    if size > max_bytes:
        raise InputError(f"{source}: {size} bytes, expected at most {max_bytes}")
    return Located(read_data(text, source, first_line), source, text, first_line)


def load_file(path: str | Path, *, max_bytes: int = MAX_BYTES) -> Located:
    """Read a document from a file.

    Raises:
        InputError: as ``load_text``, and if the file cannot be read as UTF-8 text.
    """
    return load_text(read_text(path, max_bytes=max_bytes), str(path), max_bytes=max_bytes)


def read_text(path: str | Path, *, max_bytes: int = MAX_BYTES) -> str:
    """The text of a file of limited size.

    Raises:
        InputError: missing, a folder, unreadable, too large or not UTF-8.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(max_bytes + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(content) > max_bytes:
        raise InputError(f"{path}: larger than {max_bytes} bytes")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        column = error.start - content.rfind(b"\n", 0, error.start)
        raise InputError(f"{path}:{line}:{column}: not UTF-8 text") from None


def validated(model: type[Model], located: Located) -> Model:
    """The data as a ``model``, checked strictly (no conversions but list to tuple and the like).

    Raises:
        InputError: one line per mistake.
    """
    try:
        return model.model_validate_json(json.dumps(located.data))
    except ValidationError as error:
        mistakes = find_mistakes(model, located.data, error)
    lines = [
        f"{located.where(m.path, key=m.about_key)}: {m.sentence(located.dotted(m.path))}"
        for m in mistakes
    ]
    raise InputError("\n".join(lines))


def load_model(model: type[Model], path: str | Path) -> Model:
    """``validated`` for a file."""
    return validated(model, load_file(path))
