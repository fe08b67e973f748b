"""Exact derivatives of a plan's nonlinear program, by those of one interval."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array


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
    width = value.numel_out(0)
    variables = inputs.shape[1]
    by_result, linear = rows[:, :-variables], rows[:, -variables:]
    count = by_result.shape[1] // width
    x = ca.MX.sym("x", variables)
    p = ca.MX.sym("p", 0)
    weights = ca.MX.sym("f"), ca.MX.sym("g", rows.shape[0] - 1)
    z = ca.reshape(_constant(inputs) @ x, -1, count)
    results = ca.vec(value.map(count)(z))
    objective, constraints = ca.vertsplit(
        _constant(by_result) @ results + _constant(linear) @ x, [0, 1, rows.shape[0]]
    )
    costs = np.arange(width - 1, width * count, width)
    others = np.delete(np.arange(width * count), costs)

    def assembled(function, left, right, constant, *given):
        blocks = function.map(count)(z, *given)
        return _assembled(
            ca.vec(blocks.nz[:]), function.sparsity_out(0), count, left, right, constant
        )

    grad_f = assembled(gradient, by_result[:1, costs].T, inputs, linear[:1])
    jac_g = assembled(slope, by_result[1:, others].T, inputs, linear[1:])
    by_results = ca.reshape(_constant(by_result.T) @ ca.vertcat(*weights), -1, count)
    none = csr_array((variables, variables))
    hessian = assembled(bend, inputs, inputs, none, by_results)
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


def _assembled(blocks, sparsity, count, left, right, constant):
    """Return left^T B right + constant, sparse; blocks: the entries of all blocks of B, which lie
    on its diagonal and have one sparsity.
    """
    k = np.arange(count)[:, None]
    i, j = map(np.array, sparsity.get_triplet())
    entry, row, factor = _rows(left, (k * sparsity.size1() + i).ravel())
    again, column, other = _rows(right, (k * sparsity.size2() + j).ravel()[entry])
    entry, row, factor = entry[again], row[again], factor[again] * other
    fixed = constant.tocoo()
    height = left.shape[1]
    place = np.append(column, fixed.col) * height + np.append(row, fixed.row)
    place, number = np.unique(place, return_inverse=True)
    ours, theirs = np.split(number, [len(entry)])
    sums = coo_array((factor, (ours, entry)), shape=(len(place), blocks.numel()))
    offset = np.bincount(theirs, fixed.data, len(place))
    columns, rows = np.divmod(place, height)
    pattern = ca.Sparsity.triplet(height, right.shape[1], rows.tolist(), columns.tolist())
    return ca.MX(pattern, _constant(sums) @ blocks + offset)


def _rows(matrix, which):
    """Return (number among which, column, value) of all entries of some rows of a matrix."""
    matrix = matrix.tocsr()
    counts = np.diff(matrix.indptr)[which]
    number = np.repeat(np.arange(len(which)), counts)
    before = np.cumsum(counts) - counts
    place = matrix.indptr[which][number] + np.arange(len(number)) - before[number]
    return number, matrix.indices[place].astype(int), matrix.data[place]
