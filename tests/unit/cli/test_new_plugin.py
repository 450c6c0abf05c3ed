"""What ``mamo plugins new`` writes works before anything is edited, by the commands it tells."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from mamo_core.scaffold.package import KINDS, write_package

PAGE = Path(__file__).parents[3] / "docs" / "write_a_plugin.md"
MAMO = (sys.executable, "-c", "from mamo_core.cli.main import main; main()")


def commands(text):
    """The commands of a page's first block."""
    block = re.search(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return block.group(1).splitlines()


def execute(command, folder, environment):
    words = shlex.split(command)
    program = {"python": (sys.executable,), "mamo": MAMO}[words[0]]
    done = subprocess.run(
        [*program, *words[1:]],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def read(path):
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "action"])
def test_the_readme_leads_to_a_plan(kind, tmp_path, install):
    folder = tmp_path / "own"
    write_package(kind, "tall_thing", folder)
    first, *others = commands(read(folder / "README.md"))
    assert first == "python -m pip install -e '.[test]'"
    environment = install(folder)
    for command in others:
        execute(command, folder, environment)
    plan = json.loads(read(folder / "plan.json"))
    assert "tall_thing" in json.dumps(plan["problem" if kind == "constraint" else "recipe"])


def test_the_tutorial_leads_to_a_plan_with_the_action(tmp_path, install):
    page = read(PAGE)
    new, to_install, *others = commands(page)
    assert len(others) + 2 <= 6
    told = execute(new, tmp_path, None)
    assert [line.strip() for line in told.partition("next:\n")[2].splitlines()] == [
        to_install,
        *others,
    ]
    assert to_install == "python -m pip install -e './mamo-nudge[test]'"
    apply_diff(page, tmp_path / "mamo-nudge")
    environment = install(tmp_path / "mamo-nudge")
    for command in others:
        execute(command, tmp_path, environment)
    plan = json.loads(read(tmp_path / "plan.json"))
    assert [action["kind"] for action in plan["actions"]] == ["nudge"]
    assert (tmp_path / "plan.png").exists()


def apply_diff(page, folder):
    """The edit that the tutorial shows."""
    (name,) = re.findall(r"^\+\+\+ mamo-nudge/(\S+)$", page, re.MULTILINE)
    (old,) = re.findall(r"^-(\s.*)$", page, re.MULTILINE)
    (new,) = re.findall(r"^\+(\s.*)$", page, re.MULTILINE)
    text = read(folder / name)
    assert text.count(old) == 1
    (folder / name).write_text(text.replace(old, new), encoding="utf-8")


def test_the_commands_of_an_action_are_those_of_a_search(tmp_path):
    for kind in ("action", "search"):
        write_package(kind, "same", tmp_path / kind)
    action, search = (commands(read(tmp_path / k / "README.md")) for k in ("action", "search"))
    assert action == search


@pytest.mark.parametrize("kind", KINDS)
def test_no_placeholder_is_left(kind, tmp_path):
    write_package(kind, f"not_my_{kind}", tmp_path / "own")
    for path in sorted((tmp_path / "own").rglob("*")):
        text = str(path.relative_to(tmp_path)) + (read(path) if path.is_file() else "")
        left = re.sub(f"not_my_{kind}|not-my-{kind}|NotMy{kind.capitalize()}", "", text)
        assert not re.search(f"my_{kind}|my-{kind}|My{kind.capitalize()}|my.plugin", left), path


@pytest.mark.parametrize("kind", KINDS)
def test_what_to_edit_is_marked_and_named(kind, tmp_path):
    write_package(kind, "own", tmp_path / "own")
    readme = read(tmp_path / "own" / "README.md")
    for name in re.findall(r"^\| `([^`]+)` \|", readme, re.MULTILINE):
        assert (tmp_path / "own" / name).is_file(), name
    assert f"`mamo_own/{kind}.py`" in readme
    assert "To make it yours" in read(tmp_path / "own" / "mamo_own" / f"{kind}.py")


def test_commands_fit_the_folder(run):
    """An empty one may be given; names with blanks are quoted; a constraint has no recipe."""
    Path("my plugins").mkdir()
    told = run("plugins", "new", "constraint", "near", "-o", "my plugins")
    assert (told.code, told.err) == (0, "")
    assert (
        told.out
        == """\
my plugins: a plugin with the constraint 'near', which works as it stands
edit my plugins/mamo_near/constraint.py, and read my plugins/README.md
next:
    python -m pip install -e './my plugins[test]'
    python -m pytest 'my plugins'
    mamo plan 'my plugins/problem.yaml' -o plan.json --png plan.png
    mamo verify plan.json
"""
    )
