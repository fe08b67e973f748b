"""One self-contained HTML page with pictures, what they say, and the numbers."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path

from ...base.tables import written
from .findings import summary
from .store import Result

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff }
body { max-width: 72rem; margin: 2rem auto; padding: 0 1rem }
img { max-width: 100%; height: auto; border: 1px solid #ddd }
table { border-collapse: collapse; font-size: .8rem; display: block; overflow-x: auto }
td, th { padding: .1rem .6rem; text-align: left; border-bottom: 1px solid #eee }
td, th { white-space: nowrap } h3 { font-size: 1rem; margin: 1rem 0 .3rem }
.about { color: #666; font-size: .85rem } nav a { margin-right: 1.2rem }
.chart { overflow-x: auto } .chart img { min-width: min(40rem, 100vh) }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark } body { color: #eceff2; background: #14171b }
  .about { color: #a9b2bc } a { color: #8ab4f8 } td, th { border-color: #4c555f }
  img { border-color: #bbb; filter: invert(.92) hue-rotate(180deg) }
}
@media print {
  nav { display: none } body { margin: 0 } section + section { break-before: page }
  h2, h3 { break-after: avoid; break-inside: avoid }
  /* Firefox knows no break-after: avoid, but a heading with room for what follows */
  h2::after, h3::after { content: ""; display: block; height: 10rem; margin-bottom: -10rem }
  table { display: table; break-inside: avoid } td { white-space: normal }
}
"""
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>fivebar: speed against accuracy</title><style>{style}</style></head><body>
<h1>Speed against accuracy</h1><nav>{links}</nav>{sections}</body></html>
"""
SECTION = """<section id="{name}"><h2>{title}</h2><p>{reading}</p>
<div class="chart"><img alt="{title}" src="data:image/png;base64,{image}"></div>
<p><strong>{caption}</strong></p>{tables}<p class="about">{about}</p>
<p class="about"><a href="{name}.csv">{name}.csv</a>, <a href="{name}.svg">{name}.svg</a></p>
</section>
"""


def write_page(path: Path, results: dict[str, Result]) -> None:
    """Write the page of charts whose pictures NAME.png are in the same folder."""
    links = " ".join(f'<a href="#{escape(name)}">{escape(name)}</a>' for name in results)
    sections = []
    for name, result in results.items():
        caption, tables = summary(result)
        titled = [f"<h3>{escape(title)}</h3>{_table(head, rows)}" for title, head, rows in tables]
        sections.append(
            SECTION.format(
                name=escape(name),
                title=escape(result.chart.title),
                reading=escape(result.chart.reading),
                image=base64.b64encode(path.with_name(f"{name}.png").read_bytes()).decode(),
                caption=escape(caption),
                tables="".join(titled),
                about=escape(", ".join(f"{key} {value}" for key, value in result.about.items())),
            )
        )
    with written(path) as file:
        file.write(PAGE.format(policy=POLICY, style=STYLE, links=links, sections="".join(sections)))


def _table(head, rows):
    lines = [_line("th", head)] + [_line("td", row) for row in rows]
    return f"<table>{''.join(lines)}</table>"


def _line(tag, cells):
    content = "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
    return f"<tr>{content}</tr>"
