"""Signatures as blocks of Python."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from enum import Enum
from typing import Any

WIDTH = 100


def function_block(
    function: Callable[..., Any], *, decorators: Sequence[str] = (), without_self: bool = False
) -> str:
    """A function's head, over several lines if it is long."""
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if not (without_self and p.name == "self")]
    signature = signature.replace(parameters=own)
    head = _head(function.__name__, signature)
    return _block("\n".join([*decorators, head]))


def class_block(found: type) -> str:
    """The fields of a dataclass, or the members of an enumeration."""
    if issubclass(found, Enum):
        lines = [f"{name} = {_value(member.value)}" for name, member in found.__members__.items()]
    else:
        assert is_dataclass(found), found
        lines = [_field(field) for field in fields(found)]
    return _block("\n".join([f"class {found.__name__}:", *(f"    {line}" for line in lines)]))


def is_abstract(function: Callable[..., Any]) -> bool:
    return getattr(function, "__isabstractmethod__", False)


def _head(name: str, signature: inspect.Signature) -> str:
    one_line = f"def {name}{_plain(signature)}: ..."
    if len(one_line) <= WIDTH:
        return one_line
    arguments = "".join(f"    {argument},\n" for argument in _arguments(signature))
    return f"def {name}(\n{arguments}) -> {signature.return_annotation}: ..."


def _plain(signature: inspect.Signature) -> str:
    return f"({', '.join(_arguments(signature))}) -> {signature.return_annotation}"


def _arguments(signature: inspect.Signature) -> Iterator[str]:
    """Arguments as they are written; annotations are text already."""
    keywords = False
    for parameter in signature.parameters.values():
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY and not keywords:
            keywords = True
            yield "*"
        yield _argument(parameter)


def _argument(parameter: inspect.Parameter) -> str:
    empty = inspect.Parameter.empty
    text = parameter.name
    if parameter.annotation is not empty:
        text += f": {parameter.annotation}"
    return text if parameter.default is empty else f"{text} = {_value(parameter.default)}"


def _field(field: Field[Any]) -> str:
    text = f"{field.name}: {field.type}"
    if field.default is not MISSING:
        return f"{text} = {_value(field.default)}"
    if field.default_factory is not MISSING:
        return f"{text} = {_value(field.default_factory())}"
    return text


def _value(value: Any) -> str:
    """As it is written in our code: classes by their names, text in double quotes."""
    return value.__name__ if inspect.isclass(value) else repr(value).replace("'", '"')


def _block(text: str) -> str:
    return f"```py\n{text}\n```"
