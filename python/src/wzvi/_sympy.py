"""SymPy expressions as closures of Rust. Each term of a sum is on a line of its own, so that errors point at it."""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ._errors import CompileError, Message
from ._source import RUST_WORDS, Printed

# How tightly the outermost operation of a text binds.
BLOCK, OR, AND, COMPARE, ADD, MUL, NEGATIVE, ATOM = range(8)

#: Functions that are methods of the same number of arguments.
METHODS = {
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "asin": "asin",
    "acos": "acos",
    "atan": "atan",
    "atan2": "atan2",
    "sinh": "sinh",
    "cosh": "cosh",
    "tanh": "tanh",
    "asinh": "asinh",
    "acosh": "acosh",
    "atanh": "atanh",
    "exp": "exp",
    "log": "ln",
    "Abs": "abs",
    "sign": "signum",
    "erf": "erf",
    "erfc": "erfc",
    "sinc": "sinc",
    # Of sympy.codegen.cfunctions.
    "exp2": "exp2",
    "expm1": "exp_m1",
    "log1p": "ln_1p",
    "log2": "log2",
    "log10": "log10",
    "Sqrt": "sqrt",
    "Cbrt": "cbrt",
    "hypot": "hypot",
    "fma": "mul_add",
}
#: One divided by a function.
RECIPROCALS = {"sec": "cos", "csc": "sin", "cot": "tan", "sech": "cosh", "csch": "sinh", "coth": "tanh"}
INVERSES = {"asec": "acos", "acsc": "asin", "acot": "atan", "asech": "acosh", "acsch": "asinh", "acoth": "atanh"}
KNOWN = sorted([*METHODS, *RECIPROCALS, *INVERSES, "sqrt", "Min", "Max", "Piecewise", "Heaviside", "besselj(0, x)", "besselj(1, x)"], key=str.lower)


def is_sympy(value: Any) -> bool:
    """Whether a value is of SymPy, without importing it."""
    sympy = sys.modules.get("sympy")
    return sympy is not None and isinstance(value, (sympy.Basic, sympy.MatrixBase))


def has_sympy(value: Any) -> bool:
    """Whether there is anything of SymPy in a value, a list or a dict."""
    if isinstance(value, Mapping):
        return any(has_sympy(each) for each in value.values())
    if isinstance(value, (list, tuple)):
        return any(has_sympy(each) for each in value)
    return is_sympy(value)


class Unsupported(Exception):
    """A part of an expression that has no counterpart."""


def names_of(symbols: Iterable[Any]) -> dict[Any, str]:
    """A name for each symbol that Rust and Python accept: `x'` becomes `x_prime`, `lambda` becomes `lambda_`."""
    names: dict[Any, str] = {}
    taken: dict[str, Any] = {}
    for symbol in symbols:
        text = getattr(symbol, "name", None) or type(symbol).__name__
        name = re.sub(r"\W+", "_", re.sub(r"[\\{}]", "", text.replace("'", "_prime"))).strip("_") or "x"
        if name[0].isdigit():
            name = "_" + name
        if keyword.iskeyword(name) or name in RUST_WORDS:
            name += "_"
        if name in taken:
            raise CompileError(f"the symbols {taken[name]} and {symbol} both become `{name}`: rename one of them")
        names[symbol], taken[name] = name, symbol
    return names


