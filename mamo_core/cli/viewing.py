"""The work behind ``mamo view``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mamo_core.atomic import atomic_path
from mamo_core.choices import choose
from mamo_core.cli.output import print_json, progress, warn_of_broken_plugins
from mamo_core.cli.verifying import recipe_of
from mamo_core.cli.view_order import FILMS, RECORDING, ViewOrder, check_order, pixels
from mamo_core.compose import build_parts
from mamo_core.errors import InputError
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.plan_file import read_plan
from mamo_core.plugins import discover
from mamo_core.recording import read_recording, record, write_recording
from mamo_core.robots import load_arm
from mamo_core.types.recording import Recording
from mamo_core.view.renderers import renderer_for
from mamo_core.view.swept import with_region

if TYPE_CHECKING:
    from mamo_core.interfaces.transition_model import TransitionModel
    from mamo_core.plan_file import PlanDocument
    from mamo_core.robots.model import ArmModel


def run_view(order: ViewOrder, *, as_json: bool) -> int:
    """Record, or read a recording, and write every view of it; the exit code."""
    check_order(order, as_json=as_json)
    with progress() as tell:
        recording = _with_region(_recording(order, tell))
        for kind, path in order.files.items():
            tell(f"writing {path}")
            _write(kind, path, recording, order)
    _print(order, recording, as_json=as_json)
    if order.live:
        _serve(order, recording)
    return 0


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


def _with_region(recording: Recording) -> Recording:
    """A recording of a plan from a file, which does not say what its last motion sweeps."""
    robot = load_arm(recording.problem.scene.robot)
    return replace(recording, plan=with_region(recording.problem, recording.plan, robot))


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
        if kind in FILMS:
            _film(kind, work, recording, order)
        elif kind == "html":
            _write_html(work, recording)
        else:
            _draw(work, recording)


def _write_html(path: Path, recording: Recording) -> None:
    from mamo_core.view.browser.page import write_html

    write_html(recording, load_arm(recording.problem.scene.robot), path)


def _serve(order: ViewOrder, recording: Recording) -> None:
    from mamo_core.view.browser.live import PORT, serve

    def tell(text: str) -> None:
        print(text, flush=True)

    robot = load_arm(recording.problem.scene.robot)
    serve(recording, robot, PORT if order.port is None else order.port, tell)


def _draw(path: Path, recording: Recording) -> None:
    from mamo_core.view.engines import draw_engines
    from mamo_core.view.topdown import draw_recording

    if len(recording.executions) == 1:
        draw_recording(recording, path)
        return
    draw_engines(recording, path)


def _film(kind: str, path: Path, recording: Recording, order: ViewOrder) -> None:
    from mamo_core.view.replay import GIF, MP4, STILL, Film, write_gif, write_mp4, write_still

    writers = {"still": (write_still, STILL), "mp4": (write_mp4, MP4), "gif": (write_gif, GIF)}
    write, usual = writers[kind]
    width, height = (usual.width, usual.height) if order.size is None else pixels(order.size)
    film = Film(order.fps or usual.fps, width, height, order.speed)
    write(path, recording, renderer_for(recording.problem, discover(), order.renderer), film)


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
