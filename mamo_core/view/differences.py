"""How far engines bring the same object apart, over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.recording import Recording

SHOWN = 1.0
"""Objects that are never farther apart than this are left out, mm."""

_LEAST = 0.1
"""Where the scale begins, mm: engines that agree agree to less."""


def differences(recording: Recording) -> Mapping[str, Mapping[str, Array]]:
    """Distances (t,), mm, of objects to where the first engine has them, by other engine and
    name, of those that are more than 1 mm apart at any time."""
    first, *others = recording.executions
    return {
        other.engine: {
            item.name: apart[:, i]
            for i, item in enumerate(recording.problem.scene.objects)
            if apart[:, i].max() > SHOWN
        }
        for other in others
        for apart in [1000.0 * np.linalg.norm(other.poses[..., :3] - first.poses[..., :3], axis=2)]
    }


def draw_differences(axes: Any, recording: Recording, colors: Mapping[str, str]) -> None:
    """Plot ``differences``, a colour per engine, each line named at its end."""
    times = recording.times
    axes.set_yscale("log")
    axes.set_xlim(times[0], times[-1])
    for engine, tracks in differences(recording).items():
        for name, track in tracks.items():
            axes.plot(times, np.maximum(track, _LEAST), color=colors[engine], lw=1.2)
            end = (times[-1], max(float(track[-1]), _LEAST))
            style = {"textcoords": "offset points", "va": "center", "fontsize": 7}
            axes.annotate(name, end, (3, 0), color=colors[engine], **style)
    if not axes.lines:
        axes.text(
            0.5, 0.5, "nothing is more than 1 mm apart", ha="center", transform=axes.transAxes
        )
    axes.set_ylim(bottom=_LEAST)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("time (s)", fontsize=8)
    axes.set_ylabel(f"from {recording.executions[0].engine} (mm)", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3)
