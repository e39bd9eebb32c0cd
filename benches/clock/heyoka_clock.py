"""Problems of `cargo bench --workspace --bench clock` by heyoka (`pip install heyoka`): the fastest of five runs each, compilation not included."""

import math
import time

import heyoka as hy

x, y, px, py = hy.make_vars("x", "y", "px", "py")


def row(name, equations, start, end, energy):
    for tol in (1e-15, 1e-12):
        ta = hy.taylor_adaptive(equations, start, tol=tol)
        best, steps = float("inf"), 0
        for _ in range(5):
            ta.time, ta.state[:] = 0.0, start
            began = time.perf_counter()
            steps = ta.propagate_until(end)[3]
            best = min(best, time.perf_counter() - began)
        off = abs(energy(ta.state) - energy(start))
        print(f"{name}, tol {tol}: {steps} steps, {1e3 * best:.2f} ms, energy off by {off:.1e}, end {ta.state[0]:.15g}, {ta.state[1]:.15g}")


mu = 0.01
large, small = ((x - mu) ** 2 + y**2), ((x + 1.0 - mu) ** 2 + y**2)
restricted = [
    (x, px + y),
    (y, py - x),
    (px, py - (1.0 - mu) * (x - mu) / large**1.5 - mu * (x + 1.0 - mu) / small**1.5),
    (py, -px - (1.0 - mu) * y / large**1.5 - mu * y / small**1.5),
]


def jacobi(s):
    to_large, to_small = math.hypot(s[0] - mu, s[1]), math.hypot(s[0] + 1.0 - mu, s[1])
    return 0.5 * (s[2] ** 2 + s[3] ** 2) + s[1] * s[2] - s[0] * s[3] - (1.0 - mu) / to_large - mu / to_small


row("restricted three bodies to 2000", restricted, [-0.8, 0.0, 0.0, -0.6276410653920694], 2000.0, jacobi)

r = x**2 + y**2
kepler = [(x, px), (y, py), (px, -x / r**1.5), (py, -y / r**1.5)]
for e in (0.9, 0.99, 0.999):
    start = [1.0 - e, 0.0, 0.0, math.sqrt((1.0 + e) / (1.0 - e))]
    row(f"Kepler, e = {e}", kepler, start, 20.0 * math.pi + 1.0, lambda s: 0.5 * (s[2] ** 2 + s[3] ** 2) - 1.0 / math.hypot(s[0], s[1]))
