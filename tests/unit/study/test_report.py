"""Reports and exports of made-up rows, with figures worked out by hand."""

import csv
import json
import re
import zlib
from dataclasses import replace

import pytest

from mamo_core.errors import InputError, PluginError
from mamo_core.study.analysis import Subject, analyse
from mamo_core.study.export import write_plans, write_rows
from mamo_core.study.ompl_log import STATUSES, ompl_log
from mamo_core.study.report import report_data, report_text, write_report
from mamo_core.study.rows import Row
from mamo_core.study.split import Split, split_by_time
from mamo_core.study.store import create_store, open_store
from mamo_core.study.tables import markdown

SUBJECT = Subject("made_up", total=8, budget=10.0, baselines=("slow",))


def row(recipe, problem, cpu, level="easy", **changes):
    solved = cpu is not None and changes.get("status", "solved") == "solved"
    values = {
        "key": f"{recipe}/{problem}",
        "subject": f"{recipe}/{problem}",
        "set_name": "a",
        "problem_id": problem,
        "problem": f"hash of {problem}",
        "recipe": recipe,
        "engine": "mujoco",
        "seed": 0,
        "budget": 10.0,
        "level": level,
        "status": "solved",
        "verified": solved,
        "cpu_s": cpu,
        "actions": 2,
        "reason": "",
        "wall_s": 1.0,
        "code": "c0",
        "started": "2026-01-01T00:00:00.000+00:00",
        "finished": "2026-01-01T00:00:01.000+00:00",
        "parts": {} if cpu is None else {"rollouts": 0.75 * cpu, "mapf": 0.25 * cpu},
        "counts": {"rollouts": 5},
    }
    return Row(**{**values, **changes})


ROWS = [
    row("slow", "p1", 2.0),
    row("slow", "p2", 4.0),
    row("slow", "p3", 9.0, "hard", status="budget_exhausted", causes={"o1/push/no_ik": 3}),
    row("slow", "p4", None, "hard", status="crashed", reason="the worker was ended by SIGSEGV"),
    row("fast", "p1", 1.0),
    row("fast", "p2", 2.0, verified=False, reason="tilt: o1"),
    row("fast", "p3", 3.0, "hard"),
    row("fast", "p4", 10.5, "hard"),
]


@pytest.fixture
def data():
    return analyse(SUBJECT, ROWS)


def group(data, planner, level="all"):
    (found,) = [g for g in data["groups"] if (g["planner"], g["class"]) == (planner, level)]
    return found


def test_success(data):
    slow, fast = group(data, "slow"), group(data, "fast")
    assert (slow["n"], slow["solved"], slow["verified"], slow["succeeded"]) == (4, 2, 2, 2)
    assert (fast["n"], fast["solved"], fast["verified"], fast["succeeded"]) == (4, 4, 3, 2)
    assert (slow["holds"], fast["holds"]) == (1.0, 0.75)
    assert slow["success"] == 0.5
    assert slow["interval"] == pytest.approx([0.1500, 0.8500], abs=1e-4)
    assert slow["par2_s"] == (2.0 + 4.0 + 20.0 + 20.0) / 4
    assert group(data, "slow", "hard")["cpu_s"]["median"] is None
    assert group(data, "fast", "hard")["success"] == 0.5


def test_seconds(data):
    assert group(data, "slow")["cpu_s"] == {"min": 2.0, "median": 3.0, "p90": 3.8, "max": 4.0}
    assert group(data, "slow")["simulation_s"]["max"] == 3.0
    assert (group(data, "fast")["actions"], group(data, "fast")["rollouts"]) == (2.0, 5.0)


def test_curves(data):
    slow, fast = data["curves"]
    assert [(p["budget_s"], p["success"]) for p in slow["points"]] == [
        (1.0, 0.0),
        (2.0, 0.25),
        (5.0, 0.5),
        (10.0, 0.5),
    ]
    assert fast["seconds"] == [1.0, 3.0]


def test_comparison(data):
    (pair,) = data["comparisons"]
    assert (pair["planner"], pair["baseline"]) == ("fast", "slow")
    assert (pair["pairs"], pair["both"]) == (4, 1)
    assert (pair["only_planner"], pair["only_baseline"], pair["p"]) == (1, 1, 1.0)
    assert pair["ratio"] == pytest.approx(0.5)
    assert pair["ratio_interval"] == pytest.approx([0.5, 0.5])
    assert (pair["rollouts"], pair["medians_s"]) == ([5, 5], [2.0, 1.0])
    assert pair["seconds"] == [[2.0, 1.0], [4.0, None], [None, 3.0], [None, None]]


