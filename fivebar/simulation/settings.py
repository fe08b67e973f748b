"""How a robot is simulated: what its controller gets, and how its motion is integrated."""

from __future__ import annotations

from dataclasses import dataclass

from ..base.checks import jit as must_be_jit
from ..base.checks import one_of, optional, positive, whole
from ..models.charts import CHARTS
from .steps import METHODS

MOST_DELAY = 10_000  # samples: beyond, a number is a mistake
LEAST_TOLERANCE = 1e-12  # rad: below, a step's error is rounding


@dataclass(frozen=True)
class Measurement:
    """What the controller gets of the motion in `simulate`.

    Parameters
    ----------
    delay : int
        Samples between a measurement and the torque computed from it. The torque is 0 until then.
    encoder_resolution : float, optional
        Step of the encoders, rad (biglide: m). The controller then gets rounded joint angles, and
        their differences as velocities. None: exact values.

    Examples
    --------
    >>> import math
    >>> import fivebar as fb
    >>> fb.Measurement(delay=1, encoder_resolution=2 * math.pi / 4096).delay
    1
    """

    delay: int = 0
    encoder_resolution: float | None = None

    def __post_init__(self) -> None:
        whole(0, MOST_DELAY)(self.delay, "Measurement: delay")
        optional(positive)(self.encoder_resolution, "Measurement: encoder_resolution")


@dataclass(frozen=True)
class Integrator:
    """How `simulate` integrates the motion.

    Parameters
    ----------
    method : None, "rk4" or "dop8"
        None: Dormand and Prince's method of order 8, whose steps are as long as their error
        allows. "rk4", "dop8": fixed steps, of order 4 or 8. `simulate_many` has fixed steps only;
        None is "rk4" there.
    chart : "auto", "task" or "joint"
        The coordinates that are integrated. "auto": the angles of the four bars, which are regular
        at every singularity. "task" (x, y) and "joint" (q1, q2): by fixed steps, faster, regular
        away from Type 1 and Type 2 singularities, where they raise SingularityError.
    tolerance : float, optional
        rad, at least 1e-12. The motion is computed twice, the second time with finer steps; their
        largest difference of q is `Run.step_error`, at least the tolerance of a finer step. It
        bounds the error of the motion that you get. None: the error of each step is below 1e-12
        rad.
    jit : bool or "auto"
        Compile the steps to machine code, as `compile` does, once for all motions of the process.
        "auto": from the second motion of such a robot on, where there is a C compiler.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.Integrator("rk4", chart="task")
    Integrator(method='rk4', chart='task', tolerance=None, jit=False)
    """

    method: str | None = None
    chart: str = "auto"
    tolerance: float | None = None
    jit: bool | str = False

    def __post_init__(self) -> None:
        one_of(None, *METHODS)(self.method, "Integrator: method")
        one_of(*CHARTS)(self.chart, "Integrator: chart")
        must_be_jit(self.jit, "Integrator: jit")
        if self.tolerance is None:
            return
        if positive(self.tolerance, "Integrator: tolerance") < LEAST_TOLERANCE:
            raise ValueError(
                f"Integrator: tolerance = {self.tolerance:g} is below rounding: at least"
                f" {LEAST_TOLERANCE:g}"
            )
        if self.fixed:
            raise ValueError(
                'Integrator: tolerance chooses the steps: it goes with method=None and chart="auto"'
            )

    @property
    def fixed(self) -> bool:
        """Whether all steps have one length."""
        return self.method is not None or self.chart != "auto"
