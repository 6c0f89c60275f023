"""A chain of capsules with elastic ball joints in MuJoCo, which falls on a ball."""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

import numpy as np

from ancfsparse.errors import InputError
from benchmarks.contact import falls


def load() -> Any:
    """Return the module.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        return import_module("mujoco")
    except ImportError as error:
        raise InputError(
            f"MuJoCo cannot be imported ({error}): pip install 'ancfsparse[peers]'"
        ) from None


def run_mujoco(dt: float) -> falls.Fall:
    """Run the fall on the ball with MuJoCo's default contact and implicit integrator."""
    mujoco = load()
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes a file
    model = mujoco.MjModel.from_xml_string(_model_text(dt))
    data = mujoco.MjData(model)
    steps = round(falls.END / dt)
    begin = time.process_time()
    for _ in range(steps):
        mujoco.mj_step(model, data)
    seconds = time.process_time() - begin
    mujoco.mj_kinematics(model, data)
    tip = data.xpos[-1] + data.xmat[-1].reshape(3, 3)[:, 0] * falls.LENGTH / falls.ELEMENTS
    positions = [data.xpos[1 + k] for k in falls.WATCHED[:-1]]
    return falls.Fall(seconds, np.array([*positions, tip]))


def _model_text(dt: float) -> str:
    n, material = falls.ELEMENTS, falls.MATERIAL
    size = falls.LENGTH / n
    bending = 0.25 * np.pi * falls.RADIUS**4 * material.youngs_modulus
    geom = (
        f'<geom type="capsule" fromto="0 0 0 {size} 0 0" size="{falls.RADIUS}" '
        f'mass="{material.density * np.pi * falls.RADIUS**2 * size}" '
        f'friction="{falls.FRICTION} 0 0" contype="1" conaffinity="2"/>'
    )
    joint = f'<joint type="ball" stiffness="{bending / size}"/>'
    inner = f'<body pos="{size} 0 0">{joint}{geom}' * (n - 1) + "</body>" * (n - 1)
    first = f'<body pos="{-falls.MIDDLE} {falls.start_height(False)} 0"><freejoint/>{geom}'
    ball = (
        f'<geom type="sphere" size="{falls.OBSTACLE_RADIUS}" contype="2" conaffinity="1" '
        f'friction="{falls.FRICTION} 0 0"/>'
    )
    option = f'<option timestep="{dt}" integrator="implicitfast" gravity="0 {-falls.GRAVITY} 0"/>'
    return f"<mujoco>{option}<worldbody>{ball}{first}{inner}</body></worldbody></mujoco>"
