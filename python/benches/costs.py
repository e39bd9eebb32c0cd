"""Prints what the package costs, as the table of the guide: `python python/benches/costs.py`, from the root of the repository.

Needs the package and Rust; builds the examples of wzvi-c. On a machine that does other work the figures are larger.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path

cache = tempfile.TemporaryDirectory()
os.environ["WZVI_CACHE"] = cache.name

import wzvi  # noqa: E402

KUBO = {
    "drift": "|q, p| 0.5 * a * (q * q + p * p)",
    "noise": "|q, p| 0.5 * sigma * (q * q + p * p)",
    "embedding": "Midpoint",
    "parameters": {"a": float, "sigma": float},
    "name": "Kubo",
}
RUN = {"h": 0.02, "q": 0.0, "p": 1.0}


def seconds(call, repeats=1, best_of=1):
    """The least mean time of a call."""
    times = []
    for _ in range(best_of):
        began = time.perf_counter()
        for _ in range(repeats):
            result = call()
        times.append((time.perf_counter() - began) / repeats)
    return min(times), result


def row(what, value):
    print(f"| {what} | {value} |", flush=True)


cold, Kubo = seconds(lambda: wzvi.compile(**KUBO))
row("`compile`, the first one of all", f"{cold:.0f} s")
other = dict(KUBO, drift="|q, p| 0.5 * a * (q * q + p * p) + 0.0 * q")
warm, _ = seconds(lambda: wzvi.compile(**other))
row("a further system: paths, ensembles, sweeps", f"{warm:.1f} s")
alone, _ = seconds(lambda: wzvi.compile(**dict(other, want=("path",))))
row('with `want=("path",)`', f"{alone:.1f} s")


def refused():
    try:
        wzvi.compile(**dict(KUBO, drift="|q, p| 0.5 * a * (q * q + p * p) + b"))
    except wzvi.CompileError as error:
        return error
    raise AssertionError("a wrong closure was compiled")


row("an error of the compiler", f"{seconds(refused)[0]:.2f} s")
cached, _ = seconds(lambda: wzvi.compile(**KUBO), 100)
row("a system that was compiled before", f"{1e3 * cached:.1f} ms")

kubo = Kubo(a=1.5, sigma=1.0)
for steps in (1, 1000):
    time_of, _ = seconds(lambda steps=steps: kubo.simulate(steps=steps, seed=1, **RUN), 500, 5)
    row(f"`simulate` with {steps} step{'s' if steps > 1 else ''}", f"{1e6 * time_of:.0f} µs")
time_of, _ = seconds(lambda: kubo.ensemble(steps=1, paths=512, seed=1, threads=1, observe=["q"], **RUN), 300, 5)
row("`ensemble` of 512 paths, 1 step", f"{1e6 * time_of:.0f} µs")
whole, path = seconds(lambda: kubo.simulate(steps=2_000_000, seed=1, **RUN), 1, 3)
bare, _ = seconds(lambda: kubo.simulate(steps=2_000_000, record_every=0, seed=1, **RUN), 1, 3)
row("a step of a path, recorded; not recorded", f"{whole / 2e6 * 1e9:.0f} ns; {bare / 2e6 * 1e9:.0f} ns")

# With the features of `.ci/door`, so that both share one build.
build = ["cargo", "build", "--release", "--quiet", "--workspace", "--features", "wzvi-laws/short", "--example", "timed"]
subprocess.run(build, check=True, cwd=Path(__file__).parents[2])
program = Path(__file__).parents[2] / "target" / "release" / "examples" / "timed"
for threads in (1, 2):
    python, rust = [], []
    for _ in range(5):
        here, _ = seconds(lambda threads=threads: kubo.ensemble(until=4.0, paths=10**6, seed=7, observe=["q"], threads=threads, **RUN))
        there = float(subprocess.run([program, str(threads)], capture_output=True, text=True, check=True).stdout)
        python.append(here)
        rust.append(there)
    row(f"10⁶ paths of 200 steps, {threads} thread{'s' if threads > 1 else ''}; beside Rust", f"{min(python):.2f} s; {min(python) / min(rust):.2f}")
