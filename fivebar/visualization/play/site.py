"""The live page at an address: a folder for any static host, and a server on this computer."""

from __future__ import annotations

import html
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from ...base.tables import saved, written
from ...singularities.loci import singularity_loci
from ..style import INK, LEGS, PINK

if TYPE_CHECKING:
    from ...models.geometry import Pose
    from .live import LivePage

PREVIEW = "preview.png"
PREVIEW_SIZE = 1200, 630  # pixels: what social networks show
DESCRIPTION = (
    "Drag a five-bar parallel robot, change its lengths, and see its singularities and its largest"
    " free disc."
)


def save_site(live: LivePage, folder: Path, address: str = "") -> list[Path]:
    """Write index.html with social tags and its preview picture into a folder; return both paths.

    address: of the folder on the web; social networks find the picture only with it.
    """
    if live.pose is None:
        raise ValueError("a folder for the web shows a five-bar: its page needs a pose")
    folder.mkdir(parents=True, exist_ok=True)
    page, preview = folder / "index.html", folder / PREVIEW
    with written(page) as out:
        out.write(with_tags(live.html, address))
    saved(draw_preview(live.pose), preview, dpi=100)
    return [page, preview]


def with_tags(page: str, address: str) -> str:
    """Return the page with the tags that social networks read."""
    root = address.rstrip("/") + "/" if address else ""
    width, height = map(str, PREVIEW_SIZE)
    tags = {
        "og:type": "website",
        "og:title": "Five-bar, live",
        "og:description": DESCRIPTION,
        "og:image": root + PREVIEW,
        "og:image:width": width,
        "og:image:height": height,
    }
    if root:
        tags["og:url"] = root
    lines = [f'<meta property="{name}" content="{html.escape(x)}">' for name, x in tags.items()]
    lines.append('<meta name="twitter:card" content="summary_large_image">')
    lines.append(f'<meta name="description" content="{html.escape(DESCRIPTION)}">')
    return page.replace("<title>", "\n".join([*lines, "<title>"]), 1)


def draw_preview(pose: Pose) -> Figure:
    """Return a picture of the robot and its loci in its working mode."""
    figure = Figure(figsize=(PREVIEW_SIZE[0] / 100, PREVIEW_SIZE[1] / 100))
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_aspect("equal")
    axes.axis("off")
    robot: Any = pose.robot
    working = tuple(pose.working.tolist())
    for piece in singularity_loci(robot).task:
        here = working in piece.working
        colour = INK if piece.circle else PINK
        width, alpha = (3.0, 1.0) if here else (1.2, 0.3)
        axes.plot(*piece.points.T, color=colour, linewidth=width, alpha=alpha)
    for drive, elbow, colours in zip(robot.drives, pose.elbows, LEGS):
        base = drive.x, drive.y
        axes.plot(*zip(base, elbow), color=colours[0], linewidth=9, solid_capstyle="round")
        axes.plot(*zip(elbow, pose.xi), color=colours[1], linewidth=9, solid_capstyle="round")
        for joint, fill in ((base, INK), (elbow, "white")):
            axes.plot(*joint, "o", color=fill, markeredgecolor=INK, markersize=14, zorder=3)
    axes.plot(*pose.xi, "o", color=PINK, markeredgecolor=INK, markersize=18, zorder=4)
    return figure


def server(live: LivePage) -> ThreadingHTTPServer:
    """Return a server of the page on a free port of this computer, for this computer only."""
    body = live.html.encode()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            found = self.path == "/"
            self.send_response(200 if found else 404)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(body) if found else 0))
            self.end_headers()
            if found:
                self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Keep requests off the terminal."""

    return ThreadingHTTPServer(("127.0.0.1", 0), Handler)
