"""BAOAB for the quartic and for sine-Gordon with 1024 sites, as loops by hand in numba: nanoseconds per path and step (and site).

    pip install numba && python benches/ensemble/baoab_numba.py

One core, as the rows `Baoab` of `cargo bench --workspace --bench ensemble`, with the same systems, steps and friction, and numba's own normals.
"""

import time

import numba
import numpy as np


@numba.njit(fastmath=True)
def quartic(paths, steps, h, gamma, kt):
    decay = np.exp(-gamma * h)
    deviation = np.sqrt(kt * (1.0 - decay * decay))
    total = 0.0
    for path in range(paths):
        q, p = 0.5, 0.5
        force = -q - q * q * q
        for step in range(steps):
            p += 0.5 * h * force
            q += 0.5 * h * p
            p = decay * p + deviation * np.random.normal()
            q += 0.5 * h * p
            force = -q - q * q * q
            p += 0.5 * h * force
        total += q * q
    return total / paths


@numba.njit(fastmath=True)
def pull(q, force):
    n = q.size
    for i in range(n):
        force[i] = q[(i + 1) % n] + q[i - 1] - 2.0 * q[i] - np.sin(q[i])


@numba.njit(fastmath=True)
def sine_gordon(sites, steps, h, gamma, kt):
    decay = np.exp(-gamma * h)
    deviation = np.sqrt(kt * (1.0 - decay * decay))
    q, p, force = np.zeros(sites), np.zeros(sites), np.zeros(sites)
    pull(q, force)
    for step in range(steps):
        for i in range(sites):
            p[i] += 0.5 * h * force[i]
            q[i] += 0.5 * h * p[i]
            p[i] = decay * p[i] + deviation * np.random.normal()
            q[i] += 0.5 * h * p[i]
        pull(q, force)
        for i in range(sites):
            p[i] += 0.5 * h * force[i]
    total = 0.0
    for i in range(sites):
        total += p[i] * p[i]
    return total / sites


def shortest(run, units):
    run()
    times = []
    for _ in range(5):
        began = time.perf_counter()
        run()
        times.append(time.perf_counter() - began)
    return min(times) * 1e9 / units


print(f"quartic      {shortest(lambda: quartic(512, 1000, 0.1, 1.0, 1.0), 512 * 1000):8.2f} ns per path and step")
print(f"sine-Gordon  {shortest(lambda: sine_gordon(1024, 2000, 0.05, 1.0, 1.0), 1024 * 2000):8.2f} ns per site and step")
