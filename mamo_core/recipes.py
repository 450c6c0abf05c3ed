"""Recipes: which parts make a planner, and how each is set."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from mamo_core.config import Located, load_file, validated
from mamo_core.errors import InputError, suggestion

DEFAULT_RECIPE = "default"
SCHEMA_VERSION = 1
SUFFIXES = (".yaml", ".yml", ".json")


class Part(BaseModel):
    """A component by its name; the keys beside ``name`` are the component's own options."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True)

    name: str = Field(description="name of the component")

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """A name alone will do as well."""
        return {"anyOf": [{"type": "string"}, handler.resolve_ref_schema(handler(schema))]}

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, data: Any) -> Any:
        if isinstance(data, str):
            return {"name": data}
        if not isinstance(data, dict):
            raise ValueError("expected a name, or a mapping with a name and options")
        return data


class Recipe(BaseModel):
    """A planner: one component for each role, any number of actions."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    schema_version: Literal[1] = Field(description="version of this format")
    name: str = Field(description="name of the planner")
    summary: str = Field(default="", description="one line for listings")
    backend: Part = Field(description="physics engine")
    accept_in: tuple[Part, ...] = Field(
        default=(),
        description="engines in which an action, and the plan, must be valid, too",
        strict=False,
    )
    kinematics: Part = Field(description="arm kinematics")
    collision: Part = Field(description="collision checker")
    arm_planner: Part = Field(description="motion planner of the arm")
    retrieval: Part | None = Field(default=None, description="plans how the target is taken out")
    mapf: Part | None = Field(default=None, description="multi-agent pathfinding solver")
    actions: tuple[Part, ...] = Field(
        default=(),
        description="rearrangement actions",
        strict=False,  # a validator before this has made the list a Python list
    )
    search: Part = Field(description="the planner's outer loop")

    @model_validator(mode="before")
    @classmethod
    def _one_of_several(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        alone = {k: [data[k]] for k in SEVERAL if isinstance(data.get(k), dict | str)}
        return {**data, **alone}


ROLES = ("backend", "kinematics", "collision", "arm_planner", "retrieval", "mapf", "search")
"""Keys of a recipe that hold one part."""

SEVERAL = ("accept_in", "actions")
"""Keys of a recipe that hold any number of parts."""


@dataclass(frozen=True)
class ChosenPart:
    """A part of a recipe: its role, the component's name, and its options where they stand."""

    role: str
    name: str
    options: Located
    place: str


@dataclass(frozen=True, eq=False)
class LoadedRecipe:
    """A recipe and the document it came from."""

    recipe: Recipe
    located: Located

    @property
    def data(self) -> dict[str, Any]:
        """The recipe as it goes into plan files."""
        return dict(self.located.data)

    def parts(self, role: str) -> tuple[ChosenPart, ...]:
        """What the recipe chooses for a role (``action`` for the actions)."""
        if role == "action":
            return tuple(_chosen(role, node) for node in _nodes(self.located, "actions"))
        if role == "accept_in":
            return tuple(_chosen(role, node) for node in _nodes(self.located, role))
        if self.located.data.get(role) is None:
            return ()
        return (_chosen(role, self.located.at(role)),)


def load_recipe(located: Located) -> LoadedRecipe:
    """A recipe from its document.

    Raises:
        InputError: what is wrong, and where.
    """
    recipe = LoadedRecipe(validated(Recipe, located), located)
    _refuse_twice(recipe.parts("action"))
    _refuse_twice(recipe.parts("accept_in"))
    return recipe


def find_recipe(name_or_path: str | Path) -> Located:
    """The document of a recipe given as a file or by the name of one of ours.

    Raises:
        InputError: no such file or recipe, with the names there are.
    """
    text = str(name_or_path)
    if text.endswith(SUFFIXES) or "/" in text:
        return load_file(text)
    files = shipped_recipes()
    if text not in files:
        raise InputError(f"unknown planner {text!r}{suggestion(text, files)}, or a .yaml file")
    return load_file(files[text])


def shipped_recipes() -> dict[str, Path]:
    """Name to file of the recipes that come with mamo."""
    return {path.stem: path for path in sorted(_recipe_folder().glob("*.yaml"))}


def _recipe_folder() -> Path:
    """``_recipes`` beside this file in a wheel, ``planners`` of the repository otherwise."""
    package = Path(__file__).parent
    installed = package / "_recipes"
    return installed if installed.is_dir() else package.parent / "planners"


def _chosen(role: str, node: Located) -> ChosenPart:
    if isinstance(node.data, str):
        return ChosenPart(role, node.data, replace(node, data={}), node.where())
    return ChosenPart(role, node.data["name"], node.without("name"), node.where(("name",)))


def _nodes(located: Located, key: str) -> Iterator[Located]:
    """The parts under a key that holds several, or one alone."""
    parts = located.data.get(key, [])
    if isinstance(parts, dict | str):
        yield located.at(key)
    else:
        for i in range(len(parts)):
            yield located.at(key, i)


def _refuse_twice(parts: tuple[ChosenPart, ...]) -> None:
    """Parts are told apart by name, in statistics and by ``--set``."""
    seen: set[str] = set()
    for part in parts:
        if part.name in seen:
            raise InputError(f"{part.place}: {part.role} {part.name!r} is in the recipe twice")
        seen.add(part.name)
