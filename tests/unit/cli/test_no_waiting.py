"""After the kernels are loaded nothing is compiled while a plan is sought, verified and written."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

SCRIPT = """
import sys
from numba.core.dispatcher import Dispatcher
from mamo_core.cli import planning
from mamo_core.cli.main import main

def compiled():
    modules = [m for n, m in list(sys.modules.items()) if n.startswith("mamo_")]
    kernels = {id(k): k for m in modules for k in vars(m).values() if isinstance(k, Dispatcher)}
    return {f"{k.py_func.__module__}.{k.__name__}": list(k.signatures) for k in kernels.values()}

load, before = planning.load_kernels, {}

def load_and_look(*arguments):
    load(*arguments)
    before.update(compiled())

planning.load_kernels = load_and_look
try:
    main(sys.argv[1:])
except SystemExit as done:
    assert done.code == 0, done.code
after = compiled()
assert "mamo_core.robots.timing_kernels.smooth_rows" in after
assert "mamo_geometry.kernels.free_batch" in after
new = {name: found for name, found in after.items() if found != before.get(name, [])}
assert not new, new
"""


def test_no_plan_waits_for_a_compiler(tmp_path):
    problem = ROOT / "problems" / "shelf_5_easy_seed1.yaml"
    order = ["plan", str(problem), "--seed", "0", "-o", str(tmp_path / "plan.json")]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *order],
        capture_output=True,
        text=True,
        env=os.environ,
        check=False,
    )
    assert done.returncode == 0, done.stderr
