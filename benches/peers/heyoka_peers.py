"""The problems of `cargo bench --workspace --bench peers` by heyoka (`pip install heyoka`): the fastest of five runs each, compilation not included."""

import math
import time

import heyoka as hy

x, y, px, py = hy.make_vars("x", "y", "px", "py")
henon_heiles = [(x, px), (y, py), (px, -x - 2.0 * x * y), (py, -y - x * x + y * y)]


def energy(s):
    return 0.5 * (s[2] ** 2 + s[3] ** 2 + s[0] ** 2 + s[1] ** 2) + s[0] ** 2 * s[1] - s[1] ** 3 / 3.0


def fastest(ta, start, end):
    best = float("inf")
    for _ in range(5):
        ta.time, ta.state[:] = 0.0, start
        began = time.perf_counter()
        ta.propagate_until(end)
        best = min(best, time.perf_counter() - began)
    return best


def row(name, ta, start, end, of):
    before = of(start)
    took = fastest(ta, start, end)
    print(f"{name}: {1e3 * took:.2f} ms, energy off by {abs(of(ta.state) - before):.1e} at the end")


start = [0.1, 0.0, 0.0, 0.5]
row("Hénon and Heiles to 5e4", hy.taylor_adaptive(henon_heiles, start, tol=1e-15), start, 5e4, energy)

pendulum = hy.taylor_adaptive([(x, px), (px, -hy.sin(x))], [1.3, 0.0], tol=1e-15)
row("pendulum to 1e4", pendulum, [1.3, 0.0], 1e4, lambda s: 0.5 * s[1] ** 2 - math.cos(s[0]))

crossings = []
section = hy.nt_event(x, lambda ta, t, sign: crossings.append(t), direction=hy.event_direction.positive)
ta = hy.taylor_adaptive(henon_heiles, start, tol=1e-15, nt_events=[section])
took = fastest(ta, start, 2000.0)
print(f"section to 2000: {1e3 * took:.2f} ms, {len(crossings) // 5} crossings")
