"""What stands in a study file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Class = Literal["none", "easy", "medium", "hard", "unreachable", "unknown"]
Count = Annotated[int, Field(ge=1)]
Natural = Annotated[int, Field(ge=0)]


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class FileSource(_Strict):
    """Problems of a file, thinned in this order: ids, offset and every, classes, limit."""

    file: str = Field(
        description="problem file, relative to the study; scenes/NAME: a published set"
    )
    set: str | None = Field(default=None, description="name of the set (default: the file's)")
    ids: tuple[str | int, ...] | None = Field(default=None, description="only these")
    every: Count = Field(default=1, description="every so many")
    offset: Natural = Field(default=0, description="how many to skip at the beginning")
    classes: tuple[Class, ...] | None = Field(default=None, description="only of these classes")
    limit: Count | None = Field(default=None, description="at most so many")


class Generation(_Strict):
    """Shelves as of ``mamo problem generate shelf``, for each level and number of movables."""

    levels: tuple[Literal["easy", "medium", "hard"], ...] = Field(
        min_length=1, description="1, 2, or more movables in the way of the retrieval"
    )
    movables: tuple[Count, ...] = Field(min_length=1, description="numbers of movables")
    count: Count = Field(default=1, description="problems for each level and number")
    seed: Natural = Field(default=0, description="seed of the first; the others follow")


class GeneratedSource(_Strict):
    """Shelves that are generated; a set for each number of movables."""

    generate: Generation = Field(description="which ones")


class WorkspaceGeneration(_Strict):
    """Reaches as of ``mamo problem generate tabletop`` and ``refrigerator``."""

    workspace: Literal["tabletop", "refrigerator"] = Field(description="where to reach")
    movables: Natural | None = Field(
        default=None, description="number of movables (default: 6 or 3, as in the thesis)"
    )
    immovables: Count | None = Field(
        default=None, description="number of immovables with the target (default: 6 or 2)"
    )
    count: Count = Field(default=1, description="number of problems")
    seed: Natural = Field(default=0, description="seed of the first; the others follow")


class WorkspaceSource(_Strict):
    """Reaches in a workspace of thesis chapter 3 that are generated."""

    generate: WorkspaceGeneration = Field(description="which ones")
    set: str | None = Field(default=None, description="name of the set (default: the workspace's)")


Source = FileSource | GeneratedSource | WorkspaceSource


class RecipeEntry(_Strict):
    """A recipe with changes, under a name of its own."""

    recipe: str = Field(description="name of one of ours, or a file relative to the study")
    name: str | None = Field(default=None, description="in tables (default: the recipe's)")
    set: dict[str, Any] = Field(default_factory=dict, description="changes: dotted key to value")


class StudyFile(_Strict):
    """Problems x recipes x engines x seeds, each solved once."""

    schema_version: Literal[1] = Field(description="version of this format")
    name: str = Field(min_length=1, pattern=r"^[\w.-]+$", description="name of the study")
    problems: tuple[str | Source, ...] = Field(
        min_length=1, description="where problems come from; a file alone by its name"
    )
    recipes: tuple[str | RecipeEntry, ...] = Field(
        min_length=1, description="planners; one without changes by its name"
    )
    engines: tuple[str, ...] | None = Field(
        default=None, min_length=1, description="instead of the recipes' own"
    )
    seeds: tuple[Natural, ...] = Field(
        default=(0,), min_length=1, description="each problem is solved once with each"
    )
    budget: float = Field(default=60.0, gt=0.0, description="CPU s for planning a problem")
    deadline: float | None = Field(
        default=None, gt=0.0, description="wall s for a task (default: 4 x budget + 60)"
    )
    baseline: str | None = Field(
        default=None, description="recipe that others are compared with (default: the first)"
    )
