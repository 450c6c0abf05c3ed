"""``mamo learn-priority``: gather data, fit the priority of E-M4M, write its parameters."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from mamo_core.errors import InputError, suggestion
from mamo_planners.learning.data import Data, Settings, open_data
from mamo_planners.learning.fit import CONFIDENCE, fit
from mamo_planners.learning.gather import gather
from mamo_planners.learning.report import Report, report_of

if TYPE_CHECKING:
    from mamo_core.cli.workbench import Workbench

NAME = "learn-priority"
DEFAULT_FOLDER = Path("out")

Problems = Annotated[int, typer.Option(metavar="N", min=1, help="Problems to generate.")]
Movables = Annotated[str, typer.Option(metavar="N,...", help="Numbers of movables, in turn.")]
Levels = Annotated[str, typer.Option(metavar="LEVEL,...", help="Levels of the problems, in turn.")]
Seed = Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the first problem.")]
Expansions = Annotated[
    int, typer.Option(metavar="N", min=1, help="MAPF calls at one rearrangement, breadth first.")
]
Visits = Annotated[
    int,
    typer.Option(metavar="N", min=1, help="Rearrangements visited in a problem, breadth first."),
]
Attempt = Annotated[
    int, typer.Option(metavar="N", min=1, help="Visits to solve a rearrangement, depth first.")
]
Budget = Annotated[
    float, typer.Option(metavar="S", min=0.0, help="CPU seconds at which any search is stopped.")
]
DataFile = Annotated[
    Path | None,
    typer.Option("--data", metavar="FILE", help="JSON lines (default: out/priority.jsonl)."),
]
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="Write the parameters here, YAML."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of a table.")]


def command_of(bench: Workbench) -> Callable[..., None]:
    """The function that typer makes a command of."""

    def learn_priority(
        problems: Problems = 20,
        movables: Movables = "5,10,15",
        levels: Levels = "easy,medium,hard",
        seed: Seed = 0,
        expansions: Expansions = 12,
        visits: Visits = 40,
        attempt: Attempt = 8,
        budget: Budget = 60.0,
        data: DataFile = None,
        output: Output = None,
        json: Json = False,
    ) -> None:
        """Gather rearrangements of generated shelves and fit the priority of E-M4M to them.

        Each problem is searched breadth first; every rearrangement found is tried depth first.
        The same command goes on after an interruption.
        """
        settings = Settings(
            seed,
            numbers(movables, "--movables"),
            names(levels, "--levels", bench.levels),
            expansions,
            visits,
            attempt,
            _limit(budget),
        )
        file = data if data is not None else _default_file()
        for path in (file, output):
            if path is not None:
                bench.check_writable(path)
        with open_data(file, settings) as gathered:
            report = _learn(bench, settings, problems, gathered)
        _tell(bench, report, output, as_json=json)

    return learn_priority


def numbers(text: str, option: str) -> tuple[int, ...]:
    """Numbers with commas between them.

    Raises:
        InputError: something else.
    """
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdecimal() for word in words):
        raise InputError(f"{option} {text!r}: expected numbers, for example 5,10,15")
    return tuple(int(word) for word in words)


def names(text: str, option: str, valid: tuple[str, ...]) -> tuple[str, ...]:
    """Names with commas between them.

    Raises:
        InputError: one is not valid.
    """
    words = tuple(word.strip() for word in text.split(","))
    for word in words:
        if word not in valid:
            raise InputError(f"{option} {text!r}: unknown {word!r}{suggestion(word, valid)}")
    return words


def _default_file() -> Path:
    DEFAULT_FOLDER.mkdir(exist_ok=True)
    return DEFAULT_FOLDER / "priority.jsonl"


def _limit(budget: float) -> float:
    if not 0.0 < budget < float("inf"):  # also refuses NaN
        raise InputError(f"--budget {budget}: expected seconds, more than 0")
    return budget


def _learn(bench: Workbench, settings: Settings, problems: int, data: Data) -> Report:
    with bench.progress() as tell:
        wanted = range(settings.seed, settings.seed + problems)
        if not all(data.complete(problem) for problem in wanted):
            tell("loading kernels (the first time they are compiled: about half a minute)")
            bench.load_kernels()
            gather(bench, settings, problems, data, tell)
        points = [data.points[key] for key in sorted(data.points) if key[0] in wanted]
        tell(f"fitting to {len(points)} rearrangements")
        fitted = fit(points, np.random.default_rng(settings.seed))
    return report_of(_command(settings, problems), data, fitted, points)


def _command(settings: Settings, problems: int) -> str:
    """The command line that gathers the same."""
    options = {
        "problems": problems,
        "movables": ",".join(map(str, settings.movables)),
        "levels": ",".join(settings.levels),
        "seed": settings.seed,
        "expansions": settings.expansions,
        "visits": settings.visits,
        "attempt": settings.attempt,
        "budget": f"{settings.budget:g}",
    }
    return " ".join(["mamo", NAME, *(f"--{name} {value}" for name, value in options.items())])


def _tell(bench: Workbench, report: Report, output: Path | None, *, as_json: bool) -> None:
    if output is not None:
        bench.write_text(output, report.recipe_part())
    if as_json:
        bench.print_json(NAME, report.document())
        return
    columns = ("parameter", "fitted", f"{CONFIDENCE:.0%} interval", "default")
    bench.print_table("learned priority", columns, report.rows())
    for line in report.remarks():
        typer.echo(line)
    if output is not None:
        typer.echo(f"written to {output}")