class Printer:
    """Prints expressions of real numbers."""

    def __init__(self, names: Mapping[Any, str], integers: frozenset[Any] = frozenset()) -> None:
        import sympy

        self.sympy, self.names, self.integers = sympy, names, integers

    def at_least(self, expression: Any, binding: int) -> str:
        text, binds = self.text(expression)
        return text if binds >= binding else f"({text})"

    def text(self, e: Any) -> tuple[str, int]:
        """The text of an expression and how tightly it binds."""
        sympy = self.sympy
        if e in self.names:
            name = self.names[e]
            return (f"({name} as f64)" if e in self.integers else name), ATOM
        if e.is_Number:
            return self.number(e)
        if isinstance(e, sympy.NumberSymbol):
            known = {sympy.pi: "std::f64::consts::PI", sympy.E: "std::f64::consts::E"}
            return (known[e], ATOM) if e in known else (repr(float(e)), ATOM)
        if e.is_Add:
            return self.sum(e.as_ordered_terms()), ADD
        if e.is_Mul:
            return self.product(e)
        if e.is_Pow:
            return self.power(e)
        if isinstance(e, sympy.Piecewise):
            return self.piecewise(e), BLOCK
        if isinstance(e, (sympy.Min, sympy.Max)):
            first, *rest = sorted(e.args, key=sympy.default_sort_key, reverse=True)
            name = "min" if isinstance(e, sympy.Min) else "max"
            text = self.receiver(first)
            for each in rest:
                text = f"{text}.{name}({self.text(each)[0]})"
            return text, ATOM
        if isinstance(e, sympy.Heaviside):
            return f"if {self.text(e.args[0])[0]} < 0.0 {{ 0.0 }} else {{ 1.0 }}", BLOCK
        if isinstance(e, sympy.besselj) and e.args[0] in (0, 1):
            return f"{self.receiver(e.args[1])}.j{int(e.args[0])}()", ATOM
        if isinstance(e, sympy.ITE):
            condition, then, other = e.args
            return f"if {self.condition(condition)[0]} {{ {self.text(then)[0]} }} else {{ {self.text(other)[0]} }}", BLOCK
        if isinstance(e, (sympy.Derivative, sympy.Integral, sympy.Sum, sympy.Product, sympy.Subs)):
            done = e.doit()
            if done.has(type(e)):
                raise Unsupported(f"`{e}` cannot be worked out: write its value")
            return self.text(done)
        return self.function(e)

    def number(self, e: Any) -> tuple[str, int]:
        sympy = self.sympy
        if not e.is_finite:
            raise Unsupported(f"`{e}` is not a finite number")
        negative = e < 0
        value = -e if negative else e
        if value.is_Integer:
            text, binds = (f"{value}.0" if value < 10**15 else repr(float(value))), ATOM
        elif isinstance(value, sympy.Rational) and not float_is(value):
            text, binds = f"{self.number(sympy.Integer(value.p))[0]} / {self.number(sympy.Integer(value.q))[0]}", MUL
        else:
            text, binds = repr(float(value)), ATOM
        return (f"-{text}", min(NEGATIVE, binds)) if negative else (text, binds)

    def sum(self, terms: Sequence[Any], between: str = " ") -> str:
        parts: list[str] = []
        for term in terms:
            negative, value = self.sign(term)
            text = self.at_least(value, MUL)
            parts.append(("- " if negative else "+ ") + text if parts else ("-" if negative else "") + text)
        return between.join(parts)

    def sign(self, term: Any) -> tuple[bool, Any]:
        """Whether a term is subtracted, and the term without its sign."""
        coefficient, _ = term.as_coeff_Mul()
        if coefficient.is_Number and coefficient < 0 and not term.is_Add:
            return True, -term
        return False, term

    def product(self, e: Any) -> tuple[str, int]:
        sympy = self.sympy
        coefficient, rest = e.as_coeff_Mul()
        negative = bool(coefficient.is_Number and coefficient < 0)
        if negative:
            coefficient = -coefficient
        above, below = [], []
        if isinstance(coefficient, sympy.Rational) and not coefficient.is_Integer and not float_is(coefficient):
            if coefficient.p != 1:
                above.append(sympy.Integer(coefficient.p))
            below.append(sympy.Integer(coefficient.q))
        elif coefficient != 1:
            above.append(coefficient)
        for factor in rest.as_ordered_factors() if rest.is_Mul else [rest]:
            base, exponent = factor.as_base_exp()
            if factor.is_Pow and exponent.is_Number and exponent < 0 and base != sympy.E:
                below.append(sympy.Pow(base, -exponent, evaluate=False) if exponent != -1 else base)
            elif factor != 1:
                above.append(factor)
        # `x * x` may stand in a product as it is.
        text = " * ".join(self.factor(factor, i == 0) for i, factor in enumerate(above)) or "1.0"
        if below:
            under = " * ".join(self.at_least(factor, MUL if len(below) > 1 and i == 0 else NEGATIVE) for i, factor in enumerate(below))
            text += f" / {under}" if len(below) == 1 else f" / ({under})"
        return f"-{text}" if negative else text, MUL

    def factor(self, e: Any, is_first: bool) -> str:
        """A factor of a product. One that is a product itself needs no brackets where nothing is divided."""
        text, binds = self.text(e)
        is_plain = binds == MUL and (is_first or "/" not in text)
        return text if binds > MUL or is_plain else f"({text})"

    def power(self, e: Any) -> tuple[str, int]:
        sympy = self.sympy
        base, exponent = e.as_base_exp()
        if base == sympy.E:
            return f"{self.receiver(exponent)}.exp()", ATOM
        if exponent.is_Number and exponent < 0:
            positive = sympy.Pow(base, -exponent, evaluate=False) if exponent != -1 else base
            return f"1.0 / {self.at_least(positive, NEGATIVE)}", MUL
        if exponent == 2 and base in self.names and base not in self.integers:
            return f"{self.names[base]} * {self.names[base]}", MUL
        receiver = self.receiver(base)
        if exponent.is_Integer:
            if exponent >= 1 << 31:
                raise Unsupported(f"the exponent of `{e}` is too large")
            return f"{receiver}.powi({exponent})", ATOM
        if isinstance(exponent, sympy.Rational) and exponent.q == 2:
            return f"{receiver}.sqrt()" + (f".powi({exponent.p})" if exponent.p != 1 else ""), ATOM
        return f"{receiver}.powf({self.text(exponent)[0]})", ATOM

    def receiver(self, e: Any) -> str:
        """What a method is called on: Rust has to know that a number is a real one."""
        text, binds = self.text(e)
        if e.is_Number and binds == ATOM:
            return f"{text}_f64"
        if binds == ATOM:
            return text
        if not e.free_symbols:
            # Rust takes the type of a sum or product from its first number.
            text = re.sub(r"^(-?)(\d[\d.]*(?:e[+-]?\d+)?)(?![\w.])", r"\1\2_f64", text)
        return f"({text})"

    def piecewise(self, e: Any) -> str:
        parts = []
        for value, condition in e.args:
            if condition in (True, self.sympy.true):
                parts.append(f"{{ {self.text(value)[0]} }}")
                break
            parts.append(f"if {self.condition(condition)[0]} {{ {self.text(value)[0]} }}")
        else:
            raise Unsupported(f"`{e}` has no value where none of its conditions holds: end it with (value, True)")
        return " else ".join(parts)

    def condition(self, e: Any) -> tuple[str, int]:
        sympy = self.sympy
        if e in (True, sympy.true):
            return "true", ATOM
        if e in (False, sympy.false):
            return "false", ATOM
        if isinstance(e, sympy.Rel):
            operator = {"Eq": "==", "Ne": "!=", "Equality": "==", "Unequality": "!="}.get(type(e).__name__, e.rel_op)
            return f"{self.at_least(e.lhs, ADD)} {operator} {self.at_least(e.rhs, ADD)}", COMPARE
        if isinstance(e, (sympy.And, sympy.Or)):
            binds, word = (AND, " && ") if isinstance(e, sympy.And) else (OR, " || ")
            parts = [self.condition(each) for each in sorted(e.args, key=sympy.default_sort_key)]
            return word.join(text if inner > binds else f"({text})" for text, inner in parts), binds
        if isinstance(e, sympy.Not):
            return f"!({self.condition(e.args[0])[0]})", ATOM
        raise Unsupported(f"the condition `{e}` has no counterpart: there are <, <=, >, >=, ==, !=, and, or, not")

    def function(self, e: Any) -> tuple[str, int]:
        name = type(e).__name__
        if name in METHODS and e.args:
            rest = ", ".join(self.text(each)[0] for each in e.args[1:])
            return f"{self.receiver(e.args[0])}.{METHODS[name]}({rest})", ATOM
        if name in RECIPROCALS:
            return f"1.0 / {self.receiver(e.args[0])}.{RECIPROCALS[name]}()", MUL
        if name in INVERSES:
            return f"{self.receiver(1 / e.args[0])}.{INVERSES[name]}()", ATOM
        if e is self.sympy.I or e.has(self.sympy.I):
            raise Unsupported(f"`{e}` is not real")
        if e.is_Symbol:
            raise Unsupported(f"`{e}` is neither a coordinate or momentum nor a parameter: add it to `parameters`")
        if name == "AppliedUndef" or getattr(e, "is_Function", False) and isinstance(type(e), self.sympy.core.function.UndefinedFunction):
            raise Unsupported(f"`{e}` is a function without a definition: list it in `q` or `p`, or substitute what it is")
        raise Unsupported(f"`{name}` in `{e}` has no counterpart: there are {', '.join(KNOWN)}")


