"""Commands that plugins add, and what the core does for them.

Plugins may import only a part of the core; the rest is handed to a command as a ``Workbench``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from mamo_core.cli import output
from mamo_core.errors import PluginError
from mamo_core.plugins import Registry, discover

if TYPE_CHECKING:
    from mamo_core.compose import Planner
    from mamo_core.interfaces.search_strategy import ProgressCallback
    from mamo_core.types.problem import Problem

ROLE = "command"


@dataclass(frozen=True, eq=False)
class Workbench:
    """Problems, planners and files for the commands of plugins."""

    registry: Registry

    @property
    def levels(self) -> tuple[str, ...]:
        """How many movables may be in the way, in words."""
        from mamo_core.problems import LEVELS

        return LEVELS

    def load_kernels(self) -> None:
        """Read, or compile, what would make the first plan slow."""
        from mamo_core.warmup import load_kernels

        load_kernels(self.registry)

    def shelf(self, *, movables: int, seed: int, level: str) -> Problem:
        """The shelf that ``mamo problem generate shelf`` makes of the same arguments.

        Raises:
            InputError: nothing that fits was found.
        """
        from mamo_core.problems import generate_shelf

        return generate_shelf(movables=movables, seed=seed, level=level, classify=self._classify)

    def planner(self, recipe: str, problem: Problem, settings: Sequence[str] = ()) -> Planner:
        """A recipe, one of ours or a file, with changes as by ``--set``, for a problem.

        Raises:
            InputError: no such recipe, or a wrong setting.
        """
        from mamo_core.compose import compose
        from mamo_core.recipe_sets import chosen_recipe

        return compose(chosen_recipe(recipe, None, tuple(settings)), problem, self.registry)

    def progress(self) -> AbstractContextManager[ProgressCallback]:
        """Says on stderr what is being done."""
        return output.progress()

    def print_json(self, command: str, result: Mapping[str, Any]) -> None:
        """The one JSON document of a command."""
        output.print_json(command, result)

    def print_table(
        self, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]
    ) -> None:
        """A table on stdout."""
        output.print_table(title, columns, rows)

    def check_writable(self, path: Path) -> None:
        """Find out before the work that a result cannot be written.

        Raises:
            InputError: the folder is missing or not writable, or it is no regular file.
        """
        from mamo_core.atomic import check_writable

        check_writable(path)

    def write_text(self, path: Path, text: str) -> None:
        """Write a file completely or not at all."""
        from mamo_core.atomic import atomic_path

        with atomic_path(path) as work:
            work.write_text(text, encoding="utf-8")

    @cached_property
    def _classify(self) -> Callable[[Problem], int | None]:
        from mamo_core.classify import make_classifier
        from mamo_core.recipes import DEFAULT_RECIPE, find_recipe, load_recipe

        return make_classifier(load_recipe(find_recipe(DEFAULT_RECIPE)), self.registry)


def plugin_command(name: str) -> Any:
    """The click command of that name which a plugin adds; None if there is none.

    Raises:
        PluginError: it cannot be imported.
    """
    registry = discover()
    output.warn_of_broken_plugins(registry)
    for component in registry.components(ROLE):
        if component.name.replace("_", "-") == name:
            try:
                function = component.build(Workbench(registry), component.options())
            except ImportError as error:
                raise PluginError(f"command {name!r} cannot be loaded: {error}") from error
            return _as_command(name, function)
    return None


def _as_command(name: str, function: Callable[..., Any]) -> Any:
    app = typer.Typer(
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.command(name)(function)
    return typer.main.get_command(app)
