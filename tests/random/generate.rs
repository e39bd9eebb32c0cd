//! Writes random systems: `rustc --edition 2024 tests/random/generate.rs -o generate && ./generate > tests/random/systems.rs`.
//!
//! Every expression is defined for all real arguments and twice continuously differentiable, so that each step equation
//! has the solution that Newton's method finds from zero for small steps. Every elementary function of the compiler
//! occurs: arguments are folded into the domain first, kinks are raised to the third power.
//!
//! The systems are in macros that take more arguments of the attribute, `random_systems!(crate = wzvi,)`: a few degrees of
//! freedom with names, and arrays with sums over their sites.

#![allow(dead_code, reason = "a program, and a module of the test that compares its output with the file")]

use std::fmt::Write;

const SEED: u64 = 20_240_917;
const SYSTEMS: usize = 42;
const ARRAYS: usize = 12;
/// Sites of an array.
const SITES: usize = 5;

fn main() {
    print!("{}", systems());
}

/// The whole file.
pub(crate) fn systems() -> String {
    let mut text = String::from("// Written by generate.rs: do not edit.\n");
    let mut random = Random(SEED);
    let systems = (0..SYSTEMS).map(|number| System::new(&mut random, number)).collect::<Vec<_>>();
    write_list(&mut text, "system", &systems);
    let arrays = (0..ARRAYS).map(|number| System::array(&mut random, number)).collect::<Vec<_>>();
    write_list(&mut text, "array", &arrays);
    text
}

/// Two macros: the systems, and what calls a check with each of them.
fn write_list(text: &mut String, kind: &str, systems: &[System]) {
    let mut list = String::new();
    let _ = write!(text, "\nmacro_rules! random_{kind}s {{\n    ($($arguments:tt)*) => {{");
    for system in systems {
        system.write(text);
        let System { name, degrees, schemes, parameters: [a, b], .. } = &system;
        let (schemes, test) = (schemes.join(", "), name.to_lowercase());
        let _ = writeln!(
            list,
            "        $check!({test}, {name} {{ a: {a:?}, b: {b:?} }}, {}, [{schemes}]);",
            2 * degrees
        );
    }
    let _ = write!(text, "    }};\n}}\npub(crate) use random_{kind}s;\n");
    text.push_str(
        "\n/// `$check!(test, system, twice the degrees of freedom, [schemes])` for every system.\n",
    );
    let _ =
        write!(text, "macro_rules! every_random_{kind} {{\n    ($check:ident) => {{\n{list}    }};\n}}\n");
    let _ = writeln!(text, "pub(crate) use every_random_{kind};");
}

struct System {
    name: String,
    degrees: usize,
    /// The patterns of the closures.
    head: String,
    parameters: [f64; 2],
    drift: String,
    noise: Noise,
    schemes: Vec<&'static str>,
}

enum Noise {
    Each(Vec<String>),
    /// One for each site of an array.
    Family(String),
}

/// All but the mid-point, which every system gets.
const SCHEMES: [&str; 10] = [
    "Uncorrected<DeltaPlus>",
    "Corrected<Lambda<1, 4>>",
    "Uncorrected<Mixed<Midpoint, DeltaMinus>>",
    "Uncorrected<DeltaMinus>",
    "Corrected<DeltaPlus>",
    "Mixed<DeltaPlus, Midpoint>",
    "Uncorrected<Lambda<2, 3>>",
    "Corrected<DeltaMinus>",
    "Corrected<Mixed<Midpoint, DeltaPlus>>",
    "Uncorrected<Lambda<1, 4>>",
];

