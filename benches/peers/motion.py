"""The planar motion by RK4, written by hand for numba, built for CasADi, given to SciPy."""

from collections.abc import Iterator

import casadi as ca
import numpy as np
from numba import njit
from paired import Row, paired
from partner import Partner
from scipy.integrate import solve_ivp

STEP = 0.1


@njit(cache=False, fastmath=False)
def rates(u, v, r, a, b, c, p):
    """Accelerations; p: virtual mass, linear and quadratic drag, advance loss of surge, sway, yaw."""
    du = ((1.0 - p[3] * abs(u)) * a + p[4] * v * r - (p[1] + p[2] * abs(u)) * u) / p[0]
    dv = ((1.0 - p[7] * abs(v)) * b - p[0] * u * r - (p[5] + p[6] * abs(v)) * v) / p[4]
    dr = ((1.0 - p[11] * abs(r)) * c - (p[4] - p[0]) * u * v - (p[9] + p[10] * abs(r)) * r) / p[8]
    return du, dv, dr


@njit(cache=False)
def sail(tau_u, tau_v, tau_r, h, p):
    """All steps of the classical scheme, inputs linear between samples; returns the states at every sample."""
    n = len(tau_u)
    out = np.empty((n, 4))
    u = v = r = psi = 0.0
    out[0] = 0.0
    for k in range(n - 1):
        a, b, c = tau_u[k], tau_v[k], tau_r[k]
        a1, b1, c1 = tau_u[k + 1], tau_v[k + 1], tau_r[k + 1]
        am, bm, cm = 0.5 * (a + a1), 0.5 * (b + b1), 0.5 * (c + c1)
        u1, v1, r1 = rates(u, v, r, a, b, c, p)
        ra = r + 0.5 * h * r1
        u2, v2, r2 = rates(u + 0.5 * h * u1, v + 0.5 * h * v1, ra, am, bm, cm, p)
        rb = r + 0.5 * h * r2
        u3, v3, r3 = rates(u + 0.5 * h * u2, v + 0.5 * h * v2, rb, am, bm, cm, p)
        rc = r + h * r3
        u4, v4, r4 = rates(u + h * u3, v + h * v3, rc, a1, b1, c1, p)
        psi += h / 6.0 * (r + 2.0 * ra + 2.0 * rb + rc)
        u += h / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4)
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
        r += h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4)
        out[k + 1, 0], out[k + 1, 1], out[k + 1, 2], out[k + 1, 3] = u, v, r, psi
    return out


def casadi_rates(x, tau, p):
    """The same accelerations and the rate of the heading, as CasADi expressions."""
    u, v, r = x[0], x[1], x[2]
    return ca.vertcat(
        ((1 - p[3] * ca.fabs(u)) * tau[0] + p[4] * v * r - (p[1] + p[2] * ca.fabs(u)) * u) / p[0],
        ((1 - p[7] * ca.fabs(v)) * tau[1] - p[0] * u * r - (p[5] + p[6] * ca.fabs(v)) * v) / p[4],
        ((1 - p[11] * ca.fabs(r)) * tau[2] - (p[4] - p[0]) * u * v - (p[9] + p[10] * ca.fabs(r)) * r) / p[8],
        r,
    )


def casadi_step() -> ca.Function:
    """One step of the same scheme as a CasADi function of state, both inputs and parameters."""
    x, a, b, p = ca.SX.sym("x", 4), ca.SX.sym("a", 3), ca.SX.sym("b", 3), ca.SX.sym("p", 12)
    middle = 0.5 * (a + b)
    k1 = casadi_rates(x, a, p)
    k2 = casadi_rates(x + 0.5 * STEP * k1, middle, p)
    k3 = casadi_rates(x + 0.5 * STEP * k2, middle, p)
    k4 = casadi_rates(x + STEP * k3, b, p)
    return ca.Function("step", [x, a, b, p], [x + STEP / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)])


def scipy_sail(data: dict[str, np.ndarray], p: np.ndarray) -> str:
    """By RK45 with a step of its own choice; the inputs are interpolated where it asks."""
    t = data["t"]
    taus = [data[f"tau_{name}"] for name in "uvr"]

    def f(at, x):
        a, b, c = (np.interp(at, t, tau) for tau in taus)
        du, dv, dr = rates.py_func(x[0], x[1], x[2], a, b, c, p)
        return [du, dv, dr, x[2]]

    # tolerances at which its error is that of the fixed steps, about 1e-6
    end = solve_ivp(f, (t[0], t[-1]), [0.0] * 4, rtol=1e-6, atol=1e-9).y[:, -1]
    return str(end.tolist())


def rows(partner: Partner) -> Iterator[Row]:
    """The rows of the table."""
    data = partner.data("rk4")
    p = data["figures"]
    taus = [data[f"tau_{name}"] for name in "uvr"]
    both = np.vstack(taus)
    chain = casadi_step().mapaccum("sail", both.shape[1] - 1)
    fixed = np.repeat(p[:, None], both.shape[1] - 1, axis=1)

    def by_numba() -> str:
        return str(sail(*taus, STEP, p)[-1].tolist())

    def by_casadi() -> str:
        return str(np.asarray(chain(np.zeros(4), both[:, :-1], both[:, 1:], fixed))[:, -1].tolist())

    def sixteen_by_numba() -> str:
        for _ in range(16):
            sail(*taus, STEP, p)
        return ""

    work = "RK4, planar, 6,000 steps"
    yield paired(partner, work, "rk4", "numba by hand", by_numba, goal="1.5", pairs=41)
    yield paired(partner, work, "rk4", "CasADi", by_casadi, goal="", pairs=15)
    yield paired(partner, work, "rk4", "SciPy RK45", lambda: scipy_sail(data, p), goal="", pairs=7)
    work = "RK4, ensemble of 16 trajectories"
    yield paired(partner, work, "ensemble", "numba by hand", sixteen_by_numba, goal="4", pairs=41)
