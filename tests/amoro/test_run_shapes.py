"""`fivebar run`: shapes of scripts beyond the usual loop: threads, animations, and values that a scope may get."""

import json

import pytest

from tests.amoro.test_run import START, run

LOOP = (
    START
    + """import threading
stop = threading.Event()
def loop():
    while not stop.is_set():
        if robot.data_updated():
            robot.apply_efforts(1e-3, -1e-3)
thread = threading.Thread(target=loop)
thread.start()
"""
)
ANIMATION = """import matplotlib.pyplot as plt
from matplotlib.animation import FuncAnimation
frames, closed = [], []
figure, axes = plt.subplots()
line, = axes.plot([], [])
figure.canvas.mpl_connect("close_event", closed.append)
"""


@pytest.mark.parametrize("wait", ["thread.join()", "while thread.is_alive(): thread.join(0.1)"])
@pytest.mark.deep
def test_ctrl_c_of_a_thread_is_the_main_threads(tmp_path, wait):
    script = f"""{LOOP}
try:
    {wait}
except KeyboardInterrupt:
    stop.set()
    thread.join()
    robot.apply_efforts(0, 0)
    print("summary at", robot.get_time())
"""
    done = run(tmp_path, script, "--until", 0.5, "--record", "run.csv")
    assert done.stdout == "summary at 0.51\n" and "Traceback" not in done.stderr
    first = (tmp_path / "run.csv").read_bytes()
    run(tmp_path, script, "--until", 0.5, "--record", "run.csv")
    assert (tmp_path / "run.csv").read_bytes() == first


@pytest.mark.deep
def test_a_thread_is_waited_for(tmp_path):
    script = (
        START
        + """import threading
def loop():
    for _ in range(150):
        robot.apply_efforts(1e-3, -1e-3)
    print("done", flush=True)
threading.Thread(target=loop).start()
"""
    )
    done = run(tmp_path, script)
    assert done.stdout == "done\n" and "1.5 s simulated in" in done.stderr


@pytest.mark.parametrize("blit", [False, True])
@pytest.mark.deep
def test_an_animation_may_move_the_robot(tmp_path, blit):
    """It runs while the window would be open, until the interrupt, and no longer."""
    script = f"""{START}{ANIMATION}
def update(k):
    robot.apply_efforts(1e-3, -1e-3)
    frames.append((robot.get_time(), end.position_x))
    line.set_data(*zip(*frames))
    return [line]
animation = FuncAnimation(figure, update, interval=10, blit={blit}, cache_frame_data=False)
try:
    plt.show()
except KeyboardInterrupt:
    print(len(frames), robot.get_time())
    plt.show()
    print(len(frames), len(closed))
"""
    done = run(tmp_path, script, "--until", 0.3)
    assert done.stdout == "30 0.3\n30 1\n" and "Warning" not in done.stderr
    assert (tmp_path / "script_figure_1.png").stat().st_size > 5000


@pytest.mark.deep
def test_an_animation_is_seen_once_and_an_endless_one_is_closed(tmp_path):
    script = f"""{ANIMATION}
import itertools, time
finite = FuncAnimation(figure, frames.append, frames=[5, 6, 7], interval=100)
start = time.time()
plt.ion()
plt.show()
plt.pause(0.25)
print(frames, round(time.time() - start, 6))
plt.ioff()
plt.show()
print(frames, len(closed))
figure, axes = plt.subplots()
endless = FuncAnimation(figure, frames.append, frames=itertools.count(), interval=10, cache_frame_data=False)
plt.show()
print("closed")
figure, axes = plt.subplots()
def fail(k):
    raise ValueError("of a frame")
failing = FuncAnimation(figure, fail, frames=3)
plt.show()
"""
    done = run(tmp_path, script, code=1)
    # Matplotlib draws the first frame once before it starts to count.
    assert done.stdout.splitlines() == ["[5, 5, 6] 0.25", "[5, 5, 6, 7] 1", "closed"]
    assert done.stderr.count("ValueError: of a frame") == 1 and "Warning" not in done.stderr


@pytest.mark.deep
def test_the_picture_itself_may_be_asked_for(tmp_path):
    script = """import matplotlib.pyplot as plt, numpy as np
figure, axes = plt.subplots()
line, = axes.plot([0, 1], [0, 1], lw=20)
pictures = []
for colour in ("red", "blue"):
    line.set_color(colour)
    figure.canvas.draw()
    pictures.append(np.array(figure.canvas.buffer_rgba()))
print([picture[240, 328].tolist() for picture in pictures])
"""
    assert run(tmp_path, script).stdout == "[[255, 0, 0, 255], [0, 0, 255, 255]]\n"


@pytest.mark.deep
def test_scopes_of_anything(tmp_path):
    """Matrices, what is not finite, and titles that Matplotlib would read as formulas."""
    script = (
        START
        + r"""
scopes = Scope("a $\frac{$ b", -1, 1), Scope("two", float("nan"), 1), Scope("<three>", 1, -1)
for k in range(5):
    robot.apply_efforts(0, 0)
    for scope, y in zip(scopes, (float("inf"), float("nan"), np.matrix([[0.5]]))):
        scope.update(robot.get_time(), np.array([1.0]), y)
"""
    )
    done = run(tmp_path, script, "--json")
    about = json.loads(done.stdout, parse_constant=pytest.fail)
    assert [scope["rms_difference"] for scope in about["scopes"]] == [None, None, 0.5]
    assert about["files"] == ["script_scopes.png"]


@pytest.mark.deep
def test_what_waits_for_others_takes_real_time(tmp_path):
    """Queues, processes and asyncio under a clock that stands still; the script's own clock is the simulation's."""
    script = (
        START
        + """import asyncio, multiprocessing, queue, subprocess, sys, time
try:
    queue.Queue().get(timeout=0.02)
except queue.Empty:
    with multiprocessing.Pool(2) as pool:
        print(pool.map(abs, [-1, 2]))
print(subprocess.run([sys.executable, "-c", "print(3)"], capture_output=True, text=True, timeout=60).stdout.strip())
async def main():
    for _ in range(3):
        robot.apply_efforts(0, 0)
        await asyncio.sleep(0.01)
asyncio.run(main())
start = time.monotonic()
time.sleep(0.5)
print(start, time.monotonic(), time.perf_counter())
"""
    )
    done = run(tmp_path, script, "--timeout", 30)
    assert done.stdout.splitlines() == ["[1, 2]", "3", "0.03 0.53 0.53"]


@pytest.mark.deep
def test_a_thread_that_nobody_ends_does_not_keep_the_command(tmp_path):
    """The main thread is interrupted where it does not expect it; the other would look for news for ever."""
    script = (
        START
        + """import threading, time
def loop():
    while True:
        if robot.data_updated():
            robot.apply_efforts(1e-3, -1e-3)
threading.Thread(target=loop).start()
while True:
    pass
"""
    )
    run(tmp_path, script, "--until", 0.5)
