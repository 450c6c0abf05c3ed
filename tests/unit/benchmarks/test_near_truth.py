"""Plans are replayed with other masses and frictions, about the problem's own."""

from pathlib import Path

import near_truth
import numpy as np
import pytest

from mamo_core.cli.main import main
from mamo_core.problems import load_problem
from mamo_core.types.scene import Mobility

PROBLEM = Path(__file__).parents[3] / "problems/shelf_5_easy_seed1.yaml"


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("near_truth") / "plan.json"
    with pytest.raises(SystemExit) as end:
        main(["plan", str(PROBLEM), "--planner", "m4m", "-o", str(path)])
    assert end.value.code == 0
    return path


def test_a_plan_holds_with_its_own_values_and_not_with_any(plan, capsys):
    assert near_truth.main([str(plan), "--times", "2", "--spread", "0"]) == 0
    assert capsys.readouterr().out.split() == ["all", "1", "100.0", "%"]
    assert near_truth.main([str(plan), "--times", "8", "--spread", "3"]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith("plan ")
    assert first.split()[-2:] == last.split()[-2:] != ["100.0", "%"]


def test_what_is_drawn_is_about_the_problems_own():
    scene = load_problem(str(PROBLEM)).scene
    values = near_truth.drawn(scene, 0.02, np.random.default_rng(0))
    loose = [o for o in scene.objects if o.mobility is not Mobility.IMMOVABLE]
    assert set(values.masses) == set(values.frictions) == {o.name for o in loose}
    shares = np.array([values.masses[o.name] / o.mass for o in loose])
    assert 0.0 < np.abs(shares - 1.0).max() < 0.1
