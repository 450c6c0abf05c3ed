"""Recordings as files: NumPy arrays beside one JSON text, read without any engine."""

from __future__ import annotations

import json
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.atomic import atomic_path
from mamo_core.errors import InputError
from mamo_core.plan_file import PlanDocument, plan_text, read_plan_text
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.rollout import Violation

SCHEMA_VERSION = 1
SUFFIX = ".npz"
_TRACKS = ("joints", "openings", "poses", "contacts")


def write_recording(path: str | Path, recording: Recording) -> None:
    """An ``.npz`` file: ``times``, ``segments``, by engine ``poses/NAME``, ``joints/NAME``,
    ``openings/NAME`` and ``contacts/NAME``, and all the rest as JSON in ``document``.

    Raises:
        InputError: its folder is missing or cannot be written.
    """
    arrays: dict[str, Any] = {"times": recording.times, "segments": recording.segments}
    for execution in recording.executions:
        for track in _TRACKS:
            arrays[f"{track}/{execution.engine}"] = getattr(execution, track)
    arrays["document"] = np.array(json.dumps(_document(recording)))
    with atomic_path(path) as work, work.open("wb") as file:
        np.savez_compressed(file, **arrays)


def read_recording(path: str | Path) -> Recording:
    """What ``write_recording`` wrote.

    Raises:
        InputError: missing, damaged, or not a recording.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            document = json.loads(str(arrays["document"]))
            plan = read_plan_text(document["plan"], str(path))
            return Recording(
                plan.problem,
                plan.plan,
                arrays["times"],
                arrays["segments"],
                tuple(_execution(row, arrays) for row in document["executions"]),
            )
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not a recording of 'mamo view' ({error})") from None


def _document(recording: Recording) -> dict[str, Any]:
    plan = PlanDocument(recording.problem, recording.plan, recipe={}, seed=0)
    rows = [
        {
            "engine": execution.engine,
            "violations": [asdict(violation) for violation in execution.violations],
            "failures": list(execution.failures),
        }
        for execution in recording.executions
    ]
    return {"schema_version": SCHEMA_VERSION, "plan": plan_text(plan), "executions": rows}


def _execution(row: dict[str, Any], arrays: Any) -> RecordedExecution:
    name = row["engine"]
    return RecordedExecution(
        engine=name,
        **{track: arrays[f"{track}/{name}"] for track in _TRACKS},
        violations=tuple(Violation(**violation) for violation in row["violations"]),
        failures=tuple(row["failures"]),
    )
