"""A recording on a server of this machine, until interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NoReturn

from mamo_core.robots.model import ArmModel
from mamo_core.types.recording import Recording
from mamo_core.view.browser.moving import row_at
from mamo_core.view.browser.panel import panel_html
from mamo_core.view.browser.serving import LOOPBACK, local_server
from mamo_core.view.browser.stage import set_stage

PORT = 8080
"""Where to serve unless told otherwise."""

_PAUSE = 0.04
"""Between two pictures, s."""


def serve(
    recording: Recording, robot: ArmModel, port: int, tell: Callable[[str], None]
) -> NoReturn:
    """Show the recording with a time slider and a switch to play; ``tell`` is given the address.

    Raises:
        PluginError: viser is not installed.
        InputError: the port is in use.
    """
    with local_server(port) as server:
        show = set_stage(server, recording, robot)
        server.gui.set_panel_label(recording.problem.name)
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        end = float(recording.times[-1])
        playing = server.gui.add_checkbox("play", True)
        slider = server.gui.add_slider("time (s)", 0.0, end, 0.01, 0.0)
        server.gui.add_html(panel_html(recording))
        tell(f"http://{LOOPBACK}:{server.get_port()} shows the plan; Ctrl-C ends")
        shown = 0.0
        while True:
            time.sleep(_PAUSE)
            if playing.value:
                slider.value = 0.0 if slider.value >= end else min(slider.value + _PAUSE, end)
            if slider.value != shown:
                shown = slider.value
                show(row_at(recording, shown))