def test_every_recipe_is_compared_with_each_that_is_asked_for():
    data = analyse(replace(SUBJECT, baselines=("slow", "fast")), ROWS)
    assert [(pair["planner"], pair["baseline"]) for pair in data["comparisons"]] == [
        ("fast", "slow"),
        ("slow", "fast"),
    ]
    first, second = data["comparisons"]
    assert first["ratio"] == pytest.approx(1.0 / second["ratio"])
    assert "5 / 5" in report_text(data, ".md")


def test_shares_and_causes(data):
    assert data["shares"][0]["parts"] == {"rollouts": 0.75, "mapf": 0.25}
    assert data["causes"] == [{"planner": "slow", "cause": "push/no_ik", "times": 3, "problems": 1}]
    endings = {(f["planner"], f["status"], f["reason"]) for f in data["failures"]}
    assert endings == {
        ("slow", "budget_exhausted", ""),
        ("slow", "crashed", "the worker was ended by SIGSEGV"),
        ("fast", "not verified", ""),
        ("fast", "over budget", ""),
    }


def test_engines_are_told_apart_if_there_are_several():
    rows = [row("m4m", "p1", 1.0), row("m4m", "p1", 2.0, engine="dart")]
    found = analyse(Subject("s", 2, 10.0, "m4m"), rows)
    assert [line["planner"] for line in found["curves"]] == ["m4m in mujoco", "m4m in dart"]
    assert found["comparisons"] == []


def test_sets_and_all_of_them():
    rows = [row("m4m", "p1", 1.0), row("m4m", "p2", 1.0, "none", set_name="b")]
    lines = analyse(Subject("s", 2, 10.0, "m4m"), rows)["groups"]
    assert [(line["set"], line["class"], line["n"]) for line in lines] == [
        ("a", "all", 1),
        ("a", "easy", 1),
        ("b", "all", 1),
        ("b", "none", 1),
        ("all", "all", 2),
        ("all", "none", 1),
        ("all", "easy", 1),
    ]


def test_classes_by_the_time_of_a_planner():
    rows = [
        row("naive", "p1", 0.5),
        row("naive", "p2", 3.0),
        row("naive", "p3", 0.5, verified=False),
        *(row("spamp", problem, 0.1) for problem in ("p1", "p2", "p3", "not_yet")),
    ]
    split = split_by_time(rows, Split("naive", 1.0))
    levels = {(r.recipe, r.problem_id): r.level for r in split}
    assert levels == {
        ("naive", "p1"): "quick",
        ("naive", "p2"): "slow",
        ("naive", "p3"): "slow",
        ("spamp", "p1"): "quick",
        ("spamp", "p2"): "slow",
        ("spamp", "p3"): "slow",
    }
    found = analyse(Subject("s", 6, 60.0, ("spamp",)), split)
    assert [g["class"] for g in found["groups"] if g["planner"] == "spamp"] == [
        "all",
        "quick",
        "slow",
    ]


def test_markdown_report(data):
    text = report_text(data, ".md")
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    figures = ["4", "2", "2", "100.0", "50.0", "15.0-85.0", "11.50", "2.0", "5.0"]
    assert ["slow", "a", "all", *figures] in lines
    assert ["slow", "4", "0.0", "25.0", "50.0", "50.0"] in lines
    assert [
        "fast",
        "slow",
        "4",
        "1",
        "1",
        "1",
        "1",
        "5 / 5",
        "1.00 / 2.00",
        "0.50",
        "0.50-0.50",
    ] in lines
    assert "different code" not in text
    assert "Not finished" not in text


def test_notes_on_what_is_not_as_it_should_be():
    rows = [row("slow", "p1", 1.0), row("slow", "p2", 1.0, code="c1")]
    text = report_text(analyse(SUBJECT, rows), ".md")
    assert "The rows are of different code (c0: 1, c1: 1)." in text
    assert "Not finished: 2 of 8 tasks are done." in text


def test_html_report_needs_no_other_file(data):
    text = report_text(data, ".html")
    assert text.count("<svg") == text.count("</svg>") == 3  # curves, pairs, shares
    assert "<td>the worker was ended by SIGSEGV</td>" in text
    for outside in ("<script", "<link", "<img", "@import", "src="):
        assert outside not in text
    assert text == report_text(data, ".html")


def test_names_are_text_and_nothing_else():
    rows = [row("<b>$x_{$", "p1", 1.0), row("a|b", "p1", 1.0)]
    found = analyse(Subject("s", 2, 10.0, "a|b"), rows)
    assert "<b>" not in re.sub("<!--.*?-->", "", report_text(found, ".html"))
    assert "a\\|b" in report_text(found, ".md")


