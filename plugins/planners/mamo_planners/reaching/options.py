"""Options of the planners that reach, apart from the code that uses them."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class MotionOptions(Options):
    """How fast the arm moves."""

    joint_speed: float = Field(0.5, gt=0.0, le=1.0, description="share of the velocity limits")
    sweep_speed: float = Field(0.25, gt=0.0, description="tool speed while it may push, m/s")
    settle: float = Field(1.0, ge=0.0, description="longest wait for objects to rest, s")


class PrimitiveOptions(Options):
    """Joint primitives, and multi-heuristic A* over them (thesis 3.3.1, 3.4.1)."""

    large_step_deg: float = Field(
        7.0, gt=0.0, le=20.0, description="primitive of the first four joints, degrees"
    )
    small_step_deg: float = Field(
        4.0, gt=0.0, le=20.0, description="primitive of the other joints, degrees"
    )
    resolution: float = Field(0.02, gt=0.0, description="cells of the 3-D heuristic, m")
    hand_radius: float = Field(
        0.03, ge=0.0, description="obstacles are grown by this for the 3-D heuristic, m"
    )
    w1: float = Field(100.0, ge=1.0, description="inflation of every heuristic")
    w2: float = Field(
        1e6,
        ge=1.0,
        description="how much worse than the anchor's a queue's best state may be; a small one "
        "starves the other queues once the anchor is near a goal",
    )


class ArmLatticeOptions(PrimitiveOptions):
    """Options of ``mha_star``."""

    max_checks: int = Field(10_000, ge=1, description="edges checked per query")


class LatticeOptions(PrimitiveOptions, MotionOptions):
    """A search over primitives whose motions may push."""


class SpampOptions(LatticeOptions):
    """Options of ``spamp``; the thesis' values where it gives any."""

    delta: float = Field(
        0.2,
        gt=0.0,
        description="distance of the tool to the goal, around immovables, within which adaptive "
        "motion primitives begin, m (3.3.3)",
    )
    subgoals: int = Field(3, ge=0, description="the thesis' N: subgoals that guide the search")
    samples: int = Field(
        8, ge=0, description="the thesis' M: adaptive motion primitives that are drawn for them"
    )
    enough: int = Field(
        1, ge=1, description="draw no more once so many are valid (the thesis: all M are drawn)"
    )
    simulate_samples: bool = Field(
        True, description="simulate what is drawn, so that valid ones are preferred"
    )
    t_sim: float = Field(
        0.5,
        ge=0.0,
        description="estimated CPU time before the search simulates primitives of its own, s, if "
        "there is a valid subgoal (the thesis: 30, with simulations of 1.5 s each)",
    )
    beta: float | None = Field(
        0.5,
        gt=0.0,
        description="distance to a primitive that failed within which another one is put off, rad "
        "(3.3.6; null: never)",
    )
    growth: float = Field(
        0.1, ge=0.0, description="share of delta that each round adds to it (the thesis: 0)"
    )
    via: float = Field(
        0.5,
        ge=0.0,
        le=1.0,
        description="share of the primitives drawn from the second round on that bend at a "
        "configuration where they may push already (the thesis: 0)",
    )
    vary: float = Field(
        0.5,
        ge=0.0,
        le=1.0,
        description="share of the primitives drawn from the second round on that vary one of which "
        "nearly reached its goal (the thesis: 0)",
    )
    slow_speed: float = Field(
        0.1,
        gt=0.0,
        description="as sweep_speed, in every second round: what is pushed slowly tips less, m/s",
    )
    expansions: int = Field(
        20,
        ge=1,
        description="states expanded in the first round; later rounds follow Luby's sequence",
    )
    widest: float = Field(0.5, gt=0.0, description="delta does not grow beyond this, m")
    connect: bool = Field(
        True,
        description="ask the arm planner for the way to valid subgoals before the search (thesis: "
        "false)",
    )
    snap: bool = Field(
        True,
        description="try the straight motion to a valid subgoal from every state (thesis: false)",
    )
    rounds: int = Field(
        1000, ge=1, description="searches, each with subgoals of its own (the thesis: 1)"
    )
