"""Rows of a benchmark: kept, continued, and not mixed up."""

import pytest
from row_file import RowFile, identity

from mamo_core.errors import InputError
from mamo_core.recipe_sets import chosen_recipe


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
    monkeypatch.setattr("row_file.code_version", lambda: "other")
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
