"""Plans are replayed with other masses and frictions, about the problem's own."""

from pathlib import Path

import near_truth
import pytest

from mamo_core.cli.main import main

PROBLEM = Path(__file__).parents[3] / "problems/shelf_5_easy_seed1.yaml"


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("near_truth") / "plan.json"
    robust = ["--planner", "m4m", "--set", "search.nearby={}"]
    with pytest.raises(SystemExit) as end:
        main(["plan", str(PROBLEM), *robust, "-o", str(path)])
    assert end.value.code == 0
    return path


def test_a_plan_holds_with_its_own_values_and_not_with_any(plan, capsys):
    assert near_truth.main([str(plan), "--times", "2", "--spread", "0"]) == 0
    assert capsys.readouterr().out.split() == ["all", "1", "100.0", "%"]
    assert near_truth.main([str(plan), "--times", "8", "--spread", "3"]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith("plan ")
    assert first.split()[-2:] == last.split()[-2:] != ["100.0", "%"]
