"""Files: what is written is read back to the last bit, and what was not written by us is refused with file and line."""

import io
import os
import re
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import fivebar as fb
from fivebar.base import tables
from fivebar.linkages import PRESSES, FiveBarLinkage, FourBar, SliderCrank, Study, study
from fivebar.planning.collocation import Pieces, Scheme
from fivebar.planning.plans import PlanMesh
from fivebar.simulation.run import Control, Event
from fivebar.singularities.maps import FIELDS, Map, singularity_map

ANY = st.floats(width=64)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
ROBOTS = st.sampled_from([fb.FiveBar(), fb.FiveBar(0.1 + 0.2, 0.07, 1 / 3, 0.2, 0.1), fb.Biglide()])
CALMLY = settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)


def times(n):
    """n times that increase from 0 or later."""
    return st.lists(st.floats(0, 1e6), min_size=n, max_size=n, unique=True).map(
        lambda t: np.array(sorted(t))
    )


def same(a, b):
    """Equal to the bit, in nested tuples, dicts and arrays; nan is nan, and -0.0 is not 0.0."""
    if isinstance(a, dict):
        assert list(a) == list(b)
        a, b = tuple(a.values()), tuple(b.values())
    if isinstance(a, np.ndarray):
        assert a.shape == b.shape and a.dtype == b.dtype
        a, b = a.tolist(), b.tolist()
    assert repr(a) == repr(b)


@st.composite
def runs(draw):
    robot, n = draw(ROBOTS), draw(st.integers(1, 4))

    def columns(k, rows=n):
        return draw(arrays(float, (rows, k) if k else rows, elements=ANY))

    t, tau, control = draw(times(n)), columns(2), None
    if draw(st.booleans()):  # of some of the rows, in which the torque is the applied one
        at = draw(st.lists(st.booleans(), min_size=n, max_size=n))
        k = sum(at)
        measured = [draw(arrays(float, (k, 2), elements=FINITE)) for _ in range(3)]
        control = Control(t[at], *measured, tau[at])
    modes = st.tuples(*[st.sampled_from([-1, 0, 1])] * 3)
    events = st.tuples(FINITE, st.sampled_from(fb.Singularity), st.text(), modes, modes)
    return fb.Run(
        robot,
        t,
        columns(2),
        columns(2),
        columns(2),
        tau,
        columns(0),
        control=control,
        xi_ref=draw(st.one_of(st.none(), st.just(columns(2)))),
        torque_limit=draw(st.one_of(st.none(), FINITE)),
        events=tuple(Event(*e) for e in draw(st.lists(events, max_size=2))),
        step_error=draw(st.one_of(st.none(), FINITE)),
    )


def again(thing, kind, *others):
    """What is read from what is written."""
    file = io.StringIO(newline="")
    thing.to_csv(file)
    file.seek(0)
    return kind(file, *others)


@pytest.mark.deep
@CALMLY
@given(runs())
def test_a_run_comes_back(run):
    back = again(run, fb.Run.from_csv)
    assert back.robot == run.robot and isinstance(back, fb.Run)
    for name in (
        "t",
        "q",
        "q_dot",
        "xi",
        "tau",
        "energy",
        "xi_ref",
        "torque_limit",
        "control",
        "events",
        "step_error",
    ):
        same(getattr(run, name), getattr(back, name))


@pytest.fixture(scope="module")
def plan():
    square = ((-0.2, -0.1), (0.2, -0.1), (0.2, 0.2), (-0.2, 0.2))
    return fb.plan(
        fb.FiveBar(),
        (0.09, 0.068),
        (0.0, 0.1),
        1.0,
        constraints=fb.Constraints(
            torque=(0.05, 0.06), region=square, collisions=fb.LinkCollisions(layers=(1, 2, 3, 4))
        ),
    )


@pytest.fixture(scope="module")
def plan_in_bars():
    start, goal = (
        fb.igm(fb.FiveBar(), xi, working)
        for xi, working in (((0.0, 0.1), (-1, -1)), ((0.0, -0.1), (-1, 1)))
    )
    return fb.plan(fb.FiveBar(), start, goal, 2.0)


def alike(a, b):
    """Two plans, equal to the bit."""
    for name in ("objective", "status", "meshes", "solve_time", "tried", "robot", "working"):
        same(getattr(a, name), getattr(b, name))
    for name in ("weights", "constraints"):
        same(getattr(a.problem, name), getattr(b.problem, name))
    for (one, when), (other, then) in zip(a.problem.stops, b.problem.stops, strict=True):
        same(
            [when, *((k, np.array(v).tolist()) for k, v in one.items())],
            [then, *((k, list(v)) for k, v in other.items())],
        )
    for name in ("knots", "xi", "xi_dot", "xi_ddot", "tau"):
        same(getattr(a.pieces, name), getattr(b.pieces, name))
    t = np.linspace(-1, a.duration + 1, 33)
    same(a(t) + (a.torques(t),), b(t) + (b.torques(t),))


