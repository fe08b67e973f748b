"""Exact derivatives of a plan's nonlinear program, by those of one interval."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.sparse import csc_array, csr_array


def differentiated(z: ca.SX, nodes: list, outputs: list, result: ca.SX) -> tuple:
    """Return functions of an interval: z -> result; z -> its Jacobian, without the last row; z ->
    this row; (z, weights) -> the Hessian of the weighted results.

    nodes: (function, its input by z) at points that do not touch one another, which CasADi does not
    know: it would take three times as long. outputs: symbols that stand for what these functions
    return in `result`.
    """
    y = ca.vertcat(*outputs)
    weights = ca.SX.sym("weights", result.numel())
    by_both, gradient = ca.hessian(ca.dot(weights, result), ca.vertcat(z, y))
    expressions = [result, ca.jacobian(result, z), ca.jacobian(result, y), by_both, gradient]
    values = ca.vertcat(*(function(place) for function, place in nodes))
    value, by_z, by_y, by_both, gradient = ca.substitute(expressions, [y], [values])
    slopes = []
    hessian = ca.SX(z.numel(), z.numel())
    parts = ca.vertsplit(gradient[z.numel() :], np.cumsum([0, *map(ca.SX.numel, outputs)]).tolist())
    for (function, place), weight in zip(nodes, parts):
        slope, bend = _derivatives(function)
        along = ca.jacobian(place, z)
        slopes.append(slope(place) @ along)
        force = ca.SX.sym("force", place.numel())
        curved, _ = ca.hessian(ca.dot(force, place), z)
        hessian += along.T @ bend(place, weight) @ along
        hessian += ca.substitute(curved, force, ca.densify(slope(place).T @ weight))
    total = ca.vertcat(ca.SX.eye(z.numel()), *slopes)
    hessian += total.T @ by_both @ total
    jacobian = by_z + by_y @ total[z.numel() :, :]
    return (
        ca.Function("value", [z], [value]),
        ca.Function("slope", [z], [jacobian[:-1, :]]),
        ca.Function("gradient", [z], [jacobian[-1, :]]),
        ca.Function("bend", [z, weights], [hessian]),
    )


def _derivatives(function):
    """Return functions of the Jacobian, and of the Hessian of the weighted outputs."""
    z = ca.SX.sym("z", function.numel_in(0))
    outputs = function(z)
    weight = ca.SX.sym("weight", outputs.numel())
    jacobian = ca.jacobian(outputs, z)
    hessian, _ = ca.hessian(ca.dot(weight, outputs), z)
    options = {"cse": True}
    return (
        ca.Function("slope", [z], [jacobian], options),
        ca.Function("bend", [z, weight], [hessian], options),
    )


def program_of(functions: tuple, inputs: csr_array, rows: csr_array) -> tuple:
    """Return (nonlinear program, options with its derivatives), as of CasADi's `nlpsol`.

    functions: of an interval, as of `differentiated`. For variables x, the intervals' inputs are
    z = inputs x, and the objective and below it the constraints are rows (y, x), for all intervals'
    results y.
    """
    value, slope, gradient, bend = functions
    variables = inputs.shape[1]
    to_intervals = _constant(inputs)
    by_results, linear = _constant(rows[:, :-variables]), _constant(rows[:, -variables:])
    width = value.numel_out(0)
    count = by_results.size2() // width
    x = ca.MX.sym("x", variables)
    p = ca.MX.sym("p", 0)
    weights = ca.MX.sym("f"), ca.MX.sym("g", rows.shape[0] - 1)
    z = ca.reshape(to_intervals @ x, -1, count)

    def blocks(function, *given):
        """Return a function's matrices of all intervals as the blocks of one, on its diagonal."""
        each = function.map(count)(z, *given)
        return ca.MX(ca.diagcat(*[function.sparsity_out(0)] * count), ca.vec(each.nz[:]))

    values = by_results @ ca.vec(value.map(count)(z)) + linear @ x
    by_slopes = by_results[1:, [k for k in range(by_results.size2()) if (k + 1) % width]]
    grad_f = by_results[0, width - 1 :: width] @ blocks(gradient) @ to_intervals + linear[0, :]
    jac_g = by_slopes @ blocks(slope) @ to_intervals + linear[1:, :]
    forces = ca.reshape(by_results.T @ ca.vertcat(*weights), -1, count)
    hessian = to_intervals.T @ blocks(bend, forces) @ to_intervals
    objective, constraints = ca.vertsplit(values, [0, 1, rows.shape[0]])
    given = {"x": x, "p": p}
    lagrangian = given | dict(zip(["lam_f", "lam_g"], weights))
    found = {
        "grad_f": (given, {"f": objective, "grad_f_x": ca.densify(grad_f.T)}),
        "jac_g": (given, {"g": constraints, "jac_g_x": jac_g}),
        "hess_lag": (lagrangian, {"triu_hess_gamma_x_x": ca.triu(hessian)}),
    }
    options = {
        name: ca.Function(name, [*a.values()], [*b.values()], [*a], [*b])
        for name, (a, b) in found.items()
    }
    return {"x": x, "f": objective, "g": constraints}, options


def _constant(matrix):
    """Return a sparse matrix of SciPy as one of CasADi."""
    matrix = csc_array(matrix)
    matrix.sort_indices()
    sparsity = ca.Sparsity(*matrix.shape, matrix.indptr.tolist(), matrix.indices.tolist())
    return ca.DM(sparsity, matrix.data)
