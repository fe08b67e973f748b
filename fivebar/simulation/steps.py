"""Compiled steps of the plant: its right side in a chart, what it says of itself, and Runge-Kutta on it.

The right side is a CasADi function made from the same equations as everything else. Beside the slope it gives what the
state says of itself (angles, end-effector, singular margins and their rates, energy).
"""

from functools import lru_cache

from ..models.dynamics import energy, forward_dynamics

# Columns of an observation.
Q, Q_DOT, XI, XI_DOT, MARGINS, MARGIN_RATES, ENERGY = (
    slice(0, 2), slice(2, 4), slice(4, 6), slice(6, 8), slice(8, 11), slice(11, 14), 14,
)  # fmt: skip
COLUMNS = 15
METHODS = ("rk4", "dop8")


@lru_cache(maxsize=64)
def model_functions(robot, chart):
    """(state, tau, modes) -> (slope, observation), and (state, modes) -> observation."""
    import casadi

    state, tau, modes = casadi.SX.sym("state", 4), casadi.SX.sym("tau", 2), casadi.SX.sym("modes", 2)
    rates = chart.rates(robot, (state[0], state[1]), (state[2], state[3]), (modes[0], modes[1]))
    slope = casadi.vertcat(state[2], state[3], *chart.accelerations(forward_dynamics(rates, tau)))
    slope, seen = casadi.cse([slope, _observation(rates)])
    return casadi.Function("model", [state, tau, modes], [slope, seen]), casadi.Function("look", [state, modes], [seen])


@lru_cache(maxsize=64)
def block_function(robot, chart, method, step, count):
    """(state, tau, modes) -> (states after each of `count` steps, what is seen before each, and after the last)."""
    import casadi

    one, look = step_function(robot, chart, method, step), model_functions(robot, chart)[1]
    state, tau, modes = casadi.MX.sym("state", 4), casadi.MX.sym("tau", 2), casadi.MX.sym("modes", 2)
    held = casadi.repmat(tau, 1, count), casadi.repmat(modes, 1, count)
    states, rows = one.mapaccum(count)(state, *held)
    return casadi.Function("block", [state, tau, modes], [states, rows, look(states[:, -1], modes)])


@lru_cache(maxsize=64)
def step_function(robot, chart, method, step):
    """(state, tau, modes) -> (state after one step under a held torque, what is seen before it)."""
    import casadi

    model, _ = model_functions(robot, chart)
    state, tau, modes = casadi.SX.sym("state", 4), casadi.SX.sym("tau", 2), casadi.SX.sym("modes", 2)
    first, seen = model(state, tau, modes)
    after = runge_kutta(method, step, state, lambda stage, _: first if stage is state else model(stage, tau, modes)[0])
    return casadi.Function("step", [state, tau, modes], [after, seen])


def propagate(robot, chart, modes, method, step, count, torque):
    """(state) -> state after `count` steps from t = 0 under torque(t), read at every stage: the plant alone.

    torque: t -> (tau1, tau2), with CasADi's functions. chart, modes: as in models.charts. For the shortest time to a
    given accuracy: nothing else is computed.
    """
    import casadi

    model, _ = model_functions(robot, chart)
    state, t = casadi.SX.sym("state", 4), casadi.SX.sym("t")

    def slope(stage, fraction):
        return model(stage, casadi.vertcat(*torque(t + fraction * step)), list(modes))[0]

    one = casadi.Function("step", [state, t], casadi.cse([runge_kutta(method, step, state, slope)]))
    start = casadi.MX.sym("state", 4)
    return casadi.Function("propagate", [start], [one.fold(count)(start, step * casadi.DM(range(count)).T)])


def runge_kutta(method, step, state, slope):
    """The state one explicit Runge-Kutta step later; slope(stage's state, its fraction of the step)."""
    a, b, c = tableau(method)
    slopes = []
    for row, fraction in zip(a, c):
        stage = state
        for weight, k in zip(row, slopes):
            if weight:
                stage = stage + step * weight * k
        slopes.append(slope(stage, fraction))
    return state + step * sum(weight * k for weight, k in zip(b, slopes) if weight)


def tableau(method):
    """Butcher's a, b, c as lists of floats: the classical RK4, or Dormand and Prince's of order 8 (from SciPy)."""
    if method == "rk4":
        a = [[], [1 / 2], [0, 1 / 2], [0, 0, 1]]
        return a, [1 / 6, 1 / 3, 1 / 3, 1 / 6], [0, 1 / 2, 1 / 2, 1]
    from scipy.integrate import DOP853

    return DOP853.A.tolist(), DOP853.B.tolist(), DOP853.C.tolist()


def _observation(rates):
    """q, q', xi, xi', the sines (q12, q22, det A), their rates, kinetic energy: in the order of the columns above."""
    import casadi

    pose = rates.pose
    return casadi.vertcat(
        pose.q, rates.q_dot, pose.xi, rates.xi_dot, *pose.sines, pose.det_A, *rates.margin_rates, energy(rates)
    )
