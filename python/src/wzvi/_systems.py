"""Libraries, their systems, and systems with their parameters, which run."""

from __future__ import annotations

import inspect
import math
import operator
import os
import re
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path as FilePath
from typing import Any, Optional, TypeVar, Union

import numpy as np

from . import _build, _source
from ._errors import Error, Interrupted, RunError
from ._progress import Progress, reporter
from ._results import Exponents, Indicators, Map, Path, Result, Statistics, Tangent
from ._table import DONE, PARTIAL, Functions, Task, numbers, texts

R = TypeVar("R", bound=Result)
Names = Union[str, Sequence[str]]
Numbers = Any

_LOADED: dict[str, Library] = {}
_LOADING = threading.Lock()


class Library:
    """A library of systems: `library.Kubo`, `library["Kubo"]`, `list(library)`.

    Attributes:
        path: the file.
        systems: the systems by name.
        description: what the library says of itself.
    """

    def __init__(self, path: Union[str, os.PathLike[str]], spec: Optional[dict[str, Any]] = None, functions: Optional[Functions] = None) -> None:
        self.path = os.path.abspath(path)
        self._spec = spec
        self._functions = functions or Functions(self.path)
        self.description: dict[str, Any] = self._functions.description()
        self.systems: dict[str, System] = {each["name"]: System(self, each) for each in self.description["systems"]}

    def __getattr__(self, name: str) -> System:
        systems = self.__dict__.get("systems", {})
        if name.startswith("_") or name not in systems:
            raise AttributeError(f"no system {name}: there are {', '.join(systems)}")
        found: System = systems[name]
        return found

    def __getitem__(self, name: str) -> System:
        if name not in self.systems:
            raise KeyError(f"no system {name}: there are {', '.join(self.systems)}")
        return self.systems[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.systems)

    def __len__(self) -> int:
        return len(self.systems)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.systems})

    def __repr__(self) -> str:
        return f"<library {self.path}: {', '.join(self.systems)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _revive, (self.path, self._spec)


class System:
    """A system without its parameters: `Kubo(a=1.5, sigma=1.0)` has them, and runs.

    Attributes:
        name: its name.
        parameters: types of its parameters, by name.
        schemes: for each scheme its plan, order and equations.
        closures: keys and texts that it was compiled from.
    """

    def __init__(self, library: Library, description: Mapping[str, Any]) -> None:
        self.library, self.description = library, dict(description)
        self.name: str = description["name"]
        self.schemes: dict[str, dict[str, Any]] = {each["name"]: each for each in description["schemes"]}
        self.parameters: dict[str, str] = {each["name"]: each["type"] for each in description["fields"]}
        self.closures: list[tuple[str, str]] = [
            (each["key"], each["text"]) if isinstance(each, Mapping) else (each[0], each[1]) for each in description.get("closures", ())
        ]
        self._kinds = {name: _FieldType(of) for name, of in self.parameters.items()}
        fields = "\n".join(f"    {each['name']}: {each['type']}. {each['doc']}".rstrip() for each in description["fields"])
        self.__doc__ = f"{description['doc']}\n\nParameters:\n{fields}" if fields else description["doc"]
        if all(name.isidentifier() for name in self.parameters):
            kind = inspect.Parameter.KEYWORD_ONLY
            try:
                signed = [inspect.Parameter(name, kind, annotation=of) for name, of in self.parameters.items()]
                self.__signature__ = inspect.Signature(signed)
            except ValueError:
                # A field whose name is a word of Python.
                pass

    def equations(self, scheme: Optional[str] = None) -> str:
        """The discrete equations of a scheme, as the compiler derived them; of the only scheme without a name."""
        if scheme is None and len(self.schemes) == 1:
            return str(next(iter(self.schemes.values()))["equations"])
        if scheme not in self.schemes:
            raise KeyError(f"{self.name} was not compiled for the scheme {scheme}: there are {', '.join(self.schemes)}")
        return str(self.schemes[scheme]["equations"])

    def __call__(self, **parameters: Any) -> Bound:
        """The system with these parameters. Parameters with one axis more than their type has are a sweep."""
        for name in parameters:
            if name not in self.parameters:
                raise TypeError(f"{self.name} has no parameter {name}: it has {', '.join(self.parameters) or 'none'}")
        missing = [name for name in self.parameters if name not in parameters]
        if missing:
            raise TypeError(f"{self.name} needs {', '.join(missing)}")
        return Bound(self, parameters)

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}: {of}" for name, of in self.parameters.items())
        return "\n\n".join([f"{self.name}({fields})", *(each["equations"].rstrip() for each in self.schemes.values())])

    def _repr_html_(self) -> str:
        doc = self.description["doc"]
        fields = "".join(
            f"<tr><td><code>{escape(each['name'])}</code></td><td><code>{escape(each['type'])}</code></td><td>{escape(each['doc'])}</td></tr>"
            for each in self.description["fields"]
        )
        closures = "".join(f"<tr><td>{escape(key)}</td><td><pre>{escape(text)}</pre></td></tr>" for key, text in self.closures)
        schemes = "".join(
            f"<details{' open' if len(self.schemes) == 1 else ''}><summary><code>{escape(each['name'])}</code>, order {each['order']}</summary>"
            f"<pre>{escape(each['equations'])}</pre></details>"
            for each in self.schemes.values()
        )
        table = f"<table><thead><tr><th>parameter</th><th>type</th><th></th></tr></thead><tbody>{fields}</tbody></table>" if fields else ""
        return f"<div><b>{escape(self.name)}</b> {escape(doc)}{table}<table><tbody>{closures}</tbody></table>{schemes}</div>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _system, (self.library, self.name)


