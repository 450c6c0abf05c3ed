"""Which of all that failed is the reason.

The first of these that holds: what comes later could not help where it holds.

1. There is no retrieval even without the movables.
2. Movables cannot get out of the way, not even without physics.
3. A movable in the way was not moved aside. Of several the one that is in most of the ways looked
   at, and of these one that no action ever moved; of its failures those that were found out by
   simulating, as earlier ones only cost a candidate; of these the most frequent, for each action.
4. Nothing is in the way, but what was executed failed.
5. Otherwise, what failed most often.

What a second look at the initial scene has found decides the first two; where nobody looked they
hold if nothing else was ever tried.
"""

from __future__ import annotations

from collections.abc import Sequence

from mamo_core.explain.explanation import Detail, Explanation, Obstruction
from mamo_core.explain.facts import IN_THE_WAY, PATHS, RETRIEVAL, Facts
from mamo_core.explain.words import BLOCKED, listed, named_some
from mamo_core.types.problem import Problem, Task
from mamo_core.types.solution import Solution, Statistics


def explain(problem: Problem, solution: Solution, found: Statistics | None = None) -> Explanation:
    """Why ``solution``, which has no plan, has none.

    ``found``: what ``SearchStrategy.diagnose`` has found, if it was asked.
    """
    facts = Facts(problem, solution, found if found is not None else Statistics())
    if problem.task is Task.RETRIEVE:
        for reason in (_no_retrieval, _no_paths, _no_action, _not_executed):
            explanation = reason(facts)
            if explanation is not None:
                return explanation
    return _most_often(facts)


def _no_retrieval(facts: Facts) -> Explanation | None:
    details = facts.of(RETRIEVAL, [facts.target], found=facts.looked)
    others = {d.action for d in facts.details} - {RETRIEVAL}
    if not details or (not facts.looked and others):
        return None
    first = details[0]
    others_too = facts.of(RETRIEVAL, [facts.target])
    why = _what_blocks(first, others_too) if first.cause == BLOCKED else first.words
    words = f"no way was found to take out {facts.target}, even with all movables gone: {why}"
    return _explanation(facts, words, Obstruction.RETRIEVAL, [first])


def _no_paths(facts: Facts) -> Explanation | None:
    details = facts.of(PATHS, facts.movables, found=facts.looked)
    others = {d.action for d in facts.details} - {RETRIEVAL, PATHS}
    if not details or (not facts.looked and others):
        return None
    first = details[0]
    same = [d for d in details if d.cause == first.cause]
    stuck = [d.subject for d in same]
    words = f"{listed(stuck)} cannot get out of the way of the retrieval: {first.words}"
    around = [name for name in first.others if name not in stuck]
    if around:
        words += f"; around it: {_some(around, facts)}"
    return _explanation(facts, words, Obstruction.PATHS, same)


def _no_action(facts: Facts) -> Explanation | None:
    if not facts.blockers:
        return None
    name = facts.blockers[0]
    failed = {
        action: facts.furthest(facts.of(action, [name])) for action in facts.actions_with(name)
    }
    phrases = [f"with {kind} {_with_share(details, facts)}" for kind, details in failed.items()]
    words = f"{name} stands in the way, {_fate(facts.moved(name), bool(failed))}"
    words += f": {', '.join(phrases)}" if phrases else ""
    about = [details[0] for details in failed.values()]
    return _explanation(facts, words, Obstruction.ACTION, about, (name,))


def _fate(moved: int, tried: bool) -> str:
    if moved:
        return f"and that it was moved {_times(moved)} did not help"
    return "and no action moved it" if tried else "and the search ended before it was moved"


def _not_executed(facts: Facts) -> Explanation | None:
    details = facts.furthest(facts.executing)
    if not details or not facts.looked:
        return None
    words = "nothing stands in the way, but what was executed failed: "
    words += _with_share(details, facts)
    return _explanation(facts, words, Obstruction.EXECUTION, details[:1])


def _most_often(facts: Facts) -> Explanation:
    details = [d for d in facts.details if d.cause != IN_THE_WAY]
    if not details:
        words = facts.solution.reason or "the search counted nothing that failed"
        return _explanation(facts, words, Obstruction.UNKNOWN, [])
    first = details[0]
    words = f"what failed most often is {first.action} of {first.subject}: "
    words += f"{first.words} ({_times(first.times)})"
    return _explanation(facts, words, Obstruction.UNKNOWN, [first])


def _with_share(details: Sequence[Detail], facts: Facts) -> str:
    """The first one; of those that were simulated, how often of all."""
    first, total = details[0], sum(d.times for d in details)
    if first.cause == BLOCKED:
        return _what_blocks(first, details)
    share = f"{first.times} of {total} simulated"
    often = share if facts.are_simulated(details) else _times(first.times)
    return f"{first.words} ({often})"


def _what_blocks(blocked: Detail, details: Sequence[Detail]) -> str:
    """Who is in the way, and of the other causes the most frequent."""
    most = next((d for d in details if d.cause != BLOCKED), None)
    return f"{blocked.words} (mostly: {most.words})" if most else blocked.words


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _some(names: Sequence[str], facts: Facts) -> str:
    return listed(named_some(names, facts.problem.scene))


def _explanation(
    facts: Facts,
    words: str,
    obstruction: Obstruction,
    about: Sequence[Detail],
    subjects: tuple[str, ...] = (),
) -> Explanation:
    return Explanation(
        headline=words,
        obstruction=obstruction,
        subjects=subjects or tuple(dict.fromkeys(d.subject for d in about)),
        causes=tuple(dict.fromkeys(d.cause for d in about)),
        involved=tuple(dict.fromkeys(name for d in about for name in d.others)),
        details=facts.details,
    )
