"""Trapezoid columns, least squares, standard deviations and both condition numbers: a million rows by five.

m u' + d u + d_q u|u| + b - k v r = tau      over every sample interval
"""

from collections.abc import Iterator

import numpy as np
import statsmodels.api as sm
from paired import Row, paired
from partner import Partner


def columns(data: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """H (n - 1, 5) and y (n - 1), by the trapezoid."""
    t, u, v, r, tau = (data[name] for name in ("t", "u", "v", "r", "tau_u"))
    half = 0.5 * np.diff(t)

    def area(f: np.ndarray) -> np.ndarray:
        return half * (f[1:] + f[:-1])

    h = np.empty((len(t) - 1, 5))
    h[:, 0] = np.diff(u)
    h[:, 1] = area(u)
    h[:, 2] = area(u * np.abs(u))
    h[:, 3] = 2.0 * half
    h[:, 4] = -area(v * r)
    return h, area(tau)


def lstsq(data: dict[str, np.ndarray]) -> str:
    """By the singular values of H, as NumPy solves it."""
    h, y = columns(data)
    theta, squares, _, s = np.linalg.lstsq(h, y, rcond=None)
    variance = squares[0] / (len(y) - 5)
    _, _, vt = np.linalg.svd(np.linalg.qr(h, mode="r"))
    np.sqrt(variance * np.sum((vt.T / s) ** 2, axis=1))
    scaled = h / np.linalg.norm(h, axis=0)
    singular = np.linalg.svd(np.linalg.qr(scaled, mode="r"), compute_uv=False)
    return f"{theta.tolist()} cond {(s[0] / s[-1]) ** 2:e}, scaled {singular[0] / singular[-1]:e}"


def normal_equations(data: dict[str, np.ndarray]) -> str:
    """By the products of the columns: half of the digits, least work."""
    h, y = columns(data)
    gram, right = h.T @ h, h.T @ y
    theta = np.linalg.solve(gram, right)
    variance = (y @ y - theta @ right) / (len(y) - 5)
    np.sqrt(variance * np.diag(np.linalg.inv(gram)))
    scale = 1.0 / np.sqrt(np.diag(gram))
    return f"{theta.tolist()} cond {np.linalg.cond(gram):e}, scaled {np.linalg.cond(gram * np.outer(scale, scale)):e}"


def ols(data: dict[str, np.ndarray]) -> str:
    """By statsmodels, as its users write it."""
    h, y = columns(data)
    fit = sm.OLS(y, h).fit()
    return f"{fit.params.tolist()} cond {fit.condition_number:e} {fit.bse[0]:e}"


def rows(partner: Partner) -> Iterator[Row]:
    """The rows of the table."""
    data = partner.data("least_squares")
    work = "columns + least squares, 1e6 x 5"
    yield paired(partner, work, "least_squares", "NumPy lstsq", lambda: lstsq(data), goal="8")
    yield paired(partner, work, "least_squares", "statsmodels OLS", lambda: ols(data), goal="25")
    yield paired(partner, work, "least_squares", "NumPy normal equations", lambda: normal_equations(data), goal="1")
