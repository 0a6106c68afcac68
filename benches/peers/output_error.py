"""Output error on segments: eight planar runs of 120 s at 10 Hz, 120 segments, 491 unknowns.

min  sum |x(t; x0, theta) - y|^2 / sigma^2     by Gauss-Newton with the exact Jacobian
"""

from collections.abc import Iterator

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numba import njit
from paired import Row, paired
from partner import Partner
from scipy.sparse.linalg import spsolve

STEP = 0.1
SIGMA = np.array([0.005, 0.005, 0.003, 0.005])
# what the fit knows: m, d, d_q of surge, sway, yaw, and the biases of surge and yaw
NAMES = 11
ITERATIONS = 12


def order(start: np.ndarray) -> np.ndarray:
    """Our order (inertias, linear, quadratic, biases) as (m, d, d_q) of each degree of freedom and the biases."""
    m, d, q, bias = start[0:3], start[3:6], start[6:9], start[9:11]
    return np.concatenate([np.column_stack([m, d, q]).ravel(), bias])


def problem(data: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (segments, 80, 2, 3), measurements (segments, 80, 4) and weights of the segments' samples."""
    inputs, measured = [], []
    for k in range(8):
        tau = np.stack([data[f"run{k}_tau_{name}"] for name in "uvr"], axis=1)
        y = np.stack([data[f"run{k}_{name}"] for name in ("u", "v", "r", "psi")], axis=1)
        steps = 80
        for first in range(0, len(y) - steps, steps):
            both = np.stack([tau[first : first + steps], tau[first + 1 : first + steps + 1]], axis=1)
            inputs.append(both)
            measured.append(y[first : first + steps])
    return np.array(inputs), np.array(measured), 1.0 / SIGMA


@njit(cache=False)
def slope(x, tau, p, f, fx, fp):
    """Rates of the state, and their derivatives by state and parameters."""
    u, v, r = x[0], x[1], x[2]
    mu, du, qu, mv, dv, qv, mr, dr, qr, bu, br = p
    f[0] = (tau[0] + mv * v * r - (du + qu * abs(u)) * u - bu) / mu
    f[1] = (tau[1] - mu * u * r - (dv + qv * abs(v)) * v) / mv
    f[2] = (tau[2] - (mv - mu) * u * v - (dr + qr * abs(r)) * r - br) / mr
    f[3] = r
    fx[:] = 0.0
    fx[0, 0], fx[0, 1], fx[0, 2] = -(du + 2 * qu * abs(u)) / mu, mv * r / mu, mv * v / mu
    fx[1, 0], fx[1, 1], fx[1, 2] = -mu * r / mv, -(dv + 2 * qv * abs(v)) / mv, -mu * u / mv
    fx[2, 0], fx[2, 1], fx[2, 2] = -(mv - mu) * v / mr, -(mv - mu) * u / mr, -(dr + 2 * qr * abs(r)) / mr
    fx[3, 2] = 1.0
    fp[:] = 0.0
    fp[0, 0], fp[0, 1], fp[0, 2], fp[0, 3], fp[0, 9] = -f[0] / mu, -u / mu, -u * abs(u) / mu, v * r / mu, -1 / mu
    fp[1, 0], fp[1, 3], fp[1, 4], fp[1, 5] = -u * r / mv, -f[1] / mv, -v / mv, -v * abs(v) / mv
    fp[2, 0], fp[2, 3], fp[2, 6] = u * v / mr, -u * v / mr, -f[2] / mr
    fp[2, 7], fp[2, 8], fp[2, 10] = -r / mr, -r * abs(r) / mr, -1 / mr


@njit(cache=False)
def step(p, x0, inputs, measured, weight):
    """One Gauss-Newton step with the initial states eliminated segment by segment; changes x0, returns p and cost."""
    segments, n = measured.shape[0], measured.shape[1]
    nx, npar = 4, p.shape[0]
    gram, right = np.zeros((npar, npar)), np.zeros(npar)
    back = np.empty((segments, nx, npar + 1))
    cost = 0.0
    f, fx, fp = np.empty(nx), np.empty((nx, nx)), np.empty((nx, npar))
    for s in range(segments):
        x = x0[s].copy()
        jac = np.zeros((nx, nx + npar))
        for i in range(nx):
            jac[i, i] = 1.0
        a, b, c = np.zeros((nx, nx)), np.zeros((nx, npar)), np.zeros((npar, npar))
        gx, gp = np.zeros(nx), np.zeros(npar)
        for k in range(n):
            for i in range(nx):
                w = weight[i]
                e = (x[i] - measured[s, k, i]) * w
                cost += e * e
                row = jac[i] * w
                for j in range(nx):
                    gx[j] += row[j] * e
                    for m in range(nx):
                        a[j, m] += row[j] * row[m]
                    for m in range(npar):
                        b[j, m] += row[j] * row[nx + m]
                for j in range(npar):
                    gp[j] += row[nx + j] * e
                    for m in range(npar):
                        c[j, m] += row[nx + j] * row[nx + m]
            if k == n - 1:
                break
            total, total_j = np.zeros(nx), np.zeros((nx, nx + npar))
            kx, kj = np.zeros(nx), np.zeros((nx, nx + npar))
            for stage in range(4):
                node = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                tau = (1.0 - node) * inputs[s, k, 0] + node * inputs[s, k, 1]
                xs, js = x + STEP * node * kx, jac + STEP * node * kj
                slope(xs, tau, p, f, fx, fp)
                kx = f.copy()
                kj = fx @ js
                kj[:, nx:] += fp
                share = STEP / 6.0 * (2.0 if stage == 1 or stage == 2 else 1.0)
                total += share * kx
                total_j += share * kj
            x = x + total
            jac = jac + total_j
        both = np.empty((nx, npar + 1))
        both[:, :npar] = b
        both[:, npar] = gx
        solved = np.linalg.solve(a, both)
        back[s] = solved
        gram += c - np.ascontiguousarray(b.T) @ np.ascontiguousarray(solved[:, :npar])
        right += gp - np.ascontiguousarray(b.T) @ np.ascontiguousarray(solved[:, npar])
    change = np.linalg.solve(gram, right)
    for s in range(segments):
        x0[s] -= back[s, :, npar] - np.ascontiguousarray(back[s, :, :npar]) @ change
    return p - change, cost


def by_numba(start, inputs, measured, weight) -> str:
    """Gauss-Newton with the sensitivities above, until the cost stays."""
    p, x0, last, taken = start.copy(), measured[:, 0].copy(), np.inf, 0
    for _ in range(ITERATIONS):
        taken += 1
        p, cost = step(p, x0, inputs, measured, weight)
        if abs(last - cost) < 1e-3:
            break
        last = cost
    return f"{taken} steps, cost {cost:.6f}"


def casadi_residual(inputs, measured, weight):
    """The residuals as a function of (theta, all initial states), and their sparse Jacobian."""
    segments, n = measured.shape[0], measured.shape[1]
    x, both, p = ca.SX.sym("x", 4), ca.SX.sym("tau", 6), ca.SX.sym("p", NAMES)

    def f(x, tau):
        mu, du, qu, mv, dv, qv, mr, dr, qr, bu, br = ca.vertsplit(p)
        u, v, r = x[0], x[1], x[2]
        return ca.vertcat(
            (tau[0] + mv * v * r - (du + qu * ca.fabs(u)) * u - bu) / mu,
            (tau[1] - mu * u * r - (dv + qv * ca.fabs(v)) * v) / mv,
            (tau[2] - (mv - mu) * u * v - (dr + qr * ca.fabs(r)) * r - br) / mr,
            r,
        )

    a, b = both[:3], both[3:]
    k1 = f(x, a)
    k2 = f(x + 0.5 * STEP * k1, 0.5 * (a + b))
    k3 = f(x + 0.5 * STEP * k2, 0.5 * (a + b))
    k4 = f(x + STEP * k3, b)
    one = ca.Function("one", [x, both, p], [x + STEP / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)])
    chain = one.mapaccum("chain", n - 1)
    theta, states = ca.MX.sym("theta", NAMES), ca.MX.sym("x0", 4, segments)
    flat = inputs.reshape(segments, n, 6)
    parts = []
    for s in range(segments):
        path = chain(states[:, s], flat[s, : n - 1].T, ca.repmat(theta, 1, n - 1))
        error = ca.horzcat(states[:, s], path) - measured[s].T
        parts.append(ca.vec(error * ca.repmat(ca.DM(weight), 1, n)))
    w = ca.vertcat(theta, ca.vec(states))
    residual = ca.Function("residual", [theta, states], [ca.vertcat(*parts)])
    unknowns = ca.MX.sym("w", NAMES + 4 * segments)
    value = residual(unknowns[:NAMES], ca.reshape(unknowns[NAMES:], 4, segments))
    del w
    return ca.Function("both", [unknowns], [value, ca.jacobian(value, unknowns)])


def by_casadi(function, start, measured) -> str:
    """Gauss-Newton on the sparse Jacobian of all unknowns, until the cost stays."""
    w = np.concatenate([start, measured[:, 0].ravel()])
    last, taken = np.inf, 0
    for _ in range(ITERATIONS):
        taken += 1
        value, jacobian = function(w)
        r, j = np.asarray(value).ravel(), sp.csc_matrix(jacobian.sparse())
        cost = float(r @ r)
        if abs(last - cost) < 1e-3:
            break
        last = cost
        w = w - spsolve((j.T @ j).tocsc(), j.T @ r)
    return f"{taken} steps, cost {cost:.6f}"


def rows(partner: Partner) -> Iterator[Row]:
    """The rows of the table."""
    data = partner.data("output_error")
    start = order(data["start"])
    inputs, measured, weight = problem(data)
    function = casadi_residual(inputs, measured, weight)
    work = "output error, 8 runs, 491 unknowns"
    yield paired(
        partner, work, "output_error", "numba by hand", lambda: by_numba(start, inputs, measured, weight), goal="3"
    )
    yield paired(
        partner,
        work,
        "output_error",
        "CasADi Gauss-Newton",
        lambda: by_casadi(function, start, measured),
        goal="20",
        pairs=7,
    )
