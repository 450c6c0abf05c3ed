"""Every command that tutorials and how-tos show is run, in the order of the page.

A line ``# -> text`` below a command says what it prints, ``# exit code 2`` how it ends.
"""

import re
import shlex
import signal
import subprocess
from pathlib import Path

import pytest

from mamo_core.cli.main import main

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
README = "../README.md"
PAGES = (README, "start.md", "compose_a_planner.md", "compare_engines.md", "look_at_plans.md")
WRITING = ("write_a_plugin.md", "write_a_backend.md")
"""Pages whose commands tests of ``mamo plugins new`` run, as packages are installed there."""

ANSWER, EXIT = "# -> ", "# exit code "


def text(page):
    return (DOCS / page).read_text(encoding="utf-8")


def commands(page):
    """(command, what it must print, exit code) of every line in the page's blocks."""
    found = []
    for block in re.findall(r"^```sh\n(.*?)^```", text(page), re.MULTILINE | re.DOTALL):
        for line in block.splitlines():
            if line.startswith(ANSWER):
                found[-1]["answers"].append(line.removeprefix(ANSWER))
            elif line.startswith(EXIT):
                found[-1]["code"] = int(line.removeprefix(EXIT))
            else:
                found.append({"line": line, "answers": [], "code": 0})
    return found


def save_files(page, folder):
    """Files that the reader is told to save."""
    saved = re.findall(r"^Save this as `(\S+)`:\n\n```yaml.*\n((?:.*\n)*?)```", text(page), re.M)
    for name, content in saved:
        (folder / name).write_text(content, encoding="utf-8")


def lines_of_make(target):
    """The calls of mamo that a target of the Makefile makes when everything is installed."""
    done = subprocess.run(
        ["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=True
    )
    told = done.stdout.replace("\\\n", " ").splitlines()
    lines = [
        line.removeprefix(".venv/bin/")
        for line in told
        if line.startswith(("mkdir", ".venv/bin/mamo"))
    ]
    return [line for line in lines if "warmup" not in line]


@pytest.fixture
def execute(tmp_path, monkeypatch, capsys):
    """``execute(line, code)`` runs a line in a folder that has our problems and recipes."""
    for name in ("problems", "planners", "studies"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    handler = signal.getsignal(signal.SIGINT)

    def execute(line, code=0):
        words = shlex.split(line, comments=True)
        if words[0] == "make":
            return "".join(execute(part) for part in lines_of_make(words[1]))
        if words[:2] == ["mkdir", "-p"]:
            Path(words[2]).mkdir(parents=True, exist_ok=True)
            return ""
        if words == [".", ".venv/bin/activate"]:
            return ""
        assert words[0] == "mamo", line
        with pytest.raises(SystemExit) as caught:
            main(words[1:])
        printed = "".join(capsys.readouterr())
        assert caught.value.code == code, f"{line}\n{printed}"
        return printed

    yield execute
    signal.signal(signal.SIGINT, handler)


@pytest.mark.parametrize("page", PAGES)
def test_commands_run_and_print_what_is_said(page, execute, tmp_path):
    save_files(page, tmp_path)
    for command in commands(page):
        printed = " ".join(execute(command["line"], command["code"]).split())
        for answer in command["answers"]:
            assert answer in printed, command["line"]


def test_the_way_to_a_backend_is_what_the_command_says(execute):
    first, *others = (command["line"] for command in commands("write_a_backend.md"))
    printed = execute(first)
    assert [line.strip() for line in printed.partition("next:\n")[2].splitlines()] == others


def test_no_page_is_forgotten():
    shown = {path.name for path in DOCS.rglob("*.md") if commands(path.relative_to(DOCS))}
    assert shown == {*PAGES, *WRITING} - {README}