def test_json_report(data):
    document = json.loads(report_text(data, ".json"))
    assert document["schema_version"] == 1
    assert document["groups"][0]["success"] == 0.5


@pytest.fixture
def store(tmp_path):
    """A study that was really stored, half of it with plans."""
    from mamo_core.study.tasks import Task

    names = Task.__dataclass_fields__
    with create_store(tmp_path / "s.db") as made:
        made.set_about(study="made_up", budget="10.0", baseline="slow")
        made.set_tasks([Task(**{name: getattr(r, name) for name in names}) for r in ROWS])
        for i, item in enumerate(ROWS):
            made.finish(item, zlib.compress(b"ab") if i % 2 else None, retry=False)
    with open_store(tmp_path / "s.db") as opened:
        yield opened


def test_what_is_stored_comes_back(store):
    assert store.rows() == ROWS
    assert report_data(store)["groups"] == analyse(SUBJECT, ROWS)["groups"]


def test_csv(store, tmp_path):
    assert write_rows(store, tmp_path / "rows.csv") == 8
    with (tmp_path / "rows.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert (lines[0]["set"], lines[0]["id"], lines[0]["class"]) == ("a", "p1", "easy")
    assert (lines[3]["cpu_s"], lines[3]["verified"]) == ("", "0")
    assert json.loads(lines[0]["parts"]) == {"rollouts": 1.5, "mapf": 0.5}


def test_parquet_needs_pyarrow(store, tmp_path, monkeypatch):
    monkeypatch.setattr("mamo_core.study.export.find_spec", lambda name: None)
    with pytest.raises(
        PluginError, match=r"x.parquet: Parquet needs pyarrow; install it with: pip"
    ):
        write_rows(store, tmp_path / "x.parquet")


def test_endings(store, tmp_path):
    with pytest.raises(InputError, match=r"ending '.xls' \(valid: .csv, .parquet, .log\)"):
        write_rows(store, tmp_path / "x.xls")
    with pytest.raises(InputError, match=r"ending '.pdf' \(valid: .md, .html, .json\)"):
        write_report({}, tmp_path / "x.pdf")
    assert [path.name for path in tmp_path.iterdir() if path.suffix in (".xls", ".pdf")] == []


def test_plans(store, tmp_path):
    assert write_plans(store, tmp_path / "plans") == 4
    assert len(list((tmp_path / "plans").glob("*.json"))) == 4
    name = "a__p2__slow__mujoco__seed0.json"
    assert (tmp_path / "plans" / name).read_text() == "ab"


def test_ompl_log():
    """Read as OMPL's own script reads it."""
    lines = iter(ompl_log("made_up", ROWS).splitlines())
    assert next(lines) == "Experiment made_up"
    assert next(lines).startswith("Running on ")
    assert next(lines).startswith("Starting at 2026")
    assert next(lines) == "<<<|"
    while next(lines) != "|>>>":
        pass
    heads = [next(lines).split(maxsplit=1) for _ in range(5)]
    assert [float(number) for number, _ in heads] == [0.0, 10.0, 0.0, 4.0, 8.0]
    assert next(lines) == "1 enum type"
    assert next(lines).split("|") == ["status", *STATUSES]
    assert next(lines) == "2 planners"
    for planner in ("slow", "fast"):
        assert next(lines) == planner
        assert next(lines) == "0 common properties"
        count = int(next(lines).split()[0])
        names = ["_".join(next(lines).split()[:-1]) for _ in range(count)]
        runs = [next(lines).split("; ")[:-1] for _ in range(int(next(lines).split()[0]))]
        assert all(len(run) == count for run in runs)
        assert next(lines) == "."
        times = [run[names.index("time")] for run in runs]
        assert times == (["2", "4", "9", ""] if planner == "slow" else ["1", "2", "3", "10.5"])
    assert next(lines, None) is None


def test_markdown_lines_have_one_width():
    lines = markdown(("a", "long header"), [("wide cell", "b")]).splitlines()
    assert len({len(line) for line in lines}) == 1


@pytest.mark.parametrize(
    ("changes", "good"),
    [
        ({}, True),
        ({"verified": False}, False),
        ({"status": "budget_exhausted"}, False),
        ({"cpu_s": 10.1}, False),
    ],
)
def test_only_verified_plans_within_the_budget_are_successes(changes, good):
    assert replace(row("m4m", "p", 1.0), **changes).succeeded is good
