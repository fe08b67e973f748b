"""Which QP solver the tracker ships: solvers x time x success on its own problems, and its step's time.

`python -m tests.benchmarks.qp_solvers [--quick]`. Times are of this machine now: read the ratios to the first row. A
solver fails when it says so; it fails silently when it reports success and its solution is not optimal.
"""

import sys
import time

import casadi as ca
import numpy as np

import fivebar as fb
from fivebar.control.prediction import SIZE
from fivebar.control.qp import TOLERANCE, optimality
from fivebar.control.tracker import Tracker
from fivebar.study.control_cases import HOME, TASK_2, case
from fivebar.study.speed_accuracy.charts.trackers import SOLVERS

CONDENSED = "daqp", "qrqp", "qpoases", "osqp", "proxqp", "piqp", "ipqp", "highs"
W, Z = SIZE + 2, SIZE + 4  # of a stage in states and torques: without and with its own torque
SPARSE = "hpipm", "qrqp", "osqp", "piqp", "daqp"  # HPIPM has no dense form in CasADi


def problems(quick):
    """{kind: [(arguments of the condensed QP, arguments of the condenser, condenser), ...]} from closed loops."""
    limited = case("torque-limit")
    rest, singular = {1: (0, 0), 2: (0, 0)}, (0.0525327138758270, 0.00430328475849708)
    midway = {
        0: singular,
        1: (-0.0253611967131164, -0.0430907147919202),
        2: (0, 0),
    }  # the crossing criterion is met
    crossing = fb.polynomial([(0.0, {0: HOME, **rest}), (2.0, midway), (4.0, {0: TASK_2, **rest})])
    robot, every = fb.FiveBar(), 10 if quick else 1
    limit = limited.torque_limit
    kinds = {
        "torque limit 60 %": (limited.reference, fb.Constraints(torque=limit)),
        "crossing": (crossing, fb.Constraints(torque=0.05)),
        "speed limit": (limited.reference, fb.Constraints(torque=0.1, joint_speed=1.0)),
    }
    return {name: _collect(robot, *what)[::every] for name, what in kinds.items()}


def _collect(robot, reference, constraints):
    tracker, found, parts = Tracker(robot, constraints=constraints), [], []
    solve, condense = tracker.qp, tracker.condense

    def watch_condenser(*arguments):
        parts.append([None if a is None else np.array(a) for a in arguments])
        return condense(*arguments)

    def watch_solver(*arguments):
        found.append(([np.array(a) for a in arguments], parts[-1], condense))
        return solve(*arguments)

    # The condenser's matrices are used under its own name too, by the speed limit.
    watch_condenser.G = condense.G
    tracker.condense, tracker.qp = watch_condenser, watch_solver
    fb.simulate(robot, tracker, reference, torque_limit=constraints.torque[0])
    return found


def condensed(problem):
    """Shapes, HPIPM's options, arguments of the dense QP in the torques, and what of a result is (v, rows' forces)."""
    (H, g, rows, upper, low, high), _, _ = problem
    shapes = {"h": ca.Sparsity.dense(*H.shape), "a": ca.Sparsity.dense(*rows.shape)}
    none, zero, empty = np.full(len(upper), -np.inf), np.zeros(len(g)), np.zeros(0)
    arguments = H, g, rows.T, none, upper, low, high, zero, zero, np.zeros(len(upper)), empty, empty
    return shapes, {}, arguments, lambda result: (result[0], result[2])


