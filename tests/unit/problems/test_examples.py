"""The problems that come with the repository."""

from __future__ import annotations

from pathlib import Path

import pytest

from mamo_core.problems import load_problem

FOLDER = Path(__file__).resolve().parents[3] / "problems"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.yaml")), ids=lambda path: path.stem)
def test_it_is_valid_and_named_like_its_file(path: Path) -> None:
    problem = load_problem(path)
    assert problem.name == path.stem
    assert problem.grasps


def test_there_are_some() -> None:
    assert len(list(FOLDER.glob("*.yaml"))) >= 2
