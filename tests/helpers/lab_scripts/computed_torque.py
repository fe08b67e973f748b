"""Control task 1 as a student writes it, with the errors taken after each step; arguments: robot, file for them."""

import json
import sys
from pathlib import Path

from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *

import fivebar as fb
from fivebar.amoro import models

GAINS = {"five_bar": (100.0, 20.0), "five_bar_stiff": (400.0, 40.0), "biglide": (100.0, 20.0)}


def main(args=None):
    rclpy.init(args=args)
    kind = args[1]
    robot = Robot(kind.removesuffix("_stiff"))
    start_robot(robot)
    app = QtGui.QApplication([])  # noqa: F841
    scope_joint1 = Scope("Joint 1", -0.5, 1.5)
    lab = models(fb.Biglide() if kind == "biglide" else fb.FiveBar())
    Kp, Kd = GAINS[kind]
    if kind == "biglide":
        A, B = np.array([0.0, 0.2]), np.array([0.06, 0.25])
    else:
        A, B = np.array([0.09, 0.06796322]), np.array([0.0, 0.1])

    tf = 2.0
    t = np.arange(0, 201) * 0.01 / tf
    s = 10 * t**3 - 15 * t**4 + 6 * t**5
    sD = (30 * t**2 - 60 * t**3 + 30 * t**4) / tf
    sDD = (60 * t - 180 * t**2 + 120 * t**3) / tf**2
    qt, qtD, qtDD = np.zeros((201, 2)), np.zeros((201, 2)), np.zeros((201, 2))
    for i in range(201):
        x, y = A + s[i] * (B - A)
        xD, yD = sD[i] * (B - A)
        xDD, yDD = sDD[i] * (B - A)
        qt[i, 0], qt[i, 1] = q11, q21 = lab.igm(x, y, -1, -1)
        q12, q22 = lab.dgm_passive(q11, q21, -1)
        qtD[i, 0], qtD[i, 1] = q11D, q21D = lab.ikm(q11, q12, q21, q22, xD, yD)
        q12D, q22D = lab.dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD)
        qtDD[i, 0], qtDD[i, 1] = lab.ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD)

    index = 0
    errors = []
    try:
        robot.apply_efforts(0.0, 0.0)  # Required to start the simulation
        while True:
            if robot.data_updated():
                q11, q11D = robot.active_left_joint.position, robot.active_left_joint.velocity
                q21, q21D = robot.active_right_joint.position, robot.active_right_joint.velocity
                if index:
                    errors.append((qt[min(index, 200)] - [q11, q21]).tolist())
                i = min(index, 200)
                q12, q22 = lab.dgm_passive(q11, q21, -1)
                xD, yD = lab.dkm(q11, q12, q21, q22, q11D, q21D)
                q12D, q22D = lab.dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD)
                M, c = lab.dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
                tau = M @ (qtDD[i] + Kd * (qtD[i] - [q11D, q21D]) + Kp * (qt[i] - [q11, q21])) + c
                robot.apply_efforts(tau[0], tau[1])
                time = robot.get_time()
                if time < 5.0:
                    scope_joint1.update(time, qt[i, 0], q11)
                index += 1
    except KeyboardInterrupt:
        Path(args[2]).write_text(json.dumps(errors), encoding="utf-8")
        print(f"{len(errors)} samples")


if __name__ == "__main__":
    main(sys.argv)
