"""The poses of a five-bar flooded on a grid: what moves into what, found without loci, arcs or aspects.

All poses of a five-bar are (q1, phi1) on a torus and the right leg's two modes, which are one pose where the left
leg's end is on the limit of the right leg's reach. The left leg passes its own Type 1 on the torus without any gluing;
a right leg of equal bars folds in two points of the torus, through which a straight way changes its mode.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

LEFT, RIGHT, PARALLEL, FOLDED = 1, 2, 4, 8  # what an edge crosses


class Flood:
    """Nodes (right mode, q1, phi1), flat, with labels (left mode, right mode, assembly mode), and their edges."""

    def __init__(self, robot, n=720):
        self.robot, self.n = robot, n
        step = 2 * np.pi / n
        self.q, self.phi = (np.arange(n) + 0.37) * step, (np.arange(n) + 0.71) * step
        q, phi = np.meshgrid(self.q, self.phi, indexing="ij", sparse=True)
        self.labels = np.stack(
            [self.label(q, phi, w) for w in (1, -1)]
        )  # (2, n, n, 3), 0 where out of reach
        edges = [self._along(q, phi, axis) for axis in (0, 1)] + [
            self._limits(q, phi, axis) for axis in (0, 1)
        ]
        self.edges = np.concatenate([*edges, self._right_folds()])
        # What moves without crossing anything is one node for all other questions.
        self.regions = self._joined(self.edges[self.edges[:, 2] == 0], self.labels[..., 1].size)
        ways = np.stack(
            [self.regions[self.edges[:, 0]], self.regions[self.edges[:, 1]], self.edges[:, 2]],
            axis=-1,
        )
        self.ways = np.unique(ways[self.edges[:, 2] > 0], axis=0)

    def label(self, q, phi, w):
        robot = self.robot
        u = np.exp(1j * phi)
        z = -robot.d + robot.l11 * np.exp(1j * q) + robot.l12 * u  # from the right base
        r = np.abs(z)
        a = (robot.l21**2 - robot.l22**2 + r * r) / (2 * r)
        square = robot.l21**2 - a * a
        det = (u.conj() * z / r * (r - a - 1j * w * np.sqrt(np.maximum(square, 0.0)))).imag
        found = np.stack(
            [-np.sign(np.sin(phi - q)), np.full(r.shape, w), -np.sign(det)], axis=-1
        ).astype(int)
        found[square < 0] = 0
        return found

    def _along(self, q, phi, axis):
        number, edges = np.arange(2 * self.n**2).reshape(2, self.n, self.n), []
        half = np.pi / self.n
        middle = (q + half, phi) if axis == 0 else (q, phi + half)
        for k, w in enumerate((1, -1)):
            here, there = self.labels[k], np.roll(self.labels[k], -1, axis)
            between = self.label(*middle, w)
            left, parallel = here[..., 0] != there[..., 0], here[..., 2] != there[..., 2]
            good = (
                (here[..., 1] != 0)
                & (there[..., 1] != 0)
                & (between[..., 1] != 0)
                & ~(left & parallel)
            )
            # Twice across on the way is not across, and what is finer than the grid is not known.
            good &= left | (between[..., 0] == here[..., 0])
            good &= parallel | (between[..., 2] == here[..., 2])
            folded = left & (np.cos(middle[1] - middle[0]) < 0) & (self.robot.l11 == self.robot.l12)
            what = LEFT * left + PARALLEL * parallel + FOLDED * folded
            edges.append(np.stack([number[k], np.roll(number[k], -1, axis), what], axis=-1)[good])
        return np.concatenate(edges)

    def _limits(self, q, phi, axis):
        """Both right modes glued where a neighbour is out of the right leg's reach."""
        number, edges = np.arange(2 * self.n**2).reshape(2, self.n, self.n), []
        q, phi = np.broadcast_arrays(q, phi)
        both = (self.labels[0, ..., 2] == self.labels[1, ..., 2]) & (self.labels[0, ..., 1] != 0)
        for sign in (1, -1):
            rim = both & (np.roll(self.labels[0, ..., 1], -sign, axis) == 0)
            low, high = np.zeros(rim.sum()), np.full(rim.sum(), sign * 2 * np.pi / self.n)

            def at(s, q=q[rim], phi=phi[rim]):
                return self.label(q + s, phi, 1) if axis == 0 else self.label(q, phi + s, 1)

            for _ in range(40):
                middle = (low + high) / 2
                reached = at(middle)[:, 1] != 0
                low, high = np.where(reached, middle, low), np.where(reached, high, middle)
            same = (at(low)[:, [0, 2]] == self.labels[0][rim][:, [0, 2]]).all(axis=-1)
            pair = np.stack([number[0][rim], number[1][rim], np.full(rim.sum(), RIGHT)], axis=-1)
            edges.append(pair[same])
        return np.concatenate(edges)

    def _right_folds(self):
        robot, edges = self.robot, [np.empty((0, 3), dtype=int)]
        if (
            robot.l21 != robot.l22
            or not abs(robot.l11 - robot.l12) < robot.d < robot.l11 + robot.l12
        ):
            return edges[0]
        cosine = (robot.d**2 - robot.l11**2 - robot.l12**2) / (2 * robot.l11 * robot.l12)
        for elbow in (np.arccos(cosine), -np.arccos(cosine)):
            q = -np.angle(robot.l11 + robot.l12 * np.exp(1j * elbow))
            phi = q + elbow
            p, u = robot.l11 * 1j * np.exp(1j * q), robot.l12 * 1j * np.exp(1j * phi)
            back = np.linalg.inv([[p.real, u.real], [p.imag, u.imag]])
            for angle in np.linspace(0, 2 * np.pi, 64, endpoint=False):
                away = back @ (np.cos(angle), np.sin(angle))
                away *= 6 * np.pi / self.n / np.abs(away).max()
                (one, a), (other, b) = (
                    self._nearest(q + s * away[0], phi + s * away[1], w)
                    for s, w in ((1, 1), (-1, -1))
                )
                if a[1] and b[1] and a[0] == b[0] and a[2] == b[2]:
                    edges.append(np.array([[one, other, RIGHT | FOLDED]]))
        return np.concatenate(edges)

    def _nearest(self, q, phi, w):
        i, j = (
            int(np.round((x - own[0]) / (2 * np.pi) * self.n)) % self.n
            for x, own in ((q, self.q), (phi, self.phi))
        )
        k = (1, -1).index(w)
        return k * self.n**2 + i * self.n + j, self.labels[k, i, j]

    def components(self, may):
        """Number of each node's component when edges that cross nothing else than `may` are passed; -1 out of reach."""
        ways = self.ways[(self.ways[:, 2] & ~may) == 0]
        found = self._joined(ways, self.regions.max() + 1)[self.regions]
        return np.where(self.labels[..., 1].ravel() == 0, -1, found)

    @staticmethod
    def _joined(edges, size):
        i, j, _ = edges.T
        return connected_components(
            coo_array((np.ones(len(i)), (i, j)), shape=(size, size)), False
        )[1]

    def node(self, pose):
        """The node nearest to a regular pose among those with its modes; None where none is near."""
        (q, _), u = pose.q, pose.u2[0]
        phi, wanted = (
            np.arctan2(float(u[1]), float(u[0])),
            [*map(int, pose.working), int(pose.assembly)],
        )
        for reach in range(6):
            for i in range(-reach, reach + 1):
                for j in range(-reach, reach + 1):
                    step = 2 * np.pi / self.n
                    number, label = self._nearest(q + i * step, phi + j * step, wanted[1])
                    if max(abs(i), abs(j)) == reach and label.tolist() == wanted:
                        return number
        return None
