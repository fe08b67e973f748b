"""The plant with dry friction in its drives: each slips one way or sticks, and its steps end where
that changes.

A drive that slips stops where its rate passes 0; one that sticks lets go where more than its
friction is needed to hold it. Both are found on the step's polynomial, and the first of them is
where the step ends. Nothing is smoothed: what sticks is held at its angle to the last bit, so that
it neither creeps nor chatters.
"""

from __future__ import annotations

import numpy as np

from ..models.dynamics import held_by
from ..models.four_joints import bars_rates, closed
from ..models.physics import loads_of
from ..models.sticking import slip_of
from .plant import Plant
from .steps import between, holding

PLACES = np.linspace(0.0, 1.0, 17)[1:]  # of a step where it is looked what holds a drive
FAR = 0.2  # of a rate's largest value in a step: where it stays above, it has no zero
OVER = 1e-12  # of the friction, by which more than it is needed
AT_REST = 1e-13  # of the rates, 1 + |rate|: a drive this slow where it stops stands


def plant_of(robot, start, tolerance, jit=False):
    """The robot's plant: with dry friction the one that sticks."""
    return (StickSlip if loads_of(robot).sticks else Plant)(robot, start, tolerance, jit)


def _powers():
    """(7, 8): each coefficient of a step's polynomial (`steps.between`) in powers of the place."""
    rows, basis = [], np.polynomial.Polynomial([1.0])
    for k in range(7):
        basis = basis * np.polynomial.Polynomial([0.0, 1.0] if k % 2 == 0 else [1.0, -1.0])
        rows.append(np.pad(basis.coef, (0, 8 - len(basis.coef))))
    return np.array(rows)


POWERS = _powers()


