"""What a problem document holds; ``mamo schema problem`` prints this as JSON schema."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mamo_core.hookspecs import Options
from mamo_core.types.geometry import Box, Cylinder, Shape

SCHEMA_VERSION = 1

Positive = Annotated[float, Field(gt=0.0)]
Point = tuple[float, float, float]
Size = tuple[Positive, Positive, Positive]
Quaternion = tuple[float, float, float, float]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$")]


class PoseEntry(Options):
    """A pose: upright and turned by ``yaw``, or any orientation as ``quat_wxyz``."""

    position: Point = Field(description="x, y, z of the frame, m")
    yaw: float | None = Field(default=None, description="turn about z, rad (default 0)")
    quat_wxyz: Quaternion | None = Field(
        default=None, description="unit quaternion, instead of yaw"
    )

    @model_validator(mode="after")
    def _one_orientation(self) -> PoseEntry:
        if self.yaw is not None and self.quat_wxyz is not None:
            raise ValueError("expected 'yaw' or 'quat_wxyz', not both")
        if self.quat_wxyz is not None:
            norm = sum(v * v for v in self.quat_wxyz) ** 0.5
            if abs(norm - 1.0) > 1e-3:
                raise ValueError(f"quat_wxyz has length {norm:.4g}, expected 1")
        return self


class CylinderEntry(Options):
    """An upright cylinder."""

    radius: Positive = Field(description="m")
    height: Positive = Field(description="full height, m")


class SolidEntry(PoseEntry):
    """A named shape at a pose of its centre, world."""

    name: Name = Field(description="unique among objects and fixtures")
    box: Size | None = Field(default=None, description="FULL extents x, y, z, m")
    cylinder: CylinderEntry | None = Field(default=None, description="instead of box")

    @model_validator(mode="after")
    def _one_shape(self) -> SolidEntry:
        if (self.box is None) == (self.cylinder is None):
            raise ValueError("expected either 'box' or 'cylinder'")
        return self

    def shape(self) -> Shape:
        """The shape as a value."""
        if self.box is not None:
            return Box(self.box)  # type: ignore[arg-type]
        assert self.cylinder is not None
        return Cylinder(self.cylinder.radius, self.cylinder.height)


class FixtureEntry(SolidEntry):
    """A fixed part of the world."""

    friction: Positive = Field(default=1.0, description="multiplies the object's own coefficient")


class ObjectEntry(SolidEntry):
    """An object; the one named by ``target`` has no mobility of its own."""

    mobility: Literal["movable", "immovable"] | None = Field(
        default=None, description="may it be moved? (default movable; not for the target)"
    )
    mass: Positive = Field(description="kg")
    friction: Positive = Field(description="Coulomb's coefficient")


class RobotEntry(Options):
    """The arm: which one, where its base stands, where it starts and ends."""

    name: str = Field(description="canonical arm model, such as pr2_right_arm")
    base: PoseEntry = Field(
        default=PoseEntry(position=(0.0, 0.0, 0.0)), description="base in the world"
    )
    joints: tuple[float, ...] = Field(min_length=1, description="initial configuration, rad or m")
    home: tuple[float, ...] | None = Field(
        default=None, description="configuration to end in (default: the initial one), rad or m"
    )


class WorkspaceEntry(Options):
    """The box the objects belong in; its floor is the lower z."""

    lower: Point = Field(description="m, world")
    upper: Point = Field(description="m, world")
    overhang: Annotated[float, Field(ge=0.0)] = Field(
        default=0.05, description="how far objects may reach past the open side at -x, m"
    )


class GraspEntry(PoseEntry):
    """A grasp: the tool's pose in the target's frame while it is held."""

    approach: Positive = Field(description="straight distance along the tool's x axis before, m")
    opening: Positive = Field(description="gap between the fingers, m")


class ConstraintEntry(Options):
    """An interaction constraint by its registered name."""

    name: str = Field(description="name of the component")
    options: dict[str, Any] = Field(default_factory=dict, description="its options, SI units")


class ProblemDocument(Options):
    """A problem of manipulation among movable objects; SI units and radians throughout."""

    schema_version: Literal[1] = Field(description="version of this format")
    name: Name = Field(description="name of the problem")
    robot: RobotEntry = Field(description="the arm")
    workspace: WorkspaceEntry = Field(description="where the objects belong")
    fixtures: tuple[FixtureEntry, ...] = Field(
        default=(), description="walls and boards, which nothing moves"
    )
    objects: tuple[ObjectEntry, ...] = Field(
        min_length=1, description="everything that stands there, the target among them"
    )
    target: str = Field(description="name of the object to retrieve, or to reach for")
    task: Literal["retrieve", "reach"] = Field(
        default="retrieve",
        description="retrieve: grasp the target and carry it home; reach: bring the open hand to "
        "where the approach of one of the grasps begins",
    )
    grasps: Literal["auto"] | tuple[GraspEntry, ...] = Field(
        default="auto", description="ways to hold the target, best first; auto: side grasps"
    )
    constraints: tuple[ConstraintEntry, ...] | None = Field(
        default=None, description="interaction constraints (default: contact, tilt, speed, bounds)"
    )


def problem_schema() -> dict[str, Any]:
    """JSON schema of a problem document."""
    return ProblemDocument.model_json_schema()
