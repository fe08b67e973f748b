"""What is written of a scene: pages, animations, films and strips, and what is said where that cannot be."""

import io
import json
import os
import subprocess
import sys
import time
from base64 import b64encode
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from PIL import Image

import fivebar as fb
from fivebar import linkages
from fivebar.visualization import document, view
from fivebar.visualization.view import scenes

from ..helpers.needs import need
from .conftest import ROBOT, long_run

HOSTILE = '</title></script><script>window.hacked = 1</script><img src=x onerror="hacked = 1"> $half ${x} & é'


def test_files_that_cannot_be_written(run, tmp_path):
    with pytest.raises(
        ValueError, match=r"\.html \(a page\), \.gif \(an animation\), .* not as 'run.avi'"
    ):
        run.animate(tmp_path / "run.avi")
    with pytest.raises(FileNotFoundError, match="there is no folder .*nowhere"):
        run.animate(tmp_path / "nowhere" / "run.html")
    (tmp_path / "taken.html").mkdir()
    with pytest.raises(IsADirectoryError):
        run.animate(tmp_path / "taken.html")


def test_missing_viewer_is_told(run, tmp_path, monkeypatch):
    monkeypatch.setattr(document, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="pip install meshcat"):
        run.animate(tmp_path / "run.html")
    assert not (tmp_path / "run.html").exists()


def test_ten_seconds_are_small_and_quick(tmp_path):
    t = np.linspace(0, 10, 601)
    q = np.stack([0.4 * np.sin(3 * t), 0.3 * np.cos(2 * t)], axis=1)
    run = long_run(t, q, xi_ref=np.zeros((601, 2)))
    run.animate(tmp_path / "first.html")  # packs the viewer, once for a process
    start = time.process_time()
    run.animate(tmp_path / "run.html")
    assert time.process_time() - start < 5  # no timing, but no blunder either
    assert (tmp_path / "run.html").stat().st_size < 600_000
    view.scene(ROBOT, run, view.SHOWS).save(tmp_path / "all.html")
    assert (tmp_path / "all.html").stat().st_size < 1_000_000


def test_pages_of_the_same_motion_are_the_same(run):
    assert view.scene(ROBOT, run).html == view.scene(ROBOT, run).html


def test_texts_are_escaped(run):
    scene = view.scene(ROBOT, run, title=HOSTILE, second=run, names=[HOSTILE, "b"])
    assert "<script>window.hacked" not in scene.html and "<img" not in scene.html
    assert scene.html.count("</script>") == scene.html.count("<script")


