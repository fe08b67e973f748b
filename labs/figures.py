"""Draws the figures of the labs' statements: `python labs/figures.py [FOLDER]`, by default beside this file."""

import numpy as np
from drawing import GREEN, INK, LEFT, MM, PINK, RIGHT, arc, arrow, label, main, panels, ray

import fivebar as fb

HOME, GOAL = (0.09, 0.06796322535018479), (0.05, 0.0)
ROBOT = fb.FiveBar()
OUTWARD = (1, -1)  # working modes with the elbows outside


def points(pose):
    """Base joint, elbow and end-effector of both legs, mm."""
    bases = [(drive.x * MM, 0.0) for drive in pose.robot.drives]
    return [np.array([base, MM * elbow, MM * pose.xi]) for base, elbow in zip(bases, pose.elbows)]


def draw(axes, pose, alpha=1.0, lw=3.5, end=True):
    """The robot, a Pose or its points: left leg blue, right leg orange, motors filled."""
    for leg, colour in zip(pose if isinstance(pose, list) else points(pose), (LEFT, RIGHT)):
        axes.plot(*leg.T, color=colour, lw=lw, alpha=alpha, solid_capstyle="round", zorder=2)
        axes.plot(*leg[0], "o", color=INK, ms=9, alpha=alpha, zorder=4)
        axes.plot(*leg[1], "o", color=colour, mfc="white", mew=2, ms=7, alpha=alpha, zorder=4)
    if end:
        axes.plot(*leg[2], "o", color=INK, mfc="white", mew=2, ms=9, alpha=alpha, zorder=5)


def robot():
    figure, (axes,) = panels(1, 6.0, 4.4)
    pose = fb.igm(ROBOT, (0.012, 0.128), OUTWARD)
    draw(axes, pose)
    for leg, side, names in zip(points(pose), (-1, 1), (("11", "12"), ("21", "22"))):
        base, elbow, end = leg
        q, passive = pose.q[int(side > 0)], pose.q_passive[int(side > 0)]
        u = np.array([np.cos(q), np.sin(q)])
        ray(axes, base, (1, 0), 42)
        arc(axes, base, 20, 0, q, f"$q_{{{names[0]}}}$")
        ray(axes, elbow, u, 40)
        arc(axes, elbow, 20, q, q + passive, f"$q_{{{names[1]}}}$")
        label(axes, base, f"$A_{{{names[0]}}}$", (0, -16))
        label(axes, elbow, f"$A_{{{names[1]}}}$", (-20 if side < 0 else 20, -8))
        for a, b, name in ((base, elbow, names[0]), (elbow, end, names[1])):
            label(
                axes,
                (a + b) / 2,
                f"$l_{{{name}}}$",
                (-14 if side < 0 else 16, 4),
                color=(LEFT, RIGHT)[side > 0],
            )
    label(axes, end, "$A_{13}$ = end-effector $(x, y)$", (0, 18))
    ray(axes, (-59, 0), (1, 0), 118)
    arrow(axes, (0, 0), (22, 0), GREEN, "$x$", (4, -10))
    arrow(axes, (0, 0), (0, 22), GREEN, "$y$", (-10, 2))
    axes.annotate("", (59, -26), (-59, -26), arrowprops=dict(arrowstyle="<->", color=INK, lw=1.2))
    label(axes, (0, -26), "$d$", (0, -9))
    axes.set(xlim=(-165, 165), ylim=(-40, 152))
    return figure


def assembly_modes():
    figure, axes = panels(2)
    for each, mode in zip(axes, (-1, 1)):
        pose = fb.dgm(ROBOT, (1.5, 1.3), mode)
        draw(each, pose)
        draw(each, fb.dgm(ROBOT, (1.5, 1.3), -mode), alpha=0.15, end=False)
        left, right = (leg[1] for leg in points(pose))
        arrow(each, right, 0.92 * (left - right), INK, lw=1.2, linestyle="--")
        each.set(
            xlim=(-125, 125), ylim=(-15, 170), title=f"assembly_mode = {mode:+d}".replace("-", "−")
        )
        label(each, left, "$A_{12}$", (-16, 0))
        label(each, right, "$A_{22}$", (16, 0))
    return figure


def working_modes():
    figure, axes = panels(4, 2.4, 1.9)
    for each, mode in zip(axes, ((-1, -1), (-1, 1), (1, -1), (1, 1))):
        pose = fb.igm(ROBOT, (0.01, 0.12), mode)
        draw(each, pose)
        for base, _, end in points(pose):
            arrow(each, base, 0.9 * (end - base), INK, lw=1.0, linestyle="--")
        name = "gamma1 = {:+d}, gamma2 = {:+d}".format(*mode).replace("-", "−")
        each.set(xlim=(-155, 155), ylim=(-15, 140))
        each.set_title(name, fontsize=10)
    return figure


