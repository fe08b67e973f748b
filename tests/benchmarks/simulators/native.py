"""Loops around MuJoCo and Pinocchio in their own languages, against their wheels: no Python is
timed.

The torque is that of the motions, an amplitude times cos 2 pi t. Libraries are built once and kept,
as our models'.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fivebar.models.machine_code import library
from fivebar.simulation.steps import tableau

from .motions import DURATION, ROBOT

if TYPE_CHECKING:
    from collections.abc import Callable

    from .motions import DrivenMotion

MUJOCO = """
#include <math.h>
#include <mujoco/mujoco.h>
static double amplitude[2];
static void torque(const mjModel *m, mjData *d) {
    double wave = cos(2 * M_PI * d->time);
    d->ctrl[0] = amplitude[0] * wave;
    d->ctrl[1] = amplitude[1] * wave;
}
/* by_step: the torque is set before each step; else at every stage, by MuJoCo's callback. */
void run(mjModel *m, mjData *d, double *q, const double *v, const double *a, long count, int by_step) {
    mj_resetData(m, d);
    for (int k = 0; k < m->nq; k++) d->qpos[k] = q[k];
    for (int k = 0; k < m->nv; k++) d->qvel[k] = v[k];
    amplitude[0] = a[0];
    amplitude[1] = a[1];
    mjcb_control = by_step ? 0 : torque;
    for (long k = 0; k < count; k++) {
        if (by_step) torque(m, d);
        mj_step(m, d);
    }
    mjcb_control = 0;
    for (int k = 0; k < m->nq; k++) q[k] = d->qpos[k];
}
"""
PINOCCHIO = """
#include <cmath>
#include <string>
#include <vector>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
namespace pin = pinocchio;
template<class T> using Many = std::vector<T, Eigen::aligned_allocator<T>>;
struct Robot {
    pin::Model model;
    pin::Data data;
    Many<pin::RigidConstraintModel> constraints;
    Many<pin::RigidConstraintData> datas;
    pin::ProximalSettings settings{1e-14, 1e-8, 20};
};
static pin::SE3 at(double x) { return pin::SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(x, 0, 0)); }
/* legs: base, l1, l2, zz of each. */
extern "C" void *make(const double *legs, double mass) {
    Robot *r = new Robot;
    pin::JointIndex tips[2];
    for (int k = 0; k < 2; k++) {
        const double *leg = legs + 4 * k;
        const Eigen::Matrix3d zz = leg[3] * Eigen::Matrix3d::Identity();
        auto first = r->model.addJoint(0, pin::JointModelRZ(), at(leg[0]), "q" + std::to_string(k));
        r->model.appendBodyToJoint(first, pin::Inertia(0, Eigen::Vector3d::Zero(), zz), pin::SE3::Identity());
        tips[k] = r->model.addJoint(first, pin::JointModelRZ(), at(leg[1]), "passive" + std::to_string(k));
        pin::Inertia half(mass / 2, Eigen::Vector3d(leg[2], 0, 0), Eigen::Matrix3d::Zero());
        r->model.appendBodyToJoint(tips[k], half, pin::SE3::Identity());
    }
    r->model.gravity.linear().setZero();
    r->constraints.emplace_back(pin::CONTACT_3D, r->model, tips[0], at(legs[2]), tips[1], at(legs[6]),
                                pin::LOCAL_WORLD_ALIGNED);
    r->datas.push_back(r->constraints[0].createData());
    r->data = pin::Data(r->model);
    pin::initConstraintDynamics(r->model, r->data, r->constraints, r->datas);
    return r;
}
/* Explicit Runge-Kutta steps h of q (4) and v (4), changed in place, by Butcher's a (stages x stages), b, c. */
extern "C" void run(void *robot, double *q, double *v, const double *amplitude, double h, long count, int stages,
                    const double *a, const double *b, const double *c) {
    Robot &r = *static_cast<Robot *>(robot);
    Eigen::Vector4d place(q), speed(v), rate[16], force[16];
    Eigen::VectorXd stage(4), velocity(4), torque = Eigen::VectorXd::Zero(4);
    for (long n = 0; n < count; n++) {
        for (int i = 0; i < stages; i++) {
            rate[i] = speed;
            stage = place;
            for (int j = 0; j < i; j++)
                if (a[i * stages + j] != 0) {
                    rate[i] += h * a[i * stages + j] * force[j];
                    stage += h * a[i * stages + j] * rate[j];
                }
            velocity = rate[i];
            const double wave = std::cos(2 * M_PI * (n + c[i]) * h);
            torque[0] = amplitude[0] * wave;
            torque[2] = amplitude[1] * wave;
            force[i] = pin::constraintDynamics(r.model, r.data, stage, velocity, torque, r.constraints, r.datas,
                                               r.settings);
        }
        for (int i = 0; i < stages; i++) {
            place += h * b[i] * rate[i];
            speed += h * b[i] * force[i];
        }
    }
    for (int k = 0; k < 4; k++) {
        q[k] = place[k];
        v[k] = speed[k];
    }
}
"""
# As Pinocchio's own build files have them: most of its code is in its library, and not compiled
# anew.
DEFINED = (
    "-DNDEBUG",
    "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
    "-DPINOCCHIO_WITH_COLLISION",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
    "-O2",
    "-w",
)
POINTER = ctypes.POINTER(ctypes.c_double)


def cxx_compiler() -> str | None:
    """The system's C++ compiler, None if there is none, or where wheels' libraries are not linked
    to as on Linux.
    """
    if sys.platform != "linux":
        return None
    return (
        os.environ.get("CXX")
        or shutil.which("c++")
        or shutil.which("g++")
        or shutil.which("clang++")
    )


def lacks_cxx_compiler() -> str | None:
    """What is missing to compile C++; None if nothing."""
    return None if cxx_compiler() else "no C++ compiler (c++, g++, clang++) on Linux"


def lacks_headers() -> str | None:
    """What is missing of the headers that a loop around Pinocchio is compiled against; None if
    nothing.
    """
    prefix = _prefix()
    wanted = "pinocchio/algorithm/constrained-dynamics.hpp", "eigen3/Eigen/Core"
    missing = [name for name in wanted if not (prefix and (prefix / "include" / name).exists())]
    return f"{missing[0]} is not installed: pip install pin cmeel-eigen" if missing else None


def _prefix():
    """Where the wheels of cmeel put headers and libraries."""
    found = find_spec("pinocchio")
    places = (parent / "cmeel.prefix" for parent in Path(found.origin).parents) if found else ()
    own = (
        (parent for parent in Path(found.origin).parents if parent.name == "cmeel.prefix")
        if found
        else ()
    )
    return next((place for place in (*own, *places) if place.is_dir()), None)


def _linked(folder, name):
    """Flags that link to a library in a wheel, found there again when it is loaded."""
    return f"-L{folder}", "-Wl,--no-as-needed", f"-l{name}", f"-Wl,-rpath,{folder}"


@cache
def _mujoco():
    import mujoco

    folder = Path(mujoco.__file__).parent
    (file,) = folder.glob("libmujoco.so*")
    flags = f"-I{folder / 'include'}", *_linked(folder, f":{file.name}")
    return ctypes.CDLL(str(library(MUJOCO, mujoco.__version__, flags))).run


@cache
def _pinocchio():
    import pinocchio

    prefix = _prefix()
    folders = prefix / "include", prefix / "include" / "eigen3"
    flags = (
        *DEFINED,
        *(f"-I{each}" for each in folders),
        *_linked(prefix / "lib", "pinocchio_default"),
    )
    found = ctypes.CDLL(str(library(PINOCCHIO, pinocchio.__version__, flags, cxx_compiler())))
    found.make.restype = ctypes.c_void_p
    return found


def _arrays(*values):
    """Contiguous copies, and pointers to them."""
    arrays = [np.array(value, dtype=float) for value in values]
    return arrays, [array.ctypes.data_as(POINTER) for array in arrays]


def mujoco_loop(
    model: object, data: object, motion: DrivenMotion, starts: tuple, count: int, by_step: bool
) -> Callable:
    """call () -> final joints (4,) of MuJoCo's own objects from starts (places, rates), by a loop
    in C.
    """
    kept, (_, v, a) = _arrays(*starts, motion.torque(0.0))
    addresses, run = [ctypes.c_void_p(each._address) for each in (model, data)], _mujoco()
    rest = ctypes.c_long(count), ctypes.c_int(by_step)

    def call():
        q = kept[0].copy()
        run(*addresses, q.ctypes.data_as(POINTER), v, a, *rest)
        return q[:4]

    call.keeps = model, data  # what the addresses are of
    return call


def pinocchio_loop(
    motion: DrivenMotion, count: int, method: str, start: tuple, legs: tuple
) -> Callable:
    """call () -> final joints (4,) of Pinocchio's constraintDynamics from start (q, v), by a loop
    in C++.

    method: of `steps.tableau`; legs: as `legs_of` gives them.
    """
    own, (rows, b, c) = _pinocchio(), tableau(method)
    stages = len(b)
    a = np.zeros((stages, stages))
    for row, weights in zip(a, rows):
        row[: len(weights)] = weights[:stages]
    kept, pointers = _arrays(legs, motion.torque(0.0), a, b, c)
    robot = ctypes.c_void_p(own.make(pointers[0], ctypes.c_double(ROBOT.m)))
    numbers = ctypes.c_double(DURATION / count), ctypes.c_long(count), ctypes.c_int(stages)

    def call():
        (q, _), places = _arrays(*start)
        own.run(robot, *places, pointers[1], *numbers, *pointers[2:])
        return q

    call.keeps = kept  # what the pointers are of
    return call
