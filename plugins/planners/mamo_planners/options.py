"""Options of retrieval and actions, apart from the code that uses them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from mamo_core.hookspecs import Options


class RetrievalOptions(Options):
    """Options of ``grasp_and_extract``."""

    grasps: int = Field(
        8, ge=1, description="the problem's grasps are looked at, in its order, until so many work"
    )
    branches: int = Field(8, ge=1, description="arm configurations tried per grasp")
    lift: float = Field(0.075, gt=0.0, le=0.3, description="largest lift of the target, m")
    ceiling_gap: float = Field(0.015, gt=0.0, description="distance kept from the ceiling, m")
    joint_speed: float = Field(0.5, gt=0.0, le=1.0, description="share of the velocity limits")
    reach_speed: float = Field(0.25, gt=0.0, description="tool speed towards the grasp, m/s")
    carry_speed: float = Field(0.6, gt=0.0, description="tool speed while holding, m/s")
    tries: int = Field(4, ge=1, description="grasps whose whole retrieval is tried per call")


class PushOptions(Options):
    """Options of ``push``."""

    geometry: Literal["rich", "thesis"] = Field(
        "rich", description="rich: many tool poses per goal; thesis: one yaw, pitch and stand-off"
    )
    samples: int = Field(6, ge=1, description="pushes proposed per object and goal")
    poses: int = Field(40, ge=1, description="tool poses per goal that reach inverse kinematics")
    starts: int = Field(12, ge=1, description="arm configurations per goal that are kept")
    branches: int = Field(2, ge=1, description="arm configurations tried per tool pose")
    floor_gap: float = Field(0.004, ge=0.0, description="distance of the hand from the floor, m")
    overshoot: float = Field(0.01, ge=0.0, description="length pushed beyond the goal, m")
    sweep_speed: float = Field(0.25, gt=0.0, description="tool speed while pushing, m/s")
    joint_speed: float = Field(0.5, gt=0.0, le=1.0, description="share of the velocity limits")
    settle: float = Field(1.0, ge=0.0, description="longest wait for objects to rest, s")
    shortest: float = Field(0.02, gt=0.0, description="shortest push worth trying, m")
    longest: float | None = Field(
        None, gt=0.0, description="longest push, m; an object that is to go farther goes so far"
    )
    alike: float = Field(
        0.0,
        ge=0.0,
        description="a push that would lead this close (m) to where one with about the same hand "
        "failed from the same rearrangement, or through there, is not tried; 0: all are",
    )


class TurnOptions(Options):
    """Options of ``turn``."""

    samples: int = Field(4, ge=1, description="pushes proposed per object and request")
    per_line: int = Field(2, ge=1, description="of these, with the hand going along one line")
    lines: int = Field(24, ge=1, description="lines for the hand that are looked at per request")
    longest: float = Field(0.15, gt=0.0, description="longest push, m")
    gain: int = Field(
        2, ge=1, description="steps (1 cm, or a turn by as much) that a push brings the box nearer"
    )
    least_share: float = Field(
        0.6,
        gt=0.0,
        le=1.0,
        description="what a line gains counts by a share drawn from here to 1 in their order",
    )


class PickPlaceOptions(Options):
    """Options of ``pick_place``."""

    samples: int = Field(3, ge=1, description="actions proposed per object and goal")
    grasps: int = Field(16, ge=1, description="grasps per request that reach inverse kinematics")
    branches: int = Field(4, ge=1, description="arm configurations tried per grasp")
    places: int = Field(24, ge=1, description="places drawn per request")
    nearby: float = Field(
        0.08,
        ge=0.0,
        description="how far from the end of its path an object may be put instead, m; thesis: 0",
    )
    shortest: float = Field(0.02, gt=0.0, description="shortest displacement worth a try, m")
    draws: int = Field(160, ge=1, description="random positions looked at for these places")
    drops: int = Field(2, ge=1, description="places per grasp that the carry may end at")
    spacing: float = Field(0.01, ge=0.0, description="distance of drawn places to others, m")
    widest_yaw: float = Field(
        1.8, gt=0.0, description="largest angle between the hand and straight into the shelf, rad"
    )
    largest_tilt_deg: float = Field(
        5.0, gt=0.0, le=25.0, description="objects that lean more are not grasped, degrees"
    )
    lift: float = Field(0.04, gt=0.0, le=0.3, description="largest lift of the object, m")
    ceiling_gap: float = Field(0.01, gt=0.0, description="distance kept from the ceiling, m")
    drop_height: float = Field(0.002, ge=0.0, description="fall of the object when let go, m")
    clearance: float = Field(
        0.02, ge=0.0, description="distance of the arm to every object at the end, m"
    )
    max_checks: int = Field(10_000, ge=1, description="configurations checked per arm path")
    joint_speed: float = Field(0.5, gt=0.0, le=1.0, description="share of the velocity limits")
    reach_speed: float = Field(0.25, gt=0.0, description="tool speed to and from the object, m/s")
    lift_speed: float = Field(0.15, gt=0.0, description="tool speed up and down, m/s")
    carry_speed: float = Field(0.4, gt=0.0, description="tool speed while carrying, m/s")
    settle: float = Field(1.0, ge=0.0, description="longest wait for objects to rest, s")
