"""One self-contained HTML page with pictures, what they say, and the numbers."""

from __future__ import annotations

from html import escape
from pathlib import Path

from ...base.tables import written
from ...visualization.document import picture, report, table
from .findings import summary
from .store import Result

SECTION = """<section id="{name}"><h2>{title}</h2><p>{reading}</p>
{picture}
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
        titled = []
        for title, head, rows in tables:
            cells = [map(escape, row) for row in rows]
            titled.append(f"<h3>{escape(title)}</h3>{table(title, head, cells)}")
        png = path.with_name(f"{name}.png").read_bytes()
        sections.append(
            SECTION.format(
                name=escape(name),
                title=escape(result.chart.title),
                reading=escape(result.chart.reading),
                picture=picture(png, result.chart.title),
                caption=escape(caption),
                tables="".join(titled),
                about=escape(", ".join(f"{key} {value}" for key, value in result.about.items())),
            )
        )
    with written(path) as file:
        file.write(
            report("charts", "Speed against accuracy", links=links, sections="".join(sections))
        )
