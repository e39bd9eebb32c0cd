//! The messages about the bodies of closures. One function per mistake. Tests: `tests/compiler/ui/messages`.

use std::fmt::Display;

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, ExprUnary, Lit, UnOp};

use super::{closest, quoted, source, suggest};

messages! {
    unsupported(found, what: &str, remedy: &str) = "{what} cannot be compiled to a symbolic expression; \
        {remedy}";
    too_many_steps(found, limit: usize) = "this Hamiltonian unrolls to more than {limit} operations; \
        shorten its loops";
    too_deep(found, limit: usize) = "this is nested more than {limit} levels deep; name parts of the \
        expression with `let`";
    long_integer(found, limit: usize) = "this integer combines more than {limit} others: indices and lengths are \
        short expressions of loop variables, sizes and fields";
    vector_as_energy(found, actual: &str) = "a Hamiltonian is one number, the energy; this is {actual}. The \
        equations of motion are derived from it: `|q, p| 0.5 * (p * p + q * q)` has the vector field `[p, \
        -q]`";
    expected(found, expected: &str, actual: &str) = "expected {expected}, found {actual}";
    index_not_known(found) = "indices and bounds must be known at compile time: integer literals, loop \
        variables over literal ranges and arithmetic on them; sizes from the struct or constants are not \
        supported yet";
    index_out_of_range(found, index: i128, len: impl Display) {
        remedy = if index < 0 { wrapped(&found) } else { String::new() };
    } = "index {index} is out of range: there are {len} elements{remedy}";
    integer_arithmetic(found) = "this integer arithmetic overflows, divides by zero or leaves its type";
    division_by_zero(found) = "this divides by zero: the Hamiltonian has no value anywhere";
    truncation(found) = "a real number cannot become an integer here: the result would not be \
        differentiable";
    single_precision(found) = "`f32` is not supported: all arithmetic is in binary64; write `f64`";
    unknown_cast(found) = "only `as f64`, and `as` an integer type on known integers, are supported";
    unsupported_pattern(pattern) = "this pattern is not supported; use names, `_`, tuples and arrays";
    pattern_mismatch(pattern, actual: &str) = "this pattern does not fit {actual}";
    match_on(found, actual: &str) = "`match` selects by an integer or a condition, and this is {actual}; \
        use `if` and `else`";
    match_pattern(pattern) = "`match` takes literals, ranges of them, `|` and `_` as patterns; in the place \
        of a name write `_`, and for a constant `_ if kind == CONSTANT`";
    branches_differ(found) = "both branches must have a value of the same shape: this condition is only \
        known at run time";
    missing_else(found) = "this `if` needs an `else`: its condition is only known at run time, and a value \
        is needed either way";
    assignment_in_branch(found) = "an assignment inside a branch whose condition is not known to the \
        compiler (it depends on the state, a parameter or an index of a loop) is not supported; write `let x = \
        if condition {{ ... }} else {{ ... }};`";
    assignment_target(found) = "only local variables declared with `let mut` can be assigned";
    not_callable(found, actual: &str) = "this is {actual}, which cannot be called";
    list_of_unknown_length(found) = "the length of this list is not known at compile time; use an array \
        field such as `[f64; 3]`, or index it with known indices";
    endless_range(found) = "this range has no end; write `a..b`, or bound it with `take` or `zip`";
    too_many_variables(found, limit: usize) = "more than {limit} variables are in scope";
    no_sum(found) = "over a length that is known at run time, this can only add to a total: `|total, x| \
        total + ...`";
    long_for_loop(found) = "a `for` loop whose length is known at run time can only add to its variables: \
        `total += ...`";
    too_many_loops(found, most: usize) = "sums are nested more than {most} deep; write inner sums in closed form, \
        or nest fewer";
    too_many_cases(found, most: usize) = "the conditions on the indices of this loop split it into more than \
        {most} ranges";
    index_negative(found, index: &str, value: i128) { remedy = wrapped(&found); } = "index {index} is out of range: \
        it becomes {value}{remedy}";
    natural_negative(found, index: &str, value: i128) { remedy = wrapped(&found); } = "`{index}` becomes {value}, and \
        integers of its type begin at 0{remedy}";
    index_outside(found, index: i128, degrees: i128) = "in a branch, this reads degree of freedom {index}, and there \
        are {degrees}, numbered from 0: both branches of a condition are evaluated; where an index wraps around, write \
        `(i + n - 1) % n`";
    nonlinear_sum(found) = "this is a nonlinear function of a sum that reads the variable of a loop around it, or of \
        one in a family of noises: a sum over sites may stand in any function where it reads no such variable, as in `let m: \
        f64 = q.iter().sum();`; write the square of another sum as a double sum, `(0..n).map(|i| (0..n).map(|j| x[i] * \
        x[j]).sum::<f64>()).sum::<f64>()`, or give it a length that is a literal";
    collective_noise(found) = "under `calculus = Ito`, a noise cannot be a nonlinear function of a sum over sites: the \
        conversion does not take its derivatives; write the equations in the sense of Stratonovich, without `calculus`";
    collective_friction(found) = "friction and temperature cannot be nonlinear functions of a sum over sites; write such \
        friction as a force, `force = |q, p| ...`, without a temperature";
    family_count(found) = "the number of noises of a family is an integer, a constant or a field, as in \
        `[|q, p, k| q[k]; N]`";
    too_many_members(found, limit: i128) = "more than {limit} noises that differ in more than a number: use the number \
        of the noise as an index, or as a factor";
    friction_closure(closure) = "`friction` is an expression of fields, a list of them by degree of freedom, \
        or a closure of the coordinates, `|q| ...`; write friction that depends on momenta or the time as a force, as in \
        `force = |q, p, t| -gamma * p`, without a temperature";
    /// A closure in `temperature` whose parameters are not a site and the time.
    temperature_closure(closure) = "`temperature` is kT: one number, a list by degree of freedom, `|t| ...`, or, by site, \
        `[|i| ...; N]` or `[|i, t| ...; N]`; a temperature of the coordinates or momenta is not offered, because no Boltzmann law \
        is known to check it by";
    number_of_sites(found) = "the number of sites with a temperature is an integer, a constant or a field, as in \
        `temperature = [|i| t0 + dt * i as f64; N]`";
    damping_closure(closure) = "`damping` is a constant matrix of expressions of fields, `[[...]]`; where only the state \
        knows its size, `|q| (0..q.len()).map(...)` of rows; write friction that depends on momenta or the time as a \
        force, without a temperature";
    /// A name in `friction`, `damping` or `temperature` that no field has.
    unknown_name_of_key(name, fields: &[String], remedy: &str) {
        list = listed_fields(fields, "the struct has no fields");
    } = "no field named `{name}`; {list}; {remedy}";
    /// `p ^ 2` or `p**2`.
    power(found, base: &syn::Expr, exponent: &syn::Expr, is_of_integers: bool) {
        text = source(exponent);
        is_integer = text.trim_matches(['(', ')', '-']).parse::<u32>().is_ok();
        method = if is_of_integers { "pow" } else if is_integer { "powi" } else { "powf" };
        base = receiver(base);
    } = "Rust has no operator for powers; write `{base}.{method}({text})`";
    /// `sin(q)`
    function_as_method(name, method: &str, arguments: &[&syn::Expr]) {
        call = match arguments {
            [first, rest @ ..] => {
                let rest: Vec<String> = rest.iter().copied().map(source).collect();
                format!("{}.{method}({})", receiver(first), rest.join(", "))
            }
            [] => format!("x.{method}()"),
        };
    } = "functions of `f64` are methods: write `{call}`";
    unknown_name(name, fields: &[String], locals: &[String]) {
        word = name.to_string();
        list = listed_fields(fields, "the struct has no fields");
        meant = closest(&word, fields.iter().chain(locals).map(String::as_str));
        remedy = match meant {
            Some(_) => suggest(meant),
            None => "; a Hamiltonian cannot use outside variables: make it a field".to_owned(),
        };
    } = "no field or variable named `{name}`; {list}{remedy}";
    unknown_field(name, fields: &[String]) {
        list = listed_fields(fields, "it has none");
        meant = suggest(closest(&name.to_string(), fields.iter().map(String::as_str)));
    } = "the struct has no field `{name}`; {list}{meant}";
    field_type(found, name: &str, ty: &str) {
        remedy = match ty {
            "f32" => "make it `f64`: all arithmetic is in binary64",
            _ => "a Hamiltonian can read `f64`, integers, and arrays, `Vec`s and slices of them",
        };
    } = "`{name}` has the type `{ty}`; {remedy}";
    integer_not_real(found) { real = as_real(&found); } = "expected an `f64`, found an integer; write `{real}`";
    /// The receiver of a method of `f64`.
    integer_receiver(found) { real = as_real_receiver(&found); } = "expected an `f64`, found an integer; write `{real}`";
    /// `i32::pow(-2, 3)`
    integer_function(found, ty: &str, method: &str, arguments: &[&syn::Expr]) {
        call = match arguments {
            [first, rest @ ..] => {
                let rest: Vec<String> = rest.iter().copied().map(source).collect();
                format!("{}.{method}({})", integer_receiver_of(first, ty), rest.join(", "))
            }
            [] => format!("n.{method}()"),
        };
    } = "functions of integers are methods here: write `{call}`";
    function_call(found) { text = found.to_string().replace(' ', ""); } = "`{text}` is opaque to the compiler: only \
        `f64` functions, local closures and functions with the attribute `#[hamiltonian_fn]` can be differentiated";
    unknown_method(found, name: &str, receiver: &str, known: &[&str]) {
        list = quoted(known);
        meant = synonym(name).filter(|meant| known.contains(meant));
        meant = suggest(meant.or_else(|| closest(name, known.iter().copied())));
    } = "`{name}` is not supported on {receiver}; the supported ones are {list}{meant}";
    argument_count(found, expected: usize, actual: usize) { plural = if expected == 1 { "" } else { "s" }; } =
        "expected {expected} argument{plural}, found {actual}";
    index_beyond(found, index: &str, length: &str, excess: i128) {
        reached = if excess == 0 { length.to_owned() } else { format!("{length} + {excess}") };
    } = "index {index} is out of range: it reaches {reached}, and there are {length} elements";
    /// A covector, or a part of one, with the wrong number of entries.
    entries(found, expected: &str, length: Option<&str>) {
        has = length.unwrap_or("of a number that is not known");
        // The length of a list of fields is not that of the state.
        advice = match expected.parse::<u64>() {
            Ok(_) => String::new(),
            Err(_) => {
                format!("; entries of a field are read one by one, as in `(0..{expected}).map(|i| list[i])`")
            }
        };
    } = "this has one entry for each degree of freedom, arranged as the coordinates are: {expected} entries are \
        expected here, and these are {has}{advice}";
}

