"""SVG as text: elements and attributes, escaped."""

from __future__ import annotations

from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

Attribute = str | float | None
"""None leaves it away."""
Style = dict[str, Attribute]


def element(name: str, *inside: str, **attributes: Attribute) -> str:
    """``<name ...>inside</name>``; what is ``inside`` is written as it is: see ``text_of``.

    In the names of attributes ``_`` stands for ``-``; numbers are rounded to 0.01.
    """
    words = "".join(
        f" {key.rstrip('_').replace('_', '-')}={quoteattr(_value(value))}"
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{words}>{''.join(inside)}</{name}>" if inside else f"<{name}{words}/>"


def text_of(words: str) -> str:
    """Words as the content of an element."""
    return escape(words)


def label(x: float, y: float, words: str, **attributes: Attribute) -> str:
    """A line of text with its baseline at (x, y)."""
    return element("text", text_of(words), x=x, y=y, **attributes)


def document(width: float, height: float, parts: Iterable[str]) -> str:
    """A whole file on white ground."""
    ground = element("rect", width="100%", height="100%", fill="white")
    return element(
        "svg",
        ground,
        *parts,
        xmlns="http://www.w3.org/2000/svg",
        width=width,
        height=height,
        viewBox=f"0 0 {_value(width)} {_value(height)}",
        font_family="sans-serif",
        font_size=12,
    )


def _value(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.2f}".rstrip("0").rstrip(".")
