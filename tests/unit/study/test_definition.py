"""Study files: what they mean, and complaints that name place, value and what is valid."""

from pathlib import Path

import pytest

from mamo_core.errors import InputError
from mamo_core.problems import generate_shelf, save_problems
from mamo_core.study.definition import load_study
from mamo_core.study.problems import pick, pick_source, wanted
from mamo_core.study.schema import (
    FileSource,
    GeneratedSource,
    Generation,
    WorkspaceGeneration,
    WorkspaceSource,
)
from mamo_core.study.tasks import make_tasks

ROOT = Path(__file__).parents[3]
GOOD = """\
schema_version: 1
name: good
problems:
  - set.jsonl
  - {file: set.jsonl, set: thinned, ids: [b, d, c], offset: 1, every: 2, limit: 1, classes: [easy]}
  - {generate: {levels: [easy, hard], movables: [5, 10], count: 2, seed: 3}}
recipes:
  - m4m
  - {recipe: m4m, set: {search.iterate: false}}
  - {recipe: own.yaml, name: ours}
engines: [mujoco, dart]
seeds: [0, 1]
budget: 10
baseline: ours
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "own.yaml").write_text((ROOT / "planners" / "m4m.yaml").read_text())
    path = tmp_path / "study.yaml"
    path.write_text(GOOD)
    return path


def test_a_study(path):
    study = load_study(path)
    assert (study.name, study.budget, study.deadline, study.baseline) == (
        "good",
        10.0,
        100.0,
        "ours",
    )
    assert [(v.recipe, v.engine) for v in study.variants] == [
        ("m4m", "mujoco"),
        ("m4m", "dart"),
        ("m4m search.iterate=False", "mujoco"),
        ("m4m search.iterate=False", "dart"),
        ("ours", "mujoco"),
        ("ours", "dart"),
    ]
    changed = study.variants[3].loaded.data
    assert (changed["backend"], changed["search"]["iterate"]) == ("dart", False)


def test_defaults(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("{schema_version: 1, name: s, problems: [x.yaml], recipes: [m4m]}")
    study = load_study(path)
    assert (study.seeds, study.budget, study.deadline, study.baseline) == ((0,), 60.0, 300.0, "m4m")
    assert [(v.recipe, v.engine) for v in study.variants] == [("m4m", "mujoco")]


def test_settings_change_the_study(path):
    study = load_study(path, ["budget=2", "problems.2.generate.count=1", "engines=[mujoco]"])
    assert (study.budget, study.deadline) == (2.0, 68.0)
    assert study.sources[2].generate.count == 1
    assert {v.engine for v in study.variants} == {"mujoco"}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("seeds: [0, 1]", "sedes: [0, 1]", ":12:1: unknown key 'sedes'; did you mean 'seeds'?"),
        ("budget: 10", "budget: 0", "study.yaml:13:9: budget: 0, expected"),
        ("budget: 10", "budget: .nan", "budget: nan"),
        ("seeds: [0, 1]", "seeds: [-1]", "study.yaml:12:9: seeds.0: -1, expected"),
        ("seeds: [0, 1]", "seeds: [1, 1]", "study.yaml:12:8: seeds: 1 is there twice"),
        ("seeds: [0, 1]", "seeds: []", "study.yaml:12:8: seeds: [], expected at least 1 items"),
        ("name: good", "name: a/b", "study.yaml:2:7: name: 'a/b', expected"),
        ("classes: [easy]", "classes: [esay]", "problems.1.classes.0: 'esay', expected"),
        ("every: 2", "every: 0", "problems.1.every: 0, expected"),
        ("levels: [easy, hard]", "levels: [none]", "generate.levels.0: 'none', expected"),
        ("levels: [easy, hard],", "levels: [easy], leves: [],", "problems.2.generate.leves'"),
        ("  - m4m\n", "  - m4n\n", "study.yaml:8:5: unknown planner 'm4n'; did you mean 'm4m'?"),
        ("own.yaml, name: ours", "no.yaml, name: ours", "no.yaml: no such file"),
        ("name: ours", "name: m4m", ":10:5: recipes.2: 'm4m' is there twice, give one a name"),
        ("{search.iter", "{serach.iter", "study.yaml:9:5: serach.iterate: unknown key 'serach'"),
        ("baseline: ours", "baseline: our", "baseline: no recipe 'our'; did you mean 'ours'?"),
        ("engines: [mujoco, dart]", "engines: [dart, dart]", "engines: 'dart' is there twice"),
    ],
)  # fmt: skip
def test_complaints(path, old, new, message):
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert message in str(caught.value)


SHELVES = "{generate: {levels: [easy, hard], movables: [5, 10], count: 2, seed: 3}}"


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("{generate: {workspace: fridge}}", "workspace: 'fridge', expected 'tabletop' or 'refri"),
        ("{generate: {workspace: tabletop, count: 0}}", "generate.count: 0, expected a number of"),
        ("{generate: {workspace: tabletop, movables: -1}}", "generate.movables: -1, expected a nu"),
        ("{generate: {workspace: tabletop, immovables: 0}}", "generate.immovables: 0, expected"),
        ("{generate: {workspace: tabletop, movabels: 1}}", "'problems.2.generate.movabels'; did"),
        ("{generate: {workspace: tabletop}, sets: x}", "'problems.2.sets'; did you mean 'set'?"),
        ("{generate: {seed: 1}}", "problems.2.generate: missing key 'workspace'"),
        ("7", "problems.2: 7, expected text or expected a mapping"),
    ],
)
def test_complaints_about_generated_sources(path, source, message):
    assert SHELVES in GOOD
    path.write_text(GOOD.replace(SHELVES, source))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert message in str(caught.value)


def test_complaints_about_settings(path):
    with pytest.raises(InputError, match="--set budget: budget: 'soon', expected"):
        load_study(path, ["budget=soon"])
    with pytest.raises(InputError, match=r"--set problems.9.limit: no '9' in 'problems'"):
        load_study(path, ["problems.9.limit=1"])


@pytest.fixture
def letters(tmp_path):
    documents = [generate_shelf(movables=1, seed=seed) for seed in range(5)]
    save_problems(documents, tmp_path / "set.jsonl")
    lines = (tmp_path / "set.jsonl").read_text().splitlines()
    renamed = [line.replace(f"shelf_1_seed{i}", "abcde"[i]) for i, line in enumerate(lines)]
    (tmp_path / "set.jsonl").write_text("\n".join(renamed) + "\n")
    return tmp_path


def test_thinning(letters):
    def ids(**options):
        return [p.id for p in pick_source(FileSource(file="set.jsonl", **options), letters)]

    assert ids() == ["a", "b", "c", "d", "e"]
    assert ids(every=2) == ["a", "c", "e"]
    assert ids(every=2, offset=1) == ["b", "d"]
    assert ids(ids=("d", "b"), offset=1) == ["b"]
    assert [p.key for p in pick([letters / "set.jsonl"], every=3)] == [("set", "a"), ("set", "d")]
    assert [p.id for p in pick([letters / "set.jsonl"], limit=1)] == ["a"]


def test_an_unknown_id(letters):
    with pytest.raises(InputError, match=r"set.jsonl: no problem 'f' \(5 in all\)"):
        pick_source(FileSource(file="set.jsonl", ids=("f",)), letters)


def test_published_scenes_are_looked_for(tmp_path, monkeypatch):
    monkeypatch.setenv("MAMO_SCENES", str(tmp_path))
    with pytest.raises(
        InputError, match=r"x.jsonl.gz: no such file of published scenes \(set MAMO"
    ):
        pick_source(FileSource(file="scenes/x.jsonl.gz"), Path())
    save_problems([generate_shelf(movables=1, seed=1)], tmp_path / "x.jsonl.gz")
    (picked,) = pick_source(FileSource(file="scenes/x.jsonl.gz"), Path())
    assert picked.key == ("x", "shelf_1_seed1")


def test_what_is_generated():
    generation = Generation(levels=("easy", "hard"), movables=(5, 10), count=2, seed=3)
    items = list(wanted(GeneratedSource(generate=generation)))
    assert [(i.set_name, i.subject) for i in items[:3]] == [
        ("shelf_5", "easy/5/3"),
        ("shelf_5", "easy/5/4"),
        ("shelf_5", "hard/5/3"),
    ]
    assert len(items) == 8
    assert items[0].arguments == {"level": "easy", "movables": 5, "seed": 3}


def test_reaches_that_are_generated():
    generation = WorkspaceGeneration(workspace="tabletop", movables=8, count=2, seed=3)
    items = list(wanted(WorkspaceSource(generate=generation)))
    assert [(i.set_name, i.subject) for i in items] == [
        ("tabletop", "tabletop/8/6/3"),
        ("tabletop", "tabletop/8/6/4"),
    ]
    assert items[1].function == "generate_workspace"
    expected = {"workspace": "tabletop", "movables": 8, "immovables": 6, "seed": 4}
    assert items[1].arguments == expected
    named = WorkspaceSource(generate=WorkspaceGeneration(workspace="refrigerator"), set="cold")
    assert [(i.set_name, i.subject) for i in wanted(named)] == [("cold", "refrigerator/3/2/0")]


def test_keys_tell_apart_what_rows_depend_on(path, letters):
    from mamo_core.study.problems import loaded

    (letters / "own.yaml").write_text((ROOT / "planners" / "m4m.yaml").read_text())
    problems = [loaded(p) for p in pick([letters / "set.jsonl"])]

    def keys(*settings, code="c"):
        return [task.key for task, _, _ in make_tasks(load_study(path, settings), problems, code)]

    first = keys()
    assert first == keys("name=other", "deadline=7", "baseline=m4m")
    assert len(first) == 5 * 3 * 2 * 2
    assert len(set(first)) == 5 * 2 * 2 * 2  # 'ours' is m4m under another name
    for changed in (keys("budget=11"), keys("seeds=[5, 6]"), keys(code="d")):
        assert not set(first) & set(changed)
