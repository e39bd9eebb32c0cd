"""The table of a library of systems (`wzvi.h`), and tasks: runs with settings by name in and arrays by name out."""

from __future__ import annotations

import _thread
import ctypes as C
import json
import os
import threading
from collections.abc import Callable, Iterable
from typing import Any, Optional, Union

import numpy as np

from ._errors import Error, Interrupted

ABI, DONE, PARTIAL, FAILED = 1, 0, 1, 2
AXES = 8
#: A run with fewer steps than this is over before anybody could interrupt it: below 50 ms for most systems.
SHORT = 2e5

_P, _S, _Z = C.c_void_p, C.c_char_p, C.c_size_t
_PZ = C.POINTER(_Z)


class Table(C.Structure):
    _fields_ = [
        ("size", _Z),
        ("abi", C.c_uint32),
        ("reserved", C.c_uint32),
        ("inside", _P),
        ("describe", C.CFUNCTYPE(_S, _P)),
        ("begin", C.CFUNCTYPE(_P, _P, _S, _S)),
        ("set_real", C.CFUNCTYPE(C.c_int32, _P, _S, C.c_double)),
        ("set_integer", C.CFUNCTYPE(C.c_int32, _P, _S, C.c_int64)),
        ("set_text", C.CFUNCTYPE(C.c_int32, _P, _S, _S)),
        ("set_reals", C.CFUNCTYPE(C.c_int32, _P, _S, _P, _Z, _PZ)),
        ("set_integers", C.CFUNCTYPE(C.c_int32, _P, _S, _P, _Z, _PZ)),
        ("run", C.CFUNCTYPE(C.c_int32, _P)),
        ("stop", C.CFUNCTYPE(None, _P)),
        ("progress", C.CFUNCTYPE(None, _P, C.POINTER(C.c_uint64), C.POINTER(C.c_uint64))),
        ("results", C.CFUNCTYPE(_Z, _P)),
        ("result", C.CFUNCTYPE(_Z, _P, _Z, C.POINTER(_S), C.POINTER(_P), _PZ)),
        ("columns", C.CFUNCTYPE(_S, _P)),
        ("error", C.CFUNCTYPE(_S, _P)),
        ("code", C.CFUNCTYPE(_S, _P)),
        ("end", C.CFUNCTYPE(None, _P)),
    ]


class Functions:
    """The functions of a table, read once: each access to a field of a structure makes a new object."""

    def __init__(self, path: str) -> None:
        try:
            self.library = C.CDLL(path)
        except OSError as error:
            if os.path.exists(path):
                raise Error(f"{path} cannot be loaded: {error}") from error
            raise Error(f"there is no library {path}: compile it, or give load() the path of one") from None
        try:
            symbol = self.library.wzvi_table
        except AttributeError:
            raise Error(f"{path} is no library of wzvi: it has no symbol wzvi_table") from None
        symbol.restype, symbol.argtypes = C.POINTER(Table), []
        table = symbol().contents
        if table.abi != ABI or table.size < C.sizeof(Table):
            raise Error(f"{path} has version {table.abi} of the table, and this package reads version {ABI}: build it again")
        self.table = table
        self.address = C.addressof(table)
        for name, *_ in Table._fields_[4:]:
            setattr(self, name, getattr(table, name))

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)

    def description(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.describe(self.address).decode())
        return found


class View:
    """Memory of a task as numpy asks for it. It keeps the task alive."""

    __slots__ = ("__array_interface__", "task")

    def __init__(self, task: Task, address: int, shape: tuple[int, ...]) -> None:
        self.task = task
        # Read-only: other arrays may be views of the same memory.
        self.__array_interface__ = {"version": 3, "typestr": "<f8", "shape": shape, "data": (address, True)}


Raw = tuple[int, tuple[int, ...]]


