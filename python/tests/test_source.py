"""Crates that are written, without a compiler."""

import pickle

import pytest

import wzvi
from wzvi._source import Printed, balanced, identifier, rust_type, source


def crate(drift="|q, p| q * p", embedding=("Midpoint",), name="System", parameters=None, schemes=(), items=None, doc="", docs=None, **keys):
    return source(
        drift, name=name, doc=doc, parameters=parameters or {}, embedding=list(embedding), schemes=schemes, items=items, keys=keys, field_docs=docs
    )


def places(found):
    """Argument, line and text of each line of the user."""
    return [(origin.argument, origin.line, line) for line, origin in zip(found.text.split("\n"), found.origins) if origin.argument]


def test_every_line_of_the_user_keeps_its_place():
    found = crate(
        drift="|q, p| 0.5 * p * p\n    + a * q * q",
        noise=["|q, p| q", "|q, p|\n  p"],
        invariant={"action": "|q, p| q * q"},
        observe={"radius": "|q, p| q"},
        friction="gamma",
        embedding=["Verlet", "Midpoint"],
        schemes=["Composed<Verlet, KahanLi8>"],
        parameters={"a": float, "gamma": float},
    )
    assert places(found) == [
        ("drift", 1, "|q, p| 0.5 * p * p"),
        ("drift", 2, "    + a * q * q"),
        ("noise[0]", 1, "|q, p| q"),
        ("noise[1]", 1, "|q, p|"),
        ("noise[1]", 2, "  p"),
        ("invariant['action']", 1, "|q, p| q * q"),
        ("observe['radius']", 1, "|q, p| q"),
        ("friction", 1, "gamma"),
        ("embedding[0]", 1, "Verlet"),
        ("embedding[1]", 1, "Midpoint"),
        ("schemes", 1, "Composed<Verlet, KahanLi8>"),
        ("parameters['a']", 1, "f64"),
        ("parameters['gamma']", 1, "f64"),
    ]
    assert len(found.origins) == len(found.text.split("\n")) - 1


def test_the_text_of_a_crate():
    text = crate("drift = |q, p| q * p", parameters={"a": float}, doc="Two\nlines.", docs={"a": "A rate."}, items="const N: usize = 3;").text
    assert "#![forbid(unsafe_code)]" in text and "wzvi_c::export! { System }" in text
    assert "/// Two\n/// lines.\n#[hamiltonian(\ndrift = |q, p| q * p\n,\n" in text
    assert "    /// A rate.\n    pub a:\nf64\n,\n" in text and text.index("const N") < text.index("#[hamiltonian(")


def test_two_parts_of_a_drift():
    assert [place[:2] for place in places(crate(["|q, p| p", "|q, p| q"]))][:2] == [("drift[0]", 1), ("drift[1]", 1)]


def test_lines_that_other_systems_end_otherwise():
    found = crate("|q, p| q\r\n  * p\u2028")
    assert [place[0] for place in places(found)][:2] == ["drift", "drift"] and "\r" not in found.text


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("|q, p| q * p)] struct Evil; #[cfg(any())] (", 1, 13),
        ("|q, p| q * (p", 1, 12),
        ("|q, p|\n  q * [p)", 2, 9),
        ('|q, p| "q', 1, 8),
        ("|q, p| q /* p", 1, 10),
        ("", None, None),
    ],
)
def test_texts_that_would_end_the_attribute(text, line, column):
    with pytest.raises(wzvi.CompileError) as caught:
        wzvi.compile(text, embedding="Midpoint")
    if line is not None:
        (message,) = caught.value.messages
        assert (message.argument, message.line, message.column) == ("drift", line, column)
        assert "  --> drift, line" in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.messages == caught.value.messages


@pytest.mark.parametrize(
    "text", ["'('", '"("', 'r#"("#', "/* ( /* ) */ */ q", "// (\nq", "'a: q", r"'\''", r'"\""', "Composed<Verlet, KahanLi8>", r"'\u{28}'"]
)
def test_brackets_that_are_none(text):
    assert balanced(text, "drift") == text


