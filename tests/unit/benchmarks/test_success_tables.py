"""Statistics and tables of the success benchmark."""

import pytest
from success_tables import markdown, quantile, report, succeeded, wilson


def row(set_name="a", level="easy", cpu=1.0, *, status="solved", verified=True, code="c0"):
    return {
        "set": set_name,
        "id": "1",
        "difficulty": level,
        "status": status,
        "verified": verified,
        "cpu_s": cpu,
        "parts": {"rollouts": 0.75 * cpu, "mapf": 0.25 * cpu},
        "actions": 2,
        "rollouts": 5,
        "code": code,
    }


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(0, 0, 0.0, 1.0), (0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634), (10, 10, 0.7225, 1.0)],
)
def test_wilson(successes, n, low, high):
    assert wilson(successes, n) == pytest.approx((low, high), abs=1e-4)


def test_quantile():
    assert quantile([], 0.5) is None
    assert quantile([3.0], 0.9) == 3.0
    assert quantile([1.0, 2.0, 3.0, 4.0], 0.5) == 2.5
    assert quantile([1.0, 2.0], 1.0) == 2.0


@pytest.mark.parametrize(
    ("changes", "good"),
    [
        ({}, True),
        ({"verified": False}, False),
        ({"status": "budget_exhausted"}, False),
        ({"cpu": 10.1}, False),
    ],
)
def test_only_verified_plans_within_the_budget_are_successes(changes, good):
    assert succeeded(row(**changes), budget=10.0) is good


def test_report():
    rows = [
        row(cpu=1.0),
        row(cpu=3.0),
        row(level="hard", cpu=9.0, status="budget_exhausted", verified=False),
        row("b", "none", 0.5),
    ]
    lines = report(rows, budget=60.0).splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert cells[2][:10] == ["a", "all", "3", "2", "2", "66.7", "20.8-93.9", "2.00", "2.80", "3.00"]
    assert [line[:2] for line in cells[3:10]] == [
        ["a", "easy"],
        ["a", "hard"],
        ["b", "all"],
        ["b", "none"],
        ["all", "all"],
        ["all", "none"],
        ["all", "easy"],
    ]
    assert cells[4][5:] == ["0.0", "0.0-79.3", "-", "-", "-", "-", "-"]
    assert ["share of CPU", "rollouts", "mapf"] in cells
    assert ["a", "75.0 %", "25.0 %"] in cells
    assert "different code" not in lines[-1]


def test_rows_of_different_code_are_pointed_out():
    assert "(c0: 1, c1: 2)" in report([row(), row(code="c1"), row(code="c1")], 60.0)


def test_markdown_lines_have_one_width():
    lines = markdown(("a", "long header"), [("wide cell", "b")]).splitlines()
    assert len({len(line) for line in lines}) == 1
