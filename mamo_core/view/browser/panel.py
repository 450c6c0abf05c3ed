"""What stands beside the scene, as HTML: what colours mean, what failed, how engines differ."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from html import escape

from mamo_core.types.recording import Recording
from mamo_core.view.browser.moving import WRONG
from mamo_core.view.differences import draw_differences
from mamo_core.view.engines import engine_colors
from mamo_core.view.topdown import COLORS, PATH, REGION, last_part

_STYLE = "padding:0.3em 0.6em;font:13px/1.5 system-ui,sans-serif;color:#222"
_ROW = (
    '<div><span style="display:inline-block;width:0.9em;height:0.9em;margin-right:0.5em;'
    'vertical-align:-0.1em;background:{color}"></span>{text}</div>'
)


def panel_html(recording: Recording) -> str:
    """Verdicts, legend and, for several engines, a plot; complete elements without a page."""
    rows = "".join(
        _ROW.format(color=color, text=escape(text)) for color, text in _legend(recording)
    )
    return f'<div style="{_STYLE}">{_verdicts(recording)}{rows}{_plot(recording)}</div>'


def _verdicts(recording: Recording) -> str:
    parts = []
    for execution in recording.executions:
        engine = escape(execution.engine)
        if not execution.failures:
            parts.append(f"<div>holds in {engine}</div>")
            continue
        texts = "".join(f"<li>{escape(text)}</li>" for text in execution.failures)
        items = f'<ul style="margin:0;padding-left:1.4em">{texts}</ul>'
        parts.append(f'<div style="color:{WRONG}">fails in {engine}:{items}</div>')
    return "".join(parts)


def _legend(recording: Recording) -> Iterator[tuple[str, str]]:
    present = {item.mobility for item in recording.problem.scene.objects}
    for mobility, color in COLORS.items():
        if mobility in present:
            yield color, str(mobility)
    if recording.plan.region is not None:
        yield REGION, f"swept by the {last_part(recording.problem)} (NGR)"
    if recording.plan.actions:
        yield PATH, "intended path"
    for engine, color in list(engine_colors(recording).items())[1:]:
        yield color, f"{engine}, if over 1 mm away"
    if any(execution.violations for execution in recording.executions):
        yield WRONG, "violation"


def _plot(recording: Recording) -> str:
    """The differences over time as an image in the text, if there is something to compare."""
    if len(recording.executions) == 1:
        return ""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 2.6), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    draw_differences(figure.subplots(), recording, engine_colors(recording))
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    data = base64.b64encode(picture.getvalue()).decode("ascii")
    return f'<img alt="distances over time" style="width:100%" src="data:image/png;base64,{data}">'
