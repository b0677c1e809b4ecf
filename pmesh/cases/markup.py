"""Pieces of HTML: tables, pictures and small lines, all inside the page."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = Sequence[str]


def table(names: Row, rows: Sequence[Row], *, numbers: Iterable[int]) -> str:
    """A table that becomes a card per row on a narrow screen; cells are HTML."""
    right = set(numbers)
    kinds = [' class="number"' if i in right else "" for i in range(len(names))]
    head = "".join(f'<th scope="col"{k}>{n}</th>' for n, k in zip(names, kinds, strict=True))
    body = []
    for row in rows:
        cells = [f'<th scope="row">{row[0]}</th>']
        for name, cell, kind in zip(names[1:], row[1:], kinds[1:], strict=True):
            cells.append(f'<td data-name="{name}"{kind}>{cell}</td>')
        body.append(f"<tr>{''.join(cells)}</tr>")
    lines = "\n".join(body)
    return (
        f'<div class="wide"><table class="cards"><thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{lines}\n</tbody></table></div>"
    )


def drawn(figure: Figure, text: str) -> str:
    """A figure as a picture in the page, with its caption."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=160)
    return image(stream.getvalue(), "png", text)


def image(content: bytes, kind: str, text: str) -> str:
    """A picture in the page, with its caption."""
    data, words = base64.b64encode(content).decode(), escape(text, quote=True)
    return (
        f'<figure><img src="data:image/{kind};base64,{data}" alt="{words}">'
        f"<figcaption>{words}</figcaption></figure>"
    )


def spark(time: Any, values: Any) -> str:
    """A small line of a column over time."""
    shown = np.isfinite(values)
    x, y = np.asarray(time)[shown], np.asarray(values)[shown]
    if x.size < 2 or x[-1] <= x[0]:
        return ""
    low, high = np.quantile(y, [0.01, 0.99])
    even = np.linspace(x[0], x[-1], 121)
    height = (np.interp(even, x, y) - low) / ((high - low) or 1.0)
    level = 27 - 24 * np.clip(height, -0.1, 1.1) if high > low else np.full(121, 15.0)
    points = " ".join(f"{a},{b:.1f}" for a, b in zip(range(121), level, strict=True))
    line = f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1.5"/>'
    return f'<svg viewBox="0 0 120 30" preserveAspectRatio="none" aria-hidden="true">{line}</svg>'


def span(kind: str, text: str) -> str:
    """Words of a kind."""
    return f'<span class="{kind}">{text}</span>'


def anchor(name: str) -> str:
    """The address of a section in the page."""
    return name.lower().replace(" ", "-")


def number(value: float | None) -> str:
    """A number with five digits, nothing for None."""
    return "" if value is None else f"{float(value):.5g}"


def video(content: bytes, text: str) -> str:
    """An MP4 in the page, with its caption."""
    data, words = base64.b64encode(content).decode(), escape(text)
    return (
        f'<figure><video controls muted loop playsinline src="data:video/mp4;base64,{data}">'
        f"</video><figcaption>{words}</figcaption></figure>"
    )
