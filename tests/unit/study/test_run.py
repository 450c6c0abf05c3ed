"""Studies with workers that pretend: rows, resuming, failures, what is refused."""

from dataclasses import replace

import pytest
import study_deeds as deeds

import mamo_core.study.run
from mamo_core.errors import InputError
from mamo_core.study.lock import StoreLock
from mamo_core.study.store import create_store, open_store


def seconds_aside(found):
    return [{k: v for k, v in vars(row).items() if k not in deeds.SECONDS} for row in found]


def test_rows(study, run, rows):
    status, told = run(study(seeds=[0, 1]))
    assert {k: status[k] for k in ("total", "done", "pending", "failed", "duplicates")} == {
        "total": 4,
        "done": 4,
        "pending": 0,
        "failed": 0,
        "duplicates": 0,
    }
    counts = {"total": 4, "done": 4, "pending": 0, "failed": 0, "solved": 2, "verified": 2}
    assert status["by_recipe"] == [{"recipe": "m4m", **counts}]
    first, second = rows()[:2]
    assert (first.set_name, first.problem_id, first.level) == ("few", "shelf_1_seed1", "easy")
    assert (first.status, first.verified, first.cpu_s, first.reason) == ("solved", True, 0.03, "")
    assert (second.status, second.verified, second.rollouts) == ("budget_exhausted", False, 3)
    assert second.causes == {"o1/push/no_ik": 2, "o2/push/no_ik": 1}
    assert told[-1].startswith("[4/4] few#shelf_1_seed2  easy  m4m in mujoco, seed 1  budget_exha")


def test_again_does_nothing(study, run, rows, did):
    path = study()
    run(path)
    before, done = rows(), did("solve")
    status, told = run(path)
    assert rows() == before
    assert did("solve") == done
    assert (status["done"], status["duplicates"]) == (2, 0)
    assert told == ["2 of 2 tasks are done already"]


def test_more_tasks_do_only_what_is_new(study, run, did):
    run(study(seeds=[0]))
    status, _ = run(study(seeds=[0, 2]))
    assert (status["total"], status["done"]) == (4, 4)
    assert [line.split()[-1] for line in did("solve")] == ["0", "0", "2", "2"]
    assert len(did("classify")) == 2


def test_fewer_tasks_keep_the_rows_for_later(study, run, rows, did):
    run(study(seeds=[0, 2]))
    status, _ = run(study(seeds=[2]))
    assert (status["total"], {row.seed for row in rows()}) == (2, {2})
    run(study(seeds=[0, 2]))
    assert len(did("solve")) == 4


DEADLY = {
    deeds.ABORT: ("crashed", "the worker was ended by SIGABRT"),
    deeds.SEGFAULT: ("crashed", "the worker was ended by SIGSEGV"),
    deeds.KILL: ("crashed", "the worker was ended by SIGKILL"),
    deeds.HANG: ("timeout", "no answer for 2 s"),
    deeds.FAIL: ("error", "TimeoutError: no luck"),
}


def test_failures_are_rows_and_the_others_go_on(study, run, rows):
    seeds = [0, *DEADLY, 2]
    status, _ = run(study(seeds=seeds, deadline=2.0), workers=2)
    assert (status["total"], status["done"], status["failed"]) == (14, 14, 10)
    found = {(row.problem_id, row.seed): (row.status, row.reason) for row in rows()}
    for problem in ("shelf_1_seed1", "shelf_1_seed2"):
        assert {seed: found[problem, seed] for seed in DEADLY} == DEADLY
        assert found[problem, 2] == ("solved", "")
    assert all(row.cpu_s is None for row in rows() if row.failed)


def test_failures_are_tried_again_only_if_asked(study, run, rows, did):
    path = study(seeds=[0, deeds.FAIL])
    run(path)
    assert run(path)[1] == ["4 of 4 tasks are done already"]
    status, told = run(path, retry_failed=True)
    assert told[0] == "2 of 4 tasks are done already"
    assert (status["done"], status["failed"], status["duplicates"]) == (4, 2, 0)
    assert len(did("solve")) == 2


def test_rows_of_other_code(study, run, rows, did, monkeypatch):
    path = study()
    run(path)
    monkeypatch.setattr(mamo_core.study.run, "code_version", lambda: "other")
    status, _ = run(path, any_code=True)
    assert (status["done"], len(did("solve"))) == (2, 2)
    status, told = run(path)
    assert (status["done"], len(did("solve"))) == (2, 4)
    assert "2 rows of other code are not used (they are with --any-code)" in told
    assert {row.code for row in rows()} == {"other"}