@pytest.mark.deep
def test_a_plan_comes_back(plan, plan_in_bars):
    assert plan.working and plan_in_bars.working is None
    for made in (plan, plan_in_bars):
        alike(made, again(made, fb.Plan.from_csv))
    path = again(plan_in_bars, fb.from_csv)  # it is a path like any other, too
    np.testing.assert_allclose(path(1.0)[0], plan_in_bars(1.0)[0], atol=1e-5)


@CALMLY
@given(st.data(), st.integers(2, 7), st.lists(st.floats(1e-3, 9), min_size=1, max_size=4))
def test_any_plan_comes_back(plan, data, degree, widths):
    rule = Scheme(degree)
    n = len(widths)
    xi = data.draw(arrays(float, (n, 2), elements=st.floats(0.05, 0.09)))  # reachable
    xi_dot = data.draw(arrays(float, (n, 2), elements=st.floats(-1e-3, 1e-3)))
    values = data.draw(arrays(float, (n, degree, 4), elements=st.floats(-1e-3, 1e-3)))
    pieces = Pieces(rule, np.cumsum([0.0, *widths]), xi, xi_dot, values[..., :2], values[..., 2:])
    mesh = PlanMesh(n, 3, data.draw(ANY), data.draw(ANY), data.draw(ANY))
    given = replace(
        plan,
        problem=replace(plan.problem, scheme=rule),
        pieces=pieces,
        meshes=(mesh,),
        solve_time=1.5,
    )
    alike(given, again(given, fb.Plan.from_csv))


LINKAGES = st.one_of(
    st.builds(
        FourBar,
        st.just(0.2),
        st.floats(0.03, 0.06),
        st.just(0.16),
        st.just(0.14),
        point=st.just((0.08, 0.05)),
    ),
    st.builds(SliderCrank, st.floats(0.03, 0.06), st.just(0.2), st.floats(0, 0.1)),
    st.just(FiveBarLinkage(fb.FiveBar())),
    st.just(PRESSES["repaired"][0]),
)


@pytest.mark.deep
@CALMLY
@given(
    LINKAGES,
    st.floats(0.1, 9),
    st.floats(0.3, 2),
    st.integers(3, 9),
    st.sampled_from(["turn", "swing", "until-lock"]),
)
def test_a_study_comes_back(linkage, speed, turns, samples, drive):
    between = (0.5, 1.0) if drive == "swing" and not isinstance(linkage, FiveBarLinkage) else None
    try:
        made = study(
            linkage,
            speed,
            turns,
            drive,
            samples=samples,
            between=between,
            gravity=np.array([0.0, -9.81]),
        )
    except (ValueError, ArithmeticError):
        return  # it locks there
    back = again(made, Study.from_csv)
    assert back.linkage == made.linkage and back.lock == made.lock
    for name in ("t", "q", "columns"):
        same(getattr(made, name), getattr(back, name))
    same(made.points(), back.points())


@CALMLY
@given(ROBOTS, st.sampled_from(sorted(FIELDS)), st.sampled_from(["task", "joint"]), st.data())
def test_a_map_comes_back(tmp_path, robot, field, space, data):
    nx, ny = data.draw(st.integers(2, 4)), data.draw(st.integers(2, 4))
    modes = ((-1, 1), (1, 1)) if space == "task" else (1, -1)
    values = data.draw(arrays(float, (2, ny, nx), elements=ANY))
    made = Map(robot, field, space, np.linspace(0, 1, nx), np.linspace(-1, 1, ny), modes, values)
    made.to_npz(tmp_path / "map.npz")
    back = Map.from_npz(tmp_path / "map.npz")
    assert (back.robot, back.field, back.space, back.modes) == (robot, field, space, modes)
    for name in ("x", "y", "values"):
        same(getattr(made, name), getattr(back, name))
    table = again(
        made,
        lambda file: np.array([line.split(",") for line in file.read().splitlines()[2:]], float),
    )
    same(
        values.reshape(2, -1).T[~np.isnan(values).all(axis=0).ravel()], table.reshape(-1, 4)[:, 2:]
    )


# What cannot be read

LINE = fb.line((0.09, 0.068), (0.0, 0.1), 1.0)
RUN = fb.simulate(
    fb.FiveBar(), fb.ComputedTorque(fb.FiveBar(), 100, 20), LINE, duration=0.02, control_period=0.01
)
STUDY = study(FourBar(0.2, 0.06, 0.16, 0.14), samples=5)


