"""SymPy expressions as closures: what is printed, and its values beside those of SymPy."""

import math
import shutil
import subprocess

import pytest

import wzvi

sympy = pytest.importorskip("sympy")
from wzvi._sympy import Printer, Translation, Unsupported, names_of  # noqa: E402

x, y, px, py, k, n, t = sympy.symbols("x y px py k n t")
S = sympy
VALUES = {x: 0.7, y: 1.3, k: 2.5, n: 3}

EXPRESSIONS = [
    x + y, x - y, -x - y, x * y / k, -x / y, x**2, -(x**2), x**3, x**-1, x**-2, x**S.Rational(3, 2), x**S.Rational(-1, 2), x**S.Rational(1, 3),
    x**y, x**n, 2**x, 1 / (x * y), 1 / (x**2 + y**2), k / S.sqrt(x**2 + y**2), S.Rational(1, 3) * x, S.Rational(3, 8) * x, S.Rational(-2, 3) * x * y,
    S.Rational(1, 3), S.Integer(2), S.Float("0.1") * x, 10**20 * x, S.pi * x, S.E * x, S.EulerGamma * x, S.sqrt(2) * x, S.sqrt(2), (x + y) ** 2,
    x / (y / k), x / y / k, x - (y - k), x - (y + k), (x + y) * (x - y), -(x + y) * k, S.exp(x), S.exp(-(x**2)), S.exp(-(x**2) / 2) / 3, S.exp(1) ** 2,
    S.sin(x), S.cos(x - y), S.tan(x), S.asin(x), S.acos(x), S.atan(x), S.atan2(y, x), S.sinh(x), S.cosh(x), S.tanh(x), S.asinh(x), S.acosh(y),
    S.atanh(x), S.log(x), S.log(x, 2), S.Abs(x - y), S.sign(x - y), S.Min(x, y), S.Max(x, y, k), S.Min(x, 1), S.sec(x), S.csc(x), S.cot(x), S.sech(x),
    S.csch(x), S.coth(x), S.Piecewise((x, x > y), (y * 2, True)), x * S.Piecewise((x, (x > y) | (x < 0)), (y, S.Eq(x, y)), (k, True)) + 1,
    S.Heaviside(x - y), S.Heaviside(y - x) * x, S.cos(2) * x, S.sin(S.sqrt(3)) * x, S.log(3) * x, x**2 * y**2 / k**2, (x * y) ** 2, S.sqrt(x * y),
    S.Derivative(x**3, x), S.Sum(x**n, (n, 0, 3)), S.Integral(y, (y, 0, x)), S.exp(x * y / k) * S.sin(x) ** 2, S.exp(-x) ** 2, 1 / S.exp(x), (x**2) ** y,
    S.cbrt(x), S.sqrt(x) ** 3 / y, -S.sqrt(x), S.Rational(1, 2) / x, -2 * S.pi, S.pi**2 * x, S.ITE(x > y, x > 1, x < 2).subs(x, x), S.sinc(x),
    S.erf(x), S.erfc(x), S.besselj(0, x), S.besselj(1, x), S.Mul(2, x + y, evaluate=False), S.Pow(x, 2, evaluate=False) ** 2, 1 / (x / y),
    S.Mul(-1, S.Pow(x, 2), evaluate=False) ** 3, S.Piecewise((1, S.Not(S.And(x > 0, y > 2))), (0, True)), S.acot(x), S.asec(y), n * x, x / n, S.sqrt(n),
]  # fmt: skip
NUMERIC = [e for e in EXPRESSIONS if not isinstance(e, S.logic.boolalg.Boolean)]
FUNCTIONS = """
trait Special { fn erf(self) -> f64; fn erfc(self) -> f64; fn sinc(self) -> f64; fn j0(self) -> f64; fn j1(self) -> f64; }
impl Special for f64 {
    fn erf(self) -> f64 { (0..60).map(|i| { let i = i as f64; (-1.0_f64).powf(i) * self.powf(2.0 * i + 1.0) / ((1..=i as u32).map(f64::from).product::<f64>() * (2.0 * i + 1.0)) }).sum::<f64>() * 2.0 / std::f64::consts::PI.sqrt() }
    fn erfc(self) -> f64 { 1.0 - Special::erf(self) }
    fn sinc(self) -> f64 { self.sin() / self }
    fn j0(self) -> f64 { j(0, self) }
    fn j1(self) -> f64 { j(1, self) }
}
fn j(n: u32, x: f64) -> f64 { let f = |m: u32| (1..=m).map(f64::from).product::<f64>(); (0..30u32).map(|m| (-1.0_f64).powi(m as i32) / (f(m) * f(m + n)) * (x / 2.0).powi((2 * m + n) as i32)).sum() }
"""


@pytest.mark.skipif(shutil.which("rustc") is None, reason="needs rustc")
def test_values_are_those_of_sympy(tmp_path):
    printer = Printer({x: "x", y: "y", k: "k", n: "n"}, frozenset([n]))
    texts = [printer.text(e)[0] for e in NUMERIC]
    lines = "\n".join(f"    let v: f64 = {text}; println!(\"{{v:?}}\");" for text in texts)
    lines = lines.replace(".erf()", ".serf()").replace(".erfc()", ".serfc()")
    functions = FUNCTIONS.replace("fn erf(", "fn serf(").replace("fn erfc(", "fn serfc(").replace("Special::erf(", "Special::serf(")
    program = f"#![allow(unused_parens)]\n{functions}\nfn main() {{\n    let (x, y, k, n) = (0.7_f64, 1.3_f64, 2.5_f64, 3_i64);\n{lines}\n}}\n"
    (tmp_path / "main.rs").write_text(program)
    subprocess.run(["rustc", "-Cdebuginfo=0", "main.rs"], cwd=tmp_path, check=True, capture_output=True, text=True)
    got = [float(line) for line in subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout.split()]
    assert len(got) == len(NUMERIC)
    for e, text, value in zip(NUMERIC, texts, got):
        expected = float(e.doit().subs(VALUES).evalf(30))
        # Some operations, each with an error of a unit in the last place.
        assert math.isclose(value, expected, rel_tol=3e-15, abs_tol=1e-15), (e, text, value, expected)


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (px**2 / 2 - k / S.sqrt(x**2 + y**2), "|[x, y], [px, py]|\n    -k / (x * x + y * y).sqrt()\n    + 0.5 * px * px"),
        (x, "|[x, y], [px, py]|\n    x"),
        (x * S.cos(t), "|[x, y], [px, py], t|\n    x * t.cos()"),
    ],
)
def test_closures(expression, text):
    assert Translation([x, y], [px, py], t, None, [expression]).argument("drift", expression).text == text