def float_is(value: Any) -> bool:
    """Whether a fraction is a number of a few binary digits, such as 0.375, whose decimals are exact and short."""
    return bool(value.q & (value.q - 1) == 0 and value.q <= 1024 and abs(value.p) < 1 << 40)


class Translation:
    """Arguments of `compile` in which SymPy expressions are closures."""

    def __init__(self, q: Any, p: Any, t: Any, parameters: Any, everything: Sequence[Any]) -> None:
        import sympy

        self.sympy = sympy
        if q is None or p is None:
            raise TypeError("a SymPy expression needs its variables: q=[x, y], p=[px, py], and t=t if it has the time")
        self.single = not isinstance(q, (list, tuple, sympy.MatrixBase, sympy.Tuple)) or len(q) == 1
        self.q, self.p = self._variables("q", q), self._variables("p", p)
        if len(self.q) != len(self.p):
            raise ValueError(f"there are {len(self.q)} coordinates and {len(self.p)} momenta: give as many of both")
        # Coordinates that are functions of the time, x(t), stand for themselves.
        self.plain = {each: sympy.Symbol(each.func.__name__, real=True) for each in [*self.q, *self.p] if not each.is_Symbol}
        self.q = [self.plain.get(each, each) for each in self.q]
        self.p = [self.plain.get(each, each) for each in self.p]
        if len({*self.q, *self.p}) != 2 * len(self.q):
            raise ValueError("a symbol is listed twice in q and p")
        self.t = t
        free: set[Any] = set()
        for each in self._expressions(everything):
            free |= each.free_symbols
        variables = {*self.q, *self.p, *([t] if t is not None else [])}
        self.timed = t is not None and t in free
        if parameters is None:
            fields = {symbol: float for symbol in sorted(free - variables, key=lambda symbol: symbol.name)}
        elif isinstance(parameters, Mapping):
            fields = dict(parameters)
        else:
            fields = {each: float for each in parameters}
        by_name = {getattr(symbol, "name", None): symbol for symbol in free}
        # Names stand for the symbols of this name.
        fields = {by_name.get(each, sympy.Symbol(each)) if isinstance(each, str) else each: of for each, of in fields.items()}
        clash = [str(each) for each in fields if each in variables]
        if clash:
            raise ValueError(f"{', '.join(clash)} is listed as a parameter and as a variable")
        order = [*self.q, *self.p, *([t] if t is not None else []), *fields]
        self.names = names_of(order)
        self.parameters = {self.names[each]: of for each, of in fields.items()}
        integers = frozenset(each for each, of in fields.items() if of is int or isinstance(of, str) and re.fullmatch(r"[iu](8|16|32|64|128|size)", of))
        arrays = [each for each, of in fields.items() if isinstance(of, (list, tuple))]
        if arrays:
            raise TypeError(f"the parameter {arrays[0]} is an array: SymPy expressions have parameters that are numbers")
        self.printer = Printer(self.names, integers)

    def _variables(self, name: str, given: Any) -> list[Any]:
        sympy = self.sympy
        listed = list(given) if isinstance(given, (list, tuple, sympy.MatrixBase, sympy.Tuple)) else [given]
        for each in listed:
            applied = isinstance(each, sympy.core.function.AppliedUndef)
            if not (is_sympy(each) and (each.is_Symbol or applied)):
                raise TypeError(f"{name} has to be a symbol or a list of symbols, not {each!r}")
        return listed

    def _expressions(self, value: Any) -> list[Any]:
        if isinstance(value, Mapping):
            return [each for part in value.values() for each in self._expressions(part)]
        if isinstance(value, (list, tuple)):
            return [each for part in value for each in self._expressions(part)]
        if is_sympy(value):
            return [self._plain(each) for each in (list(value) if isinstance(value, self.sympy.MatrixBase) else [value])]
        return []

    def _plain(self, expression: Any) -> Any:
        return expression.xreplace(self.plain) if self.plain else expression

    def pattern(self, momenta: bool = True, time: bool = True) -> str:
        def group(symbols: list[Any]) -> str:
            names = [self.names[each] for each in symbols]
            return names[0] if self.single else f"[{', '.join(names)}]"

        parts = [group(self.q), *([group(self.p)] if momenta else []), *([self.names[self.t]] if time and self.timed else [])]
        return f"|{', '.join(parts)}|"

    def argument(self, key: str, value: Any) -> Any:
        """The value of a key with its expressions printed."""
        if not has_sympy(value):
            return value
        if isinstance(value, Mapping):
            return {label: self.closure(key, f"{key}[{label!r}]", each) for label, each in value.items()}
        if key == "damping":
            return self.matrix(key, value)
        if key == "force" or (key == "noise_force" and is_sympy(value)):
            return self.vector(key, key, value)
        if key == "noise_force":
            nested = all(isinstance(each, (list, tuple)) or isinstance(each, self.sympy.MatrixBase) for each in value)
            if self.single or nested:
                several = len(value) > 1
                return [self.vector(key, f"{key}[{i}]" if several else key, each) for i, each in enumerate(value)]
            return [self.vector(key, key, value)]
        if isinstance(value, (list, tuple)):
            several = len(value) > 1
            return [self.closure(key, f"{key}[{i}]" if several else key, each) for i, each in enumerate(value)]
        return self.closure(key, key, value)

    def _head(self, key: str, expression: Any) -> str:
        """The parameters of the closure of a key; no closure where only fields occur."""
        if key in ("friction", "damping", "temperature"):
            free = expression.free_symbols
            if key == "temperature":
                if free & {*self.q, *self.p}:
                    raise CompileError(f"temperature: `{expression}` has coordinates or momenta: a temperature depends on the time and parameters")
                return f"|{self.names[self.t]}|" if self.t is not None and self.t in free else ""
            if free & set(self.p):
                raise CompileError(f"{key}: `{expression}` has momenta: rates depend on coordinates and parameters")
            return self.pattern(momenta=False, time=False) if free & set(self.q) else ""
        return self.pattern(momenta=key != "constraint")

    def closure(self, key: str, argument: str, expression: Any) -> Any:
        if not is_sympy(expression):
            return repr(float(expression)) if isinstance(expression, (int, float)) else expression
        expression = self._plain(expression)
        lines, terms = self.body(argument, expression)
        head = self._head(key, expression)
        if head:
            lines, terms = [head, *("    " + line for line in lines)], [str(expression), *terms]
        return Printed("\n".join(lines), tuple(terms))

    def vector(self, key: str, argument: str, value: Any) -> Any:
        """A closure with an entry for each degree of freedom."""
        listed = [value] if is_sympy(value) and not isinstance(value, self.sympy.MatrixBase) else list(value)
        if len(listed) != len(self.q):
            raise ValueError(f"{argument} has {len(listed)} entries: it has one for each of the {len(self.q)} degrees of freedom")
        lines, terms = [self.pattern()], [str(value)]
        entries = [self.body(argument, self._plain(self.sympy.sympify(each))) for each in listed]
        if self.single:
            lines += ["    " + line for line in entries[0][0]]
            terms += entries[0][1]
        else:
            lines.append("[")
            terms.append(str(value))
            for entry, its_terms in entries:
                lines += ["    " + line for line in entry]
                lines[-1] += ","
                terms += its_terms
            lines.append("]")
            terms.append(str(value))
        return Printed("\n".join(lines), tuple(terms))

    def matrix(self, key: str, value: Any) -> Any:
        """A constant matrix, a line for each row."""
        rows = value.tolist() if isinstance(value, self.sympy.MatrixBase) else value
        lines, terms = ["["], [str(value)]
        for row in rows:
            entries = [" ".join(self.body(key, self.sympy.sympify(each))[0]) for each in row]
            lines.append(f"    [{', '.join(entries)}],")
            terms.append(str(list(row)))
        return Printed("\n".join([*lines, "]"]), (*terms, str(value)))

    def body(self, argument: str, expression: Any) -> tuple[list[str], list[str]]:
        """A line for each term of a sum, and the terms."""
        terms = expression.as_ordered_terms() if expression.is_Add else [expression]
        lines: list[str] = []
        for term in terms:
            try:
                text = self.printer.sum([term])
            except Unsupported as error:
                places = [Message(str(error), argument, len(lines) + 1, 1, None, None, str(term))]
                raise CompileError(f"{error}\n  --> {argument}, the term `{term}`", places) from None
            if lines:
                text = f"- {text[1:]}" if text.startswith("-") else f"+ {text}"
            lines.append(text)
        return lines, [str(term) for term in terms]
