"""``mamo learn-priority`` as a user calls it, on data that are there already."""

import json
import signal

import pytest
from mamo_planners.learning.data import Explored, Point, Settings, open_data
from mamo_planners.search.features import Features

from mamo_core.cli.main import main

SETTINGS = Settings(0, (5, 10, 15), ("easy", "medium", "hard"), 12, 40, 8, 60.0)


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    handler = signal.getsignal(signal.SIGINT)

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            main(["learn-priority", *map(str, arguments)])
        return caught.value.code, *capsys.readouterr()

    yield run
    signal.signal(signal.SIGINT, handler)


@pytest.fixture
def gathered(tmp_path):
    path = tmp_path / "data.jsonl"
    with open_data(path, SETTINGS) as data:
        for problem in range(3):
            data.add(Explored(problem, "shelf", 4))
            for n in range(4):
                features = Features(0.01 * (n + problem), n, (0.1,) * n)
                data.add(Point(problem, n, 0, features, n < 3, cut=n == 3))
    return path


def test_it_fits_and_writes(run, gathered, tmp_path):
    code, out, _ = run("--problems", 3, "--data", gathered, "-o", "p.yaml")
    assert code == 0
    for word in ("alpha", "count_rate", "12 rearrangements of 3 problems, 9 solved", "cut short"):
        assert word in out
    text = (tmp_path / "p.yaml").read_text()
    assert text.startswith("# mamo learn-priority --problems 3 --movables 5,10,15 ")
    assert "search:\n  name: best_first\n  alpha: " in text


def test_json(run, gathered):
    code, out, _ = run("--problems", 3, "--data", gathered, "--json")
    assert code == 0
    document = json.loads(out)
    assert (document["schema_version"], document["command"]) == (1, "learn-priority")
    assert (document["fit"]["points"], document["fit"]["solved"], document["cut"]) == (12, 9, 3)
    assert document["search"]["count_rate"] == 1.0
    assert document["ranked_right"]["survival"] == 1.0


def test_only_the_problems_asked_for_count(run, gathered):
    _, out, _ = run("--problems", 2, "--data", gathered, "--json")
    assert json.loads(out)["fit"]["points"] == 8


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--problems", 0), "--problems"),
        (("--visits", "many"), "--visits"),
        (("--movables", "5,x"), "--movables '5,x': expected numbers, for example 5,10,15"),
        (("--movables", ""), "--movables '': expected numbers"),
        (
            ("--levels", "easy,mdium"),
            "unknown 'mdium'; did you mean 'medium'? (valid: easy, hard, medium)",
        ),
        (("--budget", 0), "--budget 0.0: expected seconds, more than 0"),
        (("--budget", "nan"), "--budget"),
        (("--data", "nowhere/data.jsonl"), "nowhere/data.jsonl: no such folder 'nowhere'"),
        (("-o", "."), "is a folder, expected a file"),
        (("--expansions", 3, "--data", "data.jsonl"), "was gathered with expansions 12, not 3"),
    ],
)
def test_bad_input(run, gathered, arguments, expected):
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert expected in err
    assert "Traceback" not in err
