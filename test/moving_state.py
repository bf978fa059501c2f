"""A navigator in the middle of a motion, what it measures there, and what it should."""

import numpy as np
from scipy.spatial.transform import Rotation
from simulated_walks import filtered, navigator, streamed, walk

from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.navigation.aids import NO_AIDS

DT = 0.005
LEVEL_WALK = walk(strides=12, turn=0.3, mounted=np.eye(3))

STATE = {
    'attitude': Rotation.from_euler('xyz', [0.5, -0.7, 2.0]),
    'velocity': np.array([3.0, -1.0, 0.5]),
    'rate': np.array([0.4, -0.3, 0.8]),
    'rate_bias': np.array([0.01, -0.02, 0.005]),
}


def placed(**settings):
    """Return rules and a state in which all errors are known a little, and a moving sample."""
    found = navigator(look_ahead=0.0, acceleration_noise=1e-6, **settings)
    streamed(found, LEVEL_WALK.block().part(0, 110))
    state = found._state
    state[layout.X_ATTITUDE : layout.X_ATTITUDE + 4] = STATE['attitude'].as_quat()
    state[layout.X_VELOCITY : layout.X_VELOCITY + 3] = STATE['velocity']
    state[layout.X_RATE_BIAS : layout.X_RATE_BIAS + 3] = STATE['rate_bias']
    root = 1e-3 * np.random.default_rng(0).normal(size=(16, 16))
    state[layout.COVARIANCE : layout.COVARIANCE + 256] = (root @ root.T).ravel()
    row = np.array([[DT, *STATE['attitude'].inv().apply([0.0, 0.0, 9.81]), *STATE['rate'], 0.0]])
    return found._rules, state, row


def measurements(rules, state, row, aids=NO_AIDS):
    """Return state before, and (H, innovation) of all that one sample measures."""
    off = rules.copy()
    off[[layout.NONHOLONOMIC, layout.GRAVITY_DIRECTION]] = 0.0
    moving = np.array([[0.0, 1.0, 0.0]])
    _, before, _ = filtered(off, state.copy(), row, moving)
    _, after, log = filtered(rules, state, row, moving, aids)
    log = log[: int(after[0, -1])]
    log = log[log[:, 0] == layout.MEASURE]
    return before[0, 16:33], [(entry[19:35], entry[2]) for entry in log]


def jacobian(value, x):
    """Return the derivatives of value(position, v, R, b_g, b_a) by the errors, numerically."""

    def moved(e):
        turn = Rotation.from_rotvec(e[6:9])
        return value(
            turn.apply(x[3:6]) + e[3:6], turn * Rotation.from_quat(x[13:17]), x[6:9] + e[9:12]
        )

    h, columns = 1e-6, []
    for j in range(16):
        e = np.zeros(16)
        e[j] = h
        columns.append((moved(e) - moved(-e)) / (2.0 * h))
    return np.array(columns).T
