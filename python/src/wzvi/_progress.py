"""How far a run is: a line on a terminal or in a notebook, or a function of the user."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, Optional, Union

Progress = Union[None, bool, Callable[[int, int], object]]


def in_notebook() -> bool:
    """Whether the program runs in the kernel of a notebook."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None and hasattr(module, "get_ipython") else None
    return shell is not None and type(shell).__name__ == "ZMQInteractiveShell"


class Line:
    """One line that is written again and again."""

    def __init__(self) -> None:
        self.handle: Any = None
        self.length = 0
        self.notebook = in_notebook()

    def write(self, text: str) -> None:
        if self.notebook:
            from IPython.display import display

            shown = {"text/plain": text}
            if self.handle is None:
                self.handle = display(shown, raw=True, display_id=True)
            else:
                self.handle.update(shown, raw=True)
        else:
            sys.stderr.write("\r" + text.ljust(self.length))
            sys.stderr.flush()
            self.length = len(text)

    def end(self) -> None:
        if not self.notebook and self.length:
            sys.stderr.write("\n")
            sys.stderr.flush()
            self.length = 0


class RunLine:
    """`progress=True`: the part that is done, and the time that is left."""

    def __init__(self, unit: str) -> None:
        self.line, self.unit, self.began, self.last = Line(), unit, time.monotonic(), 0.0
        self.is_over = False

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if now - self.last < 0.1 and done < total:
            return
        self.last = now
        if total <= 0 or self.is_over:
            return
        self.is_over = done >= total
        part = min(done / total, 1.0)
        took = now - self.began
        left = f", {duration(took * (1 - part) / part)} left" if 0.0 < part < 1.0 else f", {duration(took)}" if part == 1.0 else ""
        bar = "█" * round(24 * part)
        self.line.write(f"{bar:░<24} {100 * part:5.1f} % of {total} {self.unit}{left}")

    def end(self) -> None:
        self.line.end()


def duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def reporter(progress: Progress, unit: str) -> Optional[Callable[[int, int], object]]:
    """What is called with the work that is done and all of it."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return RunLine(unit)
    return progress