def text_of(thing):
    file = io.StringIO(newline="")
    thing.to_csv(file)
    return file.getvalue()


@pytest.fixture(scope="module")
def readers(plan):
    path = "t,x,y\n" + "".join(f"{k / 9!r},{k * 0.01!r},0.1\n" for k in range(10))
    return {
        "trajectory": (fb.from_csv, path),
        "run": (fb.Run.from_csv, text_of(RUN)),
        "plan": (fb.Plan.from_csv, text_of(plan)),
        "study": (Study.from_csv, text_of(STUDY)),
    }


@pytest.mark.deep
@settings(CALMLY, max_examples=60)
@given(
    st.sampled_from(["trajectory", "run", "plan", "study"]),
    st.lists(
        st.tuples(
            st.floats(0, 1),
            st.integers(0, 9),
            st.one_of(
                st.text(max_size=6),
                st.sampled_from(["nan", "-", "1e999", "null", '"', ",", "[", "{}", "9", "\n"]),
            ),
        ),
        min_size=1,
        max_size=3,
    ),
    st.booleans(),
)
def test_damaged_files_are_read_or_refused_with_their_name(
    tmp_path, readers, name, changes, in_first
):
    read, text = readers[name]
    for place, cut, put in changes:
        k = int(place * (text.index("\n") if in_first else len(text)))
        text = text[:k] + put + text[k + cut :]
    path = tmp_path / "it.csv"
    path.write_bytes(text.encode(errors="surrogatepass"))
    try:
        with np.errstate(all="ignore"):
            read(path)
    except ValueError as error:
        assert str(error).startswith(str(path)), error


@settings(CALMLY, max_examples=60)
@given(
    st.one_of(
        st.binary(), st.text().map(str.encode), st.text('t,xy0.\n#"e-', max_size=40).map(str.encode)
    )
)
def test_other_files_are_refused_with_their_name(tmp_path, readers, content):
    path = tmp_path / "it.csv"
    path.write_bytes(content)
    for read in (*(read for read, _ in readers.values()), Map.from_npz):
        with pytest.raises(ValueError, match=re.escape(str(path))):
            read(path)


@pytest.mark.deep
@settings(CALMLY, max_examples=60)
@given(
    st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 3), st.binary(max_size=4)), min_size=1, max_size=4
    )
)
def test_damaged_maps_are_read_or_refused_with_their_name(tmp_path, changes):
    path = tmp_path / "map.npz"
    singularity_map(fb.FiveBar(), shape=(4, 4)).to_npz(path)
    content = path.read_bytes()
    for place, cut, put in changes:
        k = int(place * len(content))
        content = content[:k] + put + content[k + cut :]
    path.write_bytes(content)
    try:
        Map.from_npz(path)
    except ValueError as error:
        assert "is not a map written by to_npz" in str(error)


@pytest.mark.parametrize(
    "text, message",
    [
        ("t,x,y,x\n0,1,2,3\n", "line 1: 'x' and 'x' both are x; leave one"),
        ("t,x,y\n-2,1,2\n-1,1,2\n", "line 2: time must not be negative, but is -2"),
        (
            '# half a quote, "\n\nt,x,y\n0,1,2\n0,1,2\n',
            "line 5: time must increase, but 0 follows 0",
        ),
        ("t,x,y\n0,1,2,5\n", "line 2: 4 cells, where the header has 3"),
        ("t,x,y\n0,1,2,\n1,1,z,\n", "line 3: y must be a number, not 'z'"),
        ("t,x,y\nnan,1,2\n", "line 2: t is missing"),
        ('t,x,y\n0,1,"' + 200000 * "9", "field larger than field limit"),
    ],
)
def test_lines_are_named(text, message):
    with pytest.raises(
        ValueError, match=re.escape("the open file, " if "line" in message else "") + message
    ):
        fb.from_csv(io.StringIO(text))


def test_a_file_of_another_kind_is_called_what_it_is(tmp_path, readers):
    plan, path = readers["plan"][1], readers["trajectory"][1]
    for text, instead in (
        (plan, "not a file written by Run.to_csv: a fivebar plan"),
        (path, "not a file written by Run.to_csv: it begins with 't,x,y'"),
        ("", "not a file written by Run.to_csv: it is empty"),
        ("# fivebar run, SI units: {}\n", "not a file written by Run.to_csv: KeyError"),
        (
            "# fivebar run, SI units: " + 10**5 * "[",
            "not a file written by Run.to_csv: RecursionError",
        ),
    ):
        with pytest.raises(ValueError, match=f"line 1: {instead}"):
            fb.Run.from_csv(io.StringIO(text))
    (tmp_path / "it.csv").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    with pytest.raises(ValueError, match="it.csv: not a text file, but a binary one"):
        fb.Run.from_csv(tmp_path / "it.csv")


