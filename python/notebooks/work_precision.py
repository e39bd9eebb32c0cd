# %% [markdown]
# # Work and precision beside SciPy
#
# A Kepler orbit of eccentricity 0.6 over 50 periods: the error of the end against the time that it takes, and the error of
# the energy along the path. `solve_ivp` controls its own step and calls a function of Python; the symplectic schemes have a
# constant step and are compiled.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import wzvi

Kepler = wzvi.compile(
    "|[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt()",
    embedding=["Verlet", "Gauss<8>"],
    schemes="Composed<Verlet, KahanLi8>",
    name="Kepler",
    doc="Kepler's problem in the plane, with unit mass and attraction.",
    want="path",
)
kepler = Kepler()

# %%
eccentricity, end = 0.6, 100 * np.pi
q, p = np.array([1 - eccentricity, 0.0]), np.array([0.0, np.sqrt((1 + eccentricity) / (1 - eccentricity))])


def timed(run):
    """The result of a run, and the shortest of three times."""
    times = []
    for _ in range(3):
        began = time.perf_counter()
        result = run()
        times.append(time.perf_counter() - began)
    return result, min(times)


def right_hand_side(t, z):
    r3 = (z[0] * z[0] + z[1] * z[1]) ** 1.5
    return [z[2], z[3], -z[0] / r3, -z[1] / r3]


# %%
curves = {}
for scheme, steps in [("Verlet", (4, 6, 8, 10)), ("Composed<Verlet, KahanLi8>", (0, 1, 2, 3, 4)), ("Gauss<8>", (-1, 0, 1, 2))]:
    for power in steps:
        h = 2 * np.pi / (32 * 2**power)
        path, took = timed(lambda: kepler.simulate(scheme, h=h, q=q, p=p, until=end, record_every=0))
        curves.setdefault(scheme, []).append((took, np.hypot(*(path.q[-1] - q))))
for method in ("RK45", "DOP853"):
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        solution, took = timed(lambda: solve_ivp(right_hand_side, (0, end), [*q, *p], method=method, rtol=tolerance, atol=tolerance))
        curves.setdefault(f"SciPy {method}", []).append((took, np.hypot(*(solution.y[:2, -1] - q))))

# %% [markdown]
# ## Energies along the path
# Those of a symplectic scheme oscillate and do not drift.

# %%
path = kepler.simulate("Composed<Verlet, KahanLi8>", h=2 * np.pi / 64, q=q, p=p, until=end, record_every=3)
solution = solve_ivp(right_hand_side, (0, end), [*q, *p], method="DOP853", rtol=1e-7, atol=1e-7)
z = solution.y
energies = 0.5 * (z[2] ** 2 + z[3] ** 2) - 1 / np.hypot(z[0], z[1])

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for name, points in curves.items():
    took, error = np.array(points).T
    left.loglog(error, took, "o--" if name.startswith("SciPy") else "o-", label=name, ms=4)
left.set(xlabel="error of the position after 50 periods", ylabel="time in s")
left.invert_xaxis()
left.legend(fontsize=8)
right.semilogy(path.t / (2 * np.pi), np.abs(path.energy / path.energy[0] - 1) + 1e-16, lw=0.6, label="Composed<Verlet, KahanLi8>, h = T/64")
right.semilogy(solution.t / (2 * np.pi), np.abs(energies / energies[0] - 1) + 1e-16, lw=0.6, label="SciPy DOP853, rtol = 1e-7")
right.set(xlabel="time in periods", ylabel="relative error of the energy", ylim=(1e-9, None))
right.legend(fontsize=8)
figure.savefig("work_precision.png", dpi=120)

# %%
for name, points in curves.items():
    print(f"{name:28}", ", ".join(f"{error:.1e} in {1000 * took:.1f} ms" for took, error in points))
assert min(error for _, error in curves["Gauss<8>"]) < 1e-8
