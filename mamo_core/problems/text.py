"""Reading and writing the text of problem files, gzipped or not."""

from __future__ import annotations

import gzip
import io
import zlib
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedSeq

from mamo_core.errors import InputError

_GZIP_MAGIC = b"\x1f\x8b"


def read_text(path: Path) -> str:
    """The text of a file, gzipped or not.

    Raises:
        InputError: no such file, unreadable, cut short or not UTF-8.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    if data.startswith(_GZIP_MAGIC):
        data = _gunzipped(data, path)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8 text") from error


def _gunzipped(data: bytes, path: Path) -> bytes:
    try:
        return gzip.decompress(data)
    except (EOFError, OSError, zlib.error) as error:
        raise InputError(f"{path}: the gzip file is damaged or cut short ({error})") from error


def yaml_text(document: dict[str, Any]) -> str:
    """A document as YAML for people: lists of plain values in one line."""
    writer = YAML()
    writer.width = 100
    out = io.StringIO()
    writer.dump(_flowing(document), out)
    return out.getvalue()


def _flowing(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _flowing(item) for key, item in value.items()}
    if not isinstance(value, list):
        return value
    if any(isinstance(item, dict | list) for item in value):
        return [_flowing(item) for item in value]
    line = CommentedSeq(value)
    line.fa.set_flow_style()
    return line