class _FieldType:
    """What a field takes."""

    __slots__ = ("axes", "is_flag", "is_real")

    def __init__(self, of: str) -> None:
        self.axes = of.count("Vec<") + of.count("[")
        self.is_real = re.search(r"\bf64\b", of) is not None
        self.is_flag = re.search(r"\bbool\b", of) is not None

    def value(self, name: str, given: Any) -> Any:
        """A number or an array of the type of this field."""
        try:
            if np.ndim(given) == 0:
                return float(given) if self.is_real else bool(given) if self.is_flag else operator.index(given)
            array = np.asarray(given)
            if self.is_real:
                return np.ascontiguousarray(array, dtype=np.float64)
            if array.dtype.kind not in "iub":
                raise TypeError
            return np.ascontiguousarray(array, dtype=np.int64)
        except (TypeError, ValueError):
            expected = "real numbers" if self.is_real else "integers"
            raise TypeError(f"the parameter {name} has to be {expected}, not {given!r}") from None


def _real(task: Task, name: str, value: Any) -> None:
    try:
        task.set_real(name, float(value))
    except (TypeError, ValueError):
        raise TypeError(f"{name} has to be a number, not {value!r}") from None


def _whole(task: Task, name: str, value: Any) -> None:
    try:
        # A million is often written 1e6.
        number = int(value) if isinstance(value, (float, np.floating)) and value == int(value) else operator.index(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} has to be an integer, not {value!r}") from None
    task.set_integer(name, number)


def _flag(task: Task, name: str, value: Any) -> None:
    task.set_integer(name, 1 if value else 0)


def _text(task: Task, name: str, value: Any) -> None:
    if not isinstance(value, str):
        raise TypeError(f"{name} has to be a text, not {value!r}")
    task.set_text(name, value)


def _texts(task: Task, name: str, value: Any) -> None:
    task.set_text(name, texts(name, value))


def _reals(task: Task, name: str, value: Any) -> None:
    task.set_array(name, numbers(name, value))


_SETTERS: dict[str, Callable[[Task, str, Any], None]] = {
    **dict.fromkeys(("h", "eps", "t", "until", "width", "truncation", "allow_losses"), _real),
    **dict.fromkeys(("steps", "threads", "seed", "path", "record_every", "retry", "paths", "sweep", "keep_paths", "keep_crossings"), _whole),
    **dict.fromkeys(("copies", "exponents"), _whole),
    **dict.fromkeys(("whole_steps", "project_start", "unwatched", "covariances", "antithetic", "observe_work"), _flag),
    **dict.fromkeys(("observe_temperatures", "multipliers"), _flag),
    **dict.fromkeys(("scheme", "noise"), _text),
    **dict.fromkeys(("observe", "sections", "end_at", "histograms", "passages", "until_error", "by"), _texts),
    **dict.fromkeys(("q", "p", "increments", "record_at", "quantiles", "ranges", "errors", "deviations"), _reals),
}