def sparse(problem):
    """The same for the QP in states and torques: stages of (state's deviation (8), torque before (2)), torque (2)."""
    (_, _, _, _, low, high), (_, _, AB, _, previous, guess, _), condenser = problem
    N, scale = len(AB), condenser.known[0, SIZE, 0]
    H, g = _sparse_cost(problem)
    A, b = np.zeros((W * N, len(g))), np.zeros(W * N)
    lower, upper = np.full(len(g), -np.inf), np.full(len(g), np.inf)
    used = np.zeros(H.shape, bool), np.zeros(A.shape, bool)
    for k in range(N):
        rows, stage, after = (
            slice(W * k, W * k + W),
            slice(Z * k, Z * k + Z),
            slice(Z * k + Z, Z * k + Z + W),
        )
        F = np.zeros((W, Z))
        F[:SIZE, :SIZE], F[:SIZE, W:], F[SIZE:, W:] = (
            AB[k, :, :SIZE],
            scale * AB[k, :, SIZE:],
            np.eye(2),
        )
        A[rows, stage], A[rows, after] = F, -np.eye(W)
        b[W * k : W * k + SIZE] = F[:SIZE, W:] @ guess[2 * k : 2 * k + 2]
        lower[Z * k + W : Z * k + Z], upper[Z * k + W : Z * k + Z] = (
            low[2 * k : 2 * k + 2],
            high[2 * k : 2 * k + 2],
        )
        used[0][stage, stage], used[1][rows, stage], used[1][rows, after] = True, True, np.eye(W)
    used[0][Z * N :, Z * N :] = True
    # The first state is known: its columns go to the right sides.
    first = np.array([*np.zeros(SIZE), *previous])
    g, b, lower, upper = (g + H[:, :W] @ first)[W:], b - A[:, :W] @ first, lower[W:], upper[W:]
    H, A, used = H[W:, W:], A[:, W:], (used[0][W:, W:], used[1][:, W:])
    shapes = {
        name: ca.sparsify(ca.DM(mask.astype(float))).sparsity() for name, mask in zip("ha", used)
    }
    zero, torques = np.zeros(len(g)), np.array([[Z * k, Z * k + 1] for k in range(N)]).ravel()
    arguments = (
        H.T[used[0].T],
        g,
        A.T[used[1].T],
        b,
        b,
        lower,
        upper,
        zero,
        zero,
        np.zeros(W * N),
        zero[:0],
        zero[:0],
    )
    options = {"N": N, "nx": [0] + [W] * N, "nu": [2] * N + [0], "ng": [0] * (N + 1)}
    return shapes, options, arguments, lambda result: (result[0][torques], zero[:0])


def _sparse_cost(problem):
    """H and g of the residuals of `Condenser`, by stages."""
    _, (e0, e, AB, C, _, guess, _), condenser = problem
    N, scale = len(AB), condenser.known[0, SIZE, 0]
    outputs, errors = [0 * C[0], *C], [e0, *e]
    H, g = np.zeros((Z * N + W, Z * N + W)), np.zeros(Z * N + W)

    def add(columns, rows, offset):
        H[columns, columns] += rows.T @ rows
        g[columns] += rows.T @ offset

    for k in range(N):
        C, weight = outputs[k + 1], condenser.acceleration[k, 0]
        change = np.zeros((2, Z))
        change[:, :SIZE] = C[2:] @ AB[k, :, :SIZE] - outputs[k][2:]
        change[:, W:] = scale * C[2:] @ AB[k, :, SIZE:]
        offset = errors[k + 1][2:] - errors[k][2:] - change[:, W:] @ guess[2 * k : 2 * k + 2]
        add(slice(Z * k, Z * k + Z), weight * change, weight * offset)
        add(
            slice(Z * k + SIZE, Z * k + Z),
            np.sqrt(condenser.first) * np.hstack([np.eye(2), -np.eye(2)]),
            np.zeros(2),
        )
        if k:
            weight = condenser.position[k - 1, 0]
            add(slice(Z * k, Z * k + SIZE), weight * outputs[k][:2], weight * errors[k][:2])
    add(slice(Z * N, Z * N + SIZE), condenser.terminal @ outputs[N], condenser.terminal @ errors[N])
    return H, g