def velocities():
    figure, (axes,) = panels(1, 5.4, 4.2)
    rates = fb.ikm(fb.igm(ROBOT, (0.025, 0.12), OUTWARD), (-0.075, 0.1))
    pose = rates.pose
    draw(axes, pose, alpha=0.45)
    (base, elbow, end), _ = points(pose)
    own = pose.q[0]
    v11 = np.array([-np.sin(own), np.cos(own)])
    u12 = pose.A[0]
    v12 = np.array([-u12[1], u12[0]])
    scale = 0.4 * MM
    elbow_velocity = scale * ROBOT.l11 * rates.q_dot[0] * v11
    swing = scale * ROBOT.l12 * (rates.q_dot[0] + rates.q_passive_dot[0]) * v12
    arrow(axes, elbow, elbow_velocity, GREEN, r"$l_{11}\dot q_{11}v_{11}$", (-10, 14))
    arrow(axes, end, elbow_velocity, GREEN, linestyle="--", lw=1.3)
    arrow(
        axes,
        end + elbow_velocity,
        swing,
        PINK,
        r"$l_{12}(\dot q_{11}+\dot q_{12})v_{12}$",
        (-20, 12),
    )
    arrow(axes, end, scale * rates.xi_dot, INK, r"$\dot\xi$", (14, -8))
    arrow(axes, elbow, 30 * u12, LEFT, "$u_{12}$", (14, 2))
    arrow(axes, base, 30 * np.array([np.cos(own), np.sin(own)]), LEFT, "$u_{11}$", (16, 2))
    axes.set(xlim=(-165, 170), ylim=(-15, 185))
    return figure


def accelerations():
    figure, (axes,) = panels(1, 5.4, 4.2)
    pose = fb.igm(ROBOT, (0.025, 0.12), OUTWARD)
    draw(axes, pose, alpha=0.45)
    (base, elbow, end), _ = points(pose)
    u11 = np.array([np.cos(pose.q[0]), np.sin(pose.q[0])])
    u12 = pose.A[0]
    v11, v12 = (np.array([-u[1], u[0]]) for u in (u11, u12))
    arrow(axes, elbow, 42 * v11, GREEN, r"$l_{11}\ddot q_{11}v_{11}$", (-22, 10))
    arrow(axes, elbow, -34 * u11, RIGHT, r"$-l_{11}\dot q_{11}^2u_{11}$", (-38, -2))
    arrow(axes, end, 40 * v12, GREEN, r"$l_{12}(\ddot q_{11}+\ddot q_{12})v_{12}$", (0, 14))
    arrow(axes, end, -46 * u12, RIGHT, r"$-l_{12}(\dot q_{11}+\dot q_{12})^2u_{12}$", (18, -16))
    axes.set(xlim=(-165, 170), ylim=(-15, 185))
    return figure


def types():
    figure, axes = panels(3, 2.9, 3.1)
    straight = fb.igm(ROBOT, (-0.059 + 0.18 * np.cos(1.0), 0.18 * np.sin(1.0)))
    stretched = in_line(2.0, 1)
    end, elbow, base = (
        np.array([59.0, 135.92645]),
        np.array([0.0, 67.963225]),
        np.array([59.0, 0.0]),
    )
    both = [np.array([-base, elbow, end]), np.array([base, elbow, end])]
    titles = "Type 1: a leg in line", "Type 2: distal bars in line", "Type 3: both"
    for each, pose, title in zip(axes, (straight, stretched, both), titles):
        draw(each, pose)
        each.set(xlim=(-130, 165), ylim=(-20, 215))
        each.set_title(title, fontsize=11)
    end = points(straight)[0][2]
    u = straight.A[0]
    arrow(axes[0], end, 45 * u, PINK, "lost motion", (-4, 10))
    _, elbow, end = stretched[0]
    u = (end - elbow) / np.hypot(*(end - elbow))
    arrow(axes[1], end, 55 * np.array([-u[1], u[0]]), PINK, "lost force", (0, 10))
    return figure


def in_line(q11, branch):
    """The robot's points with its distal bars stretched in one line."""
    elbow = -ROBOT.d / 2 + ROBOT.l11 * np.exp(1j * q11)
    span, bar = ROBOT.d / 2 - elbow, ROBOT.l12 + ROBOT.l22
    along = (abs(span) ** 2 + bar**2 - ROBOT.l21**2) / (2 * abs(span))
    far = elbow + (along + 1j * branch * np.sqrt(bar**2 - along**2)) * span / abs(span)
    end = elbow + ROBOT.l12 / bar * (far - elbow)
    legs = (-ROBOT.d / 2, elbow, end), (ROBOT.d / 2, far, end)
    return [MM * np.stack([np.real(leg), np.imag(leg)], axis=-1) for leg in legs]


