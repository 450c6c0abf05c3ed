"""All checks: the name, the promise in a line, the capability it needs, and its grade."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mamo_core.testing.conformance import (
    arm,
    constraints,
    friction,
    isolation,
    repeatability,
    reporting,
    standing,
)
from mamo_core.testing.conformance.bench import Bench


@dataclass(frozen=True)
class Check:
    """``run`` returns a measured figure in words, if it has one, or raises CheckFailedError.

    ``grade``: how exact a backend is that passes, unless it declares itself less.
    """

    name: str
    promise: str
    run: Callable[[Bench], str | None]
    needs: str | None = None
    grade: str = "exact"


_D = "dynamics"
_BITS = "bit-exact"
_ONSET = "within 60 ms"


CHECKS: tuple[Check, ...] = (
    Check(
        "same_arguments",
        "the same arguments give the same bits",
        repeatability.same_arguments,
        grade=_BITS,
    ),
    Check("order", "what ran before does not matter (A, B, A)", repeatability.order, grade=_BITS),
    Check("models", "a new model gives the same bits", repeatability.models, grade=_BITS),
    Check("processes", "a new process gives the same bits", repeatability.processes, grade=_BITS),
    Check("arguments", "arguments are left alone", repeatability.arguments),
    Check("batch", "a batch is a loop", repeatability.batch, grade=_BITS),
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
        grade=_BITS,
    ),
    Check(
        "continuation",
        "stopped in mid-push, it goes on as if it had not been",
        repeatability.continuation,
        "exact_continuation",
        grade=_BITS,
    ),
    Check(
        "foreign_continuation",
        "a continuation of another model is refused",
        repeatability.foreign_continuation,
    ),
    Check("still", "nothing moves while the arm rests", reporting.still, grade="within 1 mm"),
    Check("final_state", "the final state is complete", reporting.final_state),
    Check("arrival", "the arm arrives", reporting.arrival, grade="within 0.05 rad"),
    Check("push", "a push moves what it meets", reporting.push),
    Check("moved", "moved names what moved", reporting.moved),
    Check("contact_pairs", "contacts name the pairs that touch", reporting.contact_pairs),
    Check("segment_states", "segment states are the starts", reporting.segment_states),
    Check("trace", "a trace is on the grid and changes nothing", reporting.trace, grade=_BITS),
    Check("early_stop", "early stop ends at the first violation", reporting.early_stop),
    Check("time_order", "violations come in time order", reporting.time_order),
    Check(
        "forward_kinematics",
        "the tool is where our kinematics has it",
        arm.forward_kinematics,
        "tool_pose",
        grade="within 1e-6",
    ),
    Check(
        "rest",
        "objects at rest stay for 5 s",
        standing.rest,
        _D,
        grade="within 0.2 mm and 0.2 deg",
    ),
    Check(
        "stacks",
        "stacked and leaning objects stay",
        standing.stacks,
        _D,
        grade="within 2 mm and 1 deg",
    ),
    Check(
        "sliding",
        "boxes slide as far as friction lets them, at 0, 22.5 and 45 degrees",
        friction.sliding,
        _D,
        grade="within 6 %",
    ),
    Check(
        "immovables",
        "a state says where immovable objects stand",
        standing.immovables,
        grade=_ONSET,
    ),
    Check(
        "tipping",
        "low pushes slide a box, high pushes tip it",
        standing.tipping,
        _D,
        grade="within a factor of 2.2",
    ),
    Check(
        "incline",
        "a box slides from the friction angle on",
        friction.incline,
        _D,
        grade="within 10 %",
    ),
    Check(
        "object_friction",
        "between two objects friction is the product",
        friction.object_friction,
        "friction_product",
        grade="within 30 %",
    ),
    Check(
        "fixture_friction",
        "a fixture's friction multiplies the object's",
        friction.fixture_friction,
        "friction_product",
        grade="within 10 %",
    ),
    Check(
        "half_friction",
        "half the friction, twice the way",
        friction.half_friction,
        _D,
        grade="within 10 %",
    ),
    Check(
        "double_mass",
        "twice the mass shoves farther",
        friction.double_mass,
        _D,
        grade="approximated",
    ),
    Check("attachment", "a held object follows the hand", arm.attachment, _D, grade="within 5 mm"),
    Check("tracking", "the arm follows its trajectory", arm.tracking, _D, grade="within 20 mm"),
    Check("stall", "an arm that cannot go on is reported", arm.stall, _D, grade="within 12 cm"),
    Check(
        "robot_touches_immovable",
        "contact of robot and immovable, at its time",
        constraints.robot_touches_immovable,
        _D,
        grade=_ONSET,
    ),
    Check(
        "robot_touches_target",
        "contact of robot and target before the grasp",
        constraints.robot_touches_target,
        _D,
        grade=_ONSET,
    ),
    Check(
        "robot_touches_fixture",
        "contact of robot and fixture",
        constraints.robot_touches_fixture,
        _D,
        grade=_ONSET,
    ),
    Check(
        "robot_touches_itself",
        "contact of the arm and another part of the robot",
        constraints.robot_touches_itself,
        "self_contact",
        grade=_ONSET,
    ),
    Check(
        "object_touches_immovable",
        "contact of a pushed object and an immovable",
        constraints.object_touches_immovable,
        _D,
        grade=_ONSET,
    ),
    Check(
        "object_touches_target",
        "contact of a pushed object and the target",
        constraints.object_touches_target,
        _D,
        grade=_ONSET,
    ),
    Check(
        "clearance",
        "what comes near counts as touching, and nothing else changes",
        constraints.clearance,
        "clearance",
        grade=_ONSET,
    ),
    Check("tilt", "tilt is seen at its limit", constraints.tilt, _D, grade="within 6 deg"),
    Check("speed", "speed is seen at its limit", constraints.speed, _D, grade=_ONSET),
    Check("bounds", "a falling object is seen", constraints.bounds, _D, grade="within 0.8 s"),
    Check(
        "penetration",
        "what is pressed into something is seen",
        constraints.penetration,
        _D,
        grade="within 10 %",
    ),
    Check("nothing_else", "no constraint fires without cause", constraints.nothing_else, _D),
    Check(
        "killed",
        "a killed engine process loses one rollout, nothing else",
        isolation.killed,
        "isolated",
    ),
)
