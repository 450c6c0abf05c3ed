"""All checks: the name, the promise in a line, and the capability without which it has no sense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mamo_core.testing.conformance import (
    constraints,
    isolation,
    physics,
    repeatability,
    reporting,
)
from mamo_core.testing.conformance.bench import Bench


@dataclass(frozen=True)
class Check:
    """``run`` returns a measured figure in words, if it has one, or raises CheckFailedError."""

    name: str
    promise: str
    run: Callable[[Bench], str | None]
    needs: str | None = None


_D = "dynamics"


CHECKS: tuple[Check, ...] = (
    Check("same_arguments", "the same arguments give the same bits", repeatability.same_arguments),
    Check("order", "what ran before does not matter (A, B, A)", repeatability.order),
    Check("models", "a new model gives the same bits", repeatability.models),
    Check("processes", "a new process gives the same bits", repeatability.processes),
    Check("arguments", "arguments are left alone", repeatability.arguments),
    Check("batch", "a batch is a loop", repeatability.batch),
    Check(
        "overrides_act",
        "other masses and frictions change the outcome",
        repeatability.overrides_act,
        "parameter_overrides",
    ),
    Check(
        "overrides_end",
        "and leave nothing behind",
        repeatability.overrides_end,
        "parameter_overrides",
    ),
    Check(
        "continuation",
        "continued twice, it is the whole execution bit for bit",
        repeatability.continuation,
        "exact_continuation",
    ),
    Check(
        "foreign_continuation",
        "a continuation of another model is refused",
        repeatability.foreign_continuation,
    ),
    Check("still", "nothing moves while the arm rests", reporting.still),
    Check("final_state", "the final state is complete", reporting.final_state),
    Check("arrival", "the arm arrives", reporting.arrival),
    Check("push", "a push moves what it meets", reporting.push),
    Check("moved", "moved names what moved", reporting.moved),
    Check("contact_pairs", "contacts name the pairs that touch", reporting.contact_pairs),
    Check("segment_states", "segment states are the starts", reporting.segment_states),
    Check("trace", "a trace is on the grid and changes nothing", reporting.trace),
    Check("early_stop", "early stop ends at the first violation", reporting.early_stop),
    Check("time_order", "violations come in time order", reporting.time_order),
    Check(
        "forward_kinematics",
        "the tool is where our kinematics has it, within 1e-6",
        physics.forward_kinematics,
        "tool_pose",
    ),
    Check("rest", "objects at rest stay for 5 s within 0.2 mm and 0.2 degrees", physics.rest, _D),
    Check("stacks", "stacked and leaning objects stay", physics.stacks, _D),
    Check("sliding", "boxes slide as far as friction lets them, within 6 %", physics.sliding, _D),
    Check("tipping", "low pushes slide a box, high pushes tip it", physics.tipping, _D),
    Check("incline", "a box slides from the friction angle on", physics.incline, _D),
    Check(
        "object_friction",
        "between two objects friction is the product",
        physics.object_friction,
        "friction_product",
    ),
    Check(
        "fixture_friction",
        "a fixture's friction multiplies the object's",
        physics.fixture_friction,
        "friction_product",
    ),
    Check("half_friction", "half the friction, twice the way", physics.half_friction, _D),
    Check("double_mass", "twice the mass shoves farther", physics.double_mass, _D),
    Check("attachment", "a held object follows the hand", physics.attachment, _D),
    Check("tracking", "the arm follows its trajectory", physics.tracking, _D),
    Check("stall", "an arm that cannot go on is reported", physics.stall, _D),
    Check(
        "robot_touches_immovable",
        "contact of robot and immovable, at its time",
        constraints.robot_touches_immovable,
        _D,
    ),
    Check(
        "robot_touches_target",
        "contact of robot and target before the grasp",
        constraints.robot_touches_target,
        _D,
    ),
    Check(
        "robot_touches_fixture",
        "contact of robot and fixture",
        constraints.robot_touches_fixture,
        _D,
    ),
    Check(
        "object_touches_immovable",
        "contact of a pushed object and an immovable",
        constraints.object_touches_immovable,
        _D,
    ),
    Check(
        "object_touches_target",
        "contact of a pushed object and the target",
        constraints.object_touches_target,
        _D,
    ),
    Check("tilt", "tilt is seen at its limit", constraints.tilt, _D),
    Check("speed", "speed is seen at its limit", constraints.speed, _D),
    Check("bounds", "a falling object is seen", constraints.bounds, _D),
    Check("nothing_else", "no constraint fires without cause", constraints.nothing_else, _D),
    Check(
        "killed",
        "a killed engine process loses one rollout, nothing else",
        isolation.killed,
        "isolated",
    ),
)
