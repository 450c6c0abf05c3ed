"""The page of hooks: how a plugin registers what it brings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from inspect import getdoc

from mamo_core.build_context import BuildContext
from mamo_core.choices import BUILD_ORDER
from mamo_core.hookspecs import HOOK_OF_ROLE, Component, HookSpecs
from reference_pages.markdown import page, prose
from reference_pages.signatures import class_block, function_block

INTRODUCTION = """\
A plugin is a module with functions that are named like these hooks and decorated with
`mamo_core.hookspecs.hookimpl`; a package names it under the entry points of the group `mamo`. Each
hook returns components. [write_a_plugin.md](../write_a_plugin.md) leads to the first one."""


def hooks_page() -> str:
    """Every hook, and the values that registering needs."""
    order = ", ".join(f"`{role}`" for role in BUILD_ORDER)
    return page(
        "Hooks",
        INTRODUCTION,
        *_hooks(),
        *("## What a hook returns", "Of `mamo_core.hookspecs`:", class_block(Component)),
        prose(getdoc(Component) or ""),
        *("## What a build function receives", "Of `mamo_core.build_context`:"),
        *(class_block(BuildContext), prose(getdoc(BuildContext) or "")),
        f"Parts are built in the order {order}.",
    )


def _hooks() -> Iterator[str]:
    for role, name in HOOK_OF_ROLE.items():
        hook = inspect.getattr_static(HookSpecs, name)
        yield f"## `{name}`"
        yield f"Role `{role}`."
        yield function_block(hook, without_self=True)
        yield prose(getdoc(hook) or "")