class StickSlip(Plant):
    """Plant of a robot with Coulomb friction; slip: per drive +1, -1, or 0 where it sticks."""

    def __init__(self, robot, start, tolerance, jit=False):
        super().__init__(robot, start, tolerance, jit)
        self.dry = np.array(robot.physics.coulomb)
        self._held = self._call(holding, jit)
        self.slip = np.ones(2)

    @property
    def moves(self):
        return bool(self.slip.any())

    def _tried(self, tau, length):
        return self._step(self.state, tau, length, self.tolerance, self.parameters, self.slip)

    def _advance(self, until, tau):
        self._settle(tau)
        super()._advance(until, tau)
        if not self.moves and until > self.t:
            self._pieces.append((self.t, until - self.t, self.state, np.zeros((7, 8))))
            self.t = until

    def _settle(self, tau):
        """Which drives stick now: where none stands, or what sticks is still held, nothing has to
        be solved.
        """
        standing = (self.state[4:7:2] == 0) & (self.dry > 0)
        if not standing.any():
            self.slip = np.where(self.state[4:7:2] < 0, -1.0, 1.0)
            return
        if (self.slip[standing] == 0).all():
            held = self._held(self.state, tau, self.parameters, self.slip)[0]
            if (np.abs(held[standing]) <= self.dry[standing]).all():
                return
        rates = self.rates
        self.slip = np.array(slip_of(rates, tuple(tau.tolist()), held_by))
        if not self.moves:
            if np.abs(self.state[4:]).max() > 1e-9:
                self._refuse(
                    tau, "both drives stick while the distal bars, in one line, still move"
                )
            self.state = np.concatenate([self.state[:4], np.zeros(4)])

    def _kept(self, tau, length, after, polynomial):
        place, drive = self._first_event(tau, polynomial)
        if place is None:
            return super()._kept(tau, length, after, polynomial)
        stops = self.slip[drive] != 0
        after, polynomial, cut = self._cut(
            tau, place * length, length, drive if stops else None, polynomial
        )
        super()._kept(tau, cut, after, polynomial)
        if stops:
            self._stop(drive)
            self._settle(tau)
        else:
            needed = self._held(self.state, tau, self.parameters, self.slip)[0]
            self.slip = self.slip.copy()
            self.slip[drive] = np.sign(needed[drive])
        return cut

    def _cut(self, tau, cut, length, drive, polynomial):
        """(state, polynomial, length) of a step that ends where the drive's rate is 0, or after
        `cut` s.
        """
        after, _, found = self._tried(tau, cut)
        for _ in range(4 if drive is not None else 0):
            rate = after[4 + 2 * drive]
            if abs(rate) <= AT_REST * (1 + np.abs(after[4:]).max()):
                break
            coefficients = (polynomial[:, 4 + 2 * drive] @ POWERS)[1:] * np.arange(1, 8)
            slope = np.polynomial.polynomial.polyval(cut / length, coefficients) / length
            better = cut - rate / slope if slope else cut
            if not 0 < better <= length:
                break
            cut = better
            after, _, found = self._tried(tau, cut)
        return after.copy(), found.copy(), cut

    def _stop(self, drive):
        """The state with a drive that stands, its loop closed by the others."""
        state = self.state.copy()
        state[4 + 2 * drive] = 0.0
        free = tuple(float(state[4 + 2 * k] != 0) for k in (0, 1))
        if any(free):
            c, c_dot, _ = closed(
                self.robot, tuple(state[:4].tolist()), tuple(state[4:].tolist()), free
            )
            state = np.array([*c, *c_dot])
        self.state = state

    def _first_event(self, tau, polynomial):
        """(place in (0, 1], drive) where a drive first stops or lets go in a step; (None, None)."""
        found = []
        for k in np.flatnonzero(self.dry):
            place = (
                self._stops_at(k, polynomial)
                if self.slip[k]
                else self._lets_go_at(k, tau, polynomial)
            )
            if place is not None:
                found.append((place, k))
        return min(found) if found else (None, None)

    def _stops_at(self, k, polynomial):
        column, begin = 4 + 2 * k, self.state[4 + 2 * k]
        coefficients = polynomial[:, column] @ POWERS
        coefficients[0] += begin
        if begin == 0:  # it has just begun to slip
            coefficients = coefficients[1:]
        values = np.polynomial.polynomial.polyval(PLACES, coefficients) * self.slip[k]
        if values.min() > FAR * values.max():
            return None
        roots = (
            np.polynomial.polynomial.polyroots(np.trim_zeros(coefficients, "b"))
            if coefficients.any()
            else []
        )
        places = sorted(root.real for root in roots if abs(root.imag) < 1e-9 and 0 < root.real <= 1)
        slope = coefficients[1:] * np.arange(1, len(coefficients))
        for place in places:
            if np.polynomial.polynomial.polyval(place, slope) * self.slip[k] <= 0:
                return place
        return None

    def _lets_go_at(self, k, tau, polynomial):
        def over(place):
            state = between(self.state[None], polynomial[None], np.array([place]))[0]
            return abs(self._held(state, tau, self.parameters, self.slip)[0][k]) - self.dry[k] * (
                1 + OVER
            )

        low = 0.0
        for place in PLACES:
            if over(place) > 0:
                high = place
                break
            low = place
        else:
            return None
        while high - low >= 1e-12:
            middle = (low + high) / 2
            low, high = (low, middle) if over(middle) > 0 else (middle, high)
        return high

    def _free(self, states, polynomials):
        moving = (states[:, 4:7:2] != 0) | (polynomials[:, :, 4:7:2] != 0).any(axis=1)
        moving |= ~moving.any(
            axis=1, keepdims=True
        )  # where both stand, so does what is between them
        return tuple(moving.T.astype(float))

    def rows(self, t):
        rows, found = super().rows(t)
        self._known = self.pieces
        return rows, np.column_stack([found, t])

    def after(self, state, tau, length):
        """As of Plant; a state of `rows` knows its time, and what comes after it, sticking and
        slipping, is known.
        """
        t0, lengths, states, polynomials = self._known
        t = float(state[8]) + length
        at = max(int(np.searchsorted(t0, t, side="right")) - 1, 0)
        place = np.array([(t - t0[at]) / lengths[at]])
        a = between(states[at : at + 1], polynomials[at : at + 1], place)[0].tolist()
        return bars_rates(self.robot, tuple(a[:4]), tuple(a[4:]))
