"""What this package raises, and the sentences that several places say."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple, Optional

__all__ = ["CompileError", "Error", "Interrupted", "Message", "RunError"]

#: The oldest compiler that the sources accept.
OLDEST_RUST = (1, 89)

NO_CARGO = (
    "there is no cargo on this machine, and a new system has to be compiled: install Rust 1.89 or newer: https://rustup.rs, "
    "or `pip install wzvi[rust]`, or load() a library that was built elsewhere"
)
NO_LINKER = (
    "Rust is there, but no linker: install gcc or clang (Debian and Ubuntu: `apt install gcc`; macOS: `xcode-select --install`), "
    "or `pip install ziglang`, which is then used"
)
OLD_RUST = (
    "Rust {found} is too old: install Rust 1.89 or newer: `rustup update`, https://rustup.rs, or `pip install wzvi[rust]`, "
    "or load() a library that was built elsewhere"
)
NO_SOURCES = (
    "the Rust sources of wzvi are missing from this package: install it again, or set WZVI_SOURCES to a checkout of the repository"
)
DISK_FULL = "the disk of the cache {folder} is full: make room, call wzvi.clear_cache(), or set WZVI_CACHE to another folder"


class Error(Exception):
    """Anything that this package has to say."""


class RunError(Error):
    """A run that could not begin or could not go on.

    Attributes:
        code: the kind of the error as a short word: "setting", "name", "step", "noise", "stopped", ...
        partial: the result up to where the run ended, or None.
    """

    def __init__(self, message: str, code: str = "", partial: Any = None) -> None:
        super().__init__(message)
        self.code = code
        self.partial = partial

    def __reduce__(self) -> tuple[Any, ...]:
        return RunError, (str(self), self.code, self.partial)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run.

    Attributes:
        partial: the result up to where the run was stopped, or None.
    """

    def __init__(self, message: str = "the run was stopped", partial: Any = None) -> None:
        super().__init__(message)
        self.partial = partial


class Message(NamedTuple):
    """One place of a mistake in the texts that were given to `compile`. Lines and columns count from 1."""

    #: What is wrong.
    text: str
    #: The argument of `compile`: "drift", "noise[1]", "observe['radius']"; None if it is no single one.
    argument: Optional[str]
    #: The line in the text of this argument.
    line: Optional[int]
    #: The column in this line.
    column: Optional[int]
    #: How many characters are meant.
    width: Optional[int]
    #: What is said of this place in particular.
    label: Optional[str] = None
    #: The SymPy term that the line was printed from.
    term: Optional[str] = None


class CompileError(Error):
    """Mistakes in the texts or expressions that were given to `compile`.

    Attributes:
        messages: a `Message` for each place, with text, argument, line, column, width, label and, for SymPy, the term.
    """

    def __init__(self, text: str, messages: Iterable[Message] = ()) -> None:
        super().__init__(text)
        self.messages: list[Message] = list(messages)

    def __reduce__(self) -> tuple[Any, ...]:
        return CompileError, (str(self), self.messages)


def pointed(line: str, column: int, width: int, mark: str = "^", label: str = "") -> str:
    """A line of a text and a mark below it; `column` counts from 1. Tabs stay tabs, so that both lines agree."""
    padding = "".join("\t" if c == "\t" else " " for c in line[: column - 1])
    return f"    {line}\n    {padding}{mark * max(width, 1)}{' ' + label if label else ''}"


def at(text: str, argument: str, source: str, index: int, width: int = 1) -> CompileError:
    """An error at one place of a text."""
    line = source.count("\n", 0, index)
    start = source.rfind("\n", 0, index) + 1
    column = index - start + 1
    whole = source[start:].split("\n", 1)[0]
    message = Message(text, argument, line + 1, column, width)
    return CompileError(f"{text}\n  --> {argument}, line {line + 1}\n{pointed(whole, column, width)}", [message])
