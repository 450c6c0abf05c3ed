"""Does what is left of a study; the only process that writes to the store."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mamo_core.choices import choose
from mamo_core.errors import InputError, suggestion
from mamo_core.plugins import Registry, discover
from mamo_core.problems import problem_from_document
from mamo_core.study.code import code_version
from mamo_core.study.definition import Study, Variant, load_study
from mamo_core.study.facts import UNKNOWN, Researcher, Tell
from mamo_core.study.jobs import Executor
from mamo_core.study.problems import DOCUMENT, StudyProblem
from mamo_core.study.rows import Row, row_of
from mamo_core.study.status import status_of
from mamo_core.study.store import Store, create_store, is_failed
from mamo_core.study.tasks import Task, Work, make_tasks, solve_job

EXECUTORS = ("local", "ray")
DEFAULT_FOLDER = Path("out")
Item = tuple[Task, StudyProblem, Variant]


@dataclass(frozen=True)
class StudyOrder:
    """The arguments of ``mamo study run``.

    ``workers``: None for as many as there are cores. ``any_code``: rows of other code count as
    done. ``plans``: keep the plans in the store, too.
    """

    study: Path
    store: Path | None = None
    executor: str = "local"
    workers: int | None = None
    settings: tuple[str, ...] = ()
    retry_failed: bool = False
    any_code: bool = False
    plans: bool = True


def run_study(order: StudyOrder, tell: Tell, work: Work | None = None) -> dict[str, Any]:
    """Do what has no row yet; the status of the store in the end.

    Raises:
        InputError: the study, a problem or a recipe is wrong, or the store is in use.
        PluginError: an engine that is needed cannot be used.
    """
    study = load_study(order.study, order.settings)
    with _store(order, study) as store, closing(_executor(order)) as executor:
        _Run(order, study, store, executor, tell, work or Work()).run()
        return status_of(store)


def store_path(order: StudyOrder, study: Study) -> Path:
    """Where the rows go."""
    return order.store if order.store is not None else DEFAULT_FOLDER / f"{study.name}.db"


@contextmanager
def _store(order: StudyOrder, study: Study) -> Iterator[Store]:
    if order.store is None:
        _make_default_folder()
    with create_store(store_path(order, study)) as store:
        name = store.about("study")
        if name not in (None, study.name):
            raise InputError(
                f"{store.path}: holds study {name!r}, not {study.name!r}; choose another --store"
            )
        yield store


def _make_default_folder() -> None:
    try:
        DEFAULT_FOLDER.mkdir(exist_ok=True)
    except OSError as error:
        words = f"{DEFAULT_FOLDER}: cannot be made: {error.strerror}; choose a --store"
        raise InputError(words) from None


def _executor(order: StudyOrder) -> Executor:
    if order.executor == "local":
        from mamo_core.study.local import LocalExecutor, cores

        return LocalExecutor(order.workers if order.workers is not None else cores())
    if order.executor == "ray":
        from mamo_core.study.ray_cluster import RayExecutor

        return RayExecutor(order.workers)
    hint = suggestion(order.executor, EXECUTORS)
    raise InputError(f"--executor: unknown executor {order.executor!r}{hint}")


class _Run:
    """One run of a study."""

    def __init__(
        self,
        order: StudyOrder,
        study: Study,
        store: Store,
        executor: Executor,
        tell: Tell,
        work: Work,
    ) -> None:
        self._order, self._study, self._store = order, study, store
        self._executor, self._tell, self._work = executor, tell, work
        self._code = code_version()
        self._research = Researcher(store, executor, work, self._code, order.any_code, tell)

    def run(self) -> None:
        sources = self._research.problems(self._study)
        everything = [problem for _, problems in sources for problem in problems]
        if not everything:
            raise InputError(f"{self._order.study}: problems: none are left")
        _check_variants(self._study, everything, discover())
        self._describe(self._items(self._wanted(sources)))
        self._research.classify(everything, retry=self._order.retry_failed)
        items = self._items(self._wanted(sources))
        self._describe(items)
        self._solve(items)

    def _wanted(self, sources: Any) -> list[StudyProblem]:
        """The problems of the classes that are asked for, as far as classes are known."""
        found: list[StudyProblem] = []
        for source, problems in sources:
            if source is None:
                found += problems
                continue
            classes = source.classes
            kept = [p for p in problems if classes is None or self._may_be(p, classes)]
            found += kept[: source.limit]
        return found

    def _may_be(self, problem: StudyProblem, classes: tuple[str, ...]) -> bool:
        level = self._research.level(problem)
        return level is None or level in classes

    def _items(self, problems: list[StudyProblem]) -> list[Item]:
        items = list(make_tasks(self._study, problems, self._code))
        return [self._reused(item) for item in items] if self._order.any_code else items

    def _reused(self, item: Item) -> Item:
        task, problem, variant = item
        key = self._store.key_of_subject(task.subject)
        return (replace(task, key=key) if key is not None else task), problem, variant

    def _describe(self, items: list[Item]) -> None:
        self._store.set_tasks([task for task, _, _ in items])
        for problem in {item[1].hash: item[1] for item in items}.values():
            if self._store.fact(DOCUMENT, problem.hash) is None:
                self._store.set_fact(DOCUMENT, problem.hash, self._code, problem.document)
        self._store.set_about(
            study=self._study.name,
            file=str(self._order.study),
            baseline=self._study.baseline,
            budget=repr(self._study.budget),
        )

    def _solve(self, items: list[Item]) -> None:
        statuses = self._store.finished()
        jobs: dict[str, Item] = {}
        for item in items:
            status = statuses.get(item[0].key)
            if status is None or (self._order.retry_failed and is_failed(status)):
                jobs[item[0].key] = item
        done = sum(task.key not in jobs for task, _, _ in items)
        if done:
            self._tell(f"{done} of {len(items)} tasks are done already")
        self._tell_of_other_code(list(jobs.values()))
        deadline = self._study.deadline
        orders = [solve_job(*item, deadline, self._code, self._work) for item in jobs.values()]
        for number, outcome in enumerate(self._executor.run(orders), done + 1):
            if outcome.refused is not None:
                raise outcome.refused
            task, problem, _ = jobs[outcome.key]
            level = self._research.level(problem) or UNKNOWN
            row = row_of(task, outcome, level, self._code)
            plan = outcome.value.get("plan") if outcome.failure is None else None
            kept = plan if self._order.plans else None
            self._store.finish(row, kept, retry=task.key in statuses)
            self._tell(f"[{number}/{len(items)}] {line_of(row)}")

    def _tell_of_other_code(self, items: list[Item]) -> None:
        others = sum(
            self._store.key_of_subject(task.subject) not in (None, task.key) for task, _, _ in items
        )
        if others:
            self._tell(f"{others} rows of other code are not used (they are with --any-code)")


def _check_variants(study: Study, problems: list[StudyProblem], registry: Registry) -> None:
    """Complain of recipes and engines before anything runs, with one problem of each task."""
    examples = {problem.document.get("task"): problem for problem in reversed(problems)}
    for problem in examples.values():
        scene = problem_from_document(problem.document, problem.id)
        for variant in study.variants:
            choose(variant.loaded, scene, registry)


def line_of(row: Row) -> str:
    """A row in a line."""
    seconds = "" if row.cpu_s is None else f"{row.cpu_s:.2f} s, "
    words = [
        f"{row.set_name}#{row.problem_id}",
        row.level,
        f"{row.recipe} in {row.engine}, seed {row.seed}",
        row.status + (", verified" if row.verified else ""),
        f"{seconds}{row.actions} actions, {row.rollouts} rollouts",
    ]
    return "  ".join(words) + (f"  ({row.reason})" if row.reason else "")