impl System {
    fn new(random: &mut Random, number: usize) -> Self {
        let degrees = 1 + number % 3;
        let is_timed = random.below(4) == 0;
        let noises = random.below(4);
        let mut writer = Writer { random, locals: 0 };
        let (q, p) = (coordinates(degrees), momenta(degrees));
        let mut all: Vec<&str> = q.iter().chain(p).copied().collect();
        let (mut q, mut p) = (q.to_vec(), p.to_vec());
        if is_timed {
            [&mut all, &mut q, &mut p].into_iter().for_each(|variables| variables.push("t"));
        }
        let squares: Vec<String> =
            p[..degrees].iter().chain(&q[..degrees]).map(|x| format!("0.5 * {x} * {x}")).collect();
        let mut drift = squares.join(" + ");
        // A third is separable: other solvers.
        let scopes = if number % 4 == 3 { [&q, &p] } else { [&all, &all] };
        for variables in scopes {
            let term = writer.expression(variables, 3);
            let _ = write!(drift, " + 0.3 * {term}");
        }
        let noise = (0..noises)
            .map(|k| {
                let variables = if number % 5 == 4 && k == 0 { &q } else { &all };
                format!("0.3 * {}", writer.expression(variables, 2))
            })
            .collect();
        let mut schemes = vec!["Midpoint"];
        schemes.push(SCHEMES[number % SCHEMES.len()]);
        let list = |names: &[&str]| match names {
            [name] => (*name).to_owned(),
            names => format!("[{}]", names.join(", ")),
        };
        let time = if is_timed { ", t" } else { "" };
        let head = format!("|{}, {}{time}|", list(coordinates(degrees)), list(momenta(degrees)));
        let name = format!("Random{number:02}");
        Self {
            name,
            degrees,
            head,
            parameters: parameters(random),
            drift,
            noise: Noise::Each(noise),
            schemes,
        }
    }

    /// Sums over sites: every third without coupling, every other with a noise of each site, most others with one noise
    /// of all.
    fn array(random: &mut Random, number: usize) -> Self {
        let mut writer = Writer { random, locals: 0 };
        let is_timed = number % 5 == 4;
        let own: &[&str] = if is_timed { &["q[i]", "p[i]", "t"] } else { &["q[i]", "p[i]"] };
        let neighbours = ["q[i]", "q[i + 1]", "p[i]"];
        let sum = |end: usize, body: &str| format!("(0..{end}).map(|i| {body}).sum::<f64>()");
        // A third is separable: other solvers.
        let site = match number % 3 {
            1 => format!("{} + 0.3 * {}", writer.expression(&own[..1], 2), writer.expression(&own[1..2], 2)),
            _ => writer.expression(own, 3),
        };
        let mut drift = sum(SITES, &format!("0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * {site}"));
        if !number.is_multiple_of(3) {
            let pairs = if number % 3 == 1 { &neighbours[..2] } else { &neighbours[..] };
            let _ = write!(drift, " + {}", sum(SITES - 1, &format!("0.3 * {}", writer.expression(pairs, 2))));
        }
        let noise = match number % 4 {
            0 | 2 => Noise::Family(format!("0.3 * {}", writer.expression(&["q[k]", "p[k]"], 2))),
            1 => Noise::Each(vec![sum(SITES, &format!("0.3 * {}", writer.expression(own, 2)))]),
            _ => Noise::Each(Vec::new()),
        };
        let schemes = vec!["Midpoint", SCHEMES[number % SCHEMES.len()]];
        let time = if is_timed { ", t" } else { "" };
        let head = format!("|q: [f64; {SITES}], p: [f64; {SITES}]{time}|");
        let name = format!("Array{number:02}");
        Self { name, degrees: SITES, head, parameters: parameters(random), drift, noise, schemes }
    }

    fn write(&self, text: &mut String) {
        let Self { head, name, .. } = self;
        let _ = write!(text, "\n#[hamiltonian(\n    drift = {head} {},\n", self.drift);
        match &self.noise {
            Noise::Each(list) if list.is_empty() => {}
            Noise::Each(list) => {
                text.push_str("    noise = [\n");
                for noise in list {
                    let _ = writeln!(text, "        {head} {noise},");
                }
                text.push_str("    ],\n");
            }
            Noise::Family(noise) => {
                let _ = writeln!(text, "    noise = [|q, p, k| {noise}; {}],", self.degrees);
            }
        }
        let _ = writeln!(text, "    embedding = [{}],\n    $($arguments)*\n)]", self.schemes.join(", "));
        let _ =
            writeln!(text, "pub(crate) struct {name} {{\n    pub(crate) a: f64,\n    pub(crate) b: f64,\n}}");
    }
}

fn parameters(random: &mut Random) -> [f64; 2] {
    [0.5 + random.unit(), 0.5 + random.unit()].map(|x| (x * 64.0).round() / 64.0)
}

fn coordinates(degrees: usize) -> &'static [&'static str] {
    &["x", "y", "z"][..degrees]
}

fn momenta(degrees: usize) -> &'static [&'static str] {
    &["u", "v", "w"][..degrees]
}

struct Writer<'r> {
    random: &'r mut Random,
    locals: usize,
}

