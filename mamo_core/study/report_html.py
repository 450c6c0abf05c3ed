"""A report as one HTML file that needs no other."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from mamo_core.study.plots import curve_plot, scatter_plot, share_plot
from mamo_core.study.tables import Table, notes, report_tables

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; font-size: 13px; display: block; overflow-x: auto }
th, td { padding: .2rem .6rem; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }
th { background: #f4f4f4 }
svg { max-width: 100%; height: auto }
a { text-decoration: none } a:hover { text-decoration: underline }
.plots { display: flex; flex-wrap: wrap; gap: 1rem } .plots svg { width: 23rem }
.good { color: #1a7f37 } .bad { color: #b35900 }
"""


def html_report(data: Mapping[str, Any], problems: str = "") -> str:
    """Tables, notes and plots; ``problems``: HTML of a table of all problems, if there is one."""
    title = escape(f"Study {data['study']}")
    body = [f"<h1>{title}</h1>"]
    body += [f"<p>{escape(words)}</p>" for words in notes(data)]
    if data["curves"]:
        body += ["<h2>Success over CPU time</h2>", curve_plot(data)]
    if data["comparisons"]:
        body += ["<h2>Problem by problem</h2>", _pairs(data)]
    if any(line["parts"] for line in data["shares"]):
        body += ["<h2>Where the CPU time went</h2>", share_plot(data)]
    body += [_table(table) for table in report_tables(data)]
    body += [problems] if problems else []
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style></head>\n<body>\n" + "\n".join(body) + "\n</body></html>\n"
    )


def _pairs(data: Mapping[str, Any]) -> str:
    """The plots of all comparisons beside each other."""
    plots = (scatter_plot(comparison, data["budget_s"]) for comparison in data["comparisons"])
    return f'<div class="plots">\n{"".join(plots)}</div>'


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.header)
    lines = "\n".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows
    )
    return f"<h2>{escape(table.title)}</h2>\n<table><tr>{head}</tr>\n{lines}</table>"
