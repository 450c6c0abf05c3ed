"""What stands in a plan file (``mamo schema plan``)."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from mamo_core.types.motion import SegmentKind

SCHEMA_VERSION = 2


class _Document(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


class SegmentDocument(_Document):
    """One stretch of a motion."""

    kind: SegmentKind = Field(description="what the arm does meanwhile")
    times: tuple[float, ...] = Field(min_length=1, description="s, from 0")
    positions: tuple[tuple[float, ...], ...] = Field(description="joint positions at times, rad")
    velocities: tuple[tuple[float, ...], ...] = Field(
        description="joint velocities at times, rad/s; cubics in between"
    )
    opening: float = Field(description="gap between the fingers at the end, m")
    held: str | None = Field(description="object attached to the tool")
    contact_free: bool = Field(description="nothing but what is in the hand may touch the arm")
    settle: float = Field(ge=0.0, description="longest wait for objects to rest, s")
    closes_on: str | None = Field(description="object the fingers close on, or let go of")


class MotionDocument(_Document):
    """Segments executed one after the other."""

    opening: float = Field(description="gap between the fingers at the start, m")
    segments: tuple[SegmentDocument, ...] = Field(min_length=1, description="in order")


class ActionDocument(_Document):
    """A rearrangement."""

    kind: str = Field(description="action generator that proposed it")
    object: str = Field(description="object it is meant to move")
    path: tuple[tuple[float, ...], ...] = Field(description="world xy to follow, m")
    motion: MotionDocument = Field(description="what the arm does, from where it is")
    info: dict[str, Any] = Field(description="remarks of the action generator")


class PlanFile(_Document):
    """A verified plan that replays itself."""

    schema_version: Literal[2] = Field(description="version of this format")
    problem: dict[str, Any] = Field(description="a problem document")
    recipe: dict[str, Any] = Field(description="the recipe it was planned with")
    seed: int = Field(description="seed of the search")
    status: Literal["solved"] = Field(description="only plans that were found are written")
    versions: dict[str, str] = Field(description="packages that made it")
    margin: dict[str, float] = Field(
        description="share of the worlds in which it holds, by how far they are off"
    )
    actions: tuple[ActionDocument, ...] = Field(description="rearrangements in order")
    retrieval: MotionDocument = Field(description="the motion that does the task, at the end")