def four_bar():
    figure, axes = panels(2, 3.4, 3.0)
    for each, branch in zip(axes, (1, -1)):
        left, right = legs = in_line(2.0, branch)
        draw(each, legs)
        arrow(each, left[1], 0.92 * (right[0] - left[1]), INK, lw=1.2, linestyle="--")
        for at, text, offset in (
            (left[0], "$A_{11}$", (-16, -10)),
            (right[0], "$A_{21}$", (16, -10)),
            (left[1], "$A_{12}$", (-18, 2)),
            (right[1], "$A_{22}$", (18, 6)),
            (left[2], "$(x, y)$", (6, 16)),
        ):
            label(each, at, text, offset)
        each.set(
            xlim=(-140, 165), ylim=(-105, 150), title=f"branch = {branch:+d}".replace("-", "−")
        )
    return figure


def loci(axes, modes):
    for piece in fb.singularity_loci(ROBOT).task:
        if modes in piece.working:
            parallel = piece.type & fb.Singularity.PARALLEL
            axes.plot(
                *(MM * piece.points).T,
                color=PINK if parallel else INK,
                lw=1.8,
                ls="-" if parallel else "--",
            )


def locus():
    figure, (axes,) = panels(1, 4.6, 4.4)
    loci(axes, (-1, -1))
    axes.plot([], [], color=INK, ls="--", label="Type 1")
    axes.plot([], [], color=PINK, label="Type 2")
    path = MM * np.array([(0.09, 0.068), (-0.06, -0.02)])
    axes.plot(*path.T, color=GREEN, lw=2.2, label="a path: $s$ from 0 to 1")
    axes.plot(*path[0], "o", color=GREEN)
    axes.plot(*path[1], "s", color=GREEN)
    axes.plot([-59, 59], [0, 0], "o", color=INK, ms=8)
    axes.legend(loc="lower center", fontsize=9, frameon=False, ncols=3, bbox_to_anchor=(0.5, -0.06))
    axes.set_title("working modes (−1, −1)", fontsize=11)
    return figure


def forces():
    figure, (axes,) = panels(1, 5.4, 4.2)
    pose = fb.igm(ROBOT, (0.012, 0.128), OUTWARD)
    draw(axes, pose, alpha=0.45)
    end = points(pose)[0][2]
    for leg, u, colour, number in zip(points(pose), pose.A, (LEFT, RIGHT), "12"):
        arrow(
            axes,
            end,
            46 * u,
            colour,
            rf"$\lambda_{number}u_{{{number}2}}$",
            (14 if number == "1" else -16, 8),
        )
        arrow(
            axes,
            leg[1],
            -30 * u,
            colour,
            rf"$-\lambda_{number}u_{{{number}2}}$",
            (0, -14),
            linestyle="--",
            lw=1.5,
        )
        arc(axes, leg[0], 15, -0.6, 2.2, rf"$\tau_{number}$", far=1.9)
    label(axes, end, "$m$", (0, -18))
    axes.set(xlim=(-165, 165), ylim=(-20, 195))
    return figure


def profile():
    figure, axes = panels(3, 2.7, 2.4, axis=True)
    u = np.linspace(0, 1, 200)
    xi, velocity, acceleration = fb.line((0, 0), (1, 0), 1.0)(u)
    for each, y, name in zip(
        axes, (xi, velocity, acceleration), ("$s$", "$T\\,\\dot s$", "$T^2\\ddot s$")
    ):
        each.plot(u, y[:, 0], color=LEFT, lw=2)
        each.set(xlabel="$t/T$", title=name)
        each.grid(alpha=0.3)
    return figure


def error_decay():
    figure, (axes,) = panels(1, 5.2, 2.9, axis=True)
    names = ((0.05, LEFT, "-"), (0.6, GREEN, (0, (6, 2))), (1.2, RIGHT, (0, (2, 1.5))))
    for size, colour, dashes in names:
        kp, kd = size**2, 2 * size
        e, rate, history = 1.0, 0.0, [1.0]
        for _ in range(60):
            push = -kp * e - kd * rate
            e, rate = e + rate + push / 2, rate + push
            if abs(e) > 3:
                break
            history.append(e)
        axes.plot(history, color=colour, ls=dashes, lw=2, label=rf"$\omega h = {size:g}$")
    axes.axvline(40, color=INK, lw=0.9, ls=":")
    axes.axhspan(-0.01, 0.01, color=GREEN, alpha=0.2)
    axes.set(ylim=(-1.1, 1.2), xlabel="control periods", ylabel="error")
    axes.legend(frameon=False, fontsize=9, loc="lower right")
    return figure