class Sanitized(HTMLParser):
    """What is left of a picture where frames, scripts and styles are taken out."""

    def __init__(self, text):
        super().__init__()
        self.left, self.inside = [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in ("iframe", "script", "style"):
            self.left.append((tag, {name: value for name, value in attributes if name != "style"}))


def test_notebooks_get_the_page_and_a_picture(run):
    scene = view.scene(ROBOT, run, title='a "b" <c>')
    text = scene._repr_html_()
    assert text.count("<iframe") == 1 and 'srcdoc="&lt;!DOCTYPE html&gt;' in text
    _, (tag, attributes) = Sanitized(text).left
    assert tag == "img" and attributes["alt"] == 'a "b" <c>'
    picture = b64encode(scene._repr_png_()).decode()
    assert attributes["src"] == "data:image/png;base64," + picture
    picture = np.asarray(Image.open(io.BytesIO(scene.png)).convert("RGB"), dtype=float)
    assert picture.shape[1] > picture.shape[0] and (np.ptp(picture, axis=2) > 80).mean() > 0.005
    assert repr(scene) == "Scene('a \"b\" <c>', 0.5 s)"


def test_gif_plays_the_motion(run, tmp_path):
    view.scene(ROBOT, run, ["trace", "torques", "velocity"], title=HOSTILE).save(
        tmp_path / "run.gif"
    )
    picture = Image.open(io.BytesIO((tmp_path / "run.gif").read_bytes()))
    assert picture.n_frames == 10 and picture.info["duration"] == 50
    frames = []
    for k in (0, 9):
        picture.seek(k)
        frames.append(np.asarray(picture.convert("RGB"), dtype=float))
    assert (np.abs(frames[0] - frames[1]).max(axis=2) > 60).mean() > 0.01


def test_long_gifs_are_shown_faster(tmp_path, monkeypatch):
    from fivebar.visualization.plot import poses

    monkeypatch.setattr(poses, "GIF", (20, 4, 80))
    linkages.study(linkages.FourBar(0.2, 0.06, 0.16, 0.14)).animate(tmp_path / "slow.gif")
    assert Image.open(io.BytesIO((tmp_path / "slow.gif").read_bytes())).n_frames == 4


@pytest.mark.every(2)
@pytest.mark.parametrize(("name", "codec"), [("run.mp4", "h264"), ("run.WEBM", "vp9")])
def test_films_play_the_motion(tmp_path, name, codec):
    need("ffmpeg")
    reference = fb.line((0.09, 0.068), (0.05, 0.08), 0.1)
    fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), reference).animate(tmp_path / name)
    entries = "stream=codec_name,pix_fmt,width,height,r_frame_rate,nb_read_frames"
    command = [
        "ffprobe",
        "-v",
        "error",
        "-count_frames",
        "-show_entries",
        entries,
        "-of",
        "json",
        str(tmp_path / name),
    ]
    (found,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)[
        "streams"
    ]
    assert (found["codec_name"], found["pix_fmt"], found["r_frame_rate"]) == (
        codec,
        "yuv420p",
        "30/1",
    )
    assert found["nb_read_frames"] == "3" and found["width"] == 960 and found["height"] > 400
    decode = [
        "ffmpeg",
        "-v",
        "error",
        "-i",
        str(tmp_path / name),
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    frames = np.frombuffer(subprocess.run(decode, capture_output=True, check=True).stdout, np.uint8)
    frames = frames.reshape(3, found["height"], 960, 3).astype(int)
    assert (np.ptp(frames[:, 80:], axis=0).max(axis=2) > 60).mean() > 0.005  # it moves
    for colour in ((0, 114, 178), (199, 68, 60)):  # both proximal bars
        assert (np.abs(frames[0] - colour) < 25).all(axis=2).mean() > 0.005


def test_a_film_without_ffmpeg_names_it_and_what_goes_without(run, tmp_path, monkeypatch):
    monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", str(tmp_path / "ffmpeg"))
    with pytest.raises(FileNotFoundError, match=r"\.mp4 is written by the program ffmpeg"):
        run.animate(tmp_path / "run.mp4")
    (tmp_path / "ffmpeg").write_text(
        "#!/bin/sh\necho no codec today >&2\nexit 1\n", encoding="utf-8"
    )
    (tmp_path / "ffmpeg").chmod(0o755)
    with pytest.raises(OSError, match=r"ffmpeg could not write a \.webm: no codec today"):
        run.animate(tmp_path / "run.webm")
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.every(2)
@pytest.mark.parametrize("poses", [1, 6, 7])
def test_strips_have_their_poses(crossing_run, tmp_path, poses):
    figure = view.strip(crossing_run, tmp_path / "strip.png", poses, show=view.SHOWS)
    assert len(figure.axes) == poses
    assert (tmp_path / "strip.png").read_bytes()[:4] == b"\x89PNG"
    assert figure.axes[0].get_title() == "0 s" and (
        poses == 1 or figure.axes[-1].get_title() == "4 s"
    )


@pytest.mark.parametrize("poses", [0, -1, 2.5, True, 100])
def test_strips_of_no_poses(run, poses):
    with pytest.raises(ValueError, match="poses must be a whole number from 1 to 48"):
        view.strip(run, poses=poses)


def test_no_server_is_started_or_loaded(tmp_path):
    script = f"""
import socket, sys, threading
def refuse(*arguments): raise AssertionError("a server was started")
socket.socket.bind = socket.socket.listen = refuse
import fivebar as fb
from fivebar import view
assert not {{"meshcat", "umsgpack", "matplotlib", "scipy", "casadi", "PIL"}} & sys.modules.keys(), "too early"
robot = fb.FiveBar()
view.scene(robot, fb.line((0.05, 0.1), (0.0, 0.1), 1.0)).save({str(tmp_path / "page.html")!r})
assert not {{"meshcat", "zmq", "tornado", "matplotlib", "casadi"}} & sys.modules.keys()
assert threading.active_count() == 1
"""
    folder = Path(scenes.__file__).parents[2]
    subprocess.run(
        [sys.executable, "-W", "error", "-c", script], check=True, cwd=folder, env={**os.environ}
    )
