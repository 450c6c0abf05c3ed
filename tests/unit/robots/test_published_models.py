"""Our arms are those of the published models: kinematics, masses, surfaces, grippers."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trimesh

from mamo_core.robots import load_arm
from mamo_core.robots.kinematics import finger_transforms, link_transforms, tool_transform
from mamo_core.robots.specs import SPECS, robot_data_folder

ARMS = sorted(SPECS)
MODELS = {}


def published(name):
    """The whole robot as published, in pinocchio."""
    if name not in MODELS:
        MODELS[name] = pin.buildModelFromUrdf(str(robot_data_folder() / SPECS[name].urdf))
    return MODELS[name]


def place(model, q, joint, value):
    """Write a joint position; continuous joints are cosine and sine in pinocchio."""
    number = model.getJointId(joint)
    at = model.joints[number].idx_q
    if model.joints[number].nq == 2:
        q[at : at + 2] = np.cos(value), np.sin(value)
    else:
        q[at] = value


def random_configurations(arm, count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(np.maximum(arm.lower, -4.0), np.minimum(arm.upper, 4.0), (count, arm.dof))


@pytest.mark.parametrize("name", ARMS)
def test_forward_kinematics_of_every_link(name):
    arm, spec, model = load_arm(name), SPECS[name], published(name)
    data = model.createData()
    tool = model.getFrameId(spec.tool_link)
    rng = np.random.default_rng(1)
    for configuration in random_configurations(arm, 200):
        opening = rng.uniform(arm.gripper.closed, arm.gripper.max_opening)
        q = pin.neutral(model)
        for joint, value in spec.locked.items():
            place(model, q, joint, value)
        for joint, value in zip(arm.joint_names, configuration, strict=True):
            place(model, q, joint, value)
        for joint in spec.finger_joints:
            place(model, q, joint, arm.gripper.drive(opening))
        pin.framesForwardKinematics(model, data, q)
        expected = data.oMf[tool].homogeneous @ spec.T_link_tool
        np.testing.assert_allclose(tool_transform(arm, configuration), expected, atol=1e-9)
        ours = link_transforms(arm, configuration, opening)
        for link, T in zip(arm.links, ours, strict=True):
            theirs = data.oMi[model.getJointId(link.name)].homogeneous
            np.testing.assert_allclose(T, theirs, atol=1e-9, err_msg=link.name)


def test_the_torso_of_the_pr2_is_up_by_ten_centimetres():
    raised = SPECS["pr2_right_arm"].locked["torso_lift_joint"]
    model = published("pr2_right_arm")
    data = model.createData()
    heights = []
    for torso in (0.0, raised):
        q = pin.neutral(model)
        place(model, q, "torso_lift_joint", torso)
        pin.forwardKinematics(model, data, q)
        heights.append(data.oMi[model.getJointId("r_shoulder_pan_joint")].translation[2])
    ours = link_transforms(load_arm("pr2_right_arm"), np.zeros(7), 0.0)[0][2, 3]
    assert ours == pytest.approx(heights[1], abs=1e-9)
    assert heights[1] - heights[0] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_mass_of_what_moves_is_kept(name):
    arm, model = load_arm(name), published(name)
    moving = model.subtrees[model.getJointId(arm.joint_names[0])]
    expected = sum(model.inertias[int(joint)].mass for joint in moving)
    assert sum(link.mass for link in arm.links) == pytest.approx(expected, rel=1e-12)
    assert all(link.mass > 0.0 for link in arm.links)


@pytest.mark.parametrize("name", ARMS)
def test_inertia_of_what_moves_is_kept(name):
    """The inertia of the whole stiff arm about the base, at one configuration."""
    arm, spec, model = load_arm(name), SPECS[name], published(name)
    data = model.createData()
    configuration = random_configurations(arm, 1, seed=5)[0]
    q = pin.neutral(model)
    for joint, value in spec.locked.items():
        place(model, q, joint, value)
    for joint, value in zip(arm.joint_names, configuration, strict=True):
        place(model, q, joint, value)
    pin.forwardKinematics(model, data, q)
    expected = pin.Inertia.Zero()
    for joint in model.subtrees[model.getJointId(arm.joint_names[0])]:
        expected += data.oMi[int(joint)].act(model.inertias[int(joint)])
    ours = pin.Inertia.Zero()
    drive = arm.gripper.drive_of_opening[0, 1]
    assert drive == 0.0
    for link, T in zip(arm.links, link_transforms(arm, configuration, 0.0), strict=True):
        ours += pin.SE3(T).act(pin.Inertia(link.mass, link.center_of_mass, link.inertia))
    np.testing.assert_allclose(ours.matrix(), expected.matrix(), atol=1e-9)


def hulls_of(link):
    return [trimesh.load(path, force="mesh") for path in link.hulls]


def beyond(hull, points):
    """How far (k,) points are outside of a convex mesh; negative inside."""
    offsets = np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])
    return (points @ hull.face_normals.T - offsets).max(axis=1)


@pytest.mark.parametrize("name", ARMS)
def test_spheres_cover_the_hulls(name):
    count = 0
    for link in load_arm(name).links:
        for hull in hulls_of(link):
            points, _ = trimesh.sample.sample_surface(hull, 1_800, seed=7)
            points = np.vstack([points, hull.vertices])
            gaps = np.linalg.norm(points[:, None] - link.spheres[None, :, :3], axis=2)
            outside = (gaps > link.spheres[:, 3] + 1e-6).all(axis=1)
            assert not outside.any(), f"{link.name}: {outside.sum()} points"
            count += len(points)
    assert count > 20_000


@pytest.mark.parametrize("name", ARMS)
def test_spheres_stick_out_by_the_slack_at_most(name):
    spec = SPECS[name]
    for link in load_arm(name).links:
        slack = spec.finger_slack if link.coordinate < 0 else spec.cover_slack[link.name]
        hulls = hulls_of(link)
        if hulls:
            reach = np.min([beyond(hull, link.spheres[:, :3]) for hull in hulls], axis=0)
            assert (reach + link.spheres[:, 3]).max() <= slack + 1e-5, link.name


@pytest.mark.parametrize("name", ARMS)
def test_hulls_contain_the_meshes(name):
    for link in load_arm(name).links:
        assert len(link.hulls) == len(link.meshes)
        for hull, path in zip(hulls_of(link), link.meshes, strict=True):
            mesh = trimesh.load(path, force="mesh")
            assert beyond(hull, mesh.vertices).max() < 1e-6, path.name


@pytest.mark.parametrize("name", ARMS)
def test_gripper_table(name):
    gripper = load_arm(name).gripper
    openings, drives = gripper.drive_of_opening.T
    assert (np.diff(openings) > 0.0).all()
    assert (np.diff(drives) > 0.0).all()
    assert 0.0 <= gripper.closed < 0.01
    assert gripper.max_opening > 0.07
    assert gripper.drive(gripper.max_opening) == pytest.approx(SPECS[name].finger_travel)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("opening", [0.02, 0.045, 0.07])
def test_the_gap_between_the_fingers_is_the_opening(name, opening):
    arm = load_arm(name)
    T_tool_link = np.linalg.inv(arm.T_link_tool)
    sides = []
    for number, T in finger_transforms(arm.links, arm.gripper.drive(opening)).items():
        for hull in hulls_of(arm.links[number]):
            hull.apply_transform(T_tool_link @ T)
            plane = [1.0, 0.0, 0.0], [-arm.gripper.depth, 0.0, 0.0]
            cut = trimesh.intersections.mesh_plane(hull, *plane).reshape(-1, 3)
            front = hull.vertices[hull.vertices[:, 0] >= -arm.gripper.depth]
            if len(front) + len(cut):
                sides.append(np.concatenate([front[:, 1], cut[:, 1]]))
    gap = min(y.min() for y in sides if y.mean() > 0) - max(y.max() for y in sides if y.mean() < 0)
    # Between the rows of the table the gap is interpolated.
    assert gap == pytest.approx(opening, abs=1e-3)


@pytest.mark.parametrize("name", ARMS)
def test_the_written_urdf_has_the_same_kinematics_in_pinocchio(name):
    arm = load_arm(name)
    model = pin.buildModelFromUrdf(str(arm.urdf))
    data = model.createData()
    assert model.nq == len(arm.links)
    for configuration in random_configurations(arm, 20, seed=2):
        q = np.zeros(model.nq)
        for link in arm.links:
            at = model.joints[model.getJointId(link.name)].idx_q
            drive = arm.gripper.drive(0.03)
            q[at] = drive if link.coordinate < 0 else configuration[link.coordinate]
        pin.forwardKinematics(model, data, q)
        for link, T in zip(arm.links, link_transforms(arm, configuration, 0.03), strict=True):
            theirs = data.oMi[model.getJointId(link.name)].homogeneous
            np.testing.assert_allclose(T, theirs, atol=1e-9, err_msg=link.name)


@pytest.mark.parametrize("name", ARMS)
def test_the_written_urdf_has_the_same_kinematics_and_masses_in_mujoco(name):
    arm = load_arm(name)
    model = mujoco.MjModel.from_xml_path(str(arm.urdf))
    data = mujoco.MjData(model)
    configuration = random_configurations(arm, 1, seed=3)[0]
    for link in arm.links:
        drive = arm.gripper.drive(0.03)
        at = model.jnt_qposadr[model.joint(link.name).id]
        data.qpos[at] = drive if link.coordinate < 0 else configuration[link.coordinate]
    mujoco.mj_kinematics(model, data)
    for link, T in zip(arm.links, link_transforms(arm, configuration, 0.03), strict=True):
        body = model.body(f"link_{link.name}").id
        np.testing.assert_allclose(data.xpos[body], T[:3, 3], atol=1e-8)
        np.testing.assert_allclose(data.xmat[body].reshape(3, 3), T[:3, :3], atol=1e-8)
        assert model.body_mass[body] == pytest.approx(link.mass)


@pytest.mark.parametrize("name", ARMS)
def test_home_is_within_the_limits(name):
    arm = load_arm(name)
    assert arm.within_limits(arm.home)
    assert not arm.within_limits(arm.upper + 0.1)
    assert (arm.lower < arm.upper).all()
    assert (arm.velocity > 0.0).all()
