"""Frame times of the live page in a headless Chromium without a graphics processor, and their chart:

`python -m tests.benchmarks.live_page [--quick] [--out frames.png]`. A length slides with the loci of all four modes in
the picture, then the end-effector is dragged for a minute; of each frame the time of its own work and the interval
between frames are kept.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import fivebar as fb

from ..helpers.browsing import chromium, until

# As fast as it can draw, or the screen's own 60 frames a second would be all that is seen.
FLAGS = "--disable-gpu", "--disable-frame-rate-limit", "--disable-gpu-vsync"
SLIDE = """count => new Promise(done => {
    const seen = [], range = sliders[0].range;
    let k = 0, before = 0, own = 0;
    const next = now => {
        if (before) seen.push([now - before, costs[(costCount - 1 + costs.length) % costs.length] + own]);
        before = now;
        if (k === count) { range.onchange(); return done(seen); }
        range.value = 1e6 * (0.09 + 0.03 * Math.sin(0.05 * k++)) / slidingTop;
        own = performance.now();
        range.oninput();
        own = performance.now() - own;
        requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
})"""
DRAG = """seconds => new Promise(done => {
    const seen = [], box = task.box.getBoundingClientRect(), end = performance.now() + 1000 * seconds;
    const send = (type, point) => {
        const [x, y] = task.at(point);
        task.box.dispatchEvent(new PointerEvent(type, {pointerId: 1, clientX: box.left + x, clientY: box.top + y}));
    };
    task.box.setPointerCapture = () => {};
    send("pointerdown", pose.xi);
    let k = 0, before = 0;
    const next = now => {
        if (before) seen.push([now - before, costs[(costCount - 1 + costs.length) % costs.length]]);
        before = now;
        if (now > end) { send("pointerup", pose.xi); return done(seen); }
        k++;
        send("pointermove", [0.12 * Math.cos(0.031 * k), 0.08 + 0.09 * Math.sin(0.023 * k)]);
        requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
})"""


def measured(seconds, slides):
    """(load, s; frames of sliding; frames of dragging): (n, 2) ms, the interval and the work of each."""
    with tempfile.TemporaryDirectory() as folder, chromium(*FLAGS) as browser:
        path = Path(folder) / "play.html"
        fb.play().save(path)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        begun = time.perf_counter()
        page.goto(path.as_uri())
        until(page, "document.body.dataset.ready")
        load = time.perf_counter() - begun
        page.evaluate(SLIDE, 60)  # a browser compiles what has run some times
        return load, np.array(page.evaluate(SLIDE, slides)), np.array(page.evaluate(DRAG, seconds))


def main(quick=False, out=None):
    load, sliding, dragging = measured(2 if quick else 60, 60 if quick else 1200)
    print(f"load: {load:.2f} s (bound 1 s)")
    for name, frames in (("a length slides", sliding), ("the end-effector is dragged", dragging)):
        for what, values in zip(("between frames", "work of a frame"), frames.T):
            median, late = np.median(values), np.quantile(values, 0.99)
            print(
                f"{name}, {what}: median {median:.1f} ms (bound 16), 99th percentile {late:.1f} ms (bound 33), "
                f"longest {values.max():.1f} ms, {len(values)} frames"
            )
    if out:
        _chart(sliding, dragging).savefig(out, dpi=120)
        print(out)


def _chart(sliding, dragging):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), layout="constrained")
    for axes, frames, title in zip(
        figure.subplots(2, 1), (sliding, dragging), ("a length slides", "dragging")
    ):
        axes.plot(np.cumsum(frames[:, 0]) / 1000, frames[:, 0], ".", ms=2, label="between frames")
        axes.plot(np.cumsum(frames[:, 0]) / 1000, frames[:, 1], ".", ms=2, label="work of a frame")
        axes.axhline(16, color="0.6", lw=0.8)
        axes.axhline(33, color="0.6", lw=0.8, ls="--")
        axes.set(title=title, ylabel="ms", ylim=(0, 50))
        axes.legend(fontsize=8, loc="upper right")
    axes.set_xlabel("s")
    return figure


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    main(arguments.quick, arguments.out)
