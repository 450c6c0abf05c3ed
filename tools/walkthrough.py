"""How a plan comes about: plans one problem, draws every step, and prints its numbers.

``make pictures-docs`` writes the pictures of docs/how_a_plan_comes_about.md.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from walkthrough_parts.measures import told
from walkthrough_parts.pictures import draw_all
from walkthrough_parts.walk import walk

from mamo_core.problems import load_problem

ROOT = Path(__file__).parents[1]
PROBLEM = ROOT / "problems" / "shelf_12_hard_seed2.yaml"
FOLDER = ROOT / "docs" / "images"


def main() -> None:
    parser = argparse.ArgumentParser(description="Show how a plan comes about.")
    parser.add_argument("problem", nargs="?", default=str(PROBLEM), help="problem file")
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, metavar="FOLDER")
    arguments = parser.parse_args()
    way = walk(load_problem(arguments.problem))
    draw_all(way, arguments.output)
    print(told(way))


if __name__ == "__main__":
    main()
