"""What a scene makes of loads that begin smoothly, followed mode by mode over their whole course.

Nothing starts at once there, so the amplitudes of the start show nothing.  But the loads are known
ahead: between the times at which they are sampled they are taken as straight, and with a load g
that bends by d at the times s, a mode of frequency w moves by

    eta(t) = g(t) / w^2 - sum d sin(w (t - s)) / w^3,

the load's own course and the vibration that its bends have set off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

# A mode is slower than the motion if it makes less than one turn in its time; and what has no
# frequency is given this angle, so small that it bends no motion [rad].
TURN, STILL = 2.0 * np.pi, 1e-3
# Share of the time after which loads are faded out, so that what they hold at the end does not
# count as a vibration.
FADED = 0.6


def parts(times: Vector, load: Vector, omega: Vector) -> tuple[Vector, Vector, Vector, Vector]:
    """Return what each mode does: the course it is led on, and the vibration about it.

    Parameters
    ----------
    times : (n,) float
        Equally spaced, the first one that of the start [s].
    load : (k, n) float
        Load of each mode of unit mass, zero at the start.
    omega : (k,) float
        Angular frequencies [rad/s].

    Returns
    -------
    led, led_omega : (k,) float
        Size of the whole motion, and the frequency that it has as a whole.
    free, free_omega : (k,) float
        Size of the vibration, none where a mode is slower than the motion.
    """
    t = times - times[0]
    length = float(t[-1])
    w = np.maximum(omega, STILL / length)
    slope = np.diff(load, axis=1) / np.diff(t)
    bend = np.diff(slope, axis=1, prepend=0.0)
    turns = np.exp(-1j * np.outer(w, t))
    before = np.pad(np.cumsum(bend * turns[:, :-1], axis=1), ((0, 0), (1, 0)))
    course = load / w[:, None] ** 2 - (before * turns.conj()).imag / w[:, None] ** 3
    led = np.abs(course).max(axis=1)
    acceleration = np.abs(load - w[:, None] ** 2 * course).max(axis=1)
    led_omega = np.sqrt(acceleration / np.maximum(led, np.finfo(float).tiny))
    fading = 0.5 + 0.5 * np.cos(np.pi * np.clip((t[:-1] / length - FADED) / (1.0 - FADED), 0, 1))
    free = np.abs((bend * fading * turns[:, :-1]).sum(axis=1)) / w**3
    fast = omega * length > TURN
    led_omega = np.where(fast, np.minimum(led_omega, w), led_omega)
    return led, led_omega, np.where(fast, np.minimum(free, led), 0.0), w