def test_classes_are_found_out_before_they_choose(study, run, did):
    path = study()
    text = path.read_text().replace(
        "[few.jsonl]", "[{file: few.jsonl, classes: [hard]}, {file: few.jsonl, limit: 1}]"
    )
    path.write_text(text)
    status, _ = run(path)
    assert (status["total"], len(did("classify")), len(did("solve"))) == (1, 2, 1)


def test_generated_problems(study, run, rows, did):
    path = study()
    source = "[{generate: {levels: [easy, hard], movables: [1, 2], count: 1, seed: 4}}]"
    path.write_text(path.read_text().replace("[few.jsonl]", source))
    run(path)
    assert [(row.set_name, row.problem_id) for row in rows()] == [
        ("shelf_1", "easy_1_4"),
        ("shelf_1", "hard_1_4"),
        ("shelf_2", "easy_2_4"),
        ("shelf_2", "hard_2_4"),
    ]
    run(path)
    assert len(did("generate")) == 4


REACHES = "[{generate: {workspace: refrigerator, count: 2, seed: 4}}]"


def test_generated_reaches(study, run, rows, did, monkeypatch):
    """Searches that reach are not needed here: nothing is solved."""
    monkeypatch.setattr(mamo_core.study.run, "choose", lambda *arguments: ())
    path = study()
    path.write_text(path.read_text().replace("[few.jsonl]", REACHES))
    run(path)
    assert [(row.set_name, row.problem_id) for row in rows()] == [
        ("refrigerator", "refrigerator_3_2_seed4"),
        ("refrigerator", "refrigerator_3_2_seed5"),
    ]
    run(path)
    assert did("generate") == ["generate refrigerator 3 2 4", "generate refrigerator 3 2 5"]


def test_a_recipe_for_another_task_is_refused_before_anything_is_solved(study, run, did):
    path = study()
    both = f"[few.jsonl, {REACHES[1:]}"
    path.write_text(path.read_text().replace("[few.jsonl]", both))
    with pytest.raises(InputError, match="'greedy' does not plan for the task 'reach' of problem"):
        run(path)
    assert did("solve") == []


def test_two_names_of_the_same_recipe_share_a_row(study, run, rows, did):
    path = study()
    path.write_text(path.read_text().replace("[m4m]", "[m4m, {recipe: m4m, name: again}]"))
    status, _ = run(path)
    assert (status["total"], status["done"], len(did("solve"))) == (4, 4, 2)
    assert [row.recipe for row in rows()] == ["m4m", "again", "m4m", "again"]


def test_one_writer(study, run, tmp_path):
    path = study()
    with (
        StoreLock(tmp_path / "s.db"),
        pytest.raises(
            InputError, match=r"s.db: another 'mamo study run' \(process \d+\) is writing"
        ),
    ):
        run(path)
    run(path)


def test_another_study_is_not_mixed_in(study, run):
    path = study()
    run(path)
    path.write_text(path.read_text().replace("pretence", "earnest"))
    with pytest.raises(InputError, match="holds study 'pretence', not 'earnest'; choose another"):
        run(path)


@pytest.mark.parametrize("content", [b"", b"no database at all", None])
def test_stores_that_are_none(tmp_path, content):
    path = tmp_path / "x.db"
    if content is not None:
        path.write_bytes(content)
    with (
        pytest.raises(InputError, match=r"x.db: (is not|no such) .*store of a study"),
        open_store(path),
    ):
        pass


def test_other_files_are_not_written_to(study, run, tmp_path):
    (tmp_path / "s.db").write_text("notes of somebody else, and not short ones either" * 20)
    with pytest.raises(InputError, match="is not the store of a study"):
        run(study())
    assert (tmp_path / "s.db").read_text().startswith("notes")
    with pytest.raises(InputError, match="expected a file in a folder that exists"):
        run(study(), store=tmp_path / "no" / "s.db")


def test_a_recipe_that_cannot_work_is_refused_before_anything_runs(study, run, did):
    path = study(more="engines: [mujoko]\n")
    with pytest.raises(InputError, match="unknown backend 'mujoko'; did you mean 'mujoco'"):
        run(path)
    assert did("solve") == []


def test_a_row_is_written_once(study, run, rows, tmp_path):
    """Even if two processes did the same, the first row stays, and it is counted."""
    run(study())
    row = rows()[0]
    with create_store(tmp_path / "s.db") as store:
        store.finish(replace(row, status="budget_exhausted"), None, retry=False)
        assert store.duplicates() == 1
        assert store.rows()[0] == row


def test_results_do_not_depend_on_the_number_of_workers(study, run, rows, tmp_path):
    path = study(seeds=range(6))
    run(path)
    run(path, store=tmp_path / "t.db", workers=3)
    assert seconds_aside(rows()) == seconds_aside(rows("t.db"))
