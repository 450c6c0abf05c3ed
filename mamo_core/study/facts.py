"""What must be known before there are tasks: generated problems, and the classes of all.

Both are found out in worker processes, once, and kept in the store.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from mamo_core.errors import InputError, WorkerCrashedError
from mamo_core.study.definition import Study
from mamo_core.study.jobs import Call, Executor, Failure, Job, Outcome
from mamo_core.study.problems import (
    StudyProblem,
    Wanted,
    loaded,
    pick_source,
    study_problem,
    wanted,
)
from mamo_core.study.schema import FileSource
from mamo_core.study.store import Store
from mamo_core.study.tasks import Work

UNKNOWN = "unknown"
_DEADLINE = 600.0
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Researcher:
    """Finds out facts with an executor and keeps them in a store.

    ``code``: that the facts are of; with ``any_code`` older facts do as well.
    """

    store: Store
    executor: Executor
    work: Work
    code: str
    any_code: bool
    tell: Tell

    def problems(self, study: Study) -> list[tuple[FileSource | None, list[StudyProblem]]]:
        """The problems of each source, classes and limits not yet regarded.

        Raises:
            InputError: a file, an id or a problem is wrong, or nothing fits to be generated.
        """
        found: list[tuple[FileSource | None, list[StudyProblem]]] = []
        for source in study.sources:
            if isinstance(source, FileSource):
                picked = pick_source(source, study.folder)
                found.append((source, [loaded(entry) for entry in picked]))
            else:
                found.append((None, self._generated(list(wanted(source)))))
        return found

    def classify(self, problems: Iterable[StudyProblem], *, retry: bool) -> None:
        """Find out the classes that are not known; those that failed again only to ``retry``."""
        missing = {p.hash: p for p in problems if self._lacks_class(p, retry)}
        jobs = [self._job(p.hash, self.work.classify, problem=p.document) for p in missing.values()]
        for number, outcome in enumerate(self._run(jobs), 1):
            level = outcome.value if outcome.failure is None else UNKNOWN
            self.store.set_fact("class", outcome.key, self.code, level)
            words = f": {outcome.cause}" if outcome.cause else ""
            name = missing[outcome.key].id
            self.tell(f"class {number} of {len(jobs)}: {name} is {level}{words}")

    def level(self, problem: StudyProblem) -> str | None:
        """The class of a problem, if it has been found out."""
        code = None if self.any_code else self.code
        level: str | None = self.store.fact("class", problem.hash, code)
        return level

    def _lacks_class(self, problem: StudyProblem, retry: bool) -> bool:
        level = self.level(problem)
        return level is None or (retry and level == UNKNOWN)

    def _generated(self, items: list[Wanted]) -> list[StudyProblem]:
        code = None if self.any_code else self.code
        missing = [i for i in items if self.store.fact("problem", i.subject, code) is None]
        jobs = [
            self._job(item.subject, getattr(self.work, item.function), **item.arguments)
            for item in missing
        ]
        for number, outcome in enumerate(self._run(jobs), 1):
            _check_generated(outcome)
            self.store.set_fact("problem", outcome.key, self.code, outcome.value)
            self.tell(f"generated {number} of {len(jobs)}: {outcome.value['name']}")
        documents = [(item, self.store.fact("problem", item.subject)) for item in items]
        return [study_problem(item.set_name, d["name"], d) for item, d in documents]

    def _run(self, jobs: list[Job]) -> Iterator[Outcome]:
        for outcome in self.executor.run(jobs):
            if outcome.refused is not None:
                raise outcome.refused
            yield outcome

    def _job(self, key: str, function: str, **arguments: object) -> Job:
        ready = Call(self.work.ready_to_classify, {"code": self.code})
        return Job(key, Call(function, arguments), _DEADLINE, ready)


def _check_generated(outcome: Outcome) -> None:
    """There is no study without its problems."""
    words = f"generate {outcome.key}: {outcome.cause}"
    if outcome.failure is Failure.ERROR:
        raise InputError(words)
    if outcome.failure is not None:
        raise WorkerCrashedError(words)