@pytest.mark.parametrize("keys", [dict(parameters={"a; fn x": float}), dict(parameters={"a": "f64, b: (fn())"}), dict(parameters={"a": "f64, b: f64"})])
def test_names_and_types_are_names_and_types(keys):
    with pytest.raises((ValueError, TypeError), match="a"):
        wzvi.compile("|q, p| q * p", embedding="Midpoint", **keys)


def test_a_system_that_is_named_as_its_scheme():
    with pytest.raises(ValueError, match="'Clocked' is a scheme"):
        wzvi.compile("|q, p| q * p", embedding="Clocked<Verlet>", name="Clocked")


@pytest.mark.parametrize("name", ["A {} fn b() {", "type", "", "1a"])
def test_names_of_systems(name):
    with pytest.raises(ValueError, match="name"):
        wzvi.compile("|q, p| q * p", embedding="Midpoint", name=name)
    with pytest.raises(ValueError, match="what"):
        identifier(name, "what")


def test_types():
    assert [rust_type("a", of) for of in (float, int, bool, [float], (float, 3), [(int, 2)], "Vec<[usize; 2]>", "[[f64; 3]; 4]")] == [
        "f64", "i64", "bool", "Vec<f64>", "[f64; 3]", "Vec<[i64; 2]>", "Vec<[usize; 2]>", "[[f64; 3]; 4]",
    ]  # fmt: skip
    for wrong in (str, None, [float, float], (float, -1), "f64;", "f64, b: f64", 3):
        with pytest.raises(TypeError, match="float"):
            rust_type("a", wrong)


def test_keys_that_do_not_exist():
    with pytest.raises(TypeError, match="frictoin"):
        crate(frictoin="gamma")
    with pytest.raises(TypeError, match="frictoin"):
        wzvi.compile("|q, p| q * p", embedding="Midpoint", frictoin="gamma")
    with pytest.raises(TypeError, match="dict"):
        crate(observe=["|q, p| q"])
    with pytest.raises(TypeError, match="no names"):
        crate(noise={"a": "|q, p| q"})
    with pytest.raises(ValueError, match="orbit"):
        wzvi.compile("|q, p| q * p", embedding="Midpoint", want=("orbit",))
    with pytest.raises(TypeError, match="SymPy"):
        wzvi.compile("|q, p| q * p", embedding="Midpoint", q="q")


def test_printed_lines_have_terms():
    found = crate(Printed("|q, p|\n    q\n    + p", ("q + p", "q", "p")))
    assert [origin.term for origin in found.origins if origin.argument == "drift"] == ["q + p", "q", "p"]


def test_messages_are_at_lines_of_the_user():
    from wzvi._build import failure

    found = crate("|q, p| 0.5 * p * p +\n\tb * q")
    at = next(number for number, origin in enumerate(found.origins) if origin.argument == "drift" and origin.line == 2)

    def span(line, column, end, **more):
        return dict(file_name="lib.rs", line_start=line, line_end=line, column_start=column, column_end=end, is_primary=True, label=None, expansion=None, **more)

    def error(text, spans):
        return {"reason": "compiler-message", "message": {"level": "error", "message": text, "spans": spans, "children": [], "rendered": text}}

    expanded = {**span(1, 1, 2), "file_name": "elsewhere.rs", "expansion": {"span": span(at + 1, 6, 7)}}
    messages = [
        error("no field or variable named `b`", [span(at + 1, 2, 3)]),
        error("no field or variable named `b`", [span(at + 1, 2, 3)]),
        error("what follows", [span(at + 1, 2, 3)]),
        error("something about the macro", [expanded]),
        error("`System` is not `Exported`", [span(1, 1, 2)]),
        error("aborting due to 3 errors", []),
    ]
    caught = failure(messages, "", found, wzvi._cache.folder())
    assert isinstance(caught, wzvi.CompileError)
    assert [message[:5] for message in caught.messages] == [
        ("no field or variable named `b`", "drift", 2, 2, 1),
        ("something about the macro", "drift", 2, 6, 1),
    ]
    assert "Exported" not in str(caught) and "    \tb * q\n    \t^" in str(caught)
