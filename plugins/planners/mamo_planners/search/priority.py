"""The learned priority of E-M4M (thesis 5.5.3), and one without its flaw."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.stats import beta, expon

from mamo_planners.search.features import Features

LEAST_SHARE = 1e-4
"""Densities are infinite where nothing is occupied; a share below this counts as this."""


@dataclass(frozen=True)
class PriorityModel:
    """Naive Bayes: ``alpha``, ``beta`` of the occupied share; rates of the other features.

    The prior is the same for all and left out.
    """

    alpha: float
    beta: float
    count_rate: float
    effort_rate: float


def log_density(model: PriorityModel, features: Features) -> float:
    """The thesis' product of densities.

    They may exceed 1, so that one more object with a small effort RAISES it.
    """
    share = min(max(features.occupied, LEAST_SHARE), 1.0 - LEAST_SHARE)
    terms = [
        beta.logpdf(share, model.alpha, model.beta),
        expon.logpdf(features.count, scale=1.0 / model.count_rate),
        *(expon.logpdf(effort, scale=1.0 / model.effort_rate) for effort in features.efforts),
    ]
    return float(sum(terms))


def log_survival(model: PriorityModel, features: Features) -> float:
    """How likely a solvable rearrangement is at least as hard: falls with every object."""
    share = min(features.occupied, 1.0 - LEAST_SHARE)
    terms = [
        beta.logsf(share, model.alpha, model.beta),
        -model.count_rate * features.count,
        *(-model.effort_rate * effort for effort in features.efforts),
    ]
    return float(sum(terms))
