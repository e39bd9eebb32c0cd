"""Results of runs: arrays by name, which are views of the memory of the library, and tables of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._table import Raw, Task

if TYPE_CHECKING:
    import pandas
    import polars

    from ._systems import Bound

Array = npt.NDArray[np.float64]


class Result:
    """Arrays of a run by name: `result["energy"]`, or `result.energy` where the name has no dots.

    The arrays are read-only views of memory of the library, which lives as long as any of them. `.copy()` an array to
    change it. A pickle has copies.

    Attributes:
        system: the system with its parameters.
        names: of statistics the names of the observables; of other results those of time, coordinates and momenta.
    """

    system: Bound
    names: list[str]

    def __init__(self, system: Bound, task: Task) -> None:
        self.system = system
        self._task: Any = task
        self._raw: dict[str, Raw] = task.raw()
        self._arrays: dict[str, Any] = {}
        self.names = task.columns()

    def __getitem__(self, name: str) -> Any:
        found = self._arrays.get(name)
        if found is None:
            raw = self._raw.get(name)
            if raw is None:
                raise KeyError(f"no {name!r}: there are {', '.join(self.keys())}")
            found = self._arrays[name] = self._task.view(raw)
        return found

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or "_raw" not in self.__dict__:
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"a {type(self).__name__} has no {name!r} here: there are {', '.join(self.keys())}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._raw

    def __iter__(self) -> Iterator[str]:
        return iter(self._raw)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(name for name in self._raw if name.isidentifier())})

    def keys(self) -> list[str]:
        """Names of the arrays."""
        return list(self._raw)

    def items(self) -> list[tuple[str, Any]]:
        """Names and arrays."""
        return [(name, self[name]) for name in self._raw]

    def group(self, prefix: str) -> dict[str, Any]:
        """The arrays whose names begin with this prefix and a dot: `path.group("crossings")["t"]`."""
        return {name[len(prefix) + 1 :]: self[name] for name in self._raw if name.startswith(prefix + ".")}

    def __getstate__(self) -> dict[str, Any]:
        arrays = {name: np.array(self[name]) if np.ndim(self[name]) else self[name] for name in self._raw}
        return {"system": self.system, "names": self.names, "_arrays": arrays, "_raw": dict.fromkeys(self._raw), "_task": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def columns(self) -> dict[str, Any]:
        """What a table of this result has: names of columns, and arrays of one axis."""
        raise NotImplementedError

    def to_pandas(self) -> pandas.DataFrame:
        """The columns as a data frame of pandas."""
        import pandas

        return pandas.DataFrame(self.columns())

    def to_polars(self) -> polars.DataFrame:
        """The columns as a data frame of polars."""
        import polars

        return polars.DataFrame({name: np.ascontiguousarray(values) for name, values in self.columns().items()})

    def _variables(self, degrees: int) -> tuple[str, list[str], list[str]]:
        """Names of the time, the coordinates and the momenta."""
        names = self.names
        if len(names) != 2 * degrees + 1:
            # A result without nodes does not know how many there are.
            names = ["t", *(f"{name}[{i}]" for name in "qp" for i in range(degrees))]
        return names[0], names[1 : degrees + 1], names[degrees + 1 :]

    def _title(self) -> str:
        return f"{type(self).__name__} of {self.system!r}"

    def _repr_html_(self) -> str:
        columns = self.columns()
        count = min((len(values) for values in columns.values()), default=0)
        shown = list(range(count)) if count <= 8 else [*range(4), -1, *range(count - 3, count)]
        head = "".join(f"<th>{escape(name)}</th>" for name in columns)
        rows = []
        for row in shown:
            cells = ("…" if row < 0 else number(values[row]) for values in columns.values())
            rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        single = ", ".join(f"{escape(name)} {number(self[name])}" for name in self._raw if np.ndim(self[name]) == 0)
        return (
            f"<div><b>{escape(self._title())}</b><table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
            f"<small>{count} rows{'; ' + single if single else ''}</small></div>"
        )


def number(value: Any) -> str:
    """A number with as many digits as a table needs."""
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else escape(str(value))


def spread(result: Result, name: str, labels: Sequence[str]) -> dict[str, Any]:
    """An array with an axis of quantities as a column for each."""
    array = result[name]
    return {label: array[:, i] for i, label in enumerate(labels)}


class Path(Result):
    """One path.

    Arrays, for `n` recorded nodes, `d` degrees of freedom and `k` Wiener processes:
        t [n], q [n, d], p [n, d], energy [n]; dw [n-1, k], the increments of the steps;
        invariant.<name> [n]; observed.<name> [n];
        crossings.section, .direction, .t [c], crossings.q, .p [c, d], of the sections;
        events.event, .t, .q, .p, where `end_at` ended the run; intervals.t, .h, .rho of schemes with a clock.
    Numbers: steps, iterations, work, heat.
    """

    t: Array
    q: Array
    p: Array
    energy: Array
    dw: Array
    steps: float
    iterations: float
    work: float
    heat: float

    def columns(self) -> dict[str, Any]:
        time, coordinates, momenta = self._variables(self.q.shape[1])
        columns = {time: self.t, **spread(self, "q", coordinates), **spread(self, "p", momenta)}
        for name in self._raw:
            kind, _, label = name.partition(".")
            if name == "energy" or kind in ("invariant", "observed"):
                columns[label or name] = self[name]
        return columns

    def __repr__(self) -> str:
        if not len(self.t):
            return f"<{self._title()}: no nodes>"
        return f"<{self._title()}: {len(self.t)} nodes, t = {self.t[0]:.6g} to {self.t[-1]:.6g}>"


class Statistics(Result):
    """Statistics of many paths, for each recorded time and each observable.

    Arrays, for `n` times and `m` observables (`names`):
        t, count, lost [n]; mean, error, error_bound, variance [n, m]; covariance [n, m, m];
        quantiles [n, m, l] with levels [l]; histogram.<name> [n, bins] with edges.<name> [bins + 1];
        passage.<name> [7]: passed, censored, lost, mean, standard error, rate, error of the rate; passage_times.<name>;
        paths [paths, n, m] with `keep_paths`; crossings.*; failures [f, 3].
    `error` is the standard error of the mean. `error_bound` is an upper estimate of it, as if the largest deviation that was
    seen had occurred ten more times. Both have the units of the observable.
    """

    t: Array
    count: Array
    lost: Array
    mean: Array
    error: Array
    error_bound: Array
    variance: Array
    covariance: Array
    quantiles: Array
    levels: Array
    paths: Array

    def of(self, name: str) -> dict[str, Any]:
        """What is known of one observable: mean, error, variance, quantiles, histogram, edges, passage, paths."""
        if name not in self.names:
            raise KeyError(f"no {name!r}: there are {', '.join(self.names)}")
        index = self.names.index(name)
        found = {key: self[key][:, index] for key in ("mean", "error", "error_bound", "variance", "quantiles") if key in self}
        if "paths" in self:
            found["paths"] = self["paths"][..., index]
        for key in ("histogram", "edges", "passage", "passage_times"):
            if f"{key}.{name}" in self:
                found[key] = self[f"{key}.{name}"]
        return found

    def columns(self) -> dict[str, Any]:
        columns = {name: self[name] for name in ("t", "count", "lost") if name in self}
        for i, name in enumerate(self.names):
            columns[name] = self.mean[:, i]
            for key in ("error", "variance"):
                if key in self:
                    columns[f"{name} {key}"] = self[key][:, i]
            if "quantiles" in self and "levels" in self:
                for level, values in zip(self.levels, self.quantiles[:, i].T):
                    columns[f"{name} {100 * level:g} %"] = values
        return columns

    def __repr__(self) -> str:
        if not len(self.t):
            return f"<{self._title()}: no times>"
        rows = [f"{name} = {mean:.6g} ± {error:.1g}" for name, mean, error in zip(self.names, self.mean[-1], self.error[-1])]
        return "\n".join([f"<{self._title()}: {int(self.count[-1])} paths at t = {self.t[-1]:.6g}>", *("  " + row for row in rows)])


class Indicators(Result):
    """Indicators of chaos along one path.

    Numbers at the end of the path: megno, megno_mean, sali, fli, time; gali, an array from GALI_2 on. With `record_every`
    also along the path: series.t, series.megno, series.megno_mean, series.sali, series.fli [n], series.gali [n, ...].
    Where a path is regular, megno_mean goes to 2; where it is chaotic, it goes to half the largest exponent times the
    time, and SALI falls exponentially.
    """

    megno: float
    megno_mean: float
    sali: float
    gali: Array
    fli: float
    time: float

    def columns(self) -> dict[str, Any]:
        series = self.group("series")
        if not series:
            series = {name: np.atleast_1d(self[name]) for name in self._raw if np.ndim(self[name]) == 0}
            series["gali"] = np.atleast_2d(self.gali)
        gali = series.pop("gali", np.zeros((0, 0)))
        return {**series, **{f"gali_{i + 2}": gali[:, i] for i in range(gali.shape[1])}}

    def __repr__(self) -> str:
        return f"<{self._title()}: mean of MEGNO {self.megno_mean:.4g}, SALI {self.sali:.2g}, FLI {self.fli:.4g} after {self.time:.6g}>"


class Exponents(Result):
    """Lyapunov exponents of one path, the largest first, in 1/time.

    Arrays: exponents, errors [k], NaN where they are not known; copies [c, k], the exponents of the copies; with
    `record_every` series.t [n], series.exponents [n, k]. Numbers: pair_defect, sum_defect, time. The errors are standard
    deviations over the path and its copies.
    """

    exponents: Array
    errors: Array
    copies: Array
    pair_defect: float
    sum_defect: float
    time: float

    def columns(self) -> dict[str, Any]:
        return {"exponent": self.exponents, "error": self.errors}

    def __repr__(self) -> str:
        rows = (f"{value:.4g}" + ("" if np.isnan(error) else f" ± {error:.1g}") for value, error in zip(self.exponents, self.errors))
        return f"<{self._title()}: {', '.join(rows)}>"


class Map(Result):
    """Indicators of chaos at the end of many paths.

    Arrays for `n` paths of `d` degrees of freedom: megno, megno_mean, sali, gali_2, fli [n], NaN for paths that failed;
    q, p [n, d], the starts; failures [f, 3]: path, step, time. Number: time.
    """

    megno: Array
    megno_mean: Array
    sali: Array
    gali_2: Array
    fli: Array
    q: Array
    p: Array
    failures: Array
    time: float
    #: Names of the indicators.
    indicators = ("megno", "megno_mean", "sali", "gali_2", "fli")

    def columns(self) -> dict[str, Any]:
        _, coordinates, momenta = self._variables(self.q.shape[1])
        return {**spread(self, "q", coordinates), **spread(self, "p", momenta), **{name: self[name] for name in self.indicators}}

    def __repr__(self) -> str:
        return f"<{self._title()}: {', '.join(self.indicators)} of {len(self.q)} paths>"


class Tangent(Result):
    """Derivatives of the end of one path.

    Arrays for `d` degrees of freedom: t [1], q, p [1, d], the end; by_start [2d, 2d], a row for each coordinate and then each
    momentum of the end, a column for each of the start; by_parameters [2d, m], by_step_size [2d] with `by`.
    """

    t: Array
    q: Array
    p: Array
    by_start: Array
    by_parameters: Array
    by_step_size: Array
    by: list[str]

    def columns(self) -> dict[str, Any]:
        _, coordinates, momenta = self._variables(self.q.shape[-1])
        labels = [*coordinates, *momenta]
        columns = {"end": np.array(labels), "value": np.concatenate([self.q.ravel(), self.p.ravel()])}
        columns.update({f"d/d{name}": self.by_start[:, i] for i, name in enumerate(labels)})
        if "by_parameters" in self:
            columns.update({f"d/d{name}": self.by_parameters[:, i] for i, name in enumerate(self.__dict__.get("by", ()))})
        return columns

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "by": self.__dict__.get("by", [])}

    def __repr__(self) -> str:
        return f"<{self._title()}: the end at t = {self.t.ravel()[-1]:.6g}, and {self.by_start.shape[0]} derivatives by {self.by_start.shape[1]}>"
