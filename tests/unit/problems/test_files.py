from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from mamo_core.errors import InputError
from mamo_core.problems import (
    generate_shelf,
    import_file,
    load_problem,
    problem_document,
    problem_ids,
    save_problems,
)
from mamo_core.types.problem import Problem


@pytest.fixture(scope="module")
def several() -> list[Problem]:
    return [generate_shelf(movables=2, seed=seed) for seed in range(15)]


@pytest.mark.parametrize("ending", [".yaml", ".yml", ".json", ".json.jsonl", ".jsonl.gz"])
def test_every_format_comes_back(ending: str, shelf: Problem, tmp_path: Path) -> None:
    path = tmp_path / f"shelf{ending}"
    save_problems([shelf], path)
    assert problem_document(load_problem(path)) == problem_document(shelf)
    assert problem_ids(path) == [shelf.name]


def test_a_set_is_picked_from_by_id(several: list[Problem], tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl.gz"
    save_problems(several, path)
    assert problem_ids(path) == [p.name for p in several]
    assert load_problem(f"{path}#shelf_2_seed7").name == "shelf_2_seed7"
    problems, warnings = import_file(path)
    assert [p.name for p in problems] == [p.name for p in several]
    assert warnings == []


def test_the_same_problems_make_the_same_bytes(several: list[Problem], tmp_path: Path) -> None:
    for name in ("a.jsonl.gz", "b.jsonl.gz"):
        save_problems(several, tmp_path / name)
    assert (tmp_path / "a.jsonl.gz").read_bytes() == (tmp_path / "b.jsonl.gz").read_bytes()


def test_an_unknown_id_gets_a_suggestion_and_few_of_many(
    several: list[Problem], tmp_path: Path
) -> None:
    path = tmp_path / "set.jsonl"
    save_problems(several, path)
    with pytest.raises(InputError) as caught:
        load_problem(f"{path}#shelf_2_sed7")
    text = str(caught.value)
    assert text.startswith(f"{path}: no problem 'shelf_2_sed7'; did you mean 'shelf_2_seed7'?")
    assert "shelf_2_seed0" in text
    assert "15 in all" in text
    assert "shelf_2_seed12" not in text


def test_a_set_needs_an_id(several: list[Problem], tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl"
    save_problems(several, path)
    with pytest.raises(InputError, match="holds 15 problems, pick one with '#id'"):
        load_problem(path)


def test_a_name_with_a_hash_is_a_file(shelf: Problem, tmp_path: Path) -> None:
    path = tmp_path / "odd#name.json"
    save_problems([shelf], path)
    assert load_problem(path).name == shelf.name


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        load_problem(tmp_path / "none.yaml")


def test_a_cut_gzip_file(several: list[Problem], tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl.gz"
    save_problems(several, path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(InputError, match="gzip file is damaged or cut short"):
        load_problem(f"{path}#shelf_2_seed0")


def test_a_cut_set_names_the_line(several: list[Problem], tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl"
    save_problems(several, path)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], lines[1][:500]]))
    with pytest.raises(InputError, match=r"set\.jsonl:2:"):
        load_problem(f"{path}#shelf_2_seed0")


def test_a_cut_document_names_the_place(shelf: Problem, tmp_path: Path) -> None:
    path = tmp_path / "shelf.json"
    save_problems([shelf], path)
    path.write_text(path.read_text()[:700])
    with pytest.raises(InputError, match=r"shelf\.json:\d+:\d+: not valid YAML or JSON"):
        load_problem(path)


def test_ids_are_there_and_unique(shelf: Problem, tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl"
    line = json.dumps({"id": "a", **problem_document(shelf)})
    path.write_text(f"{line}\n{line}\n")
    with pytest.raises(InputError, match=r"set\.jsonl:2: id 'a' stands twice"):
        problem_ids(path)
    path.write_text(json.dumps(problem_document(shelf)))
    with pytest.raises(InputError, match=r"set\.jsonl:1:1: every line .* 'id'"):
        problem_ids(path)
    path.write_text("\n")
    with pytest.raises(InputError, match="the set is empty"):
        problem_ids(path)


def test_mistakes_in_a_set_name_their_line(shelf: Problem, tmp_path: Path) -> None:
    path = tmp_path / "set.jsonl"
    good = {"id": "a", **problem_document(shelf)}
    bad = {**good, "id": 7, "target": "o99"}
    path.write_text(f"{json.dumps(good)}\n{json.dumps(bad)}\n")
    assert load_problem(f"{path}#a").name == shelf.name
    with pytest.raises(InputError, match=r"set\.jsonl:2:\d+: target: no object 'o99'"):
        load_problem(f"{path}#7")


def test_sets_are_told_by_content_too(several: list[Problem], tmp_path: Path) -> None:
    save_problems(several, tmp_path / "set.jsonl")
    path = tmp_path / "set.txt.gz"
    path.write_bytes(gzip.compress((tmp_path / "set.jsonl").read_bytes()))
    assert len(problem_ids(path)) == len(several)


def test_saving_refuses_what_it_cannot_write(
    several: list[Problem], shelf: Problem, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=r"15 problems, but such a file holds one"):
        save_problems(several, tmp_path / "x.json")
    with pytest.raises(InputError, match=r"ending '\.txt' \(valid: \.json, \.jsonl"):
        save_problems([shelf], tmp_path / "x.txt")
    with pytest.raises(InputError, match="names stand twice: shelf_3_seed1"):
        save_problems([shelf, shelf], tmp_path / "x.jsonl")
