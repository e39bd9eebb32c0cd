"""Ends of Kepler's flow to 80 digits, with their conditions: python3 kepler_flow.py > kepler_flow.json (pip install mpmath)"""

import json
import math

from mpmath import cos, cosh, factorial, mp, mpf, nstr, sin, sinh, sqrt

mp.dps = 80


def stumpff(beta, s):
    """s^n c_n(beta s^2) for n = 0 to 3"""
    x = beta * s * s
    if abs(x) < mpf("1e-3"):
        return [s**n * sum((-x) ** j / factorial(n + 2 * j) for j in range(30)) for n in range(4)]
    root = sqrt(abs(beta))
    (c, f) = (cos(root * s), sin(root * s)) if beta > 0 else (cosh(root * s), sinh(root * s))
    return [c, f / root, (1 - c) / beta, (s - f / root) / beta]


def flow(w, k, q, p, h):
    v, mu = [w * x for x in p], w * k
    r0 = sqrt(sum(x * x for x in q))
    eta = sum(a * b for a, b in zip(q, v))
    beta = 2 * mu / r0 - sum(x * x for x in v)
    zeta = mu - beta * r0

    def left(s):
        g = stumpff(beta, s)
        return r0 * s + eta * g[2] + zeta * g[3] - h

    sign = 1 if h > 0 else -1
    low, high = mpf(0), sign * mpf("1e-12")
    while sign * left(high) < 0:
        high *= 2
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if sign * left(middle) < 0 else (low, middle)
    s = (low + high) / 2
    for _ in range(12):
        g = stumpff(beta, s)
        correction = left(s) / (r0 + eta * g[1] + zeta * g[2])
        s -= correction
        if abs(correction) < abs(s) * mpf(10) ** -46:
            break
    else:
        raise SystemExit("no solution")
    g = stumpff(beta, s)
    r = r0 + eta * g[1] + zeta * g[2]
    q1 = [(1 - mu * g[2] / r0) * a + (r0 * g[1] + eta * g[2]) * b for a, b in zip(q, v)]
    p1 = [-k * g[1] / (r * r0) * a + (1 - mu * g[2] / r) * b for a, b in zip(q, p)]
    return q1 + p1


def condition(arguments, end):
    """The sizes of the changes of q and p by relative changes of all arguments."""
    changes = [mpf(0)] * 6
    for i, a in enumerate(arguments):
        if a == 0:
            continue
        moved, step = list(arguments), abs(a) * mpf(10) ** -18
        moved[i] = a + step
        other = flow(moved[6], moved[7], moved[:3], moved[3:6], moved[8])
        for j in range(6):
            changes[j] += abs((other[j] - end[j]) / step * a)
    return [float(f"{float(sqrt(sum(c * c for c in half))):.4g}") for half in (changes[:3], changes[3:])]


def placed(x, y):
    """A plane in space."""
    x, y = math.cos(0.7) * x - math.sin(0.7) * y, math.sin(0.7) * x + math.cos(0.7) * y
    return [x, math.cos(0.4) * y, math.sin(0.4) * y]


cases = []


def add(e, nu, periods):
    w, k = 0.8, 1.3
    mu = w * k
    # Semi-major axis 1; a parabola has the parameter 1.
    pericentre = 0.5 if e == 1 else abs(1 - e)
    spin = math.sqrt(mu * pericentre * (1 + e))
    r = pericentre * (1 + e) / (1 + e * math.cos(nu))
    q = placed(r * math.cos(nu), r * math.sin(nu))
    p = [c / w for c in placed(-mu / spin * math.sin(nu), mu / spin * (e + math.cos(nu)))]
    h = periods * (2 * math.pi / math.sqrt(mu))
    arguments = [mpf(x) for x in q + p + [w, k, h]]
    end = flow(arguments[6], arguments[7], arguments[:3], arguments[3:6], arguments[8])
    case = {"e": e, "periods": abs(periods), "w": w, "k": k, "h": h, "q": q, "p": p}
    cases.append(case | {"end": [nstr(x, 30) for x in end], "condition": condition(arguments, end)})


for e in [0, 0.5, 0.99, 1, 1.5, 3]:
    for place in [0, 1]:
        nu = [0.0, 1.9 if e < 1 else -1.2][place]
        for periods in [1e-6, 1e-3, 0.05, 0.37, 1.0, 9.3, 1e3]:
            for sign in [1] if periods in (1e-3, 9.3) else [1, -1]:
                add(e, nu, sign * periods)
# From far away past the pericentre to far away.
for e in [1.01, 1.5, 3]:
    for sign in [1, -1]:
        for distance, periods in [(1e2, 50.0), (1e4, 4e3)]:
            nu = math.acos(((e * e - 1) / distance - 1) / e)
            add(e, -sign * nu, sign * periods)
print("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]")