class Bound:
    """A system with its parameters. Its methods are runs.

    All quantities are in the units of the closures. `q` and `p` are a number or an array with one for each degree of
    freedom. Names of quantities are those of the closure of the drift for coordinates and momenta ("q", "x", "q[0]"),
    "energy", the names of first integrals, those of `observe`, and "t".

    Ctrl-C ends a run and raises `Interrupted`, whose `partial` is the result so far. A step that fails raises `RunError`,
    likewise. Other threads of Python go on during a run.

    Attributes:
        system: the system.
        parameters: its parameters, by name.
    """

    def __init__(self, system: System, parameters: Mapping[str, Any]) -> None:
        self.system, self.parameters = system, dict(parameters)
        kinds = system._kinds
        self._values = {name: kinds[name].value(name, value) for name, value in self.parameters.items()}
        lengths = {len(value) for name, value in self._values.items() if np.ndim(value) > kinds[name].axes}
        if len(lengths) > 1:
            raise ValueError(f"the parameters of a sweep have to be as many: there are {' and '.join(map(str, sorted(lengths)))}")
        self._sweep: Optional[int] = lengths.pop() if lengths else None

    def __repr__(self) -> str:
        return f"{self.system.name}({', '.join(f'{name}={_short(value)}' for name, value in self.parameters.items())})"

    def _repr_html_(self) -> str:
        values = "".join(f"<tr><td><code>{escape(name)}</code></td><td>{escape(_short(value))}</td></tr>" for name, value in self.parameters.items())
        return f"<table><tbody>{values}</tbody></table>{self.system._repr_html_()}"

    def __reduce__(self) -> tuple[Any, ...]:
        return Bound, (self.system, self.parameters)

    def replace(self, **parameters: Any) -> Bound:
        """The same system with some parameters changed."""
        return self.system(**{**self.parameters, **parameters})

    def simulate(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        path: Optional[int] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        increments: Optional[Numbers] = None,
        record_every: Optional[int] = None,
        record_at: Optional[Numbers] = None,
        observe: Optional[Names] = None,
        sections: Optional[Names] = None,
        end_at: Optional[Names] = None,
        retry: Optional[int] = None,
        unwatched: Optional[bool] = None,
        multipliers: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Path:
        """One path.

        Args:
            scheme: one of `system.schemes`; may be left out if there is one.
            q, p: coordinates and momenta at the start.
            h: the length of a step, a time.
            eps: in its place for schemes with a clock: the length in units of the clock, a fraction such as 0.3.
            t: the time at the start; 0 by default.
            until: the time at the end. The last step is shorter if it has to be.
            steps: or the number of steps.
            whole_steps: end with a whole step, at or after `until`.
            project_start: move the start onto the constraints.
            seed: of the noise: an integer of 0 or more.
            noise: "steps" (the default: normals for each step, as in ensembles), "wiener" (a Wiener path that does not
                depend on `h`), "wong-zakai" (its average over `width`).
            path: the number of the path of an ensemble with this seed; 0 by default.
            width: of "wong-zakai", a time.
            truncation: the `k` of the bound `max(6, √(2 k |ln h|))` on increments, in standard deviations, 1 or more; 0 for none.
                By default 4 for implicit steps with noise that could reach a pole, and none for others.
            increments: the increments of the Wiener processes in place of a noise: a row for each step, in √time.
            record_every: record every n-th node; 1 by default, 0 for start and end alone.
            record_at: record at these times, between nodes from the dense output.
            observe: quantities to record: arrays `observed.<name>`.
            sections: quantities whose zeros are crossings: "q" in both directions, "+q" rising, "-q" falling.
            end_at: likewise, and the first one ends the run.
            retry: halve a step that fails, up to so many times.
            unwatched: do not watch the energy.
            multipliers: record the multipliers of constraints.
            threads: of one path: for systems that are large enough.
            progress: True for a line, or a function of the work that is done and all of it.
        """
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "path": path, "width": width, "truncation": truncation,
            "increments": increments, "record_every": record_every, "record_at": record_at, "observe": observe, "sections": sections,
            "end_at": end_at, "retry": retry, "unwatched": unwatched, "multipliers": multipliers, "threads": threads,
        }  # fmt: skip
        return self._run("path", Path, settings, np.size(q), progress, "steps")

    def ensemble(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        paths: Optional[int] = None,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        antithetic: Optional[bool] = None,
        record_every: Optional[int] = None,
        record_at: Optional[Numbers] = None,
        observe: Optional[Names] = None,
        observe_work: Optional[bool] = None,
        observe_temperatures: Optional[bool] = None,
        covariances: Optional[bool] = None,
        quantiles: Optional[Numbers] = None,
        histograms: Optional[Mapping[str, tuple[float, float, int]]] = None,
        sections: Optional[Names] = None,
        keep_crossings: Optional[int] = None,
        passages: Optional[Names] = None,
        keep_paths: Union[None, bool, int] = None,
        until_error: Optional[Mapping[str, float]] = None,
        allow_losses: Optional[float] = None,
        retry: Optional[int] = None,
        unwatched: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Statistics:
        """Many paths, for their statistics.

        Parameters of the system that are arrays are a sweep: path `i` has the `i`-th of each. `q` and `p` of two axes are
        starts: path `i` has row `i`. The same seed gives the same bits for any number of threads.

        Args:
            scheme: one of `system.schemes`; may be left out if there is one.
            q, p: coordinates and momenta at the start, of all paths or a row for each.
            paths: how many; by default as many as there are starts or parameters.
            h, eps, t, until, steps, whole_steps, project_start: as for `simulate`.
            seed, noise, width, truncation: as for `simulate`; each path has a noise of its own.
            antithetic: pairs of paths with opposite noises.
            record_every: statistics at every n-th node; by default at the end alone.
            record_at: statistics at these times.
            observe: quantities; by default coordinates, momenta, the energy, and those that the system declares.
            observe_work: observe work, shadow work and heat of each path, energies.
            observe_temperatures: observe the kinetic temperature, an energy.
            covariances: of all pairs of quantities.
            quantiles: levels between 0 and 1.
            histograms: for each quantity the lower and the upper limit and the number of bins.
            sections: quantities whose zeros are crossings, as for `simulate`; they are counted.
            keep_crossings: keep the first n crossings of each path with their states.
            passages: quantities whose first zero is a passage.
            keep_paths: keep the recorded quantities of each path; True for up to 1 GB, or a number of bytes.
            until_error: begin no more paths once the error bound of each of these quantities is below its number.
            allow_losses: the fraction of paths that may fail.
            retry, unwatched: as for `simulate`.
            threads: by default all cores.
            progress: True for a line, or a function of the paths that are done and all of them.
        """
        bound, sweep = self, self._sweep
        if sweep is not None:
            bound = self._spread(sweep)
            if paths is None and np.ndim(q) < 2:
                paths = sweep
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "width": width, "truncation": truncation, "antithetic": antithetic,
            "paths": paths, "sweep": sweep, "record_every": record_every, "record_at": record_at, "observe": observe,
            "observe_work": observe_work, "observe_temperatures": observe_temperatures, "covariances": covariances,
            "quantiles": quantiles, "sections": sections, "keep_crossings": keep_crossings, "passages": passages,
            "keep_paths": (1 << 30 if keep_paths is True else keep_paths or None), "allow_losses": allow_losses, "retry": retry,
            "unwatched": unwatched, "threads": threads,
        }  # fmt: skip
        if histograms:
            settings["histograms"] = list(histograms)
            settings["ranges"] = [[float(each) for each in limits] for limits in histograms.values()]
        if until_error:
            settings["until_error"] = list(until_error)
            settings["errors"] = [float(each) for each in until_error.values()]
        count = paths or sweep or (len(q) if np.ndim(q) > 1 else 1)
        return bound._run("ensemble", Statistics, settings, count, progress, "paths", sweep=sweep)

    def indicators(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        path: Optional[int] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        increments: Optional[Numbers] = None,
        record_every: Optional[int] = None,
        deviations: Optional[Numbers] = None,
        unwatched: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Indicators:
        """Indicators of chaos along one path: MEGNO and its mean, SALI, GALI, FLI, all without units.

        Args:
            record_every: record them at every n-th node: arrays `series.<name>`.
            deviations: deviations at the start, each a row of 2d numbers; by default unit vectors without symmetry.
            scheme, q, p, h, eps, t, until, steps and the others: as for `simulate`.
        """
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "path": path, "width": width, "truncation": truncation,
            "increments": increments, "record_every": record_every, "deviations": deviations, "unwatched": unwatched, "threads": threads,
        }  # fmt: skip
        return self._run("indicators", Indicators, settings, 4 * np.size(q), progress, "steps")

    def lyapunov(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        path: Optional[int] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        increments: Optional[Numbers] = None,
        record_every: Optional[int] = None,
        deviations: Optional[Numbers] = None,
        copies: Optional[int] = None,
        exponents: Optional[int] = None,
        unwatched: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Exponents:
        """Lyapunov exponents of one path, in 1/time, the largest first.

        Args:
            record_every: record the exponents so far at every n-th node: `series.t`, `series.exponents`.
            deviations: deviations at the start, each a row of 2d numbers.
            copies: how many paths beside this one give the errors; 8 by default, 0 for none.
            exponents: only the largest so many.
            scheme, q, p, h, eps, t, until, steps and the others: as for `simulate`.
        """
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "path": path, "width": width, "truncation": truncation,
            "increments": increments, "record_every": record_every, "deviations": deviations, "copies": copies, "exponents": exponents,
            "unwatched": unwatched, "threads": threads,
        }  # fmt: skip
        return self._run("lyapunov", Exponents, settings, 40 * np.size(q), progress, "steps")

    def map(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        paths: Optional[int] = None,
        deviations: Optional[Numbers] = None,
        allow_losses: Optional[float] = None,
        unwatched: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Map:
        """Indicators of chaos at the end of many paths: MEGNO and its mean, SALI, GALI_2, FLI for each start.

        Args:
            q, p: the starts, a row for each path.
            paths: how many; by default as many as there are starts.
            deviations: deviations at the start, each a row of 2d numbers.
            allow_losses: the fraction of paths that may fail; their values are NaN.
            progress: True for a line, or a function of the paths that are done and all of them.
            scheme, h, eps, t, until, steps and the others: as for `ensemble`.
        """
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "width": width, "truncation": truncation, "paths": paths,
            "deviations": deviations, "allow_losses": allow_losses, "unwatched": unwatched, "threads": threads,
        }  # fmt: skip
        count = paths or (len(q) if np.ndim(q) > 1 else 1)
        return self._run("map", Map, settings, 4 * count, progress, "paths")

    def tangent(
        self,
        scheme: Optional[str] = None,
        *,
        q: Numbers,
        p: Numbers,
        by: Optional[Names] = None,
        h: Optional[float] = None,
        eps: Optional[float] = None,
        t: Optional[float] = None,
        until: Optional[float] = None,
        steps: Optional[int] = None,
        whole_steps: Optional[bool] = None,
        project_start: Optional[bool] = None,
        seed: Optional[int] = None,
        noise: Optional[str] = None,
        path: Optional[int] = None,
        width: Optional[float] = None,
        truncation: Optional[float] = None,
        increments: Optional[Numbers] = None,
        unwatched: Optional[bool] = None,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Tangent:
        """The end of one path, and its derivatives by the start and by parameters, exact for the discrete steps.

        Args:
            by: parameters of the system.
            scheme, q, p, h, eps, t, until, steps and the others: as for `simulate`.
        """
        settings = {
            "scheme": scheme, "h": h, "eps": eps, "q": q, "p": p, "t": t, "until": until, "steps": steps, "whole_steps": whole_steps,
            "project_start": project_start, "seed": seed, "noise": noise, "path": path, "width": width, "truncation": truncation,
            "increments": increments, "by": by, "unwatched": unwatched, "threads": threads,
        }  # fmt: skip
        found = self._run("tangent", Tangent, settings, 4 * np.size(q), progress, "steps")
        found.by = [by] if isinstance(by, str) else list(by or ())
        return found

    def _spread(self, sweep: int) -> Bound:
        """The same system with a value of each parameter for each path of a sweep."""
        kinds = self.system._kinds
        spread = {
            name: value if np.ndim(value) > kinds[name].axes else np.broadcast_to(value, (sweep, *np.shape(value)))
            for name, value in self._values.items()
        }
        return Bound(self.system, spread)

    def _run(
        self,
        kind: str,
        result: Callable[[Bound, Task], R],
        settings: Mapping[str, Any],
        weight: float,
        progress: Progress,
        unit: str,
        sweep: Optional[int] = None,
    ) -> R:
        if self._sweep is not None and sweep is None:
            raise ValueError("parameters that are arrays are a sweep, which ensemble() runs: give a number for each")
        task = Task(self.system.library._functions, self.system.name, kind)
        for name, value in self._values.items():
            key = f"parameter.{name}"
            if isinstance(value, float):
                task.set_real(key, value)
            elif isinstance(value, int):
                task.set_integer(key, value)
            else:
                task.set_array(key, value)
        for name, value in settings.items():
            if value is not None:
                _SETTERS[name](task, name, value)
        steps = settings["steps"]
        if steps is None:
            until, h = settings["until"], settings["h"]
            # With a clock, or without an end, nobody knows.
            steps = math.inf if until is None or not h else abs((until - (settings["t"] or 0.0)) / h)
        try:
            status = task.run(steps * weight, reporter(progress, unit))
        except Interrupted as interrupted:
            interrupted.partial = result(self, task) if interrupted.partial in (PARTIAL, DONE) else None
            raise
        if status == DONE:
            return result(self, task)
        message, code = task.error(), task.code()
        if "was not compiled for" in message and kind != "path":
            message += f": compile it with want=(..., {_WANT.get(kind, 'chaos')!r})"
        raise RunError(message, code, result(self, task) if status == PARTIAL else None)


_WANT = {"ensemble": "ensemble"}


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return np.array2string(value, threshold=6, separator=", ")
    if isinstance(value, np.generic):
        return repr(value.item())
    return repr(value)


def load(path: Union[str, os.PathLike[str]]) -> Library:
    """A library that is there: from `compile`, from a wheel, or from `cargo build` of a crate with `wzvi_c::export!`.

    A library is a program: load only what you would run.
    """
    return Library(path)


def compiled(spec: Mapping[str, Any], progress: Optional[bool] = None) -> Library:
    """The library of a crate with one system, from the cache or from cargo."""
    spec = dict(spec)
    crate = _source.source(
        spec["drift"],
        name=spec["name"],
        doc=spec["doc"],
        parameters=spec["parameters"],
        embedding=spec["embedding"],
        schemes=spec["schemes"],
        items=spec["items"],
        keys=spec["keys"],
        field_docs=spec["docs"],
    )

    def check(path: FilePath) -> None:
        with _LOADING:
            key = str(path)
            if key not in _LOADED:
                _LOADED[key] = Library(key, spec)

    path = _build.build(
        crate, want=spec["want"], opt=spec["opt"], units=spec["units"], name=spec["name"], progress=progress, check=check
    )
    return _LOADED[str(path)]


def compile(
    drift: Any,
    *,
    embedding: Union[str, Iterable[str]],
    name: str = "System",
    q: Any = None,
    p: Any = None,
    t: Any = None,
    parameters: Any = None,
    noise: Any = None,
    force: Any = None,
    noise_force: Any = None,
    friction: Any = None,
    damping: Any = None,
    temperature: Any = None,
    invariant: Any = None,
    constraint: Any = None,
    clock: Any = None,
    calculus: Optional[str] = None,
    observe: Optional[Mapping[str, Any]] = None,
    schemes: Union[str, Iterable[str]] = (),
    items: Optional[str] = None,
    doc: str = "",
    docs: Optional[Mapping[str, str]] = None,
    want: Union[str, Iterable[str]] = ("path", "ensemble", "sweep"),
    progress: Optional[bool] = None,
    opt: int = 3,
    units: int = 16,
) -> System:
    """A system from its Hamiltonian: closures of Rust as texts, or SymPy expressions.

        Kubo = wzvi.compile(
            "|q, p| 0.5 * a * (q * q + p * p)",
            noise="|q, p| 0.5 * sigma * (q * q + p * p)",
            embedding="Midpoint",
            parameters={"a": float, "sigma": float},
            name="Kubo",
        )
        path = Kubo(a=1.5, sigma=1.0).simulate(h=0.02, q=0.0, p=1.0, until=20.0, seed=7)

    The compiler derives the discrete equations; `print(Kubo)` shows them. Mistakes raise `CompileError` with the argument,
    the line and the column. The result is kept on disk: the same system is there at once the next time.

    With SymPy the variables are given, and free symbols are parameters:

        x, v, k = sympy.symbols("x v k")
        Well = wzvi.compile(v**2 / 2 + k * (x**2 - 1) ** 2, q=x, p=v, embedding="Verlet")

    A text is a program: never compile one of somebody else.

    Args:
        drift: the Hamiltonian, an energy: a closure "|q, p| ...", "|[x, y], [px, py], t| ...", or an expression; or a list of
            two parts of it with known flows.
        embedding: a scheme or a list of schemes: "Midpoint", "Verlet", "Gauss<8>", "Baoab", ...
        name: of the system, a name of Rust.
        q, p, t: for expressions: symbols of coordinates, momenta and time.
        parameters: names and types: float, int, [float] (a list), (float, 3) (an array), or a text of Rust such as
            "Vec<[usize; 2]>". For expressions also a list of symbols; by default all free symbols.
        noise: Hamiltonians that Wiener processes drive: one, or a list; energy/√time.
        force: a force beside that of the Hamiltonian: an entry for each degree of freedom; momentum/time.
        noise_force: forces that Wiener processes drive; momentum/√time.
        friction: rates of friction, 1/time.
        damping: a matrix of friction, mass/time.
        temperature: of the heat bath that belongs to the friction, an energy.
        invariant: first integrals that the compiler proves: one, a list, or a dict of names.
        constraint: functions of the coordinates that stay zero.
        clock: the wanted length of a step up to a factor, for schemes "Clocked<...>".
        calculus: "Ito" for an Ito equation; Stratonovich by default.
        observe: quantities by name: closures "|q, p| ...", or expressions.
        schemes: further schemes made from those of `embedding`: "Composed<Verlet, KahanLi8>".
        items: items of Rust beside the system: constants, functions with #[hamiltonian_fn].
        doc, docs: a sentence on the system, and one for each parameter.
        want: kinds of runs: "path" (always), "ensemble", "sweep", "chaos" (indicators, lyapunov, map, tangent). Fewer compile faster.
        progress: whether a line says that the compiler is at work; by default on a terminal and in a notebook.
        opt, units: optimisation level and codegen units of the compiler.
    """
    keys = {
        "noise": noise, "force": force, "noise_force": noise_force, "friction": friction, "damping": damping, "temperature": temperature,
        "invariant": invariant, "constraint": constraint, "clock": clock, "calculus": calculus, "observe": observe,
    }  # fmt: skip
    keys = {key: value for key, value in keys.items() if value is not None}
    from . import _sympy

    if any(_sympy.has_sympy(value) for value in (drift, *keys.values())):
        translation = _sympy.Translation(q, p, t, parameters, [drift, *keys.values()])
        drift = translation.argument("drift", drift)
        keys = {key: translation.argument(key, value) for key, value in keys.items()}
        parameters = translation.parameters
    elif q is not None or p is not None or t is not None:
        raise TypeError("q, p and t belong to SymPy expressions: a closure has names of its own, '|q, p| ...'")
    elif parameters is not None and not isinstance(parameters, Mapping):
        parameters = {str(each): float for each in parameters}
    spec = {
        "drift": drift if isinstance(drift, (str, _source.Printed)) else list(drift),
        "name": name,
        "doc": doc,
        "docs": dict(docs or {}),
        "parameters": dict(parameters or {}),
        "embedding": _source.listed(embedding),
        "schemes": _source.listed(schemes),
        "items": items,
        "keys": keys,
        "want": _build.features(want),
        "opt": opt,
        "units": units,
    }
    return compiled(spec, progress)[name]


def _revive(path: str, spec: Optional[dict[str, Any]]) -> Library:
    """The library of a pickle: the one that is loaded or on disk, or compiled again."""
    found = _LOADED.get(path)
    if found is not None:
        return found
    if spec is None:
        return Library(path)
    if os.path.exists(path):
        try:
            with _LOADING:
                return _LOADED.setdefault(path, Library(path, spec))
        except Error:
            pass
    return compiled(spec)


def _system(library: Library, name: str) -> System:
    return library[name]
