"""Every hook is documented, has a role, and the roles are the ones that recipes know."""

import inspect

import pytest

from mamo_core.choices import BUILD_ORDER
from mamo_core.cli import workbench
from mamo_core.hookspecs import HOOK_OF_ROLE, HookSpecs
from mamo_core.recipes import ROLES, SEVERAL, Recipe
from mamo_core.view import renderers

HOOKS = {name for name in vars(HookSpecs) if name.startswith("mamo_")}


def test_every_hook_has_a_role():
    assert set(HOOK_OF_ROLE.values()) == HOOKS


@pytest.mark.parametrize("name", sorted(HOOKS))
def test_every_hook_is_documented(name):
    hook = getattr(HookSpecs, name)
    assert inspect.getdoc(hook)
    assert list(inspect.signature(hook).parameters) == ["self"]
    assert inspect.signature(hook).return_annotation == "Iterable[Component]"


def test_every_role_of_a_planner_is_built():
    parts = set(HOOK_OF_ROLE) - {workbench.ROLE, renderers.ROLE}
    assert set(BUILD_ORDER) == {*parts, "accept_in"}
    assert {*ROLES, "action", "constraint"} == parts
    assert {*ROLES, *SEVERAL} <= set(Recipe.model_fields)
