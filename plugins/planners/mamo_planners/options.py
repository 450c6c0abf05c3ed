"""Options of retrieval, actions and searches, apart from the code that uses them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from mamo_core.hookspecs import Options


class RetrievalOptions(Options):
    """Options of ``grasp_and_extract``."""

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


class GreedyOptions(Options):
    """Options of ``greedy`` (M4M)."""

    iterate: bool = Field(True, description="solve the MAPF problem again after every valid push")
    regions: int = Field(
        4, ge=1, description="retrievals drawn for the NGR; the least occupied one is taken"
    )
    grasp_tries: int = Field(3, ge=1, description="retrievals tried at one state")
    rounds: int = Field(6, ge=1, description="MAPF calls at one state without a valid push")
    agnostic: int = Field(
        8, ge=0, description="goal-agnostic pushes tried per state when guided ones fail"
    )
    max_actions: int = Field(25, ge=1, description="actions of one attempt")
    attempts: int = Field(1000, ge=1, description="restarts from the initial scene")
    hopeless_attempts: int = Field(
        6, ge=1, description="attempts without any retrieval, movables ignored, before giving up"
    )
    goal_margin: float = Field(0.015, ge=0.0, description="distance of MAPF goals to the NGR, m")
    mapf_nodes: int = Field(300, ge=1, description="high-level nodes per MAPF call")
    mapf_expansions: int = Field(60_000, ge=1, description="low-level expansions per MAPF call")
