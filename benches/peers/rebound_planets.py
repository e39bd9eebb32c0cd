"""The outer solar system of the example `planets` by REBOUND's WHFast, SABA and IAS15.

pip install rebound; python3 benches/peers/rebound_planets.py
"""

import time

import rebound

G = 2.95912208286e-4
MASSES = [1.00000597682, 0.000954786104043, 0.000285583733151, 0.0000437273164546, 0.0000517759138449]
POSITIONS = [
    (0.0, 0.0, 0.0),
    (-3.5023653, -3.8169847, -1.5507963),
    (9.0755314, -3.0458353, -1.6483708),
    (8.310142, -16.2901086, -7.2521278),
    (11.4707666, -25.7294829, -10.8169456),
]
VELOCITIES = [
    (0.0, 0.0, 0.0),
    (0.00565429, -0.0041249, -0.00190589),
    (0.00168318, 0.00483525, 0.00192462),
    (0.00354178, 0.00137102, 0.00055029),
    (0.0028893, 0.00114527, 0.00039677),
]
YEAR = 4332.6
YEARS = 1000


def simulation(integrator, steps, settings):
    sim = rebound.Simulation()
    sim.G = G
    for m, (x, y, z), (vx, vy, vz) in zip(MASSES, POSITIONS, VELOCITIES):
        sim.add(m=m, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    sim.move_to_com()
    sim.integrator = integrator
    sim.dt = YEAR / steps
    settings(sim)
    return sim


def run(name, integrator, steps, settings):
    best = float("inf")
    for _ in range(5):
        sim = simulation(integrator, steps, settings)
        began = time.perf_counter()
        sim.integrate(YEARS * YEAR, exact_finish_time=0)
        best = min(best, time.perf_counter() - began)
    sim = simulation(integrator, steps, settings)
    start, worst = sim.energy(), 0.0
    for year in range(1, 4 * YEARS + 1):
        sim.integrate(year * YEAR / 4, exact_finish_time=0)
        sim.synchronize()
        worst = max(worst, abs(sim.energy() / start - 1))
    print(f"  {name}, {steps} steps/year: {1e3 * best:.1f} ms, energy off by {worst:.1e}")


def whfast(corrector):
    def settings(sim):
        sim.integrator.safe_mode = 0
        sim.integrator.corrector = corrector

    return settings


def saba(kind):
    def settings(sim):
        sim.integrator.type = kind
        sim.integrator.safe_mode = 0

    return settings


print(f"rebound {rebound.__version__}: the outer solar system over {YEARS} of Jupiter's years")
for steps in [20, 40, 80]:
    run("WHFast", "whfast", steps, whfast(0))
for steps in [20, 40, 80]:
    run("WHFast, corrector 17", "whfast", steps, whfast(17))
for steps in [10, 20, 40]:
    run("SABA(8,6,4)", "saba", steps, saba("8_6_4"))
for steps in [10, 20, 40]:
    run("SABA(10,6,4)", "saba", steps, saba("10_6_4"))
for steps in [20]:
    run("IAS15", "ias15", steps, lambda sim: None)