class Task:
    """One run of a system. Arrays of its results are views of its memory."""

    __slots__ = ("__weakref__", "functions", "pointer")

    def __init__(self, functions: Functions, system: str, kind: str) -> None:
        self.functions = functions
        self.pointer = functions.begin(functions.address, system.encode(), kind.encode())
        if not self.pointer:
            raise MemoryError("no memory for a run")

    def __del__(self) -> None:
        pointer = getattr(self, "pointer", None)
        if pointer:
            self.functions.end(pointer)

    def set_text(self, name: str, value: str) -> None:
        self._checked(self.functions.set_text(self.pointer, name.encode(), value.encode()))

    def set_integer(self, name: str, value: int) -> None:
        if not -(1 << 63) <= value < 1 << 63:
            raise ValueError(f"{name} is {value}: integers have to be below 2^63")
        self._checked(self.functions.set_integer(self.pointer, name.encode(), value))

    def set_real(self, name: str, value: float) -> None:
        self._checked(self.functions.set_real(self.pointer, name.encode(), value))

    def set_array(self, name: str, array: np.ndarray) -> None:
        if array.ndim > AXES:
            raise ValueError(f"{name} has {array.ndim} axes: there may be {AXES}")
        kind = array.dtype.kind
        if kind in "iub":
            array, setter = np.ascontiguousarray(array, dtype=np.int64), self.functions.set_integers
        elif kind == "f":
            array, setter = np.ascontiguousarray(array, dtype=np.float64), self.functions.set_reals
        else:
            raise TypeError(f"{name} has to be numbers, not {array.dtype}")
        shape = (_Z * AXES)(*array.shape)
        self._checked(setter(self.pointer, name.encode(), array.ctypes.data, array.ndim, shape))

    def set(self, name: str, value: Any) -> None:
        """Sets what the type of the value says: a text, a list of texts, an integer, a number, or an array."""
        if isinstance(value, str):
            self.set_text(name, value)
        elif isinstance(value, float):
            self.set_real(name, value)
        elif isinstance(value, (bool, int, np.integer, np.bool_)):
            self.set_integer(name, int(value))
        elif isinstance(value, np.floating):
            self.set_real(name, float(value))
        elif isinstance(value, (list, tuple)) and value and all(isinstance(each, str) for each in value):
            self.set_text(name, "\n".join(value))
        else:
            array = np.asarray(value)
            if array.ndim == 0 and array.dtype.kind in "iubf":
                self.set(name, array.item())
            else:
                self.set_array(name, array)

    def _checked(self, status: int) -> None:
        if status != DONE:
            raise ValueError(self.error())

    def error(self) -> str:
        return (self.functions.error(self.pointer) or b"").decode()

    def code(self) -> str:
        return (self.functions.code(self.pointer) or b"").decode()

    def columns(self) -> list[str]:
        text = (self.functions.columns(self.pointer) or b"").decode()
        return text.split("\n") if text else []

    def progress(self) -> tuple[int, int]:
        done, total = C.c_uint64(), C.c_uint64()
        self.functions.progress(self.pointer, C.byref(done), C.byref(total))
        return done.value, total.value

    def run(self, work: float, progress: Optional[Callable[[int, int], object]]) -> int:
        """Runs. ctypes lets other threads run meanwhile.

        A short run is done in place, and so is one of a thread that signals do not reach. A long one is done beside
        this thread, so that Ctrl-C and `progress` get their turn.
        """
        if progress is None and (work < SHORT or threading.current_thread() is not threading.main_thread()):
            status: int = self.functions.run(self.pointer)
            return status
        return self._run_beside(progress)

    def _run_beside(self, progress: Optional[Callable[[int, int], object]]) -> int:
        statuses: list[int] = []
        over = threading.Event()
        # Who holds it decides whether the run begins: an interrupt may come before the thread has.
        begun = _thread.allocate_lock()
        interrupt: Optional[BaseException] = None

        def beside() -> None:
            if begun.acquire(False):
                try:
                    statuses.append(self.functions.run(self.pointer))
                finally:
                    over.set()

        # Not `Thread.join`: when Ctrl-C interrupts it, it takes the thread for dead.
        try:
            _thread.start_new_thread(beside, ())
        except BaseException as error:
            if isinstance(error, RuntimeError):
                # The system has no more threads.
                if begun.acquire(False):
                    status: int = self.functions.run(self.pointer)
                    return status
            interrupt = error
            if begun.acquire(False):
                raise
            self.functions.stop(self.pointer)
        pause = 0.001
        told = False
        while not over.is_set():
            try:
                over.wait(pause)
                pause = min(1.5 * pause, 0.05)
                if progress is not None and interrupt is None:
                    progress(*self.progress())
                    told = True
            except BaseException as error:  # of `progress`, too: the run ends before anything else does
                if interrupt is None or isinstance(error, KeyboardInterrupt):
                    interrupt = error
                self.functions.stop(self.pointer)
        if interrupt is None and progress is not None and statuses and statuses[0] == DONE:
            try:
                done, total = self.progress()
                progress(total if told or done == 0 else done, total)
            except BaseException as error:
                interrupt = error
        if progress is not None and hasattr(progress, "end"):
            progress.end()
        status = statuses[0] if statuses else FAILED
        if isinstance(interrupt, KeyboardInterrupt):
            raise Interrupted(partial=status) from None
        if interrupt is not None:
            raise interrupt
        return status

    def raw(self) -> dict[str, Raw]:
        """Where the arrays of the results are, by name, and their shapes."""
        functions, pointer = self.functions, self.pointer
        name, values, shape = _S(), _P(), (_Z * AXES)()
        by_name, by_values, get = C.byref(name), C.byref(values), functions.result
        found: dict[str, Raw] = {}
        for index in range(functions.results(pointer)):
            axes = get(pointer, index, by_name, by_values, shape)
            found[(name.value or b"").decode()] = (values.value or 0, tuple(shape[:axes]))
        return found

    def view(self, raw: Raw) -> Union[float, np.ndarray]:
        """An array of the results without a copy; a single number as itself."""
        address, shape = raw
        if not shape:
            return C.c_double.from_address(address).value
        if 0 in shape:
            empty = np.zeros(shape)
            empty.flags.writeable = False
            return empty
        return np.asarray(View(self, address, shape))


def numbers(name: str, value: Any) -> np.ndarray:
    """Real numbers in an array of one axis or more."""
    try:
        return np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        raise TypeError(f"{name} has to be numbers, not {value!r}") from None


def texts(name: str, value: Union[str, Iterable[str]]) -> str:
    """A list of names as one text with a line for each."""
    listed = [value] if isinstance(value, str) else list(value)
    for each in listed:
        if not isinstance(each, str) or "\n" in each:
            raise TypeError(f"{name} has to be a name or a list of names, not {each!r}")
    return "\n".join(listed)
