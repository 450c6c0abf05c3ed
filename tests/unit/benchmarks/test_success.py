"""Rows, resuming, and a real run of the success benchmark on tiny sets."""

import json

import pytest
import success
from success_rows import RowFile, identity
from success_runner import Picked, Runner, difficulty, pick

from mamo_core.cli.planning import chosen_recipe
from mamo_core.errors import InputError
from mamo_core.problems import generate_shelf, save_problems

KEYS = {
    "id",
    "set",
    "movables",
    "difficulty",
    "status",
    "verified",
    "cpu_s",
    "parts",
    "actions",
    "rollouts",
    "valid_rollouts",
    "causes",
    "reason",
    "code",
}


@pytest.fixture
def tiny(tmp_path):
    path = tmp_path / "tiny.jsonl.gz"
    save_problems([generate_shelf(movables=1, seed=seed) for seed in (1, 2, 3, 4)], path)
    return path


def test_every_and_limit(tiny):
    assert [p.id for p in pick([tiny], every=2)] == ["shelf_1_seed1", "shelf_1_seed3"]
    assert [p.key for p in pick([tiny], limit=1)] == [("tiny", "shelf_1_seed1")]


@pytest.mark.parametrize(
    ("in_the_way", "expected"),
    [(None, "unreachable"), (0, "none"), (1, "easy"), (2, "medium"), (3, "hard"), (7, "hard")],
)
def test_difficulty(in_the_way, expected):
    assert difficulty(in_the_way) == expected


def test_rows_are_kept_and_continued(tmp_path, capsys):
    path = tmp_path / "out.json"
    first = RowFile(path, {"seed": 0})
    first.load()
    first.add({"set": "a", "id": "1", "verified": True})
    second = RowFile(path, {"seed": 0})
    second.load()
    assert second.find(("a", "1"))["verified"]
    assert second.find(("a", "2")) is None
    assert "1 finished rows kept" in capsys.readouterr().err


def test_rows_of_other_code_are_kept_with_a_warning(tmp_path, capsys, monkeypatch):
    path = tmp_path / "out.json"
    RowFile(path, {}).add({"set": "a", "id": "1"})
    monkeypatch.setattr("success_rows.code_version", lambda: "other")
    RowFile(path, {}).load()
    assert "warning: some are of other code" in capsys.readouterr().err


def test_rows_of_other_arguments_are_refused_unless_fresh(tmp_path):
    path = tmp_path / "out.json"
    RowFile(path, {"seed": 0}).add({"set": "a", "id": "1"})
    other = RowFile(path, {"seed": 1})
    with pytest.raises(InputError, match="another recipe, budget or seed"):
        other.load()
    other.load(fresh=True)
    assert other.rows == []


@pytest.mark.parametrize("text", ["", "[]", '{"rows": []}'])
def test_other_files_are_not_overwritten(tmp_path, text):
    path = tmp_path / "out.json"
    path.write_text(text)
    with pytest.raises(InputError, match="not a result of this benchmark"):
        RowFile(path, {}).load()


def test_identity_tells_settings_apart():
    once = chosen_recipe("m4m", None, ("search.iterate=false",))
    assert identity(once, 1.0, 0) != identity(chosen_recipe("m4m"), 1.0, 0)


def test_a_crash_is_a_row():
    def load():
        raise ValueError("broken scene")

    row = Runner("m4m", (), 1.0, 0).row(Picked("a", "1", load))
    assert (row["status"], row["verified"]) == ("error", False)
    assert row["reason"] == "ValueError: broken scene"


def test_a_real_run_and_its_continuation(tiny, tmp_path, capsys):
    path = tmp_path / "out.json"
    command = [str(tiny), "--budget", "20", "--json", str(path)]
    assert success.main([*command, "--limit", "1"]) == 0
    first = json.loads(path.read_text())["rows"]
    assert [set(row) for row in first] == [KEYS]
    assert first[0]["status"] == "solved"
    assert first[0]["verified"]
    assert first[0]["cpu_s"] == pytest.approx(sum(first[0]["parts"].values()), abs=1e-6)
    assert success.main([*command, "--limit", "2"]) == 0
    rows = json.loads(path.read_text())["rows"]
    assert rows[0] == first[0]
    assert len(rows) == 2
    out, err = capsys.readouterr()
    assert "| tiny | all" in out
    assert "[2/2] tiny#shelf_1_seed2" in err


def test_a_wrong_planner_is_an_error_without_traceback(tiny, capsys):
    assert success.main([str(tiny), "--planner", "m4n"]) == 2
    assert "unknown planner 'm4n'; did you mean 'm4m'" in capsys.readouterr().err


def test_interrupted(tiny, tmp_path, monkeypatch, capsys):
    def stop(self, entry):
        raise KeyboardInterrupt

    monkeypatch.setattr("success_runner.warm_up", lambda recipe, registry: None)
    monkeypatch.setattr(Runner, "row", stop)
    assert success.main([str(tiny)]) == 130
    assert "interrupted" in capsys.readouterr().err
