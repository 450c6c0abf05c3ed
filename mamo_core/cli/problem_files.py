"""The work behind ``mamo problem import`` and ``mamo problem show``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from mamo_core.atomic import atomic_path, check_writable
from mamo_core.cli.output import print_json, print_table, warn
from mamo_core.errors import InputError
from mamo_core.problems import import_file, load_problem, save_problems
from mamo_core.problems.documents import problem_document
from mamo_core.types.geometry import Box, Shape
from mamo_core.types.problem import Problem

SETS = (".jsonl", ".jsonl.gz")
DOCUMENTS = (".json", ".yaml", ".yml")


def check_output(path: Path, count: int = 1) -> None:
    """Find out early that so many problems cannot be written to ``path``."""
    check_writable(path)
    if not path.name.endswith((*SETS, *DOCUMENTS)):
        raise InputError(f"{path}: unknown ending (valid: {', '.join((*SETS, *DOCUMENTS))})")
    if count > 1 and not path.name.endswith(SETS):
        raise InputError(f"{path}: {count} problems need a file that ends in {' or '.join(SETS)}")


def run_import(source: Path, output: Path) -> None:
    """Convert a file of problems."""
    check_output(output)
    problems, changes = import_file(source)
    check_output(output, len(problems))
    for change in changes:
        warn(change)
    write_problems(problems, output)


def write_problems(problems: list[Problem], output: Path) -> None:
    """Save problems and say so."""
    with atomic_path(output) as work:
        save_problems(problems, work)
    noun = "problem" if len(problems) == 1 else "problems"
    sys.stdout.write(f"{output}: {len(problems)} {noun}\n")


def run_show(reference: str, png: Path | None, *, as_json: bool) -> None:
    """Print, and perhaps draw, a problem."""
    if png is not None:
        check_writable(png)
    problem = load_problem(reference)
    if png is not None:
        from mamo_core.view.topdown import draw

        with atomic_path(png) as work:
            draw(problem, path=work)
    if as_json:
        print_json("problem show", {"problem": problem_document(problem)})
        return
    columns = ("object", "mobility", "shape", "x, y, z (m)", "mass (kg)", "friction")
    print_table(f"{problem.name} ({problem.scene.robot})", columns, _rows(problem))


def _rows(problem: Problem) -> Iterator[list[str]]:
    for item, pose in zip(problem.scene.objects, problem.initial.object_poses, strict=True):
        position = ", ".join(f"{value:.3f}" for value in pose[:3])
        numbers = [f"{item.mass:.3f}", f"{item.friction:.3f}"]
        yield [item.name, str(item.mobility), _shape_words(item.shape), position, *numbers]


def _shape_words(shape: Shape) -> str:
    if isinstance(shape, Box):
        return "box " + " x ".join(f"{size:.3f}" for size in shape.size)
    return f"cylinder r {shape.radius:.3f}, h {shape.height:.3f}"
