#!/usr/bin/env python3
"""Steps of 100 random linkages, solved to 40 digits: writes `linkages.json`. Needs mpmath.

    P = p - (h/2) (V_q(q) + G(q)^T lam),  q1 = q + h P/m,  g(q1) = 0,
    p1 = P - (h/2) (V_q(q1) + G(q1)^T mu),  G(q1) p1/m = 0

for `V = sum_i m_i gravity . x_i + trap_i |x_i|^4 / 4`, rods `(|x_a - x_b|^2 - length^2)/2` and pins
`(|x_a|^2 - arm^2)/2`. All input numbers are doubles. The condition number is that of `G W G^T` scaled to a unit
diagonal, the larger one of both ends.
"""
import json
import os
import random

from mpmath import eigsy, exp, lu_solve, matrix, mp, mpf, sqrt

mp.dps = 50
random.seed(56)
CASES = 100


class Linkage:
    def __init__(self, number):
        self.dimension = 2 + number % 2
        rods = random.randint(3, 12)
        self.rods, self.pins = [], []
        if random.random() < 0.5:
            # A tree: every body hangs on one before it.
            bodies = rods + 1
            self.rods = [[random.randrange(i), i] for i in range(1, bodies)]
        else:
            # A ring, and chords while the Jacobian keeps its rank.
            bodies = random.randint(3, rods)
            self.rods = [[i, (i + 1) % bodies] for i in range(bodies)]
            chords = [[i, j] for i in range(bodies) for j in range(i + 2, bodies) if (j + 1) % bodies != i]
            random.shuffle(chords)
            most = min(rods, self.dimension * bodies - 1 - self.dimension * (self.dimension + 1) // 2)
            self.rods += chords[: max(0, most - len(self.rods))]
        if random.random() < 0.4:
            self.pins = [random.randrange(bodies)]
        self.bodies = bodies
        self.mass = [round(10 ** random.uniform(-2, 2), 6) for _ in range(bodies)]
        self.trap = [round(random.uniform(0, 0.5) * m, 6) for m in self.mass]
        self.gravity = [round(random.uniform(-1, 1), 6) if c < self.dimension else 0.0 for c in range(3)]
        self.q = [[random.randrange(-1024, 1024) / 512 if c < self.dimension else 0.0 for c in range(3)]
                  for _ in range(bodies)]
        flat = self.flat(self.q)
        self.length = [float(sqrt(sum((flat[3 * a + c] - flat[3 * b + c]) ** 2 for c in range(3)))) for a, b in self.rods]
        self.arm = [float(sqrt(sum(flat[3 * a + c] ** 2 for c in range(3)))) for a in self.pins]
        self.w = [1 / mpf(m) for m in self.mass for _ in range(3)]

    def flat(self, rows):
        return [mpf(entry) for row in rows for entry in row]

    def values(self, q):
        rods = [(sum((q[3 * a + c] - q[3 * b + c]) ** 2 for c in range(3)) - mpf(l) ** 2) / 2
                for (a, b), l in zip(self.rods, self.length)]
        return rods + [(sum(q[3 * a + c] ** 2 for c in range(3)) - mpf(l) ** 2) / 2 for a, l in zip(self.pins, self.arm)]

    def jacobian(self, q):
        rows = []
        for a, b in self.rods:
            rows.append({3 * s + c: sign * (q[3 * a + c] - q[3 * b + c]) for s, sign in ((a, 1), (b, -1)) for c in range(3)})
        rows += [{3 * a + c: q[3 * a + c] for c in range(3)} for a in self.pins]
        return rows

    def slope(self, q):
        slope = []
        for i in range(self.bodies):
            x = q[3 * i:3 * i + 3]
            square = sum(c * c for c in x)
            slope += [mpf(self.mass[i]) * mpf(self.gravity[c]) + mpf(self.trap[i]) * square * x[c] for c in range(3)]
        return slope

    def gram(self, later, earlier):
        return matrix([[sum((one[i] * self.w[i] * other[i] for i in one if i in other), mpf(0)) for other in earlier]
                       for one in later])

    def project(self, q, p):
        """p - G^T nu with G W p = 0."""
        rows = self.jacobian(q)
        rates = matrix([sum(entry * self.w[i] * p[i] for i, entry in row.items()) for row in rows])
        nu = lu_solve(self.gram(rows, rows), rates)
        return self.pushed(p, rows, nu)

    def pushed(self, p, rows, nu):
        p = list(p)
        for row, impulse in zip(rows, nu):
            for i, entry in row.items():
                p[i] -= entry * impulse
        return p

    def drift(self, q, p, h):
        rows = self.jacobian(q)
        nu = matrix([mpf(0)] * len(rows))
        for _ in range(60):
            moved = self.pushed(p, rows, nu)
            end = [x + h * w * y for x, w, y in zip(q, self.w, moved)]
            values = self.values(end)
            if max(abs(value) for value in values) < mpf(10) ** -42:
                return end, moved
            nu += lu_solve(self.gram(self.jacobian(end), rows), matrix(values)) / h
        return None

    def kick(self, q, p, h):
        return [y - h * slope for y, slope in zip(p, self.slope(q))]

    def rattle(self, q, p, h):
        drifted = self.drift(q, self.kick(q, p, h / 2), h)
        if drifted is None:
            return None
        q, p = drifted
        return q, self.project(q, self.kick(q, p, h / 2))

    def yoshida(self, q, p, h):
        outer = 1 / (2 - mpf(2) ** (mpf(1) / 3))
        for weight in (outer, 1 - 2 * outer, outer):
            step = self.rattle(q, p, weight * h)
            if step is None:
                return None
            q, p = step
        return q, p

    def bath(self, q, p, h, gamma, kt, normals):
        c = exp(-mpf(gamma) * h)
        p = self.project(q, self.kick(q, p, h / 2))
        for half in range(2):
            drifted = self.drift(q, p, h / 2)
            if drifted is None:
                return None
            q, p = drifted
            p = self.project(q, p)
            if half == 0:
                size = sqrt(mpf(kt) * (1 - c * c))
                p = [c * y + size / sqrt(w) * mpf(xi) for y, w, xi in zip(p, self.w, normals)]
                p = self.project(q, p)
        return q, self.project(q, self.kick(q, p, h / 2))

    def condition(self, q):
        rows = self.jacobian(q)
        a = self.gram(rows, rows)
        n = a.rows
        scaled = matrix([[a[i, j] / sqrt(a[i, i] * a[j, j]) for j in range(n)] for i in range(n)])
        values = eigsy(scaled, eigvals_only=True)
        return max(values) / min(values) if min(values) > 0 else mpf("inf")


def case(number):
    while True:
        link = Linkage(number)
        if min(link.length + link.arm) < 0.25:
            continue
        q = link.flat(link.q)
        if link.condition(q) > 1000:
            continue
        p = [mpf(random.gauss(0, 1)) / w if i % 3 < link.dimension else mpf(0) for i, w in enumerate(link.w)]
        p = [mpf(float(y)) for y in link.project(q, p)]
        v = [w * y for w, y in zip(link.w, p)]
        speeds = [sqrt(sum((v[3 * a + c] - v[3 * b + c]) ** 2 for c in range(3))) / l for (a, b), l in zip(link.rods, link.length)]
        speeds += [sqrt(sum(v[3 * a + c] ** 2 for c in range(3))) / l for a, l in zip(link.pins, link.arm)]
        h = mpf(round(float(random.uniform(0.01, 0.1) / max(max(speeds), mpf(1))), 6))
        normals, gamma, kt = [], 0.7, 0.5
        if number % 5 == 0:
            scheme, step = "Rattle4", link.yoshida(q, p, h)
        elif number % 5 == 1:
            scheme, normals = "GBaoab", [round(random.gauss(0, 1), 4) for _ in q]
            step = link.bath(q, p, h, gamma, kt, normals)
        else:
            scheme, step = "Rattle", link.rattle(q, p, h)
        if step is None:
            continue
        end, moved = step
        entry = {
            "scheme": scheme, "h": float(h), "mass": link.mass, "trap": link.trap, "gravity": link.gravity,
            "rods": link.rods, "length": link.length, "pins": link.pins, "arm": link.arm,
            "q0": [x for row in link.q for x in row], "p0": [float(y) for y in p],
            "condition": float(round(max(link.condition(q), link.condition(end)), 1)),
            "q1": [float(x) for x in end], "p1": [float(y) for y in moved],
        }
        if normals:
            entry |= {"friction": gamma, "kT": kt, "normals": normals}
        return entry


if __name__ == "__main__":
    cases = [case(number) for number in range(CASES)]
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "linkages.json"), "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(entry, separators=(",", ":")) for entry in cases) + "\n]\n")