def task_2():
    figure, (axes, torque) = panels(2, 4.1, 3.7, axis=True)
    reference = fb.line(HOME, GOAL, 4.0)
    found = fb.check_path(ROBOT, reference)
    loci(axes, (-1, -1))
    draw(axes, found.pose, alpha=0.5)
    axes.plot(*(MM * np.array([HOME, GOAL])).T, color=GREEN, lw=2.2)
    axes.plot(*(MM * np.array(HOME)), "o", color=GREEN)
    axes.plot(*(MM * np.array(GOAL)), "s", color=GREEN)
    u = found.pose.A[0]
    arrow(axes, MM * found.pose.xi, 45 * np.array([u[1], -u[0]]), PINK, "$t_s$", (6, 8))
    axes.set_aspect("equal")
    axes.set(xlim=(-125, 145), ylim=(-95, 130), xlabel="x (mm)", ylabel="y (mm)")
    t = np.linspace(0, found.time - 1e-3, 1500)
    xi, velocity, acceleration = reference(t)
    acc = fb.ikm2(fb.ikm(fb.igm(ROBOT, xi), velocity), acceleration)
    tau = fb.inverse_dynamics(acc)
    for column, colour, name in zip(tau.T, (LEFT, RIGHT), "12"):
        torque.plot(t, MM * column, color=colour, lw=2, label=rf"$\tau_{name}$")
    torque.axvline(found.time, color=PINK, ls="--", lw=1.3)
    torque.set(xlabel="t (s)", ylabel="exact torque (mN m)", xlim=(2, 3.4), ylim=(-10, 30))
    torque.grid(alpha=0.3)
    torque.legend(frameon=False)
    return figure


def misses():
    """The drawing's bars at a pose that a robot with other lengths was measured at."""
    figure, (axes,) = panels(1, 6.4, 4.6)
    q = fb.igm(ROBOT, (0.012, 0.128), OUTWARD).q
    seen = MM * np.array([0.014, 0.154])
    for name, drive, angle, bar, colour, side in zip(
        "12", ROBOT.drives, q, ROBOT.distal, (LEFT, RIGHT), (-1, 1)
    ):
        base = MM * np.array([drive.x, 0.0])
        elbow = base + MM * drive.length * np.array([np.cos(angle), np.sin(angle)])
        away = (seen - elbow) / np.linalg.norm(seen - elbow)
        reached = elbow + MM * bar * away
        turn = np.arctan2(away[1], away[0]) + np.linspace(-0.35, 0.35, 60)
        axes.plot(
            *(elbow[:, None] + MM * bar * np.array([np.cos(turn), np.sin(turn)])),
            color=colour,
            lw=1,
            ls="--",
        )
        axes.plot(
            *np.array([base, elbow, reached]).T,
            color=colour,
            lw=3.5,
            solid_capstyle="round",
            zorder=2,
        )
        axes.plot(*np.array([reached, seen]).T, color=PINK, lw=3.5, zorder=3)
        axes.plot(*base, "o", color=INK, ms=9, zorder=4)
        axes.plot(*elbow, "o", color=colour, mfc="white", mew=2, ms=7, zorder=4)
        label(axes, (reached + seen) / 2, f"$e_{name}$", (10 * side, 12), color=PINK)
        label(axes, (elbow + reached) / 2, f"$l_{{{name}2}}$", (-14 * side, -8), color=colour)
        label(axes, (base + elbow) / 2, f"$l_{{{name}1}}$", (18 * side, -4), color=colour)
        ray(axes, base, (1, 0), 40)
        arc(axes, base, 20, 0, angle, f"$q_{name} + o_{name}$", 1.9)
    axes.plot(*seen, "o", color=INK, mfc="white", mew=2, ms=9, zorder=5)
    label(axes, seen, "measured $(x, y)$", (0, 26))
    return figure


FIGURES = {
    "lab1_geometry": (robot, assembly_modes, working_modes),
    "lab2_kinematics": (velocities,),
    "lab3_second_order": (accelerations,),
    "lab4_singularities": (types, four_bar, locus),
    "lab5_dynamics": (forces,),
    "lab6_control": (profile, error_decay, task_2),
    "lab8_calibration": (misses,),
}


if __name__ == "__main__":
    main(FIGURES)
