"""One HTML page with all charts of a folder: pictures, how to read them, what they say, the
numbers. Self-contained.
"""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING

from ...base.tables import written

if TYPE_CHECKING:
    from pathlib import Path

    from .store import Result

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 72rem; margin: 2rem auto }
body { padding: 0 1rem } img { max-width: 100%; height: auto; border: 1px solid #ddd }
table { border-collapse: collapse; font-size: .8rem; display: block; overflow-x: auto }
td, th { padding: .1rem .6rem; text-align: right; border-bottom: 1px solid #eee; white-space: nowrap }
td.word, th.word { text-align: left } h3 { font-size: 1rem; margin: 1rem 0 .3rem }
.about { color: #666; font-size: .85rem } nav a { margin-right: 1.2rem }
.chart { overflow-x: auto } .chart img { min-width: min(40rem, 100vh) }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark } body { color: #eceff2; background: #14171b } .about { color: #a9b2bc }
  a { color: #8ab4f8 } td, th { border-color: #4c555f } img { border-color: #bbb }
  img { filter: invert(.92) hue-rotate(180deg) }
}
@media print {
  nav, details { display: none } body { margin: 0 } section + section { break-before: page }
  h2, h3 { break-after: avoid; break-inside: avoid }
  /* Firefox knows no break-after: avoid, but a heading with room for what follows */
  h2::after, h3::after { content: ""; display: block; height: 10rem; margin-bottom: -10rem }
  table { display: table; break-inside: avoid } td.word { white-space: normal }
}
"""
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
WORDS = ("problem", "method", "status", "word", "failed")  # columns set to the left
COLUMNS = (
    "problem",
    "method",
    "knob",
    "status",
    "word",
    "seconds",
    "seconds_low",
    "seconds_high",
    "repeats",
)


def write_page(
    path: Path, results: dict[str, Result], pictures: dict[str, bytes], notes: dict[str, tuple]
) -> None:
    """The page of results {name: Result}, pictures {name: PNG bytes} and said {name: (caption,
    table)}.
    """
    links = " ".join(f'<a href="#{escape(n)}">{escape(n)}</a>' for n in results)
    sections = [
        _section(name, result, pictures[name], *notes[name]) for name, result in results.items()
    ]
    text = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f"<title>fivebar: speed against accuracy</title><style>{STYLE}</style></head><body>"
        f"<h1>Speed against accuracy</h1><nav>{links}</nav>{''.join(sections)}</body></html>\n"
    )
    with written(path) as file:
        file.write(text)


def _section(name, result, png, caption, tables):
    image = base64.b64encode(png).decode()
    about = ", ".join(f"{key} {value}" for key, value in result.about.items())
    measures = list(dict.fromkeys(key for row in result.rows for key in row if key not in COLUMNS))
    keys = (*COLUMNS, *measures)
    rows = [[_text(row.get(key, "")) for key in keys] for row in result.rows]
    compared = "".join(
        f"<h3>{escape(title)}</h3>{_table(head, rows)}" for title, head, rows in tables
    )
    return (
        "<section"
        f' id="{escape(name)}"><h2>{escape(result.chart.title)}</h2><p>{escape(result.chart.reading)}</p><div'
        f' class="chart"><img alt="{escape(result.chart.title)}"'
        f' src="data:image/png;base64,{image}"></div><p><strong>{escape(caption)}</strong></p>{compared}<p'
        f' class="about">{escape(about)}</p><p class="about"><a'
        f' href="{escape(name)}.csv">{escape(name)}.csv</a>, <a'
        f' href="{escape(name)}.svg">{escape(name)}.svg</a></p><details><summary>{len(result.rows)}'
        f" measurements, SI units</summary>{_table(keys, rows)}</details></section>"
    )


def _table(head, rows):
    sides = [' class="word"' if key in WORDS else "" for key in head]
    lines = [("th", head), *(("td", row) for row in rows)]
    return (
        "<table>"
        + "".join(
            "<tr>"
            + "".join(f"<{tag}{side}>{escape(cell)}</{tag}>" for side, cell in zip(sides, cells))
            + "</tr>"
            for tag, cells in lines
        )
        + "</table>"
    )


def _text(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)
