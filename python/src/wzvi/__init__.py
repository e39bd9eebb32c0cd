"""Variational integrators from Hamiltonians, with and without noise: compiled by Rust, used with numpy.

    import wzvi

    Kubo = wzvi.compile(
        "|q, p| 0.5 * a * (q * q + p * p)",
        noise="|q, p| 0.5 * sigma * (q * q + p * p)",
        embedding="Midpoint",
        parameters={"a": float, "sigma": float},
        name="Kubo",
    )
    kubo = Kubo(a=1.5, sigma=1.0)
    path = kubo.simulate(h=0.02, q=0.0, p=1.0, until=20.0, seed=7)
    many = kubo.ensemble(h=0.02, q=0.0, p=1.0, until=4.0, paths=10**6, seed=7, observe=["q"])
    path.q, path.energy, many.mean, many.error, path.to_pandas()

`compile` takes closures as texts or SymPy expressions, and runs cargo on them: a text from somebody else is a program from
somebody else. `load` opens a library that is there, and needs no Rust. `clear_cache` removes what was compiled.
"""

from ._cache import clear_cache
from ._errors import CompileError, Error, Interrupted, Message, RunError
from ._results import Exponents, Indicators, Map, Path, Result, Statistics, Tangent
from ._systems import Bound, Library, System, compile, load

__version__ = "0.1.0"
__all__ = [
    "Bound",
    "CompileError",
    "Error",
    "Exponents",
    "Indicators",
    "Interrupted",
    "Library",
    "Map",
    "Message",
    "Path",
    "Result",
    "RunError",
    "Statistics",
    "System",
    "Tangent",
    "clear_cache",
    "compile",
    "load",
]
