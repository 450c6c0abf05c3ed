"""Many solves in one process: OMPL's bindings crash, if they do, without a traceback."""

import subprocess
import sys

CODE = """
import numpy as np
from mamo_core.interfaces.arm_planner import ArmPlanStatus
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.robots import load_arm
from mamo_ompl.arm_planner import OmplArmPlanner
from mamo_ompl.kinds import KINDS

class Wall(CollisionWorld):
    def free(self, q):
        return ~((np.abs(q[:, 0] + 0.5) < 0.1) & (q[:, 1] < 0.2))

    def edges_free(self, starts, ends):
        shares = np.linspace(0.0, 1.0, 50)[:, None]
        return np.array([self.free(a + shares * (b - a)).all() for a, b in zip(starts, ends)])

arm = load_arm("pr2_right_arm")
start, goal = arm.home.copy(), arm.home.copy()
start[:2], goal[:2] = (-1.2, 0.0), (0.2, 0.0)
solved = 0
for seed in range(10):
    for kind in KINDS.values():
        planner = OmplArmPlanner(arm, kind, kind.options(max_checks=3000))
        plan = planner.plan(start, goal[None], Wall(), np.random.default_rng(seed))
        solved += plan.status is ArmPlanStatus.SOLVED
print("solved", solved)
"""


def test_no_crash_in_a_hundred_solves():
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", CODE],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    word, solved = done.stdout.split()
    assert word == "solved", done.stdout
    assert int(solved) >= 50
    assert done.stderr == "", "OMPL is to be quiet"
