"""The verb `play`: one page that computes, complete in one file."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import DOP853

from ...base.checks import instance, optional
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...linkages import FourBar, SixBarPress, SliderCrank
from ...models.geometry import Pose, dgm, igm
from ...models.named_robots import ROBOTS
from ...models.robots import FiveBar
from ...paths.tool import Tool
from ..document import WebPage, as_json, document, script
from ..style import LEGS, LINKS
from .functions import BEYOND, INERTIAS, LENGTHS, models
from .mechanisms import address_of, digits, mechanisms, straight_lines

if TYPE_CHECKING:
    from ...linkages.motion import Linkage

HERE = Path(__file__).parent
PARTS = (
    "loci regions disc robot pens draw sketch motion fragment five hands five_controls guide"
    " linkage bench bench_controls bench_hands start"
).split()


@dataclass(frozen=True, eq=False)
class LivePage(WebPage):
    """The live page of a robot in a pose, or of a linkage; in a notebook it shows itself, `save`
    writes its file.

    fragment: what follows the page's address, "#...": any live page shows the same with it.
    """

    subject: FiveBar | Linkage
    pose: Pose | None
    fragment: str
    tool: Tool | None = None
    title = "live page"

    def __repr__(self) -> str:
        words = self.subject.words if isinstance(self.subject, FiveBar) else self.subject
        return one_line("Live page", words.title, self.fragment)

    @property
    def html(self) -> str:
        """The page, complete."""
        if self.pose is not None:
            content = _content(self.subject, self.pose, "", self.tool)
            return _page(as_json(content), "Five-bar, live")
        content = _content(FiveBar(), _start(FiveBar()), self.fragment)
        return _page(as_json(content), "Linkage, live")  # its script says which


@takes_robot(
    FourBar, SliderCrank, SixBarPress, pose=optional(instance(Pose)), tool=optional(instance(Tool))
)
def play(
    robot: FiveBar | Linkage | None = None,
    pose: Pose | None = None,
    branch: int | tuple[int, int] | None = None,
    tool: Tool | None = None,
) -> LivePage:
    """Return the live page of a five-bar or a linkage: drag it, and slide its lengths.

    One file for any browser, without a network. It computes with these models, written out in
    JavaScript; the exact singularity loci follow.

    Parameters
    ----------
    robot : FiveBar or linkage, optional
        The AMORO robot by default. Dry friction is left out there; the ground of a linkage is laid
        on the x axis.
    pose : Pose, optional
        In which the robot begins; one far from singularities by default.
    branch : int or tuple of int, optional
        Of a linkage.
    tool : Tool, optional
        On a distal bar of the robot: it is drawn, and the trace is its. Loci and aspects are those
        of joint C.

    Returns
    -------
    LivePage
        It shows itself in a notebook; `save` writes its file.

    Raises
    ------
    ValueError
        For a pose that is another robot's, no single one, or at a singularity, and for a linkage
        that the page does not have.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> fb.play(robot, fb.dgm(robot, (0.0, 0.0))).pose.q
    array([0., 0.])
    """
    if robot is not None and not isinstance(robot, FiveBar):
        if pose is not None or tool is not None:
            what = "tool" if pose is None else "pose"
            raise ValueError(f"{what} is a robot's: with a {robot.title} leave it out")
        return LivePage(robot, None, address_of(robot, branch))
    if branch is not None:
        raise ValueError("branch is a linkage's: a robot's pose says its modes")
    if robot is None:
        robot = FiveBar() if pose is None else pose.robot
    if pose is None:
        pose = _start(robot)
    elif pose.robot != robot:
        raise ValueError(f"pose is of another robot: {pose.robot}, not {robot}")
    if pose.xi.shape != (2,) or not np.isfinite(pose.det_A) or not all(pose.working):
        raise ValueError("pose must be a single one that closes, away from Type 1")
    subject: Any = robot
    return LivePage(subject, pose, _fragment(subject, pose, tool), tool)


def _fragment(robot, pose, tool):
    numbers = {name: getattr(robot, name) for name in (*LENGTHS, *INERTIAS)}
    numbers |= dict(zip(("gx", "gy", "x", "y"), (*robot.gravity, *pose.xi.tolist())))
    numbers |= {name: x for name in BEYOND if name != "gravity" and (x := getattr(robot, name))}
    numbers |= {} if tool is None else asdict(tool)
    signs = "".join("+" if mode > 0 else "-" for mode in pose.working)
    return f"#{'&'.join(f'{name}={digits(x)}' for name, x in numbers.items())}&working={signs}"


def _content(robot, pose, opening, tool=None):
    return {
        "opening": opening,
        "presets": _presets(),
        "kinds": mechanisms()[1],
        "legs": LEGS[:2],
        "links": LINKS,
        "straight": straight_lines(),
        **_parameters(robot, pose, tool),
    }


@lru_cache(maxsize=1)
def _presets():
    presets = {}
    for name, known in ROBOTS.items():
        if known.robot.turns:
            tool = Tool(**known.tables["tool"]) if "tool" in known.tables else None
            presets[name] = _parameters(known.robot, _start(known.robot), tool)
            presets[name]["source"] = known.source
    return presets


def _parameters(robot, pose, tool):
    scalars = (*LENGTHS, *INERTIAS, *BEYOND)
    values = {name: getattr(robot, name) for name in scalars if name != "gravity"}
    values |= {"gravity": list(robot.gravity), "dry": bool(robot.fs1 or robot.fs2), "leg": 0}
    values |= {} if tool is None else asdict(tool)
    size = sum(values[name] for name in LENGTHS)
    digit = 10 ** np.floor(np.log10(size / 5))
    return {
        "robot": values,
        "xi": pose.xi.tolist(),
        "working": pose.working.tolist(),
        "wanted": float(digit * np.round(size / 5 / digit)),
    }


def _start(robot):
    """Return a pose far from singularities, in the lab's modes where they can be."""
    best, found = -1.0, None
    q = np.stack(np.meshgrid(*[np.linspace(-np.pi, np.pi, 61)[:-1]] * 2), axis=-1).reshape(-1, 2)
    for assembly in (-1, 1):
        pose = dgm(robot, q, assembly, unreachable="nan")
        margin = np.minimum(np.abs(np.stack(pose.sines)).min(axis=0), np.abs(pose.det_A))
        above = np.where((pose.working == -1).all(axis=-1) & (pose.xi[:, 1] > 0), 1.0, 0.8)
        score = np.nan_to_num(margin * above, nan=-1.0)
        k = int(score.argmax())
        if score[k] > best:
            best = score[k]
            found = igm(robot, pose.xi[k], pose.working[k])
    return found


@lru_cache(maxsize=4)
def _page(content, title):
    """Return the page around this JSON; the browser runs only scripts of these very texts, and a
    worker that the page makes of the first.
    """
    computing = _models()
    code = f"\n{script(HERE.parent, 'parts')}\n{script(HERE, *PARTS)}\n"
    policy = f"{_hash(computing)} {_hash(code)}; worker-src blob:"
    return document(HERE, title, policy, content=content, models=computing, code=code)


def _models():
    """Return the script of all models and of the integration by DOP853, whose table it holds."""
    table = {name: getattr(DOP853, name).tolist() for name in ("A", "B", "C", "E3", "E5")}
    constant = f'"use strict";\nconst DOP853 = {as_json(table)};'
    return f"\n{constant}\n{models()}\n{script(HERE, 'integration')}\n"


def _hash(text):
    digest = hashlib.sha256(text.encode()).digest()
    return f"'sha256-{b64encode(digest).decode()}'"
