"""What a process has just compiled gives the digits that others read from the cache."""

import os
import subprocess
import sys

SWEPT = """
import numpy as np
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker
from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm

arm, problem = load_arm("pr2_right_arm"), generate_shelf(movables=3, seed=1)
checker = SphereChecker(problem.scene, arm, SphereCheckerOptions())
home = problem.initial.joint_positions
path = home + np.random.default_rng(0).normal(scale=0.4, size=(40, home.size))
print(checker.swept_region(path, opening=0.05).lowest.tobytes().hex())
"""


def digits(cache):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", SWEPT], capture_output=True, text=True, env=environment, check=True
    )
    return done.stdout


def test_the_first_process_computes_what_later_ones_do(tmp_path):
    first = digits(tmp_path)
    assert any(tmp_path.rglob("*.nbi")), "nothing was compiled"
    assert digits(tmp_path) == first
