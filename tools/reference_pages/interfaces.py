"""The page of interfaces: what a part must do."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from abc import ABC
from collections.abc import Iterator
from inspect import getdoc
from types import ModuleType

import mamo_core.interfaces
from reference_pages.markdown import page, prose, summary
from reference_pages.signatures import class_block, function_block, is_abstract

INTRODUCTION = """\
The abstract classes of `mamo_core.interfaces`, one module each, with the values that belong to
them. What is not abstract may be left as it is. Arrays are NumPy's;
[conventions.md](../conventions.md) has frames and units."""


def interfaces_page() -> str:
    """Every module with its classes."""
    names = [info.name for info in pkgutil.iter_modules(mamo_core.interfaces.__path__)]
    modules = [importlib.import_module(f"mamo_core.interfaces.{name}") for name in sorted(names)]
    return page("Interfaces", INTRODUCTION, *(part for m in modules for part in _module(m)))


def _module(module: ModuleType) -> Iterator[str]:
    yield f"## `{module.__name__}`"
    yield prose(getdoc(module) or "")
    for _, found in _own(module):
        yield f"### `{found.__name__}`"
        yield prose(getdoc(found) or "")
        yield from _methods(found) if issubclass(found, ABC) else [class_block(found)]


def _own(module: ModuleType) -> list[tuple[str, type]]:
    """Classes in the order in which they are written."""
    found = inspect.getmembers(module, lambda c: inspect.isclass(c) and _is_of(c, module))
    return sorted(found, key=lambda item: inspect.getsourcelines(item[1])[1])


def _is_of(thing: object, module: ModuleType) -> bool:
    return getattr(thing, "__module__", None) == module.__name__


def _methods(found: type) -> Iterator[str]:
    for name, method in vars(found).items():
        if inspect.isfunction(method) and not name.startswith("_"):
            yield function_block(method, decorators=("@abstractmethod",) * is_abstract(method))
            yield summary(method)
