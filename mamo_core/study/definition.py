"""A study file, read: which recipes in which engines, and where the problems come from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from mamo_core.config import Located, load_file, validated
from mamo_core.errors import InputError, suggestion
from mamo_core.recipe_sets import apply_sets, override
from mamo_core.recipes import SUFFIXES, LoadedRecipe, find_recipe, load_recipe
from mamo_core.study.schema import FileSource, RecipeEntry, Source, StudyFile


@dataclass(frozen=True, eq=False)
class Variant:
    """A recipe in an engine, as it stands in tables."""

    recipe: str
    engine: str
    loaded: LoadedRecipe


@dataclass(frozen=True, eq=False)
class Study:
    """What is to be done.

    ``budget``: CPU s for planning a problem; ``deadline``: wall s for a task. ``baseline``: the
    recipe that the others are compared with.
    """

    name: str
    folder: Path
    sources: tuple[Source, ...]
    variants: tuple[Variant, ...]
    seeds: tuple[int, ...]
    budget: float
    deadline: float
    baseline: str


def load_study(path: str | Path, settings: Iterable[str] = ()) -> Study:
    """The study in a file, with ``settings`` such as ``budget=5`` or ``problems.0.limit=2``.

    Raises:
        InputError: what is wrong, and where.
    """
    located = apply_sets(load_file(path), settings)
    file = validated(StudyFile, located)
    folder = Path(path).parent
    recipes = dict(_recipes(file, located, folder))
    _refuse_twice(located, "engines", file.engines or ())
    _refuse_twice(located, "seeds", file.seeds)
    baseline = file.baseline if file.baseline is not None else next(iter(recipes))
    if baseline not in recipes:
        message = f"baseline: no recipe {baseline!r}{suggestion(baseline, recipes)}"
        raise located.error(message, ("baseline",))
    return Study(
        name=file.name,
        folder=folder,
        sources=tuple(FileSource(file=s) if isinstance(s, str) else s for s in file.problems),
        variants=tuple(_variants(recipes, file.engines, located)),
        seeds=file.seeds,
        budget=file.budget,
        deadline=file.deadline if file.deadline is not None else 4.0 * file.budget + 60.0,
        baseline=baseline,
    )


def _recipes(file: StudyFile, located: Located, folder: Path) -> Iterator[tuple[str, LoadedRecipe]]:
    seen: set[str] = set()
    for i, entry in enumerate(file.recipes):
        where = ("recipes", i)
        if isinstance(entry, str):
            entry = RecipeEntry(recipe=entry)
        name, loaded = _recipe(entry, folder, located.where(where))
        if name in seen:
            raise located.error(f"recipes.{i}: {name!r} is there twice, give one a name", where)
        seen.add(name)
        yield name, loaded


def _recipe(entry: RecipeEntry, folder: Path, place: str) -> tuple[str, LoadedRecipe]:
    is_file = entry.recipe.endswith(SUFFIXES) or "/" in entry.recipe
    try:
        located = find_recipe(folder / entry.recipe if is_file else entry.recipe)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    for key, value in entry.set.items():
        located = override(located, key.split("."), value, f"{place}: {key}")
    loaded = load_recipe(located)
    changes = [f"{key}={value}" for key, value in entry.set.items()]
    return entry.name or " ".join([loaded.recipe.name, *changes]), loaded


def _variants(
    recipes: dict[str, LoadedRecipe], engines: tuple[str, ...] | None, located: Located
) -> Iterator[Variant]:
    for name, loaded in recipes.items():
        if engines is None:
            yield Variant(name, loaded.recipe.backend.name, loaded)
        for i, engine in enumerate(engines or ()):
            place = located.where(("engines", i))
            yield Variant(name, engine, in_engine(loaded, engine, place))


def in_engine(recipe: LoadedRecipe, engine: str, place: str) -> LoadedRecipe:
    """The recipe in an engine; with its own options if that is the recipe's own engine."""
    if recipe.recipe.backend.name == engine:
        return recipe
    return load_recipe(override(recipe.located, ["backend"], engine, place))


def _refuse_twice(located: Located, key: str, values: Iterable[object]) -> None:
    for value, times in Counter(values).items():
        if times > 1:
            raise located.error(f"{key}: {value!r} is there twice", (key,))
