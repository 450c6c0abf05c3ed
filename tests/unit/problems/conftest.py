"""What the tests of problems share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from mamo_core.problems import generate_shelf, problem_document, save_problems
from mamo_core.problems.published import scenes_folder
from mamo_core.types.problem import Problem


@pytest.fixture(scope="session", name="scenes_folder")
def _scenes_folder() -> Path:
    """Folder of the published scenes, or a skip that says where it was looked for."""
    folder = scenes_folder()
    if not (folder / "thesis_5_movables.jsonl.gz").is_file():
        pytest.skip(f"the published scenes are not in {folder} (set MAMO_SCENES)")
    return folder


@pytest.fixture(scope="session")
def shelf() -> Problem:
    return generate_shelf(movables=3, seed=1)


@pytest.fixture
def yaml_text(shelf: Problem, tmp_path: Path) -> str:
    """The shelf as a YAML document."""
    path = tmp_path / "shelf.yaml"
    save_problems([shelf], path)
    return path.read_text()


@pytest.fixture
def edited(shelf: Problem) -> Callable[..., dict[str, object]]:
    """The shelf's document with the value at a path of keys replaced."""

    def edit(*keys: str | int, value: object) -> dict[str, object]:
        document = problem_document(shelf)
        place = document
        for key in keys[:-1]:
            place = place[key]  # type: ignore[index]
        place[keys[-1]] = value  # type: ignore[index]
        return document

    return edit
