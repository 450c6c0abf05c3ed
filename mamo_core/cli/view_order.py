"""What ``mamo view`` is asked for, and whether that can be done."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mamo_core.atomic import check_writable
from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.view.renderers import DEFAULT, ROLE

RECORDING = ".npz"
FILMS = {"still", "mp4", "gif"}
"""Kinds of output that a renderer draws."""
_SMALLEST, _LARGEST = 64, 4096
"""Pixels a picture may be wide or high."""


@dataclass(frozen=True)
class ViewOrder:
    """The arguments of ``mamo view``."""

    subject: str
    backends: tuple[str, ...] | None = None
    output: Path | None = None
    png: Path | None = None
    html: Path | None = None
    live: bool = False
    port: int | None = None
    still: Path | None = None
    mp4: Path | None = None
    gif: Path | None = None
    fps: float | None = None
    speed: float = 1.0
    size: str | None = None
    renderer: str = DEFAULT

    @property
    def files(self) -> Mapping[str, Path]:
        """What is to be written, by kind."""
        wanted = {
            "recording": self.output,
            "png": self.png,
            "html": self.html,
            "still": self.still,
            "mp4": self.mp4,
            "gif": self.gif,
        }
        return {kind: path for kind, path in wanted.items() if path is not None}


def check_order(order: ViewOrder, *, as_json: bool) -> None:
    """Complain before anything slow.

    Raises:
        InputError: options that do not go together, or a file that cannot be written.
    """
    if not order.files and not order.live:
        kinds = "--png, --still, --mp4, --gif, --html, --live, -o"
        raise InputError(f"nothing to show: give one or more of {kinds}")
    if order.port is not None and not order.live:
        raise InputError(f"--port {order.port}: only --live serves; give it, too")
    if order.live and as_json:
        raise InputError("--json: --live ends when interrupted, without a result; give one of them")
    if order.subject.endswith(RECORDING) and order.backends is not None:
        raise InputError("--backends: a recording is shown as it is; give the plan instead")
    if order.backends is not None and len(set(order.backends)) < len(order.backends):
        raise InputError(f"--backends {','.join(order.backends)}: expected different engines")
    if FILMS & order.files.keys():
        discover().component(ROLE, order.renderer, "--renderer")
    if order.size is not None:
        width, height = pixels(order.size)
        if order.mp4 is not None and (width % 2 or height % 2):
            raise InputError(f"--size {order.size}: expected even numbers for --mp4")
    for path in order.files.values():
        check_writable(path)


def pixels(size: str) -> tuple[int, int]:
    """Width and height of ``WxH``.

    Raises:
        InputError: it is something else, or too small or large.
    """
    found = re.fullmatch(r"(\d{2,4})x(\d{2,4})", size)
    width, height = (int(part) for part in found.groups()) if found else (0, 0)
    if not (min(width, height) >= _SMALLEST and max(width, height) <= _LARGEST):
        raise InputError(
            f"--size {size}: expected WIDTHxHEIGHT in pixels, each {_SMALLEST} to {_LARGEST}"
        )
    return width, height
