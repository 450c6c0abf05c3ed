"""Fingers and friction carry the target, unless it is too heavy, too slippery, or not held."""

from dataclasses import replace

import pytest

from mamo_core.errors import InputError
from mamo_core.friction_engine import friction_model
from mamo_core.plugins import discover
from mamo_core.types.motion import SegmentKind
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.verify_friction import check_friction, execute_by_friction


@pytest.fixture(scope="module")
def registry():
    return discover()


@pytest.fixture(scope="module")
def model(problem, registry):
    return friction_model(problem, registry)


def test_the_plan_holds_by_friction(problem, planner, plan, model):
    report = execute_by_friction(problem, plan, model, planner.context.robot)
    assert report.failures == ()
    (slip,) = report.slips
    assert slip.name == "target"
    assert slip.distance < 0.006
    assert slip.angle < 0.05
    assert slip.let_go == 0.0
    assert report.rollout.valid


def test_until_something_is_held_it_is_the_same_world(problem, planner, plan, model):
    """Pushes are not executed differently, bit for bit."""
    robot = planner.context.robot
    by_weld = planner.verify(plan).rollout
    by_friction = execute_by_friction(problem, plan, model, robot).rollout
    segments = [segment for motion in plan.motions for segment in motion.segments]
    first = next(n for n, segment in enumerate(segments) if segment.held is not None)
    for one, other in zip(
        by_weld.segment_states[: first + 1], by_friction.segment_states[: first + 1], strict=True
    ):
        assert (one.object_poses == other.object_poses).all()
        assert (one.joint_positions == other.joint_positions).all()
    last = first + 1
    assert (
        by_weld.segment_states[last].object_poses != by_friction.segment_states[last].object_poses
    ).any()


class Changed:
    """A model with other masses or frictions."""

    def __init__(self, model, **overrides):
        self._model, self._overrides = model, ParameterOverrides(**overrides)

    def rollout(self, state, motion, **options):
        return self._model.rollout(state, motion, parameters=self._overrides, **options)


@pytest.mark.parametrize(
    "overrides", [{"masses": {"target": 12.0}}, {"frictions": {"target": 0.02}}]
)
def test_what_is_too_heavy_or_too_slippery_stays_behind(problem, planner, plan, model, overrides):
    lost = check_friction(problem, plan, Changed(model, **overrides), planner.context.robot)
    assert any("'target' slips by " in text for text in lost), lost


def test_an_open_hand_leaves_the_target_behind(problem, planner, plan, model):
    """Executed to its end: an open finger pulls at it as the hand goes."""
    segments = plan.retrieval.segments
    reach = next(s for s in segments if s.kind is SegmentKind.REACH)
    agape = tuple(
        replace(s, opening=reach.opening) if s.held or s.closes_on else s for s in segments
    )
    open_handed = replace(plan, retrieval=replace(plan.retrieval, segments=agape))
    lost = execute_by_friction(problem, open_handed, model, planner.context.robot, stop_early=False)
    (slip,) = lost.slips
    assert slip.distance > 0.3
    assert lost.failures


@pytest.mark.parametrize("backend", ["pybullet", "dart"])
def test_engines_that_cannot_say_so(problem, registry, backend):
    with pytest.raises(InputError, match=f"backend '{backend}' holds things by welds alone"):
        friction_model(problem, registry, backend=backend)
