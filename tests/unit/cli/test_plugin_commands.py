"""Commands that a plugin adds."""

import json
import sys


def test_it_is_called_with_its_options(run):
    done = run("toy-greeting", "hello", "--times", 2)
    assert done.code == 0, done.err
    document = json.loads(done.out)
    assert (document["command"], document["words"]) == ("toy greeting", ["hello"] * 2)
    assert document["levels"] == ["easy", "medium", "hard"]


def test_it_has_help_and_refuses_what_it_does_not_know(run):
    done = run("toy-greeting", "-h")
    assert done.code == 0
    assert "Greet the toys." in done.out
    assert "--times" in done.out
    assert run("toy-greeting").code == 2
    assert "No such option" in run("toy-greeting", "hello", "--tims", 2).err


def test_its_errors_are_those_of_any_command(run):
    done = run("toy-greeting", "inside")
    assert (done.code, done.out, done.err) == (2, "", "error: word 'inside': too deep\n")


def test_one_that_cannot_be_imported(run):
    done = run("toy-unfinished")
    assert (done.code, done.out) == (5, "")
    assert "command 'toy-unfinished' cannot be loaded: No module named" in done.err


def test_it_is_listed_with_its_plugin(run):
    rows = [line.split() for line in run("plugins", "list").out.splitlines()]
    assert ["command", "toy_greeting", "toys"] in rows
    assert any(row[:3] == ["command", "learn_priority", "planners"] for row in rows)


def test_plugins_are_left_alone_by_our_own_commands(run):
    for arguments in (("--help",), ("--version",), ("schema", "plan")):
        assert run(*arguments).code == 0
    assert "toy_plugin" not in sys.modules


def test_a_broken_plugin_is_named(run, tmp_path):
    (tmp_path / "site" / "toy_plugin.py").write_text("import nothing_like_it\n")
    done = run("toy-greeting", "hello")
    assert (done.code, done.out) == (2, "")
    assert "warning: plugin 'toys' is disabled" in done.err
    assert "No such command 'toy-greeting'" in done.err
    assert "warning: plugin 'toys' is disabled" in run("learn-priority", "-h").err
