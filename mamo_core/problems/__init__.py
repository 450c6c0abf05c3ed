"""Problems: files of our own and of the thesis, default grasps, the scene generators."""

from mamo_core.problems.documents import problem_document, problem_from_document
from mamo_core.problems.files import import_file, load_problem, problem_ids, save_problems
from mamo_core.problems.generator import LEVELS, generate_shelf
from mamo_core.problems.grasps import default_grasps
from mamo_core.problems.schema import problem_schema
from mamo_core.problems.workspaces import generate_workspace

__all__ = [
    "LEVELS",
    "default_grasps",
    "generate_shelf",
    "generate_workspace",
    "import_file",
    "load_problem",
    "problem_document",
    "problem_from_document",
    "problem_ids",
    "problem_schema",
    "save_problems",
]
