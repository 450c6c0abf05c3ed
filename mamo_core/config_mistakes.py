"""Pydantic's errors as short sentences that name the key, the value and what is expected."""

from __future__ import annotations

import types
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from mamo_core.config_reader import DataPath
from mamo_core.errors import suggestion

_SHOWN = 60
_OF_ANOTHER_TYPE = 1000
"""More than the wrong keys of any mapping."""


@dataclass(frozen=True)
class Mistake:
    """One mistake at ``path``; ``template`` has ``{key}`` where the dotted path belongs."""

    path: DataPath
    template: str
    about_key: bool = False

    def sentence(self, dotted: str) -> str:
        """The mistake in words, the key given by its dotted path."""
        return self.template.replace("{key}", dotted).removeprefix(": ")


def find_mistakes(model: type[BaseModel], data: Any, error: ValidationError) -> tuple[Mistake, ...]:
    """What is wrong with ``data``, in the order of the model's fields, one per place."""
    by_path: dict[DataPath, list[ErrorDetails]] = {}
    errors = [e for e in error.errors(include_url=False) if not _only_spoilt(e)]
    for details in _nearest_branches(errors, data):
        by_path.setdefault(_data_path(details["loc"], data, details["type"]), []).append(details)
    mistakes = (_mistake(model, path, group) for path, group in by_path.items())
    return tuple(dict.fromkeys(mistakes))


def _only_spoilt(details: ErrorDetails) -> bool:
    """Whether a list is long enough, but for items that are wrong and told of themselves."""
    if details["type"] != "too_short" or not isinstance(details["input"], list):
        return False
    return len(details["input"]) >= int(details["ctx"]["min_length"])


def _nearest_branches(errors: list[ErrorDetails], data: Any) -> list[ErrorDetails]:
    """Without the errors of union members that were hardly meant.

    Pydantic reports every member of a union; only the one with the fewest wrong keys is told, and
    none that is of another type than the data if there is one of theirs.
    """
    wrong_keys: Counter[DataPath] = Counter()
    for details in errors:
        branch = _branch(details, data)
        if branch is not None:
            wrong_keys[branch] += details["type"] in ("extra_forbidden", "missing")
            if details["loc"] == branch and details["type"].endswith("_type"):
                wrong_keys[branch] += _OF_ANOTHER_TYPE
    least: dict[DataPath, int] = {}
    for branch, count in wrong_keys.items():
        least[branch[:-1]] = min(count, least.get(branch[:-1], count))

    def told(details: ErrorDetails) -> bool:
        branch = _branch(details, data)
        return branch is None or wrong_keys[branch] == least[branch[:-1]]

    return [details for details in errors if told(details)]


def _branch(details: ErrorDetails, data: Any) -> DataPath | None:
    """Location up to the first step that is a union member and not in the data."""
    loc = details["loc"]
    for i, step in enumerate(loc):
        if not _holds(data, step):
            last = i == len(loc) - 1
            return None if details["type"] == "missing" and last else loc[: i + 1]
        data = data[step]
    return None


def _holds(data: Any, step: str | int) -> bool:
    if isinstance(data, dict):
        return step in data
    return isinstance(data, list) and isinstance(step, int) and step < len(data)


def _mistake(model: type[BaseModel], path: DataPath, group: list[ErrorDetails]) -> Mistake:
    kinds = {details["type"] for details in group}
    if "extra_forbidden" in kinds:
        hint = suggestion(str(path[-1]), valid_keys(model, path[:-1]))
        return Mistake(path, f"unknown key '{{key}}'{hint}", about_key=True)
    if "missing" in kinds:
        return _missing(path, group[0]["input"])
    expected = " or ".join(dict.fromkeys(_expected(details) for details in group))
    value = group[0]["input"]
    about_the_whole = "value_error" in kinds and isinstance(value, dict)
    shown = "" if about_the_whole else f"{_shown(value)}, "
    return Mistake(path, f"{{key}}: {shown}{expected}")


def _missing(path: DataPath, parent: Any) -> Mistake:
    if isinstance(path[-1], int):
        return Mistake(path[:-1], f"{{key}}: {len(parent)} items, expected more")
    return Mistake(path[:-1], f"{{key}}: missing key {path[-1]!r}")


def _data_path(loc: DataPath, data: Any, kind: str) -> DataPath:
    """``loc`` without what pydantic adds for unions; a missing key ends the path."""
    path: list[str | int] = []
    for i, step in enumerate(loc):
        if _holds(data, step):
            data = data[step]
            path.append(step)
        elif kind == "missing" and i == len(loc) - 1:
            path.append(step)
    return tuple(path)


def valid_keys(model: type[BaseModel], path: DataPath) -> set[str]:
    """Keys allowed in the mapping at ``path`` of a document of type ``model``."""
    candidates = list(_alternatives(model))
    for step in path:
        inner = [part for candidate in candidates for part in _children(candidate, step)]
        candidates = [alternative for part in inner for alternative in _alternatives(part)]
    models = [c for c in candidates if isinstance(c, type) and issubclass(c, BaseModel)]
    return {field.alias or name for m in models for name, field in m.model_fields.items()}


def _alternatives(annotation: Any) -> Iterator[Any]:
    """The annotation, or the members of a union, without ``Annotated``."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _alternatives(get_args(annotation)[0])
    elif origin in (Union, types.UnionType):
        for member in get_args(annotation):
            yield from _alternatives(member)
    else:
        yield annotation


def _children(annotation: Any, step: str | int) -> Iterator[Any]:
    """Annotations of what stands under ``step`` in a value of this annotation."""
    origin = get_origin(annotation)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel) and origin is None:
        for name, field in annotation.model_fields.items():
            if step in (name, field.alias):
                yield field.annotation
    elif isinstance(origin, type) and issubclass(origin, Mapping):
        yield get_args(annotation)[1]
    elif origin in (tuple, list) and isinstance(step, int):
        members = get_args(annotation)
        fixed = origin is tuple and members[-1] is not Ellipsis
        yield members[min(step, len(members) - 1)] if fixed else members[0]


def _shown(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, dict):
        return "a mapping"
    text = repr(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


_EXPECTED = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "dataclass_type": "a mapping",
    "none_required": "null",
    "finite_number": "a finite number",
    "greater_than": "a number above {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "less_than": "a number below {lt:g}",
    "less_than_equal": "a number of at most {le:g}",
    "literal_error": "{expected}",
    "enum": "{expected}",
    "union_tag_invalid": "{expected_tags}",
    "string_too_short": "text of at least {min_length} characters",
    "string_too_long": "text of at most {max_length} characters",
    "string_pattern_mismatch": "text like {pattern}",
    "too_short": "at least {min_length} items, there are {actual_length}",
    "too_long": "at most {max_length} items, there are more",
}


def _expected(details: ErrorDetails) -> str:
    kind = details["type"]
    if kind == "value_error":  # raised by a validator of ours or of a plugin, in its own words
        return str(details["ctx"]["error"])
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind].format(**details.get('ctx', {}))}"
    message = details["msg"]
    return message[:1].lower() + message[1:].replace("Input should be", "expected")