def test_one_degree_of_freedom_and_parameters():
    drift = px**2 / 2 + k * x**2 + n * x
    found = Translation(x, px, None, None, [drift])
    assert found.pattern() == "|x, px|" and found.parameters == {"k": float, "n": float}
    printed = found.argument("drift", drift)
    assert printed.terms == (str(drift), *map(str, drift.as_ordered_terms()))
    assert Translation([x], [px], None, [n, k], [drift]).parameters == {"n": float, "k": float}
    typed = Translation(x, px, None, {"k": float, n: int}, [drift])
    assert typed.parameters == {"k": float, "n": int} and "(n as f64)" in typed.argument("drift", drift).text


def test_functions_of_time_are_coordinates():
    q, p = S.Function("q")(t), S.Symbol("p")
    found = Translation(q, p, t, None, [p**2 / 2 + q**2])
    assert found.argument("drift", p**2 / 2 + q**2).text == "|q, p|\n    0.5 * p * p\n    + q * q"


def test_keys():
    gamma, kt = S.symbols("gamma kT")
    found = Translation([x, y], [px, py], t, None, [gamma * x, kt])
    assert found.argument("force", [x, -y]).text == "|[x, y], [px, py]|\n[\n    x,\n    -y,\n]"
    assert found.argument("friction", gamma).text == "gamma" and found.argument("temperature", kt).text == "kT"
    assert found.argument("friction", gamma * x).text == "|[x, y]|\n    gamma * x"
    assert found.argument("constraint", [x**2 + y**2 - 1])[0].text.startswith("|[x, y]|\n")
    assert found.argument("damping", S.Matrix([[gamma, 0], [0, gamma]])).text == "[\n    [gamma, 0.0],\n    [0.0, gamma],\n]"
    assert [each.text for each in found.argument("noise_force", [[x, 0], [0, kt]])] == [
        "|[x, y], [px, py]|\n[\n    x,\n    0.0,\n]", "|[x, y], [px, py]|\n[\n    0.0,\n    kT,\n]",
    ]  # fmt: skip
    assert found.argument("observe", {"r": S.sqrt(x**2 + y**2)})["r"].text.endswith("(x * x + y * y).sqrt()")
    timed = Translation(x, px, t, None, [kt * t])
    assert timed.argument("temperature", kt * t).text == "|t|\n    kT * t"
    with pytest.raises(wzvi.CompileError, match="temperature"):
        found.argument("temperature", kt * x)


def test_names():
    names = names_of(S.symbols("lambda x' type \\theta_1 m_{1} α"))
    assert list(names.values()) == ["lambda_", "x_prime", "type_", "theta_1", "m_1", "α"]
    with pytest.raises(wzvi.CompileError, match="both"):
        names_of([S.Symbol("a"), S.Symbol("a", positive=True)])


@pytest.mark.parametrize(
    ("term", "said"),
    [
        (S.gamma(x), "`gamma`"),
        (S.I * x, "real"),
        (S.Piecewise((x, x > 0)), "True"),
        (S.oo, "finite"),
        (S.Function("V")(x), "without a definition"),
        (S.floor(x), "`floor`"),
        (S.besselj(2, x), "besselj"),
        (S.Integral(S.exp(S.sin(y)), (y, 0, x)), "worked out"),
    ],
)
def test_what_has_no_counterpart_is_named(term, said):
    drift = px**2 / 2 + S.Mul(k, term, evaluate=False) if term is not S.oo else S.Add(px**2, S.oo, evaluate=False)
    with pytest.raises(wzvi.CompileError, match=said) as caught:
        wzvi.compile(drift, q=x, p=px, embedding="Verlet")
    (message,) = caught.value.messages
    assert message.argument == "drift" and message.term and message.term in str(caught.value)


def test_symbols_that_are_nothing():
    with pytest.raises(wzvi.CompileError, match="parameters"):
        wzvi.compile(px**2 + k * x, q=x, p=px, parameters=[n], embedding="Verlet")
    with pytest.raises(TypeError, match="q="):
        wzvi.compile(px**2 + x, embedding="Verlet")
    with pytest.raises(ValueError, match="as many"):
        wzvi.compile(px**2 + x, q=[x, y], p=[px], embedding="Verlet")
    with pytest.raises(ValueError, match="entries"):
        wzvi.compile(px**2 + x, q=x, p=px, force=[x, x], embedding="Verlet")
    with pytest.raises(ValueError, match="twice"):
        wzvi.compile(px**2 + x, q=[x, x], p=[px, py], embedding="Verlet")
    with pytest.raises(ValueError, match="variable"):
        wzvi.compile(px**2 + x, q=x, p=px, parameters=[x], embedding="Verlet")
    with pytest.raises(Unsupported):
        Printer({}).text(k)
