"""The Rust crate of a system, and for each of its lines the argument of `compile` that it comes from."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Optional, Union

from ._errors import CompileError, at

#: Keys of the attribute beside `drift`, `embedding` and `export`, and how their values are written.
#: "one": a value. "list": a value, or a list in brackets. "named": the same, and entries may have names.
KEYS = {
    "noise": "list",
    "force": "one",
    "noise_force": "list",
    "friction": "one",
    "damping": "one",
    "temperature": "one",
    "invariant": "named",
    "constraint": "list",
    "clock": "one",
    "calculus": "one",
    "observe": "named",
}

RUST_WORDS = frozenset(
    "as async await break const continue crate dyn else enum extern false fn for gen if impl in let loop match mod move mut pub ref return "
    "self Self static struct super trait true type unsafe use where while abstract become box do final macro override priv try typeof "
    "unsized virtual yield".split()
)
OPEN, CLOSE = "([{", ")]}"

Text = Union[str, "Printed"]


class Printed(NamedTuple):
    """A text that was printed from SymPy, with the term of each of its lines."""

    text: str
    terms: tuple[str, ...]


class Origin(NamedTuple):
    """Where a line of the crate comes from."""

    argument: Optional[str]
    line: int
    term: Optional[str] = None


class Crate(NamedTuple):
    text: str
    origins: tuple[Origin, ...]


def identifier(name: Any, what: str) -> str:
    """A name that Rust accepts."""
    if not isinstance(name, str) or not name.isidentifier():
        raise ValueError(f"{what}: {name!r} is no name: take letters, digits and _, and begin with a letter")
    if name in RUST_WORDS or name == "_":
        raise ValueError(f"{what}: {name!r} is a word of Rust: take another name, such as {name.strip('_') + '_'!r}")
    return name


def rust_type(name: str, of: Any) -> str:
    """The type of a field."""
    if of is float:
        return "f64"
    if of is int:
        return "i64"
    if of is bool:
        return "bool"
    if isinstance(of, str) and _is_type(of):
        return of.strip()
    if isinstance(of, list) and len(of) == 1:
        return f"Vec<{rust_type(name, of[0])}>"
    if isinstance(of, tuple) and len(of) == 2 and isinstance(of[1], int) and of[1] >= 0:
        return f"[{rust_type(name, of[0])}; {of[1]}]"
    raise TypeError(
        f"the type of the parameter {name} is {of!r}: take float, int, [float] for a list, (float, 3) for an array of 3, "
        "or a text of Rust such as 'Vec<[usize; 2]>'"
    )


def _is_type(text: str) -> bool:
    """Whether a text may be a type: brackets match, and nothing outside of them separates."""
    if not re.fullmatch(r"[A-Za-z0-9_<>\[\];:, ]*[A-Za-z0-9_>\]][ ]*", text):
        return False
    stack: list[str] = []
    for c in text.replace("::", "__"):
        if c in "<[":
            stack.append(c)
        elif c in ">]":
            if not stack or stack.pop() + c not in ("<>", "[]"):
                return False
        elif c in ",;:" and not stack:
            return False
    return not stack


_RAW = re.compile(r'b?r(#*)"')
_STRING = re.compile(r'"(?:\\.|[^"\\])*"', re.S)
_CHAR = re.compile(r"'(?:\\(?:x[0-9A-Fa-f]{2}|u\{[0-9A-Fa-f_]+\}|.)|[^\\'])'", re.S)


def balanced(text: str, argument: str) -> str:
    """Refuses texts whose brackets would end the attribute.

    Not for safety, which no compiler of programs can give, but for a message that makes sense.
    """
    stack: list[int] = []
    i = 0
    while i < len(text):
        c = text[i]
        if text.startswith("//", i):
            end = text.find("\n", i)
            i = len(text) if end < 0 else end + 1
            continue
        if text.startswith("/*", i):
            i = _after_comment(text, argument, i)
            continue
        raw = _RAW.match(text, i) if c in "br" and (i == 0 or not (text[i - 1].isalnum() or text[i - 1] == "_")) else None
        if raw:
            end = text.find('"' + raw[1], raw.end())
            if end < 0:
                raise at("a text in quotes does not end", argument, text, i)
            i = end + 1 + len(raw[1])
            continue
        if c == '"':
            string = _STRING.match(text, i)
            if not string:
                raise at("a text in quotes does not end", argument, text, i)
            i = string.end()
            continue
        if c == "'":
            char = _CHAR.match(text, i)
            i = char.end() if char else i + 1
            continue
        if c in OPEN:
            stack.append(i)
        elif c in CLOSE:
            if not stack:
                raise at(f"`{c}` closes nothing", argument, text, i)
            opened = stack.pop()
            if OPEN.index(text[opened]) != CLOSE.index(c):
                raise at(f"`{c}` does not close the `{text[opened]}` before it", argument, text, i)
        i += 1
    if stack:
        raise at(f"`{text[stack[-1]]}` is never closed", argument, text, stack[-1])
    return text


def _after_comment(text: str, argument: str, start: int) -> int:
    depth, i = 0, start
    while i < len(text):
        if text.startswith("/*", i):
            depth, i = depth + 1, i + 2
        elif text.startswith("*/", i):
            depth, i = depth - 1, i + 2
            if depth == 0:
                return i
        else:
            i += 1
    raise at("a comment does not end", argument, text, start)


def listed(value: Any) -> list[Any]:
    """A list of texts from one text or several."""
    return [value] if isinstance(value, (str, Printed)) else list(value)


class Writer:
    def __init__(self) -> None:
        self.lines: list[str] = []
        self.origins: list[Origin] = []

    def own(self, text: str) -> None:
        for line in text.split("\n"):
            self.lines.append(line)
            self.origins.append(Origin(None, 0))

    def user(self, value: Text, argument: str) -> None:
        """A text of the user, on lines of its own: its columns stay as they are."""
        text, terms = (value.text, value.terms) if isinstance(value, Printed) else (value, ())
        if not isinstance(text, str):
            raise TypeError(f"{argument} has to be a text or a SymPy expression, not {text!r}")
        # Rust ends lines at \n alone, and so do the lines of messages.
        text = balanced(text.replace("\r\n", "\n").rstrip().rstrip(","), argument)
        if not text.strip():
            raise CompileError(f"{argument} is empty: give a closure, such as '|q, p| 0.5 * p * p + 0.5 * q * q'")
        for number, line in enumerate(text.split("\n")):
            self.lines.append(line)
            self.origins.append(Origin(argument, number + 1, terms[number] if number < len(terms) else None))


def source(
    drift: Any,
    *,
    name: str,
    doc: str,
    parameters: Mapping[str, Any],
    embedding: Any,
    schemes: Any,
    items: Optional[str],
    keys: Mapping[str, Any],
    field_docs: Optional[Mapping[str, str]] = None,
) -> Crate:
    """The crate of a system."""
    identifier(name, "name")
    for each in [*listed(embedding), *listed(schemes)]:
        if isinstance(each, str) and re.search(rf"\b{name}\b", each):
            raise ValueError(f"name: {name!r} is a scheme of this system: take another name")
    write = Writer()
    write.own("#![forbid(unsafe_code)]\n#![allow(unused, non_snake_case, non_camel_case_types, uncommon_codepoints, confusable_idents)]")
    write.own("use wzvi::prelude::*;")
    if items:
        write.user(items, "items")
    write.own(_documentation(doc or "A system.", ""))
    write.own("#[hamiltonian(")
    _value(write, "drift", listed(drift), "list" if not isinstance(drift, (str, Printed)) else "one")
    for key, value in keys.items():
        if value is None:
            continue
        if key not in KEYS:
            raise TypeError(f"compile has no argument {key!r}: keys of the system are drift, {', '.join(KEYS)}, embedding, schemes, parameters")
        if isinstance(value, Mapping):
            if KEYS[key] != "named":
                raise TypeError(f"{key} has no names: give a text or a list")
            _named(write, key, value)
        elif KEYS[key] == "one":
            if not isinstance(value, (str, Printed)):
                # Rates, temperatures and rows for each degree of freedom.
                _value(write, key, listed(value), "list")
            else:
                _value(write, key, [value], "one")
        elif key == "observe":
            raise TypeError("observe has to be a dict of names and closures: {'radius': '|q, p| ...'}")
        else:
            _value(write, key, listed(value), "list")
    write.own("embedding = [")
    _entries(write, "embedding", listed(embedding))
    write.own("],\nexport = [")
    _entries(write, "schemes", listed(schemes))
    write.own("],\n)]")
    write.own(f"pub struct {name} {{")
    for field, of in parameters.items():
        if field_docs and field in field_docs:
            write.own(_documentation(field_docs[field], "    "))
        write.own(f"    pub {identifier(field, 'parameters')}:")
        write.user(rust_type(field, of), f"parameters[{field!r}]")
        write.own(",")
    write.own("}")
    write.own(f"wzvi_c::export! {{ {name} }}")
    return Crate("\n".join(write.lines) + "\n", tuple(write.origins))


def _documentation(text: str, indent: str) -> str:
    return "\n".join(f"{indent}/// {line}".rstrip() for line in text.replace("\r", "").split("\n"))


def _value(write: Writer, key: str, values: list[Any], kind: str) -> None:
    if kind == "one":
        value = values[0]
        text = value.text if isinstance(value, Printed) else value
        # `drift = |q, p| ...` as in a program of Rust.
        has_key = isinstance(text, str) and re.match(rf"\s*{key}\s*=[^=]", text) is not None
        if not has_key:
            write.own(f"{key} =")
        write.user(value, key)
        write.own(",")
        return
    write.own(f"{key} = [")
    _entries(write, key, values)
    write.own("],")


def _entries(write: Writer, key: str, values: Iterable[Any]) -> None:
    values = list(values)
    for number, value in enumerate(values):
        write.user(value, f"{key}[{number}]" if len(values) > 1 else key)
        write.own(",")


def _named(write: Writer, key: str, values: Mapping[str, Any]) -> None:
    write.own(f"{key} = [")
    for label, value in values.items():
        write.own(f"{identifier(label, key)} =")
        write.user(value, f"{key}[{label!r}]")
        write.own(",")
    write.own("],")
