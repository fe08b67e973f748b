"""Independent of the package: a closed chain of four rigid bodies and a payload, not grouped, by Lagrange's equations.

Positions of the bodies are functions of a = (q1, phi1, q2, phi2); CasADi differentiates their energies, NumPy solves
the masses with the closure. Each body is (mass, x along, y across, inertia about its centre of mass).
"""

import casadi
import numpy as np


class FullBodies:
    """cranks: (l11, l21), or None for two feet that slide along y, whose bodies have no inertia of their own."""

    def __init__(
        self,
        cranks,
        bars,
        d,
        bodies,
        payload,
        gravity,
        rotors=(0, 0),
        viscous=(0, 0),
        dry=(0, 0),
        elbows=(0, 0),
    ):
        a, da = casadi.SX.sym("a", 4), casadi.SX.sym("da", 4)
        self.viscous, self.dry, self.elbows, kinetic, potential, ends = (
            viscous,
            dry,
            elbows,
            0,
            0,
            [],
        )

        def add(mass, point, angle_rate, inertia):
            velocity = casadi.jtimes(point, a, da)
            return (
                mass * casadi.sumsqr(velocity) / 2 + inertia * angle_rate**2 / 2,
                -mass * casadi.dot(casadi.DM(gravity), point),
            )

        def turned(angle, x, y):
            c, s = casadi.cos(angle), casadi.sin(angle)
            return casadi.vertcat(c * x - s * y, s * x + c * y)

        for leg, x0 in enumerate((-d / 2, d / 2)):
            q, phi = a[2 * leg], a[2 * leg + 1]
            base = casadi.vertcat(x0, 0)
            (m1, x1, y1, i1), (m2, x2, y2, i2) = bodies[2 * leg], bodies[2 * leg + 1]
            elbow = base + (turned(q, cranks[leg], 0) if cranks else casadi.vertcat(0, q))
            first = base + turned(q, x1, y1) if cranks else elbow
            ends.append(elbow + turned(phi, bars[leg], 0))
            for part in (
                add(m1, first, da[2 * leg] if cranks else 0, i1),
                add(m2, elbow + turned(phi, x2, y2), da[2 * leg + 1], i2),
                (rotors[leg] * da[2 * leg] ** 2 / 2, 0),
            ):
                kinetic, potential = kinetic + part[0], potential + part[1]
        part = add(payload, ends[0], 0, 0)
        kinetic, potential = kinetic + part[0], potential + part[1]
        momentum = casadi.gradient(kinetic, da)
        M = casadi.jacobian(momentum, da)
        h = (
            casadi.jtimes(momentum, a, da)
            - casadi.gradient(kinetic, a)
            + casadi.gradient(potential, a)
        )
        closure = casadi.jacobian(ends[0] - ends[1], a)
        bias = casadi.jtimes(casadi.jtimes(ends[0] - ends[1], a, da), a, da)
        at_end = casadi.jacobian(ends[0], a)
        end_bias = casadi.jtimes(casadi.jtimes(ends[0], a, da), a, da)
        self.terms = casadi.Function(
            "t", [a, da], [M, h, closure, bias, at_end, end_bias, kinetic, potential]
        )

    def energy(self, a, da):
        return sum(map(float, self.terms(a, da)[-2:]))

    def kinetic(self, a, da):
        return float(self.terms(a, da)[-2])

    def accelerations(self, a, da, tau):
        """(q'', xi'') under torques, sliding with the signs of the rates."""
        M, h, phi, bias, at_end, end_bias = (
            np.array(each, dtype=float) for each in self.terms(a, da)[:6]
        )
        f = -h.ravel()
        for leg in (0, 1):
            rate = da[2 * leg]
            f[2 * leg] += tau[leg] - self.viscous[leg] * rate - self.dry[leg] * np.sign(rate)
            opens = self.elbows[leg] * (da[2 * leg + 1] - rate)
            f[2 * leg] += opens
            f[2 * leg + 1] -= opens
        system = np.block([[M, phi.T], [phi, np.zeros((2, 2))]])
        solved = np.linalg.solve(system, np.concatenate([f, -bias.ravel()]))[:4]
        return solved[::2], at_end @ solved + end_bias.ravel()
