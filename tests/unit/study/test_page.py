"""The page of a study: every problem leads to its picture, every plan to its file."""

import re
import zlib
from dataclasses import replace

import pytest

from mamo_core.errors import InputError
from mamo_core.plan_file import PlanDocument, plan_text, read_plan
from mamo_core.problems import generate_shelf, problem_document
from mamo_core.study.page import write_page
from mamo_core.study.problems import DOCUMENT, content_hash
from mamo_core.study.report import report_data
from mamo_core.study.rows import Row
from mamo_core.study.store import create_store
from mamo_core.study.tasks import Task
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.solution import Plan

PROBLEM = generate_shelf(movables=1, seed=1)
HASH = content_hash(problem_document(PROBLEM))


def plan():
    """A retrieval in which the arm stays where it is."""
    stay = Trajectory.still(PROBLEM.home, 0.0)
    segment = MotionSegment(SegmentKind.TRANSIT, stay, 0.0, None, True)
    document = PlanDocument(PROBLEM, Plan((), Motion((segment,), 0.0)), {}, 0)
    return plan_text(document)


def row(recipe, solved, **changes):
    return Row(
        key=recipe,
        subject=recipe,
        set_name="<shelves>",
        problem_id="one",
        problem=HASH,
        recipe=recipe,
        engine="mujoco",
        seed=0,
        budget=10.0,
        level="easy",
        status="solved" if solved else "budget_exhausted",
        verified=solved,
        cpu_s=1.5,
        actions=0,
        reason="" if solved else "no plan within the budget",
        wall_s=1.0,
        code="c0",
        started="2026-01-01T00:00:00.000+00:00",
        finished="2026-01-01T00:00:01.000+00:00",
        causes={} if solved else {"o1/push/no_ik": 3},
        **changes,
    )


def task(of):
    return Task(**{name: getattr(of, name) for name in Task.__dataclass_fields__})


@pytest.fixture
def store(tmp_path):
    rows = [row("able", True), row("unable", False)]
    with create_store(tmp_path / "s.db") as made:
        made.set_about(study="made_up", budget="10.0", baseline="able")
        made.set_tasks(
            [Task(**{n: getattr(r, n) for n in Task.__dataclass_fields__}) for r in rows]
        )
        made.set_fact(DOCUMENT, HASH, "c0", problem_document(PROBLEM))
        made.finish(rows[0], zlib.compress(plan().encode()), retry=False)
        made.finish(rows[1], None, retry=False)
        yield made


def page(store, folder):
    write_page(store, folder, report_data(store), lambda text: None)
    return (folder / "index.html").read_text()


def links(text):
    """Not those inside of plots."""
    return re.findall(r'<a href="([^"]+)"', text)


def test_links_lead_to_files(store, tmp_path):
    text = page(store, tmp_path / "page")
    found = links(text)
    assert len(found) == 3  # two pictures, and the plan of the one that has it
    for link in found:
        assert (tmp_path / "page" / link).is_file()
    (file,) = [link for link in found if link.endswith(".json")]
    assert read_plan(tmp_path / "page" / file).problem.name == PROBLEM.name
    assert "&lt;shelves&gt;#one" in text
    assert "budget exhausted" in text
    assert "no plan within the budget; o1/push/no_ik: 3" in text


def test_a_second_time_only_what_is_missing_is_drawn(store, tmp_path):
    first = page(store, tmp_path / "page")
    pictures = sorted((tmp_path / "page" / "pictures").iterdir())
    pictures[0].unlink()
    pictures[1].write_bytes(b"untouched")
    assert page(store, tmp_path / "page") == first
    assert pictures[0].is_file()
    assert pictures[1].read_bytes() == b"untouched"


def test_a_store_that_has_no_problems_gives_a_page_without_their_pictures(store, tmp_path):
    store._connection.execute("DELETE FROM facts")
    text = page(store, tmp_path / "page")
    assert len(links(text)) == 2


def test_planners_are_told_apart_by_engine_and_lines_by_seed(store, tmp_path):
    more = replace(row("able", True), key="again", subject="again", engine="dart", seed=3)
    store.set_tasks([*store.tasks(), task(more)])
    store.finish(more, None, retry=False)
    text = page(store, tmp_path / "page")
    assert "<th>able in dart</th>" in text
    assert "#one, seed 3" in text


def test_a_folder_that_is_a_file(store, tmp_path):
    from mamo_core.atomic import check_folder

    (tmp_path / "page").write_text("")
    with pytest.raises(InputError, match="is a file, expected a folder"):
        check_folder(tmp_path / "page")
    with pytest.raises(InputError, match="no such folder"):
        check_folder(tmp_path / "absent" / "page")
