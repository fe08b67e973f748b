"""The README's recording of the live page: `python -m tests.helpers.recording .readme/play.gif`.

Lengths slide, the end-effector is dragged, the robot is let go: a GIF of a headless Chromium's screenshots.
"""

import sys
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

import fivebar as fb

from .browsing import chromium, settle, until

SIZE, SCALE, COLOURS, AREAS, PERIOD = (1200, 660), 1, 80, 40, 90  # pixels; ms from frame to frame


def scenes(page):
    """Does what is shown, and says when a frame is to be taken."""
    page.evaluate("showGuide(GUIDE.length); wanted = 0.1; discCheck.input.click()")
    slide = "([k, value]) => { sliders[k].range.value = 1e6 * value / slidingTop; sliders[k].range.oninput(); }"
    for share in (1 - np.cos(np.linspace(0, np.pi, 16))) / 2:
        page.evaluate(slide, [0, 0.09 + 0.035 * share])
        page.evaluate(slide, [1, 0.09 + 0.06 * share])
        yield
    page.evaluate("sliders[0].range.onchange()")
    page.wait_for_timeout(300)
    yield
    for angle in np.linspace(0.3, 2.9, 18):
        page.evaluate(
            "at => { moveTo(at, 0.002); moved(); }",
            [0.10 * np.cos(angle), 0.13 + 0.10 * np.sin(angle)],
        )
        yield
    # its own clock stands: the frames are told apart
    page.evaluate("release([0.5, -0.9]); paceInput.value = ''")
    for _ in range(26):
        page.evaluate("flow(0.03); pose = poseOfMotion(); moved()")
        yield


def main(out):
    frames = []
    with tempfile.TemporaryDirectory() as folder, chromium("--disable-gpu") as browser:
        path = Path(folder) / "play.html"
        fb.play().save(path)
        page = browser.new_page(
            viewport=dict(zip(("width", "height"), SIZE)),
            device_scale_factor=SCALE,
            reduced_motion="reduce",
        )
        page.goto(path.as_uri())
        until(page, "document.body.dataset.ready")
        for _ in scenes(page):
            settle(page)
            frames.append(Image.open(BytesIO(page.screenshot())).convert("RGB"))
    whole = Image.new("RGB", (SIZE[0], 6 * SIZE[1]))
    for k, frame in enumerate(frames[:: len(frames) // 6][:6]):
        whole.paste(frame, (0, k * SIZE[1]))
    # Large areas keep their colours exactly, thin bars their hues.
    areas = sorted(whole.getcolors(whole.width * whole.height), reverse=True)[:AREAS]
    thin = whole.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE).getpalette()[: 3 * COLOURS]
    palette = Image.new("P", (1, 1))
    palette.putpalette([value for _, colour in areas for value in colour] + thin)
    images = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [PERIOD] * (len(images) - 1) + [1500]
    images[0].save(
        out, save_all=True, append_images=images[1:], duration=durations, loop=0, optimize=True
    )
    print(f"{out}: {len(images)} frames, {Path(out).stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(sys.argv[1])
