"""Which arms there are, and how each is cut out of its published model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mamo_core.types.geometry import Array


@dataclass(frozen=True, eq=False)
class ArmSpec:
    """A cut through a URDF of ``example-robot-data``.

    ``locked``: positions of other joints that matter (the rest stay at 0). ``tool_link`` is a URDF
    link; ``T_link_tool`` (4, 4) puts x along the fingers and y along their opening. ``cover_slack``
    (m), by link: how far planning spheres may reach beyond the surface; ``finger_slack`` that of
    the fingers, which work close to things. ``acceleration``, ``jerk``: of each of ``joints``, from
    data sheets. ``gripper_speed``: of the opening, m/s; ``gripper_force``: of each finger, N.
    ``finger_zone``: the stretch (m, behind the tool frame) in which the gap between the fingers is
    measured.
    """

    name: str
    urdf: str
    joints: tuple[str, ...]
    finger_joints: tuple[str, ...]
    tool_link: str
    T_link_tool: Array
    home: tuple[float, ...]
    finger_travel: float
    finger_zone: float
    cover_slack: Mapping[str, float]
    finger_slack: float
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]
    gripper_speed: float
    gripper_force: float
    locked: Mapping[str, float] = field(default_factory=dict)


def _translation(x: float, y: float, z: float) -> Array:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


# Hand z points along the fingers and y along their opening; the tool frame wants x and y there.
_PANDA_TOOL = np.array(
    [[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.1129], [0.0, 0.0, 0.0, 1.0]]
)

# The left arm is held as the right one's home in a mirror: beside the robot, behind what stands in
# front of it, where the published scenes begin with the right arm, too.
_LEFT_ARM = {
    "l_shoulder_pan_joint": 1.68651,
    "l_shoulder_lift_joint": -0.184315,
    "l_upper_arm_roll_joint": 1.67611,
    "l_elbow_flex_joint": -1.66215,
    "l_forearm_roll_joint": -0.285096,
    "l_wrist_flex_joint": -0.658798,
    "l_wrist_roll_joint": -1.41563,
}

PR2_RIGHT_ARM = ArmSpec(
    name="pr2_right_arm",
    urdf="pr2_description/urdf/pr2.urdf",
    joints=(
        "r_shoulder_pan_joint",
        "r_shoulder_lift_joint",
        "r_upper_arm_roll_joint",
        "r_elbow_flex_joint",
        "r_forearm_roll_joint",
        "r_wrist_flex_joint",
        "r_wrist_roll_joint",
    ),
    finger_joints=(
        "r_gripper_l_finger_joint",
        "r_gripper_l_finger_tip_joint",
        "r_gripper_r_finger_joint",
        "r_gripper_r_finger_tip_joint",
    ),
    tool_link="r_gripper_palm_link",
    T_link_tool=_translation(0.20, 0.0, 0.0),
    home=(-1.68651, -0.184315, -1.67611, -1.66215, 0.285096, -0.658798, 1.41563),
    finger_travel=0.548,
    finger_zone=0.05,
    cover_slack={
        "r_shoulder_pan_joint": 0.06,
        "r_shoulder_lift_joint": 0.05,
        "r_upper_arm_roll_joint": 0.035,
        "r_elbow_flex_joint": 0.03,
        "r_forearm_roll_joint": 0.02,
        "r_wrist_flex_joint": 0.012,
        "r_wrist_roll_joint": 0.007,
    },
    finger_slack=0.005,
    # No data sheet has them: docs/decisions/0022-time-parametrisation.md says where they are from.
    acceleration=(5.0, 5.0, 8.0, 8.0, 9.0, 7.5, 9.0),
    jerk=(100.0, 100.0, 160.0, 160.0, 180.0, 150.0, 180.0),
    # The fingers turn at 0.5 rad/s (URDF); wide open a radian opens them by 0.152 m.
    gripper_speed=0.075,
    gripper_force=50.0,
    locked={"torso_lift_joint": 0.1, **_LEFT_ARM},
)

PANDA = ArmSpec(
    name="panda",
    urdf="panda_description/urdf/panda.urdf",
    joints=tuple(f"panda_joint{i}" for i in range(1, 8)),
    finger_joints=("panda_finger_joint1", "panda_finger_joint2"),
    tool_link="panda_hand",
    T_link_tool=_PANDA_TOOL,
    home=(0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
    finger_travel=0.04,
    finger_zone=0.04,
    cover_slack={
        "panda_joint1": 0.05,
        "panda_joint2": 0.04,
        "panda_joint3": 0.035,
        "panda_joint4": 0.03,
        "panda_joint5": 0.009,
        "panda_joint6": 0.012,
        "panda_joint7": 0.01,
    },
    finger_slack=0.005,
    # Franka Control Interface documentation, control parameters: joint limits of the Panda.
    acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
    jerk=(7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0),
    gripper_speed=0.1,
    gripper_force=70.0,
)

SPECS: Mapping[str, ArmSpec] = {spec.name: spec for spec in (PR2_RIGHT_ARM, PANDA)}


def robot_data_folder() -> Path:
    """Where the ``example-robot-data`` wheel keeps its robots.

    Raises:
        FileNotFoundError: the wheel is not installed.
    """
    from importlib.metadata import files

    for entry in files("example-robot-data") or []:
        if entry.name == "panda.urdf":
            return Path(str(entry.locate())).resolve().parents[2]
    raise FileNotFoundError("the package example-robot-data holds no panda.urdf; reinstall it")
