"""From what was counted to details."""

from __future__ import annotations

from collections import Counter

from mamo_core.explain.explanation import Detail
from mamo_core.explain.words import in_words
from mamo_core.types.scene import ROBOT_NAME, Scene
from mamo_core.types.solution import Statistics


def details_of(scene: Scene, *counted: Statistics) -> tuple[Detail, ...]:
    """What was counted, the most frequent first; of a key counted twice the first number."""
    times: dict[str, int] = {}
    involved: dict[str, Counter[tuple[str, ...]]] = {}
    for statistics in counted:
        for key, count in statistics.causes.items():
            if count:
                times.setdefault(key, count)
        for key, names in statistics.involved.items():
            involved.setdefault(key, names)
    found = [_detail(key, n, involved.get(key, Counter()), scene) for key, n in times.items()]
    return tuple(sorted(found, key=lambda d: (-d.times, d.subject, d.action, d.cause)))


def _detail(key: str, times: int, involved: Counter[tuple[str, ...]], scene: Scene) -> Detail:
    subject, action, cause = (*key.split("/", 2), "", "")[:3]
    others: Counter[str] = Counter()
    for names, count in involved.items():
        others.update(dict.fromkeys(set(names) - {subject, ROBOT_NAME}, count))
    ranked = tuple(sorted(others.items(), key=lambda item: (-item[1], item[0])))
    alone = times - others.total()
    mostly = [name for name, _ in ranked] if ranked and ranked[0][1] >= alone else []
    return Detail(subject, action, cause, times, in_words(cause, mostly, scene), ranked)
