"""Tables: pandas data frames where pandas is installed, and HTML for notebooks without it."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from typing import Any


def table(rows: Sequence[Mapping[str, Any]], index: str | None = None) -> Any:
    """A data frame, or the rows as they are where pandas is not installed."""
    try:
        import pandas
    except ModuleNotFoundError:
        return list(rows)
    frame = pandas.DataFrame(list(rows))
    return frame.set_index(index) if index is not None and len(frame) > 0 else frame


def as_html(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in HTML; the first column holds names, the others numbers."""
    head = "".join(f"<th>{html.escape(heading)}</th>" for heading in headings)

    def cells(row: Sequence[str]) -> str:
        name, *numbers = (html.escape(cell) for cell in row)
        return f"<th style='text-align:left'>{name}</th>" + "".join(f"<td>{number}</td>" for number in numbers)

    def caption(line: str) -> str:
        alarm = " style='color:#c0392b;font-weight:bold'" if "ATTENTION" in line else ""
        return f"<div{alarm}>{html.escape(line)}</div>"

    body = "".join(f"<tr>{cells(row)}</tr>" for row in rows)
    lines = "".join(caption(line) for line in title.split("\n"))
    return f"<table><caption>{lines}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def as_figures(charts: Mapping[str, str]) -> str:
    """Charts as pictures of a page. As data they bring no styles or names into the page around them."""

    def figure(name: str, svg: str) -> str:
        data = base64.b64encode(svg.encode()).decode()
        return f"<img alt='{html.escape(name)}' style='max-width:100%' src='data:image/svg+xml;base64,{data}'>"

    return "".join(figure(name, svg) for name, svg in charts.items())


def as_text(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """The same in plain text."""
    widths = [max(len(row[place]) for row in [headings, *rows]) for place in range(len(headings))]

    def line(row: Sequence[str]) -> str:
        name, *numbers = zip(row, widths)
        return "  ".join([name[0].ljust(name[1]), *(number.rjust(width) for number, width in numbers)])

    return "\n".join(line(row) for row in [headings, *rows])


def decibels(level: float | None) -> str:
    """A level to a tenth of a decibel; a dash for silence."""
    return "-" if level is None else f"{level:.1f}"
