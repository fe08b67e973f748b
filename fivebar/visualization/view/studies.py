"""A study of a linkage, read as it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..skeleton import study_body
from .frames import choose

if TYPE_CHECKING:
    from ...linkages import Study


class OfStudy:
    """A study of a linkage."""

    known = "trace", "velocity", "acceleration", "torques"
    effort = "torque"
    events = ()

    def __init__(self, study: Study):
        self.study, self.title = study, study.linkage.title
        self.heading = self.title
        body = study_body(study)
        self.frames = choose(study.t, body.points)
        self.body = body.at(self.frames.index)

    @property
    def traced(self) -> np.ndarray:
        return self.body.points[:, self.body.traced]

    @property
    def velocity(self) -> np.ndarray:
        return self._of(self.study.motion.velocity)

    @property
    def acceleration(self) -> np.ndarray:
        return self._of(self.study.motion.acceleration)

    def _of(self, quantity):
        return quantity(self.study.motion.chain.traced)[self.frames.index]

    @property
    def torques(self) -> list[tuple]:
        return [
            (
                self.body.points[:, self.body.actuated[0]],
                None,
                self.study["torque"][self.frames.index],
            )
        ]