/// The remedy for an index that becomes negative: `%` keeps the sign of its left operand.
fn wrapped(index: &TokenStream) -> String {
    let written = syn::parse2(index.clone()).ok().and_then(|index| round(&index));
    match written {
        Some(written) => format!("; `%` keeps the sign: write `{written}`"),
        None => "; begin the loop later, or write `(i + n - 1) % n` where the index wraps around".to_owned(),
    }
}

/// `(a - b) % n` inside of an index as `(a + n - b) % n`.
fn round(index: &syn::Expr) -> Option<String> {
    match index {
        syn::Expr::Paren(inner) => round(&inner.expr),
        syn::Expr::Binary(binary) => match (&binary.op, difference(&binary.left)) {
            (syn::BinOp::Rem(_), Some((a, b))) => {
                let [a, b, n] = [a, b, &*binary.right].map(source);
                Some(format!("({a} + {n} - {b}) % {n}"))
            }
            _ => round(&binary.left).or_else(|| round(&binary.right)),
        },
        _ => None,
    }
}

/// `a` and `b` of `(a - b)`.
fn difference(expr: &syn::Expr) -> Option<(&syn::Expr, &syn::Expr)> {
    match expr {
        syn::Expr::Paren(inner) => difference(&inner.expr),
        syn::Expr::Binary(binary) if matches!(binary.op, syn::BinOp::Sub(_)) => {
            Some((&binary.left, &binary.right))
        }
        _ => None,
    }
}

