"""Plugins: a broken one says why and disables only itself."""

from types import ModuleType

import pytest

from mamo_core.errors import InputError, PluginError
from mamo_core.hookspecs import HOOK_OF_ROLE, Component, NoOptions, hookimpl
from mamo_core.plugins import Registry, discover, make_registry


def build(context, options):
    return object()


def plugin(**hooks):
    """A module with a hook that returns what is given; a function is the hook itself."""
    module = ModuleType("in_test")
    for name, offered in hooks.items():
        setattr(module, name, hookimpl(offered if callable(offered) else returning(offered)))
    return module


def returning(result):
    return lambda: result


def registry(*modules):
    return make_registry([(f"p{i}", lambda m=module: m) for i, module in enumerate(modules)])


GOOD = plugin(mamo_actions=[Component("push", build, summary="pushes")])


def only_problem(*modules):
    result = registry(GOOD, *modules)
    assert [component.name for component in result.components("action")] == ["push"]
    assert len(result.problems) == 1
    assert result.problems[0].plugin == "p1"
    return result.problems[0].message


def test_components_by_role():
    two = plugin(
        mamo_actions=[Component("pick", build), Component("nudge", build)],
        mamo_searches=(component for component in [Component("greedy", build)]),
    )
    result = registry(GOOD, two)
    assert [c.name for c in result.components("action")] == ["push", "pick", "nudge"]
    assert result.component("search", "greedy").options is NoOptions
    assert result.components("mapf") == ()
    assert result.problems == ()
    assert [r.plugin for r in result.registered if r.role == "action"] == ["p0", "p1", "p1"]


@pytest.mark.parametrize("hook", HOOK_OF_ROLE.values())
def test_every_hook_is_asked(hook):
    role = next(role for role, name in HOOK_OF_ROLE.items() if name == hook)
    result = registry(plugin(**{hook: [Component("x", build)]}))
    assert [c.name for c in result.components(role)] == ["x"]


def test_unknown_component_has_a_suggestion():
    with pytest.raises(InputError) as caught:
        registry(GOOD).component("action", "pusch", "m4m.yaml:3:4")
    assert str(caught.value) == (
        "m4m.yaml:3:4: unknown action 'pusch'; did you mean 'push'? (valid: push)"
    )


def test_unknown_component_of_a_broken_plugin_is_a_missing_plugin():
    def fails():
        raise ImportError("no pybullet here")

    result = make_registry([("bullet", lambda: plugin(mamo_backends=fails))])
    with pytest.raises(PluginError) as caught:
        result.component("backend", "pybullet")
    assert str(caught.value) == (
        "unknown backend 'pybullet' (valid: none)\n"
        "plugin 'bullet' is disabled: hook mamo_backends: ImportError: no pybullet here"
    )


def test_failing_hook():
    def fails():
        raise ZeroDivisionError("oh\n  no")

    assert only_problem(plugin(mamo_actions=fails)) == "hook mamo_actions: ZeroDivisionError: oh no"


@pytest.mark.parametrize(
    ("returned", "kind"), [(Component("x", build), "Component"), ("push", "str"), ({}, "dict")]
)
def test_wrong_return_type(returned, kind):
    def hook():
        return returned

    message = only_problem(plugin(mamo_actions=hook))
    assert message == f"hook mamo_actions: returned a {kind}, expected a list of Component"


def test_wrong_item():
    message = only_problem(plugin(mamo_actions=[Component("x", build), build]))
    assert message == "hook mamo_actions: item 1: a function, expected a Component"


@pytest.mark.parametrize(
    ("component", "complaint"),
    [
        (Component("a b", build), "Component(name='a b'), expected letters, digits and _"),
        (Component("x", None), "Component(build=None), expected a function (context, options)"),
        (
            Component("x", build, options=dict),
            "Component(options=<class 'dict'>), expected a subclass of Options",
        ),
        (Component("x", build, summary=3), "Component(summary=3), expected text"),
        (
            Component("x", build, provides={"batch"}),
            "Component(provides={'batch'}), expected a frozenset of capabilities",
        ),
        (
            Component("x", build, requires={"engine": frozenset()}),
            "Component(requires={'engine': frozenset()}), expected a dict of role to frozenset "
            f"(roles: {', '.join(HOOK_OF_ROLE)})",
        ),
    ],
)
def test_wrong_argument_of_component(component, complaint):
    message = only_problem(plugin(mamo_searches=[component]))
    assert message == f"hook mamo_searches: item 0: {complaint}"


def test_hook_with_an_argument():
    def mamo_actions(context):
        return []

    message = only_problem(plugin(mamo_actions=mamo_actions))
    assert "hook 'mamo_actions'" in message
    assert "{'context'}" in message


def test_unknown_hook():
    message = only_problem(plugin(mamo_action=[Component("x", build)]))
    assert message.startswith("unknown hook 'mamo_action'; did you mean 'mamo_actions'?")


def test_a_name_that_is_taken():
    message = only_problem(
        plugin(mamo_actions=[Component("pick", build), Component("push", build)])
    )
    assert message == "hook mamo_actions: action 'push' is already registered by plugin 'p0'"


def test_a_name_that_stands_twice_in_one_plugin():
    message = only_problem(plugin(mamo_actions=[Component("x", build), Component("x", build)]))
    assert message == "hook mamo_actions: action 'x' is already registered by plugin 'p1'"


def test_the_same_name_in_two_roles_is_fine():
    assert registry(GOOD, plugin(mamo_searches=[Component("push", build)])).problems == ()


def test_warm_up():
    module = plugin()
    module.warm_up = lambda: None
    assert registry(GOOD, module).warm_ups == {"p1": module.warm_up}
    module.warm_up = 3
    assert only_problem(module) == "warm_up is a int, expected a function"


def test_installed_plugin_that_cannot_be_imported(tmp_path, monkeypatch):
    install(tmp_path, monkeypatch, "broken", "import nothing_of_that_name\n")
    problems = {problem.plugin: str(problem) for problem in discover().problems}
    assert problems["broken"] == (
        "plugin 'broken' is disabled: broken_module cannot be imported: "
        "ModuleNotFoundError: No module named 'nothing_of_that_name'"
    )


def test_ours_win_against_installed_plugins_with_the_same_names(tmp_path, monkeypatch):
    code = """
from mamo_core.hookspecs import Component, hookimpl

@hookimpl
def mamo_constraints():
    return [Component("tilt", print)]
"""
    install(tmp_path, monkeypatch, "aaa", code)
    found = discover()
    assert [p.message for p in found.problems if p.plugin == "aaa"] == [
        "hook mamo_constraints: constraint 'tilt' is already registered by plugin 'constraints'"
    ]
    assert found.component("constraint", "tilt").build is not print


def install(folder, monkeypatch, name, code):
    """Put a distribution with one plugin on the path."""
    (folder / f"{name}_module.py").write_text(code)
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[mamo]\n{name} = {name}_module\n")
    monkeypatch.syspath_prepend(folder)


def test_an_empty_registry_knows_nothing():
    with pytest.raises(InputError, match=r"^unknown mapf 'cbs' \(valid: none\)$"):
        Registry(()).component("mapf", "cbs")
