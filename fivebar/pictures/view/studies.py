"""A study of a linkage, read as it is asked for."""

from .frames import choose


class OfStudy:
    """A study of a linkage."""

    known = "trace", "velocity", "acceleration", "torques"
    effort = "torque"
    events = ()

    def __init__(self, study):
        self.study, self.title = study, study.linkage.title
        self.names = study.motion.points
        self.points = study.points()
        self.frames = choose(study.t, self.points)

    @property
    def body(self):
        chain, index = self.study.motion.chain, self.names.index
        return dict(
            points=self.points[self.frames.index],
            bars=tuple((index(a), index(b)) for a, b in chain.bars),
            grounded=tuple(map(index, chain.grounded)), actuated=tuple(map(index, chain.actuated)),
            traced=index(chain.traced), rails=tuple(tuple(map(index, rail)) for rail in chain.rails),
            blocks=tuple((index(a), index(b), False) for a, b, _ in chain.blocks),
        )  # fmt: skip

    @property
    def traced(self):
        return self._of(self.study.motion.position)

    @property
    def velocity(self):
        return self._of(self.study.motion.velocity)

    @property
    def acceleration(self):
        return self._of(self.study.motion.acceleration)

    def _of(self, quantity):
        return quantity(self.study.motion.chain.traced)[self.frames.index]

    @property
    def torques(self):
        chain = self.study.motion.chain
        place = self.study.motion.position(chain.actuated[0])[self.frames.index]
        return [(place, None, self.study["torque"][self.frames.index])]