/// An expression as the receiver of a method.
fn receiver(expr: &syn::Expr) -> String {
    let text = source(expr);
    let is_operand = !matches!(expr, syn::Expr::Binary(_) | syn::Expr::Unary(_) | syn::Expr::Cast(_));
    let is_number = matches!(expr, syn::Expr::Lit(_));
    match (is_operand, is_number) {
        (true, false) => text,
        (true, true) => format!("{text}_f64"),
        (false, _) => format!("({text})"),
    }
}

/// An integer expression with its operands as real numbers: `1.0 / 2.0` for `1 / 2`.
fn as_real(tokens: &TokenStream) -> String {
    match syn::parse2::<Expr>(tokens.clone()) {
        Ok(expr) => real(&expr),
        Err(_) => format!("({} as f64)", source(tokens)),
    }
}

fn real(expr: &Expr) -> String {
    match expr {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(integer) => format!("{}.0", integer.base10_digits()),
            other => source(other),
        },
        Expr::Group(inner) => real(&inner.expr),
        Expr::Paren(inner) => {
            let inner = real(&inner.expr);
            if inner.starts_with('(') && inner.ends_with(" as f64)") { inner } else { format!("({inner})") }
        }
        Expr::Unary(ExprUnary { op: UnOp::Neg(_), expr, .. }) => format!("-{}", real(expr)),
        Expr::Binary(ExprBinary { op, left, right, .. })
            if matches!(op, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_)) =>
        {
            format!("{} {} {}", real(left), op.to_token_stream(), real(right))
        }
        other => format!("({} as f64)", receiver(other)),
    }
}

