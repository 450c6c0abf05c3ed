"""A report as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mamo_core.study.tables import markdown, notes, report_tables


def markdown_report(data: Mapping[str, Any]) -> str:
    """All tables and notes."""
    blocks = [f"# Study {data['study']}"]
    for table in report_tables(data):
        blocks.append(f"## {table.title}")
        blocks.append(markdown(table.header, table.rows))
    return "\n\n".join([*blocks, *notes(data)]) + "\n"