class Call:
    """A casadi.Function called through buffers of its nonzeros."""

    def __init__(self, function):
        self.buffer, self.run = function.buffer()
        self.inputs = [np.empty(function.nnz_in(k)) for k in range(function.n_in())]
        self.outputs = [np.empty(function.nnz_out(k)) for k in range(function.n_out())]
        for arrays, connect in (
            (self.inputs, self.buffer.set_arg),
            (self.outputs, self.buffer.set_res),
        ):
            for k, array in enumerate(arrays):
                connect(k, memoryview(array))

    def __call__(self, *arguments):
        for array, value in zip(self.inputs, arguments):
            array[:] = np.ravel(value)
        self.run()
        return self.outputs


def trial(solver, form, found):
    """Microseconds of each call, each begun at the last one's solution; how many failed, and failed silently; the
    largest residual among those that the solver calls solved."""
    times, failed, silent, worst, call, last = [], 0, 0, 0.0, None, None
    for problem in found:
        shapes, options, arguments, read = form(problem)
        if call is None or solver == "hpipm":
            # HPIPM called again through the same buffers repeats its first answer (CasADi 3.8.2): a new one each time.
            structure = options if solver == "hpipm" else {}
            conic = ca.conic(
                "qp",
                solver,
                shapes,
                {"error_on_fail": False, **SOLVERS.get(solver, {}), **structure},
            )
            call = Call(conic)
            if solver != "hpipm":
                call(*arguments)  # set up
        if last is not None:
            arguments = (*arguments[:7], *last, *arguments[10:])
        before = time.perf_counter()
        x, _, lam_a, lam_x = result = call(*arguments)
        times.append(1e6 * (time.perf_counter() - before))
        notes, residual = call.buffer.stats()["success"], optimality(*problem[0], *read(result))
        if notes:
            silent, worst = silent + (not residual <= TOLERANCE), max(worst, residual)
        failed += not notes
        last = (x.copy(), lam_x.copy(), lam_a.copy()) if notes and np.isfinite(residual) else None
    return times, failed, silent, worst


def steps(jit, quick):
    """Microseconds of the tracker's steps, task 1."""
    chosen = case("task-1")
    tracker = Tracker(chosen.model, jit=jit)
    times = []
    for _ in range(1 if quick else 5):
        chosen.simulate(tracker)
        times.append(1e6 * tracker.log.solve_time[5:])
    return min(times, key=np.median)


def main(quick=False):
    """Print both tables."""
    for kind, found in problems(quick).items():
        print(
            f"\n{kind}: {len(found)} problems, {len(found[0][0][1])} unknowns, {len(found[0][0][3])} rows"
        )
        print(
            f"{'solver':<19}{'median us':>9}{'99 % us':>9}{'ratio':>7}{'failed':>8}{'silently':>10}{'residual':>10}"
        )
        first = None
        rows = len(found[0][0][3])
        for form, solvers in ((condensed, CONDENSED), (sparse, () if rows else SPARSE)):
            for solver in solvers:
                if (
                    rows and solver == "ipqp"
                ):  # its factorization fails in two of three, a warning in each iteration
                    continue
                times, failed, silent, worst = trial(solver, form, found)
                middle, slow = np.median(times), np.percentile(times, 99)
                first = first or middle
                print(
                    f"{solver + ' ' + form.__name__:<19}{middle:9.0f}{slow:9.0f}{middle / first:7.1f}"
                    f"{failed:8d}{silent:10d}{worst:10.0e}"
                )
    print(
        "\nstep of the tracker, N = 20, 10 ms (bounds: 350 us median, 800 us 99 %; compiled 150 us)"
    )
    for name, jit in (("virtual machine", False), ("compiled", True)):
        try:
            times = steps(jit, quick)
        except RuntimeError as error:
            print(f"{name}: {error}")
            continue
        print(
            f"{name:<18}median {np.median(times):.0f} us, 99 % below {np.percentile(times, 99):.0f} us"
        )


if __name__ == "__main__":
    main("--quick" in sys.argv)
