"""Why there is no plan, in words: from a problem and what a search counted."""

from mamo_core.explain.details import details_of
from mamo_core.explain.explanation import Detail, Explanation, Obstruction
from mamo_core.explain.ranking import explain

__all__ = ["Detail", "Explanation", "Obstruction", "details_of", "explain"]
