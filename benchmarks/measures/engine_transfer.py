"""Plans of one recipe, executed in several engines."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from statistics import median
from typing import Any

from mamo_core.compose import compose
from mamo_core.plugins import Registry
from mamo_core.recipes import LoadedRecipe
from mamo_core.study.problems import Picked
from mamo_core.verify import verify
from measures.engine_pushes import engine_models

Row = dict[str, Any]


def transfer_row(
    entry: Picked,
    recipe: LoadedRecipe,
    registry: Registry,
    engines: Sequence[str],
    budget: float,
    seed: int,
) -> Row:
    """Plan a problem, then replay the plan from its start in every engine."""
    started = time.process_time()
    problem, _ = entry.load()
    planner = compose(recipe, problem, registry)
    solution = planner.solve(budget - (time.process_time() - started), seed)
    row: Row = {
        "set": entry.set_name,
        "id": entry.id,
        "status": str(solution.status),
        "cpu_s": time.process_time() - started + solution.statistics.outside_cpu,
        "actions": len(solution.plan.actions) if solution.plan is not None else 0,
        "causes": {k: int(n) for k, n in solution.statistics.causes.most_common(8)},
        "engines": {},
    }
    if solution.plan is None:
        return row
    for name, model in engine_models(planner.context, engines).items():
        report = verify(problem, solution.plan, model, planner.context.robot)
        row["engines"][name] = {
            "valid": report.ok,
            "kinds": list(report.kinds),
            "failures": list(report.failures[:3]),
        }
    return row


def line_of(row: Row) -> str:
    """A row in a line."""
    marks = [
        f"{n} {'ok' if e['valid'] else '/'.join(e['kinds'])}" for n, e in row["engines"].items()
    ]
    head = f"{row['set']}#{row['id']}  {row['status']}  {row['cpu_s']:.2f} s"
    return "  ".join([head, f"{row['actions']} actions", *marks])


def transfer_table(rows: Sequence[Row], engines: Sequence[str]) -> str:
    """How many plans hold in each engine, and in all, by set; failures by kind."""
    solved = [row for row in rows if row["engines"]]
    lines = [
        f"{len(solved)} of {len(rows)} problems solved; median CPU of the solved "
        f"{median(row['cpu_s'] for row in solved):.2f} s",
        "",
        f"| set | plans | {' | '.join(engines)} | in all |",
        "|---" * (len(engines) + 3) + "|",
    ]
    sets = list(dict.fromkeys(row["set"] for row in solved))
    groups = [(name, [r for r in solved if r["set"] == name]) for name in sets]
    for name, group in [*groups, ("all", solved)]:
        valid = [sum(r["engines"][e]["valid"] for r in group) for e in engines]
        everywhere = sum(all(r["engines"][e]["valid"] for e in engines) for r in group)
        cells = [f"{n} ({100 * n / len(group):.0f} %)" for n in (*valid, everywhere)]
        lines.append(f"| {name} | {len(group)} | {' | '.join(cells)} |")
    kinds = {e: Counter(k for r in solved for k in r["engines"][e]["kinds"]) for e in engines}
    names = sorted({k for counter in kinds.values() for k in counter})
    lines += [
        "",
        f"| failures by kind | {' | '.join(engines)} |",
        "|---" * (len(engines) + 1) + "|",
    ]
    lines += [f"| {k} | {' | '.join(str(kinds[e][k]) for e in engines)} |" for k in names]
    return "\n".join(lines)
