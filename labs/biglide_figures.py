"""Draws the figures of lab 7's statement: `python labs/biglide_figures.py [FOLDER]`, by default beside this file."""

import numpy as np
from drawing import GREEN, INK, LEFT, MM, PINK, RIGHT, arc, arrow, label, main, panels, ray

import fivebar as fb

ROBOT = fb.Biglide()
SIDES = (-1, LEFT, "1"), (1, RIGHT, "2")


def draw(axes, pose, low=-130, high=300, alpha=1.0, end=True):
    """The robot on its guides: left leg blue, right leg orange, feet filled squares."""
    tip = MM * pose.xi
    for (_, colour, _), foot in zip(SIDES, MM * pose.elbows):
        axes.plot([foot[0]] * 2, [low, high], color=INK, lw=1.2, alpha=0.35 * alpha, zorder=1)
        axes.plot(
            *np.array([foot, tip]).T,
            color=colour,
            lw=3.5,
            alpha=alpha,
            solid_capstyle="round",
            zorder=2,
        )
        axes.plot(*foot, "s", color=colour, ms=11, alpha=alpha, zorder=4)
    if end:
        axes.plot(*tip, "o", color=INK, mfc="white", mew=2, ms=9, alpha=alpha, zorder=5)


def robot():
    figure, (axes,) = panels(1, 6.0, 4.6)
    pose = fb.dgm(ROBOT, (0.035, 0.09))
    draw(axes, pose, -70, 340)
    end = MM * pose.xi
    for (side, colour, leg), (x, y), phi in zip(SIDES, MM * pose.elbows, pose.q_passive):
        ray(axes, (x, y), (1, 0), 90)
        arc(axes, (x, y), 45, 0, phi, f"$q_{{{leg}2}}$", far=1.4)
        label(
            axes,
            ((x + end[0]) / 2, (y + end[1]) / 2),
            f"$l_{leg}$",
            (-14 * -side, 10),
            color=colour,
        )
        label(axes, (x, y), f"foot {leg}", (30 * side, -12 * side), color=colour)
        axes.annotate(
            "",
            (x - 28, y),
            (x - 28, 0),
            arrowprops=dict(arrowstyle="<->", color=INK, lw=1.2, shrinkA=0, shrinkB=0),
        )
        label(axes, (x - 28, y / 2), f"$q_{{{leg}1}}$", (-14, 0))
        ray(axes, (x, y), (-1, 0), 45)
    label(axes, end, "end-effector $(x, y)$", (0, 18))
    ray(axes, (-270, 0), (1, 0), 560)
    arrow(axes, (0, 0), (50, 0), GREEN, "$x$", (4, -10))
    arrow(axes, (0, 0), (0, 50), GREEN, "$y$", (-10, 2))
    axes.annotate("", (200, -55), (-200, -55), arrowprops=dict(arrowstyle="<->", color=INK, lw=1.2))
    label(axes, (0, -55), "$d$", (0, -9))
    axes.set(xlim=(-310, 310), ylim=(-85, 350))
    return figure


def modes():
    figure, axes = panels(6, 1.9, 2.9)
    for each, mode in zip(axes, (-1, 1)):
        q = (0.03, -0.03)
        draw(each, fb.dgm(ROBOT, q, -mode), -300, 300, alpha=0.15, end=False)
        pose = fb.dgm(ROBOT, q, mode)
        draw(each, pose, -300, 300)
        left, right = MM * pose.elbows
        arrow(each, right, 0.9 * (left - right), INK, lw=1.2, linestyle="--")
        each.set_title(f"assembly_mode = {mode:+d}".replace("-", "−"), fontsize=9)
    for each, mode in zip(axes[2:], ((-1, -1), (-1, 1), (1, -1), (1, 1))):
        draw(each, fb.igm(ROBOT, (0.03, 0.0), mode), -300, 300)
        each.set_title("gamma1 = {:+d}\ngamma2 = {:+d}".format(*mode).replace("-", "−"), fontsize=9)
    for each in axes:
        each.set(xlim=(-235, 235), ylim=(-310, 310), anchor="S")
    return figure


def quintic(start, goal, duration, *middle):
    """From rest to rest, through the conditions of `middle`."""
    rest = {1: (0.0, 0.0), 2: (0.0, 0.0)}
    return fb.polynomial([(0.0, {0: start, **rest}), *middle, (duration, {0: goal, **rest})])


def crossing():
    figure, (axes, effort) = panels(2, 4.3, 3.7, axis=True)
    start, goal, mode = (-0.04, -0.02), (0.06, 0.02), (1, -1)
    careless = quintic(start, goal, 2.0)
    time = fb.check_path(ROBOT, careless, working=mode).time
    careful = fb.crossing_polynomial(
        ROBOT, start, goal, (0.0, 0.0), (0.08, 0.0), (0.0, time, 2.0), working=mode
    )
    pose = fb.igm(ROBOT, (0.0, 0.0), mode)
    draw(axes, pose, -260, 260)
    u = pose.A[0]
    arrow(axes, (0, 0), 110 * np.array([-u[1], u[0]]), PINK, "$t_s$", (6, 8))
    axes.set_aspect("equal")
    axes.set(xlim=(-260, 260), ylim=(-280, 280), xlabel="x (mm)", ylabel="y (mm)")
    for motion, colour, dashes, name in (
        (careful, GREEN, "-", "compliant"),
        (careless, RIGHT, "--", "not compliant"),
    ):
        t = np.linspace(0, 2, 4001)
        t = t[np.abs(t - time) > 1e-4]
        xi, velocity, acceleration = motion(t)
        acc = fb.ikm2(fb.ikm(fb.igm(ROBOT, xi, mode), velocity), acceleration)
        tau = np.where(np.abs(t - time) > 6e-4, fb.inverse_dynamics(acc)[:, 0], np.nan)
        effort.plot(t, tau, color=colour, ls=dashes, lw=2, label=name)
    effort.axvline(time, color=PINK, ls=":", lw=1.3)
    effort.set(xlabel="t (s)", ylabel=r"exact effort $\tau_1$ (N)", ylim=(-12, 12))
    effort.grid(alpha=0.3)
    effort.legend(frameon=False)
    return figure


if __name__ == "__main__":
    main({"lab7_biglide": (robot, modes, crossing)})
