"""Exact derivatives of a plan's nonlinear program, by those of one function at all its points."""

from __future__ import annotations

import casadi as ca
import numpy as np


class Derivatives:
    """Objective and constraints of a program, and their first and second derivatives.

    They are found by those of `point` at its own inputs alone. CasADi, which does not know that
    points do not touch one another, would take three times as long.

    point: (inputs of a point) -> outputs, (r, 1) each; at_points: the inputs at all points,
    (r, points) each, among the variables; outputs: symbols (r, points) each that stand for the
    outputs there; objective and constraints: by variables and outputs.
    """

    def __init__(self, point, variables, at_points, outputs, objective, constraints):
        count = at_points[0].shape[1]
        x = ca.vertcat(*map(ca.vec, variables))
        y = ca.vertcat(*map(ca.vec, outputs))
        columns = _places(variables, count, [_is_among(each, at_points) for each in variables])
        rows = _places(outputs, count)
        slope, bend = _at_one_point(point)
        inputs = ca.vertcat(*at_points)
        self.outputs = point.map(count)(*at_points)
        w = ca.vertcat(x, y)
        at = ca.vertcat(x, *map(ca.vec, self.outputs))
        program = ca.Function("program", [w], [objective, constraints], ["w"], ["f", "g"])
        self.objective, self.constraints = program(at)
        # w = (x, y(x)) and its derivatives by x.
        slopes = _scattered(
            slope.map(count)(inputs), slope.sparsity_out(0), rows, columns, (y.numel(), x.numel())
        )
        total = ca.vertcat(ca.MX.eye(x.numel()), slopes)
        first = program.factory("first", ["w"], ["g", "jac:g:w"])
        g, g_w = first(at)
        # The Lagrangian, whose second derivatives are those of the program by w and, weighted by
        # its first ones, those of the outputs.
        weights = ca.MX.sym("f"), ca.MX.sym("g", g.numel())
        second = program.factory(
            "second",
            ["w", "lam:f", "lam:g"],
            ["grad:gamma:w", "hess:gamma:w:w"],
            {"gamma": ["f", "g"]},
        )
        gamma_w, gamma_ww = second(at, *weights)
        of_outputs = (x.numel() + rows.ravel()).tolist()
        adjoint = ca.reshape(gamma_w[of_outputs], rows.shape[1], count)
        bends = _scattered(
            bend.map(count)(inputs, adjoint),
            bend.sparsity_out(0),
            columns,
            columns,
            (x.numel(),) * 2,
        )
        hessian = total.T @ gamma_ww @ total + bends
        none = ca.MX.sym("p", 0)
        self.options = {
            "jac_g": ca.Function(
                "jac_g", [x, none], [g, g_w @ total], ["x", "p"], ["g", "jac_g_x"]
            ),
            "hess_lag": ca.Function(
                "hess_lag",
                [x, none, *weights],
                [ca.triu(hessian)],
                ["x", "p", "lam_f", "lam_g"],
                ["triu_hess_gamma_x_x"],
            ),
        }


def _at_one_point(point):
    """Return the functions of a point's Jacobian, and of the Hessian of its weighted outputs."""
    symbols = []
    for k in range(point.n_in()):
        symbols.append(ca.SX.sym(f"z{k}", point.numel_in(k)))
    z = ca.vertcat(*symbols)
    outputs = ca.vertcat(*point(*symbols))
    weight = ca.SX.sym("weight", outputs.numel())
    jacobian = ca.jacobian(outputs, z)
    hessian, _ = ca.hessian(ca.dot(weight, outputs), z)
    return (ca.Function("slope", [z], [jacobian]), ca.Function("bend", [z, weight], [hessian]))


def _is_among(symbol, symbols):
    # == of symbols is another symbol.
    return any(symbol is each for each in symbols)


def _places(matrices, count, own=None):
    """Return where the entries of each point are among all, (points, entries)."""
    first = 0
    found = []
    for k, matrix in enumerate(matrices):
        if own is None or own[k]:
            height = matrix.shape[0]
            columns = np.arange(count)[:, None] * height
            found.append(first + columns + np.arange(height))
        first += matrix.numel()
    return np.concatenate(found, axis=1)


def _scattered(blocks, sparsity, rows, columns, shape):
    """Return a sparse matrix of the blocks of all points, side by side in `blocks`."""
    i, j = map(np.array, sparsity.get_triplet())
    pattern, order = ca.Sparsity.triplet(
        *shape, rows[:, i].ravel().tolist(), columns[:, j].ravel().tolist(), False
    )
    return ca.MX(pattern, blocks.nz[:][order])