@pytest.mark.every(4)
@pytest.mark.parametrize("number", [1, 0, None, True, b"x", 2, False, 1.0, ["a"]])
def test_numbers_are_no_files(number, plan):
    """`open` takes them for the caller's own streams, and closes these."""
    a_map, comparison = singularity_map(fb.FiveBar(), shape=(4, 4)), fb.compare({"a": RUN})
    calls = [fb.from_csv, fb.Run.from_csv, fb.Plan.from_csv, Study.from_csv, Map.from_npz]
    calls += [thing.to_csv for thing in (RUN, plan, STUDY, a_map)] + [a_map.to_npz]
    if number is not None:  # of a picture or page: not to be written
        calls += [thing.page for thing in (RUN, STUDY, a_map)] + [
            thing.animate for thing in (RUN, STUDY)
        ]
        calls += [thing.plot for thing in (RUN, plan, STUDY, comparison)]
    streams = [os.fstat(k) for k in (0, 1, 2)]
    for call in calls:
        with pytest.raises(TypeError):
            call(number)
    assert [os.fstat(k)[:3] for k in (0, 1, 2)] == [known[:3] for known in streams]


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "it.csv"
    path.write_text("what was there", encoding="utf-8")

    def rows():
        yield [1.0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tables.write(path, "run", {}, ["t"], rows())
    assert path.read_text("utf-8") == "what was there" and list(tmp_path.iterdir()) == [path]
    link = tmp_path / "link.csv"
    link.symlink_to(path)
    RUN.to_csv(link)
    assert link.is_symlink() and path.read_text("utf-8") == text_of(RUN).replace("\r\n", "\n")
    for missing in (tmp_path / "none" / "it.csv", tmp_path):
        with pytest.raises(OSError, match=re.escape(f"'{missing}'")):
            RUN.to_csv(missing)
    assert sorted(tmp_path.iterdir()) == [path, link]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names on this system")
def test_a_pipe_is_written_and_not_replaced(tmp_path):
    pipe, found = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: found.append(pipe.read_bytes()))
    reader.start()
    RUN.to_csv(pipe)
    reader.join()
    assert (
        pipe.is_fifo() and found == [text_of(RUN).encode()] and list(tmp_path.iterdir()) == [pipe]
    )


# Times that are none, and requests without measure


def test_a_time_that_is_nan_is_refused(plan):
    for motion in (LINE, fb.circle((0, 0.1), 0.02, 1.5), plan):
        with pytest.raises(ValueError, match="t must be a number of seconds, but t is nan"):
            motion(np.nan)
        with pytest.raises(ValueError, match=r"but t\[2\] is nan"):
            motion([0.0, np.inf, np.nan, np.nan])
        with pytest.raises(ValueError, match=r"but t\[1, 0\] is nan"):
            motion([[0.0], [np.nan]])
        same(motion(np.inf)[0], motion(1e9)[0])
    for other in (plan.torques, plan.accelerations, plan.bar_forces):
        with pytest.raises(ValueError, match="t is nan"):
            other(np.nan)


def test_what_would_take_hours_is_refused_at_once():
    turn = 2 * np.pi
    with pytest.raises(
        ValueError, match="window is 300 x 200 turns, .* draw the loci 6e.04 times: at most 100"
    ):
        singularity_map(fb.FiveBar(), space="joint", window=(0, 300 * turn, 0, 200 * turn))
    assert singularity_map(
        fb.FiveBar(), space="joint", window=(0, 10 * turn, 0, 10 * turn), shape=(9, 9)
    ).values.size
    assert singularity_map(
        fb.Biglide(), space="joint", window=(0, 300, 0, 300), shape=(999, 999)
    ).values.size
    with pytest.raises(ValueError, match=r"turns of 361 samples are more than 10\^6 poses"):
        study(FourBar(0.2, 0.06, 0.16, 0.14), turns=1e6)


@pytest.mark.parametrize("show", [3, True, [3], [["tau", 3]], [None]])
def test_what_to_show_is_named(show, tmp_path):
    for write in (
        RUN.animate,
        RUN.page,
        STUDY.page,
        lambda path, show: STUDY.animate(path, show=show),
    ):
        with pytest.raises(TypeError, match="show must be "):
            write(tmp_path / "it.html", show=show)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "use", [lambda file: fb.calibrate(fb.FiveBar(), file), RUN.to_csv, fb.from_log]
)
def test_a_name_that_no_file_may_have_is_said(use):
    with pytest.raises(OSError, match="zero byte in it: 'a.x00.csv'"):
        use("a\0.csv")
