"""The work behind ``mamo view``."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mamo_core.atomic import atomic_path, check_writable
from mamo_core.cli.output import print_json, progress, warn_of_broken_plugins
from mamo_core.cli.verifying import recipe_of
from mamo_core.compose import build_parts, choose
from mamo_core.errors import InputError
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.plan_file import read_plan
from mamo_core.plugins import discover
from mamo_core.recording import read_recording, record, write_recording
from mamo_core.types.recording import Recording
from mamo_core.view.renderers import DEFAULT, ROLE, renderer_for

if TYPE_CHECKING:
    from mamo_core.interfaces.transition_model import TransitionModel
    from mamo_core.plan_file import PlanDocument
    from mamo_core.robots.model import ArmModel

RECORDING = ".npz"
_FILMS = {"still", "mp4", "gif"}
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
            "still": self.still,
            "mp4": self.mp4,
            "gif": self.gif,
        }
        return {kind: path for kind, path in wanted.items() if path is not None}


def run_view(order: ViewOrder, *, as_json: bool) -> int:
    """Record, or read a recording, and write every view of it; the exit code."""
    _check(order)
    with progress() as tell:
        recording = _recording(order, tell)
        for kind, path in order.files.items():
            tell(f"writing {path}")
            _write(kind, path, recording, order)
    _print(order, recording, as_json=as_json)
    return 0


def _check(order: ViewOrder) -> None:
    if not order.files:
        raise InputError("nothing to show: give one or more of --png, --still, --mp4, --gif, -o")
    if order.subject.endswith(RECORDING) and order.backends is not None:
        raise InputError("--backends: a recording is shown as it is; give the plan instead")
    if order.backends is not None and len(set(order.backends)) < len(order.backends):
        raise InputError(f"--backends {','.join(order.backends)}: expected different engines")
    if _FILMS & order.files.keys():
        discover().component(ROLE, order.renderer, "--renderer")
    if order.size is not None:
        width, height = _pixels(order.size)
        if order.mp4 is not None and (width % 2 or height % 2):
            raise InputError(f"--size {order.size}: expected even numbers for --mp4")
    for path in order.files.values():
        check_writable(path)


def _recording(order: ViewOrder, tell: ProgressCallback) -> Recording:
    if order.subject.endswith(RECORDING):
        return read_recording(order.subject)
    document = read_plan(order.subject)
    models, robot = _engines(document, order)
    tell(f"executing the plan for {document.problem.name!r} in {', '.join(models)}")
    try:
        return record(document.problem, document.plan, models, robot)
    except ValueError as error:
        raise InputError(f"{order.subject}: {error}") from None


def _engines(
    document: PlanDocument, order: ViewOrder
) -> tuple[Mapping[str, TransitionModel], ArmModel]:
    """The plan's own engine, or those of ``--backends``, and the robot."""
    registry = discover()
    warn_of_broken_plugins(registry)
    models: dict[str, TransitionModel] = {}
    for backend in order.backends or (None,):
        recipe = recipe_of(document, order.subject, backend)
        choices = choose(recipe, document.problem, registry, ("constraint", "backend"))
        context = build_parts(choices, document.problem)
        models[recipe.recipe.backend.name] = context.part("backend")
    return models, context.robot


def _write(kind: str, path: Path, recording: Recording, order: ViewOrder) -> None:
    if kind == "recording":
        write_recording(path, recording)
        return
    with atomic_path(path) as work:
        if kind in _FILMS:
            _film(kind, work, recording, order)
        else:
            _draw(work, recording)


def _draw(path: Path, recording: Recording) -> None:
    from mamo_core.view.engines import draw_engines
    from mamo_core.view.topdown import draw_recording

    if len(recording.executions) == 1:
        draw_recording(recording, path)
        return
    draw_engines(recording.problem, {e.engine: e.poses for e in recording.executions}, path)


def _film(kind: str, path: Path, recording: Recording, order: ViewOrder) -> None:
    from mamo_core.view.replay import GIF, MP4, STILL, Film, write_gif, write_mp4, write_still

    writers = {"still": (write_still, STILL), "mp4": (write_mp4, MP4), "gif": (write_gif, GIF)}
    write, usual = writers[kind]
    width, height = (usual.width, usual.height) if order.size is None else _pixels(order.size)
    film = Film(order.fps or usual.fps, width, height, order.speed)
    write(path, recording, renderer_for(recording.problem, discover(), order.renderer), film)


def _pixels(size: str) -> tuple[int, int]:
    """Width and height of ``WxH``."""
    found = re.fullmatch(r"(\d{2,4})x(\d{2,4})", size)
    width, height = (int(part) for part in found.groups()) if found else (0, 0)
    if not (min(width, height) >= _SMALLEST and max(width, height) <= _LARGEST):
        raise InputError(
            f"--size {size}: expected WIDTHxHEIGHT in pixels, each {_SMALLEST} to {_LARGEST}"
        )
    return width, height


def _print(order: ViewOrder, recording: Recording, *, as_json: bool) -> None:
    failures = {e.engine: list(e.failures) for e in recording.executions}
    files = {kind: str(path) for kind, path in order.files.items()}
    if as_json:
        seconds = float(recording.times[-1])
        data = {"problem": recording.problem.name, "seconds": seconds, "failures": failures}
        print_json("view", {**data, "files": files})
        return
    for engine, texts in failures.items():
        verdict = "holds" if not texts else f"FAILS: {'; '.join(texts)}"
        sys.stdout.write(f"{recording.problem.name} in {engine}: {verdict}\n")
    for kind, file in files.items():
        sys.stdout.write(f"  {kind}: {file}\n")