/// A literal before a method needs a suffix: its type has to be known.
fn as_real_receiver(tokens: &TokenStream) -> String {
    let text = as_real(tokens);
    match text.parse::<f64>() {
        Ok(value) if value.is_sign_negative() => format!("({text}_f64)"),
        Ok(_) => format!("{text}_f64"),
        Err(_) if text.starts_with('(') && text.ends_with(')') => text,
        Err(_) => format!("({text})"),
    }
}

/// An integer as the receiver of a method of its type.
fn integer_receiver_of(expr: &Expr, ty: &str) -> String {
    match expr {
        Expr::Lit(_) => format!("{}_{ty}", source(expr)),
        Expr::Unary(ExprUnary { op: UnOp::Neg(_), expr, .. }) if matches!(**expr, Expr::Lit(_)) => {
            format!("(-{}_{ty})", source(expr))
        }
        other => receiver(other),
    }
}

/// The name in Rust of a function that other languages call `name`.
pub(crate) fn synonym(name: &str) -> Option<&'static str> {
    Some(match name {
        "pow" | "square" | "squared" | "sqr" | "cube" => "powi",
        "arcsin" => "asin",
        "arccos" => "acos",
        "arctan" => "atan",
        "fabs" => "abs",
        "sign" => "signum",
        "expm1" => "exp_m1",
        "log1p" => "ln_1p",
        "inv" | "inverse" => "recip",
        "size" | "length" => "len",
        _ => return None,
    })
}

fn listed_fields(fields: &[String], none: &str) -> String {
    if fields.is_empty() { none.to_owned() } else { format!("the fields are {}", quoted(fields)) }
}
