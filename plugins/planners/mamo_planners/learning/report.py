"""What was fitted, as a part of a recipe, a document and a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from mamo_planners.learning.data import Data, Point
from mamo_planners.learning.fit import CONFIDENCE, Fit
from mamo_planners.learning.ranking import ranked_right
from mamo_planners.search.features import Features
from mamo_planners.search.options import BestFirstOptions
from mamo_planners.search.priority import PriorityModel, log_density, log_survival

PARAMETERS = ("alpha", "beta", "count_rate", "effort_rate")
_DIGITS = 6


@dataclass(frozen=True)
class Report:
    """A fit, and what it was made from: ``points`` of the problems asked for."""

    command: str
    fit: Fit
    points: Sequence[Point]
    cut: int
    left_out: int

    @property
    def words(self) -> str:
        """The data in one line."""
        fit = self.fit
        return (
            f"{fit.points} rearrangements of {fit.problems} problems, {fit.solved} solved "
            f"({fit.clear} of these with a clear NGR)"
        )

    def recipe_part(self) -> str:
        """The parameters as the search of a recipe, YAML."""
        values = [f"  {name}: {_rounded(self._value(name))}" for name in PARAMETERS]
        head = (f"# {self.command}", f"# {self.words}", "search:", "  name: best_first")
        return "\n".join((*head, *values)) + "\n"

    def document(self) -> dict[str, Any]:
        """Everything as plain data."""
        return {
            "made_with": self.command,
            "search": {"name": "best_first"}
            | {name: _rounded(self._value(name)) for name in PARAMETERS},
            "confidence": CONFIDENCE,
            "fit": asdict(self.fit),
            "cut": self.cut,
            "problems_left_out": self.left_out,
            "ranked_right": self._ranked(),
        }

    def rows(self) -> list[list[str]]:
        """Name, value, interval and the default of every parameter."""
        default = BestFirstOptions()
        return [
            [name, *self._words_of(name), f"{getattr(default, name):.6g}"] for name in PARAMETERS
        ] + [["solvable", *self._words_of("solvable"), ""]]

    def remarks(self) -> list[str]:
        """What belongs below the table."""
        lines = [self.command, self.words]
        if self.cut:
            lines.append(f"{self.cut} searches were cut short by --budget, not by their work")
        if self.left_out:
            lines.append(f"{self.left_out} problems could not be generated")
        ranked = self._ranked()
        if ranked["pairs"]:
            shares = ", ".join(f"{k} {v:.3f}" for k, v in ranked.items() if k != "pairs")
            lines.append(f"solved before unsolved, of {ranked['pairs']} pairs: {shares}")
        return lines

    def _ranked(self) -> Mapping[str, Any]:
        default = BestFirstOptions()
        current = PriorityModel(*(getattr(default, name) for name in PARAMETERS))
        scores: dict[str, Callable[[Features], float]] = {
            "survival": partial(log_survival, self.fit.model),
            "density": partial(log_density, self.fit.model),
            "survival_with_defaults": partial(log_survival, current),
        }
        found = {name: ranked_right(self.points, score) for name, score in scores.items()}
        pairs = max(pairs for _, pairs in found.values())
        return {name: share for name, (share, _) in found.items()} | {"pairs": pairs}

    def _value(self, name: str) -> float:
        return float(getattr(self.fit, name).value)

    def _words_of(self, name: str) -> list[str]:
        estimate = getattr(self.fit, name)
        return [f"{estimate.value:.6g}", f"{estimate.low:.4g} to {estimate.high:.4g}"]


def report_of(command: str, data: Data, fit: Fit, points: Sequence[Point]) -> Report:
    """A report on the points that were fitted to."""
    problems = {point.problem for point in points}
    explored = data.explored.values()
    cut = sum(point.cut for point in points)
    cut += sum(item.cut for item in explored if item.problem in problems)
    return Report(command, fit, points, cut, sum(bool(item.left_out) for item in explored))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
