"""A recording as one HTML file that needs neither a server nor a network."""

from __future__ import annotations

from html import escape
from pathlib import Path

from mamo_core.robots.model import ArmModel
from mamo_core.types.recording import Recording
from mamo_core.view.browser.panel import panel_html
from mamo_core.view.browser.serving import local_server
from mamo_core.view.browser.stage import set_stage

FRAMES = 25
"""Pictures a second."""

_END = 2.0
"""How long the last picture stays before the replay begins again, s."""

_STYLE = (
    "position:fixed;top:0.8em;right:0.8em;width:22em;max-height:80vh;overflow:auto;z-index:10;"
    "padding:0.5em;border-radius:4px;background:rgba(255,255,255,0.88);"
    "font:14px/1.5 system-ui,sans-serif;color:#222"
)


def write_html(recording: Recording, robot: ArmModel, path: str | Path) -> None:
    """Write the replay with a time bar.

    Raises:
        PluginError: viser is not installed.
    """
    with local_server() as server:
        show = set_stage(server, recording, robot)
        player = server.get_scene_serializer()
        for row in rows(recording):
            show(row)
            player.insert_sleep(1.0 / FRAMES)
        player.insert_sleep(_END)
        text = player.as_html()
    Path(path).write_text(_with_panel(text, recording), encoding="utf-8")


def rows(recording: Recording) -> list[int]:
    """The rows of the recording that are shown, one for each picture, and the last one."""
    last = len(recording.times) - 1
    step = float(recording.times[1] - recording.times[0]) if last else 1.0
    stride = max(round(1.0 / (FRAMES * step)), 1)
    return [*range(0, last, stride), last]


def _with_panel(text: str, recording: Recording) -> str:
    """The page with a title and our panel, which folds away, over it."""
    name = escape(recording.problem.name)
    text = text.replace("<title>Viser</title>", f"<title>{name}</title>")
    head = f"<summary><b>{name}</b></summary>"
    panel = f'<details open style="{_STYLE}">{head}{panel_html(recording)}</details>'
    end = text.rindex("</body>")
    return f"{text[:end]}{panel}{text[end:]}"
