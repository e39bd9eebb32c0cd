"""Systems of wzvi that are compiled already, for those without Rust.

    from wzvi_gallery import Kepler

    path = Kepler(k=1.0).simulate("Verlet", h=0.01, q=[1.0, 0.0], p=[0.0, 1.0], until=10.0)

`print(Kepler)` shows its parameters and equations, and `list(wzvi_gallery.library)` all systems.
"""

from __future__ import annotations

import sys as _sys
from pathlib import Path as _Path

import wzvi as _wzvi

_SUFFIX = {"darwin": ".dylib", "win32": ".dll"}.get(_sys.platform, ".so")

#: All systems.
library = _wzvi.load(_Path(__file__).with_name("systems" + _SUFFIX))

__all__ = ["library", *library]


def __getattr__(name: str) -> _wzvi.System:
    try:
        return library.systems[name]
    except KeyError:
        raise AttributeError(f"no system {name}: there are {', '.join(library)}") from None


def __dir__() -> list[str]:
    return __all__
