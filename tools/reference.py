"""Writes the pages of docs/reference from the code.

``make reference`` runs it; a test compares what it would write with what stands there.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from reference_pages.files import files_page
from reference_pages.hooks import hooks_page
from reference_pages.interfaces import interfaces_page
from reference_pages.options import options_page

PAGES = {
    "options.md": options_page,
    "files.md": files_page,
    "hooks.md": hooks_page,
    "interfaces.md": interfaces_page,
}
FOLDER = Path(__file__).parents[1] / "docs" / "reference"


def write_pages(folder: Path) -> None:
    """Write every page into an existing folder."""
    for name, page in PAGES.items():
        (folder / name).write_text(page(), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description="Write the generated pages of the documentation.")
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, metavar="FOLDER")
    write_pages(parser.parse_args().output)


if __name__ == "__main__":
    main()
