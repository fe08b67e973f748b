"""One HTML page with all charts of a folder: pictures, how to read them, what they say, the numbers. Self-contained."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING

from ...tables import written

if TYPE_CHECKING:
    from pathlib import Path

    from .store import Result

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 72rem; margin: 2rem auto }
body { padding: 0 1rem } img { max-width: 100%; height: auto; border: 1px solid #ddd }
table { border-collapse: collapse; font-size: .8rem; display: block; overflow-x: auto }
td, th { padding: .1rem .6rem; text-align: right; border-bottom: 1px solid #eee; white-space: nowrap }
td.word, th.word { text-align: left } .about { color: #666; font-size: .85rem } nav a { margin-right: 1.2rem }
.chart { overflow-x: auto } .chart img { min-width: min(40rem, 100vh) }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark } body { color: #eceff2; background: #14171b } .about { color: #a9b2bc }
  a { color: #8ab4f8 } td, th { border-color: #4c555f } img { border-color: #bbb }
  img { filter: invert(.92) hue-rotate(180deg) }
}
@media print { nav, details { display: none } section { break-inside: avoid } }
"""
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
COLUMNS = ("problem", "method", "knob", "status", "word", "seconds", "seconds_low", "seconds_high", "repeats")


def write_page(path: Path, results: dict[str, Result], pictures: dict[str, bytes], captions: dict[str, str]) -> None:
    """The page of results {name: Result}, pictures {name: PNG bytes} and captions {name: text}."""
    links = " ".join(f'<a href="#{escape(n)}">{escape(n)}</a>' for n in results)
    sections = [_section(name, result, pictures[name], captions[name]) for name, result in results.items()]
    text = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f"<title>fivebar: speed against accuracy</title><style>{STYLE}</style></head><body>"
        f"<h1>Speed against accuracy</h1><nav>{links}</nav>{''.join(sections)}</body></html>\n"
    )
    with written(path) as file:
        file.write(text)


def _section(name, result, png, caption):
    verdict, *more = caption.split("\n")
    image = base64.b64encode(png).decode()
    about = ", ".join(f"{key} {value}" for key, value in result.about.items())
    measures = list(dict.fromkeys(key for row in result.rows for key in row if key not in COLUMNS))
    head = "".join(f"<th{_side(key)}>{escape(key)}</th>" for key in (*COLUMNS, *measures))
    rows = "".join(
        "<tr>"
        + "".join(f"<td{_side(key)}>{escape(_text(row.get(key, '')))}</td>" for key in (*COLUMNS, *measures))
        + "</tr>"
        for row in result.rows
    )
    return (
        f'<section id="{escape(name)}"><h2>{escape(result.chart.title)}</h2><p>{escape(result.chart.reading)}</p>'
        f'<div class="chart"><img alt="{escape(result.chart.title)}" src="data:image/png;base64,{image}"></div>'
        f"<p><strong>{escape(verdict)}</strong></p><ul>{''.join(f'<li>{escape(each)}</li>' for each in more)}</ul>"
        f'<p class="about">{escape(about)}</p><p class="about"><a href="{escape(name)}.csv">{escape(name)}.csv</a>, '
        f'<a href="{escape(name)}.svg">{escape(name)}.svg</a></p><details><summary>{len(result.rows)} measurements, SI '
        f"units</summary><table><tr>{head}</tr>{rows}</table></details></section>"
    )


def _side(key):
    return ' class="word"' if key in ("problem", "method", "status", "word") else ""


def _text(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)