impl Writer<'_> {
    /// An expression of nesting `depth`, in parentheses unless it is a leaf or a call.
    fn expression(&mut self, variables: &[&str], depth: usize) -> String {
        if depth == 0 {
            return self.leaf(variables);
        }
        match self.random.below(10) {
            0..=3 => {
                let operator = ["+", "-", "*", "*"][self.random.below(4)];
                let (left, right) =
                    (self.expression(variables, depth - 1), self.expression(variables, depth - 1));
                format!("({left} {operator} {right})")
            }
            4 => {
                let (above, below) =
                    (self.expression(variables, depth - 1), self.expression(variables, depth - 1));
                format!("({above} / (1.5 + {below} * {below}))")
            }
            5 => {
                let (other, x) =
                    (self.expression(variables, depth - 1), self.expression(variables, depth - 1));
                self.locals += 1;
                let s = format!("s{}", self.locals);
                match self.random.below(4) {
                    0 => format!(
                        "({{ let {s} = {x}; if {s} > 0.25 {{ {other} * ({s} - 0.25).powi(3) }} else {{ 0.0 }} }})"
                    ),
                    1 => format!("(if {x} < b {{ {other} }} else {{ {other} + ({x} - b).powi(3) }})"),
                    2 => format!("({other} * ({x} - 0.25).max(0.0).powi(3))"),
                    _ => format!("({other} * (0.125 - a * {x}).min(0.0).powi(3))"),
                }
            }
            _ => {
                let x = self.expression(variables, depth - 1);
                self.function(&x, variables)
            }
        }
    }

    fn leaf(&mut self, variables: &[&str]) -> String {
        let variable = variables[self.random.below(variables.len())];
        match self.random.below(6) {
            0 => format!("(a * {variable})"),
            1 => format!("(b + {variable})"),
            2 => format!("({variable} - {}_f64)", ["0.75", "0.5", "1.25"][self.random.below(3)]),
            _ => variable.to_owned(),
        }
    }

    /// One of the elementary functions at `x`, folded into its domain.
    fn function(&mut self, x: &str, variables: &[&str]) -> String {
        let other = self.leaf(variables);
        match self.random.below(34) {
            0 => format!("{x}.sin()"),
            1 => format!("{x}.cos()"),
            2 => format!("{x}.tanh()"),
            3 => format!("{x}.atan()"),
            4 => format!("{x}.asinh()"),
            5 => format!("(0.5 * {x}.sin()).tan()"),
            6 => format!("{x}.tanh().exp()"),
            7 => format!("{x}.sin().exp2()"),
            8 => format!("(0.5 * {x}.cos()).exp_m1()"),
            9 => format!("(1.5 + {x}.sin()).ln()"),
            10 => format!("(0.5 * {x} * {x}).ln_1p()"),
            11 => format!("(2.0 + {x}.cos()).log2()"),
            12 => format!("(1.0 + {x} * {x}).log10()"),
            13 => format!("(1.0 + {x} * {x}).sqrt()"),
            14 => format!("(2.0 + {x}.sin()).cbrt()"),
            15 => format!("(0.5 * {x}.sin()).asin()"),
            16 => format!("(0.5 * {x}.tanh()).acos()"),
            17 => format!("{x}.sin().sinh()"),
            18 => format!("{x}.tanh().cosh()"),
            19 => format!("(2.5 + {x}.cos()).acosh()"),
            20 => format!("(0.5 * {x}.sin()).atanh()"),
            21 => format!("{x}.abs().powi(3).atan()"),
            22 => format!("({x}.signum() * {x}.powi(3)).tanh()"),
            23 => format!("(2.0 + {x}.sin()).powf({other}.tanh())"),
            24 => format!("(1.0 + {x} * {x}).powf(-0.75)"),
            25 => format!("{x}.hypot(1.5)"),
            26 => format!("{x}.sin().hypot(1.0 + {other} * {other})"),
            27 => format!("{x}.atan2(2.0 + {other}.cos())"),
            28 => format!("(2.0 + {other}.sin()).atan2({x})"),
            29 => format!("(2.0 + {x}.sin()).recip()"),
            30 => format!("{x}.sin().powi(3)"),
            31 => format!("(1.0 + {x} * {x}).powi(-2)"),
            32 => format!("{x}.sin().mul_add({other}, b)"),
            _ => format!("({{ let (s, c) = {x}.sin_cos(); s * c + a * s }})"),
        }
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}
