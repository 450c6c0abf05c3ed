"""Recipes, the shipped ones, and ``--set``."""

import pytest

from mamo_core.config import load_text
from mamo_core.errors import InputError
from mamo_core.recipe_sets import apply_sets, override
from mamo_core.recipes import find_recipe, load_recipe, shipped_recipes

TEXT = """\
schema_version: 1
name: r
backend: mujoco
kinematics: dls
collision: {name: spheres}
arm_planner: {name: rrt_connect, max_checks: 50}
retrieval: grasp_and_extract
mapf: portfolio
actions: [push, {name: pick, tries: 2}]
search: {name: greedy, iterate: true}
"""


def recipe(text=TEXT, *settings):
    return load_recipe(apply_sets(load_text(text, "r.yaml"), settings))


def complaint(text, *settings):
    with pytest.raises(InputError) as caught:
        recipe(text, *settings)
    return str(caught.value)


def test_parts():
    parts = recipe().parts("action")
    assert [(part.name, part.options.data) for part in parts] == [
        ("push", {}),
        ("pick", {"tries": 2}),
    ]
    assert [part.place for part in parts] == ["r.yaml:9:11", "r.yaml:9:24"]
    (planner,) = recipe().parts("arm_planner")
    assert planner.options.data == {"max_checks": 50}
    assert planner.options.where(("max_checks",)) == "r.yaml:6:46"


def test_a_part_that_is_not_there():
    text = TEXT.replace("mapf: portfolio\n", "")
    assert recipe(text).parts("mapf") == ()
    assert recipe(TEXT.replace("mapf: portfolio", "mapf: null")).parts("mapf") == ()


@pytest.mark.parametrize("actions", ["push", "{name: push}", "[push]", "[{name: push}]"])
def test_one_action(actions):
    text = TEXT.replace("[push, {name: pick, tries: 2}]", actions)
    assert [part.name for part in recipe(text).parts("action")] == ["push"]
    assert [part.name for part in recipe(text).recipe.actions] == ["push"]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("backend: mujoco\n", "", "r.yaml:1:1: missing key 'backend'"),
        ("search:", "serch:", "r.yaml:1:1: missing key 'search'"),
        ("mujoco", "3", "r.yaml:3:10: backend: 3, expected a name, or a mapping with a name"),
        ("{name: spheres}", "{nme: x}", "r.yaml:5:12: collision: missing key 'name'"),
        ("{name: spheres}", "{name: 1}", "r.yaml:5:19: collision.name: 1, expected text"),
        ("version: 1", "version: 2", "r.yaml:1:17: schema_version: 2, expected 1"),
        ("pick", "push", "r.yaml:9:24: action 'push' is in the recipe twice"),
        ("[push,", "[3,", "r.yaml:9:11: actions.0: 3, expected a name, or a mapping"),
    ],
)
def test_mistakes(old, new, expected):
    assert complaint(TEXT.replace(old, new)).splitlines()[0].startswith(expected)


def test_misspelt_key():
    expected = "r.yaml:2:1: unknown key 'nam'; did you mean 'name'?"
    assert expected in complaint(TEXT.replace("name: r\n", "nam: r\n"))


@pytest.mark.parametrize(
    ("setting", "role", "name", "options"),
    [
        ("search.iterate=false", "search", "greedy", {"iterate": False}),
        ("backend=dart", "backend", "dart", {}),
        ("backend.time_step=0.002", "backend", "mujoco", {"time_step": 0.002}),
        ("mapf={name: cbs, nodes: 3}", "mapf", "cbs", {"nodes": 3}),
        ("search.a.b.c=[1, x]", "search", "greedy", {"iterate": True, "a": {"b": {"c": [1, "x"]}}}),
        ("actions=pick", "action", "pick", {}),
    ],
)
def test_set(setting, role, name, options):
    (part,) = recipe(TEXT, setting).parts(role)
    assert (part.name, part.options.data) == (name, options)


@pytest.mark.parametrize("actions", ["push", "{name: push}", "[pick, push]"])
def test_set_for_one_action(actions):
    text = TEXT.replace("[push, {name: pick, tries: 2}]", actions)
    assert recipe(text, "actions.push.samples=3").parts("action")[-1].options.data == {"samples": 3}


def test_the_last_setting_counts_and_the_document_stays_as_it_was():
    located = load_text(TEXT, "r.yaml")
    changed = apply_sets(located, ["search.iterate=1", "search.iterate=2"])
    assert changed.data["search"]["iterate"] == 2
    assert located.data["search"]["iterate"] is True


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("search", "--set search: expected KEY=VALUE, for example search.iterate=false"),
        ("=3", "--set =3: expected KEY=VALUE, for example search.iterate=false"),
        ("a..b=3", "--set a..b=3: expected KEY=VALUE, for example search.iterate=false"),
        ("search.iterate=", "--set search.iterate:1:1: the document is empty"),
        ("search.iterate=*x", "--set search.iterate:1:1: alias '*x': aliases are not allowed"),
        (
            "serch.iterate=false",
            "--set serch.iterate: unknown key 'serch'; did you mean 'search'? "
            "(valid: accept_in, actions, arm_planner, backend, collision, kinematics, mapf, name, "
            "retrieval, schema_version, search, summary)",
        ),
        (
            "actions.pusch.samples=3",
            "--set actions.pusch.samples: no 'pusch' in 'actions'; did you mean 'push'? "
            "(valid: pick, push)",
        ),
        (
            "search.iterate.x=3",
            "--set search.iterate.x: 'search.iterate' holds True, which has no keys",
        ),
        (
            "search=3",
            "--set search: search: 3, expected a name, or a mapping with a name and options",
        ),
        ("search.name=3", "--set search.name: search.name: 3, expected text"),
    ],
)
def test_mistakes_in_settings(setting, expected):
    assert complaint(TEXT, setting) == expected


def test_override_reports_its_own_origin():
    with pytest.raises(InputError) as caught:
        load_recipe(override(load_text(TEXT, "r"), ["backend"], 7, "--backend"))
    assert str(caught.value).startswith("--backend: backend: 7, expected a name")


def test_find_recipe(tmp_path):
    assert find_recipe("m4m").data["name"] == "m4m"
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT)
    assert find_recipe(path).data["name"] == "r"
    with pytest.raises(
        InputError, match=r"^unknown planner 'm5m'; did you mean 'm4m'\? \(valid: .*m4m"
    ):
        find_recipe("m5m")
    with pytest.raises(InputError, match=r"nowhere.yaml: no such file$"):
        find_recipe(tmp_path / "nowhere.yaml")


@pytest.mark.parametrize("name", shipped_recipes())
def test_shipped_recipes_are_named_like_their_files(name):
    loaded = load_recipe(find_recipe(name))
    assert loaded.recipe.name == name
    assert loaded.recipe.summary


def test_ablations_differ_in_one_part():
    data = {name: load_recipe(find_recipe(name)).data for name in shipped_recipes()}
    for name, key in (("m4m_no_iterate", "search"), ("m4m_thesis_push", "actions")):
        changed = {k for k in data["m4m"] if data[name][k] != data["m4m"][k]}
        assert changed == {"name", "summary", key}
