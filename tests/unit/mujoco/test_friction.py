"""Friction is what the problem says: product between objects, the object's own on fixtures."""

import mujoco
import numpy as np
import pytest
from mamo_mujoco.options import MuJoCoOptions
from mamo_mujoco.world import build_model, index_of

from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Mobility, SceneObject

G = 9.81


def thing(name, shape, friction, mass=0.3, mobility=Mobility.MOVABLE):
    return SceneObject(name, shape, mobility, mass, friction)


def flat(height=0.04, width=0.12):
    return Box(np.array([width, width, height]))


def slide(problem, arm, name, speed, angle, seconds=0.6):
    """Displacements (n, 2) of all objects after ``name`` got a push at time 0."""
    options = MuJoCoOptions()
    model = build_model(problem, arm, options)
    index = index_of(model, problem, arm)
    data = mujoco.MjData(model)
    data.qpos[index.arm_qpos] = problem.home
    data.ctrl[: problem.home.size] = problem.home
    for _ in range(25):  # settle into the contacts
        mujoco.mj_step(model, data)
    before = data.xpos[index.bodies, :2].copy()
    place = index.free_qvel[list(index.free).index(problem.scene.index(name))]
    data.qvel[place : place + 2] = speed * np.cos(angle), speed * np.sin(angle)
    for _ in range(int(seconds / options.time_step)):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel[place : place + 2]).max() < 1e-2
    return data.xpos[index.bodies, :2] - before


ANGLES = [0.0, 22.5, 45.0]


@pytest.mark.parametrize("degrees", ANGLES)
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_sliding_distance_on_a_fixture(on_a_plain, arm, degrees, friction):
    """The floor's own friction of 1 does not matter; cones are round."""
    target = thing("target", flat(), 0.5, mobility=Mobility.TARGET)
    problem = on_a_plain(
        [thing("a", flat(), friction), target],
        [make_pose([5.0, 0.0, 0.02]), make_pose([5.0, 1.0, 0.02])],
    )
    angle = np.radians(degrees)
    moved = slide(problem, arm, "a", 0.8, angle)[0]
    assert np.linalg.norm(moved) == pytest.approx(0.8**2 / (2 * friction * G), rel=0.06)
    assert np.arctan2(moved[1], moved[0]) == pytest.approx(angle, abs=0.03)


@pytest.mark.parametrize("degrees", ANGLES)
def test_sliding_distance_on_an_object(on_a_plain, arm, degrees):
    """On a heavy slab: neither the larger coefficient nor the smaller, but the product."""
    slab = Box(np.array([1.0, 1.0, 0.1]))
    problem = on_a_plain(
        [
            thing("a", flat(), 0.5),
            thing("slab", slab, 0.8, mass=500.0),
            thing("target", flat(), 0.5, mobility=Mobility.TARGET),
        ],
        [make_pose([5.0, 0.0, 0.12]), make_pose([5.0, 0.0, 0.05]), make_pose([5.0, 1.0, 0.02])],
    )
    moved = slide(problem, arm, "a", 0.8, np.radians(degrees))
    distance = np.linalg.norm(moved[0] - moved[1])
    assert distance == pytest.approx(0.8**2 / (2 * 0.5 * 0.8 * G), rel=0.06)


def test_coefficients_in_the_model(cases, arm):
    problem = cases.problem
    model = build_model(problem, arm, MuJoCoOptions())
    assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    for item in problem.scene.objects:
        geom = model.geom(item.name)
        assert geom.friction[0] == item.friction
        assert geom.priority[0] == 1
    for fixture in problem.scene.fixtures:
        assert model.geom(fixture.name).priority[0] == 0
    frictions = {o.name: o.friction for o in problem.scene.objects}
    loose = [o.name for o in problem.scene.objects if o.mobility is not Mobility.IMMOVABLE]
    found = {}
    between = [p for p in range(model.npair) if not model.pair(p).name.startswith("self:")]
    for pair in between:
        one, other = (model.geom(int(g[pair])).name for g in (model.pair_geom1, model.pair_geom2))
        found[frozenset((one, other))] = tuple(model.pair_friction[pair, :2])
    assert found == {
        frozenset((a, b)): (frictions[a] * frictions[b],) * 2
        for i, a in enumerate(loose)
        for b in loose[i + 1 :]
    }


def test_robot_geoms_yield_to_objects(cases, arm):
    """The friction against the arm is the object's own: the higher priority decides."""
    model = build_model(cases.problem, arm, MuJoCoOptions())
    names = set(cases.problem.scene.entities)
    robot = [g for g in range(model.ngeom) if model.geom(g).name not in names]
    assert robot
    assert (model.geom_priority[robot] == 0).all()


def test_masses_in_the_model(cases, arm):
    model = build_model(cases.problem, arm, MuJoCoOptions())
    for item in cases.problem.scene.objects:
        assert model.body(item.name).mass[0] == item.mass
    for link in arm.links:
        assert model.body(f"link:{link.name}").mass[0] == pytest.approx(link.mass)


def test_overrides_reach_geoms_pairs_and_bodies(cases, model):
    """In a copy: the model itself is as before."""
    worlds = model._worlds
    before = worlds._model.pair_friction.copy(), worlds._model.body_mass.copy()
    changed = worlds(ParameterOverrides({"can": 0.7}, {"bystander": 0.25}))._model
    assert changed.body("can").mass[0] == 0.7
    ratio = changed.body("can").inertia / worlds._model.body("can").inertia
    np.testing.assert_allclose(ratio, 0.7 / 0.2)
    assert changed.geom("bystander").friction[0] == 0.25
    frictions = {o.name: o.friction for o in cases.problem.scene.objects} | {"bystander": 0.25}
    of_the_robot = [changed.pair(p).name.startswith("self:") for p in range(changed.npair)]
    assert any(of_the_robot)
    untouched = np.flatnonzero(of_the_robot)
    assert np.array_equal(changed.pair_friction[untouched], before[0][untouched])
    for pair in np.flatnonzero(np.logical_not(of_the_robot)):
        one, other = changed.pair(pair).name.split("|")
        assert changed.pair_friction[pair, 0] == frictions[one] * frictions[other]
    assert np.array_equal(worlds._model.pair_friction, before[0])
    assert np.array_equal(worlds._model.body_mass, before[1])


def test_unknown_objects_in_overrides_are_refused(cases, model):
    start = cases.problem.initial
    for overrides in (ParameterOverrides({"cna": 1.0}), ParameterOverrides({}, {"cna": 1.0})):
        with pytest.raises(KeyError, match="cna"):
            model.rollout(start, cases.still, parameters=overrides)


def test_a_cylinder_stands_as_it_slides(on_a_plain, arm):
    problem = on_a_plain(
        [
            thing("a", Cylinder(0.06, 0.04), 0.4),
            thing("target", flat(), 0.5, mobility=Mobility.TARGET),
        ],
        [make_pose([5.0, 0.0, 0.02]), make_pose([5.0, 1.0, 0.02])],
    )
    moved = slide(problem, arm, "a", 0.8, 0.3)[0]
    assert np.linalg.norm(moved) == pytest.approx(0.8**2 / (2 * 0.4 * G), rel=0.06)
