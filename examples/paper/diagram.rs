//! The paper's diagram `X, X_ε, X_{ε,n}, X_n`, one arrow at a time, beside the facts that the compiler prints for each embedding.

use wzvi::noise::Sampling;
use wzvi::prelude::*;
use wzvi::report::{Axis, Document, Figure, Look, Series, number};

use crate::kubo::{KUBO, Kubo, exact};
use crate::{agrees, rms};

/// The limit of the left point: `H_0 - D`.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p) - 0.5 * sigma * sigma * q * p,
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = Midpoint,
)]
struct OtherLimit {
    a: f64,
    sigma: f64,
}

const LIMIT: OtherLimit = OtherLimit { a: KUBO.a, sigma: KUBO.sigma };
const END: f64 = 1.0;
const SEED: u64 = 29;
const PATHS: u64 = 100;
/// The width at which h goes to 0, and the step at which ε does.
const WIDTH: f64 = 0.0625;
const STEP: f64 = 0.03125;
/// Steps of the reference of the other limit.
const FINE: f64 = 1.0 / 4096.0;

type Vector = <Kubo as Hamiltonian>::Vector;
type Curve = Vec<(f64, f64)>;

fn wiener(path: u64) -> Wiener {
    Wiener::seed(SEED).path(path)
}

fn smooth(path: u64, eps: f64, sampling: Sampling) -> WongZakai {
    WongZakai::of(wiener(path), eps).sampling(sampling)
}

/// Where a path ends.
fn end<H, E>(system: &H, h: f64, noise: impl Noise) -> Result<State<Vector>, wzvi::Error>
where
    H: Discretized<E, Vector = Vector>,
{
    let run = system.simulate::<E>(h).start(State::new([0.0], [1.0])).noise(noise).until(END);
    Ok(*run.record_every(0).run()?.last())
}

/// The root mean square over paths of the distance between two ends.
fn apart(ends: impl Fn(u64) -> Result<[State<Vector>; 2], wzvi::Error>) -> Result<f64, wzvi::Error> {
    let mut distances = vec![];
    for path in 0..PATHS {
        let [a, b] = ends(path)?;
        distances.push((a.q[0] - b.q[0]).hypot(a.p[0] - b.p[0]));
    }
    Ok(rms(distances))
}

fn halvings(powers: std::ops::RangeInclusive<i32>) -> impl Iterator<Item = f64> {
    powers.map(|k| 2f64.powi(-k))
}

/// The arrows of one embedding.
struct Arrows {
    scheme: &'static str,
    /// The fact that the compiler prints about the limit by `X_n`.
    says: &'static str,
    /// h to 0 at fixed ε, against `X_ε`.
    to_smooth: Curve,
    /// ε to 0 at fixed h, against `X_n`.
    to_scheme: Curve,
    /// h to 0 without approximation, against `X`, and against the system with `H_0 - D`.
    to_system: [Curve; 2],
}

fn arrows<E>(scheme: &'static str, other_limit: &[State<Vector>]) -> Result<Arrows, wzvi::Error>
where
    Kubo: Discretized<E>,
{
    let mut to_smooth = vec![];
    for h in halvings(3..=11) {
        let error = apart(|path| {
            let mut noise = smooth(path, WIDTH, Sampling::Exact);
            let angle = noise.value(0, END)? - noise.value(0, 0.0)?;
            Ok([end::<_, E>(&KUBO, h, noise)?, exact(END, angle)])
        })?;
        to_smooth.push((h, error));
    }
    let mut to_scheme = vec![];
    for eps in halvings(3..=14) {
        let error = apart(|path| {
            let noise = smooth(path, eps, Sampling::Exact);
            Ok([end::<_, E>(&KUBO, STEP, noise)?, end::<_, E>(&KUBO, STEP, wiener(path))?])
        })?;
        to_scheme.push((eps, error));
    }
    let mut to_system = [vec![], vec![]];
    for h in halvings(3..=10) {
        let ends =
            (0..PATHS).map(|path| end::<_, E>(&KUBO, h, wiener(path))).collect::<Result<Vec<_>, _>>()?;
        let right = apart(|path| Ok([ends[path as usize], exact(END, wiener(path).value(0, END)?)]))?;
        let other = apart(|path| Ok([ends[path as usize], other_limit[path as usize]]))?;
        to_system[0].push((h, right));
        to_system[1].push((h, other));
    }
    let says = <Kubo as Discretized<E>>::EQUATIONS.lines().map(str::trim);
    let says = says.filter_map(|line| line.strip_prefix("ε → 0, then h → 0: ")).next().unwrap_or("");
    Ok(Arrows { scheme, says, to_smooth, to_scheme, to_system })
}

/// The order between the smallest two steps.
fn order(curve: &Curve) -> f64 {
    match curve.as_slice() {
        [.., before, last] => (before.1 / last.1).log2() / (before.0 / last.0).log2(),
        _ => f64::NAN,
    }
}

/// An arrow in the table: it holds where the distance falls.
fn cell(curve: &Curve) -> String {
    let order = order(curve);
    if order > 0.2 { format!("✓ order {order:.2}") } else { "✗ keeps away".to_owned() }
}

pub(crate) fn append(document: Document) -> Result<Document, wzvi::Error> {
    let other_limit = (0..PATHS).map(|path| end::<_, Midpoint>(&LIMIT, FINE, wiener(path)));
    let other_limit = other_limit.collect::<Result<Vec<_>, _>>()?;
    let all = [
        arrows::<Uncorrected<DeltaPlus>>("Uncorrected<DeltaPlus>", &other_limit)?,
        arrows::<Corrected<DeltaPlus>>("Corrected<DeltaPlus>", &other_limit)?,
        arrows::<Midpoint>("Midpoint", &other_limit)?,
    ];
    let holds = |curve: &Curve| order(curve) > 0.2;
    let agree = all.iter().all(|arrows| {
        let is_preserving = arrows.says == "X_{ε,n} → X_n → X: asymptotically preserving";
        holds(&arrows.to_smooth) && holds(&arrows.to_scheme) && holds(&arrows.to_system[0]) == is_preserving
    });
    let row = |arrows: &Arrows| {
        let [right, other] = &arrows.to_system;
        let other = if holds(right) { "-".to_owned() } else { cell(other) };
        let cells = [&arrows.to_smooth, &arrows.to_scheme, right].map(cell);
        [arrows.scheme.to_owned()].into_iter().chain(cells).chain([other, arrows.says.to_owned()]).collect()
    };
    let headings = [
        "embedding",
        "X_{ε,n} → X_ε (h → 0)",
        "X_{ε,n} → X_n (ε → 0)",
        "X_n → X (h → 0)",
        "X_n → system with H₀ - D",
        "EQUATIONS, ε → 0 first",
    ];
    Ok(document
        .heading("The diagram")
        .text(
            "X is the Stratonovich solution, X_ε that of the Wong-Zakai system, X_{ε,n} and X_n the scheme with the increments of W_ε and of W. The \
             paper leaves open which limits exist for which embedding. Distances at t = 1 on the Kubo oscillator, root mean square over 100 paths.",
        )
        .figure(to_smooth(&all))
        .figure(to_scheme(&all)?)
        .figure(to_system(&all))
        .table("The arrows, measured; the last column is what the compiler printed", headings.map(str::to_owned).to_vec(), all.iter().map(row).collect())
        .text(format!("{} what the compiler printed for the three embeddings.", agrees(agree))))
}

fn to_smooth(all: &[Arrows]) -> Figure {
    let (x, y) = (Axis::logarithmic("h"), Axis::logarithmic("distance from X_ε"));
    let figure = Figure::new("diagram-smooth", "X_{ε,n} → X_ε: h to 0 at ε = 1/16", x, y).shows(
        "With a smooth driver every embedding converges: the left point with order one, the mid-point with order two. Hence h to 0 first, then ε to 0, \
         ends at the Stratonovich solution for all of them.",
    );
    let curve = |figure: Figure, (colour, arrows): (usize, &Arrows)| {
        figure.with(Series::new(arrows.scheme, Look::Joined, colour, arrows.to_smooth.clone()))
    };
    all.iter().enumerate().fold(figure, curve)
}

fn to_scheme(all: &[Arrows]) -> Result<Figure, wzvi::Error> {
    let (x, y) = (Axis::logarithmic("ε"), Axis::logarithmic("distance from X_n"));
    let mut figure = Figure::new("diagram-scheme", "X_{ε,n} → X_n: ε to 0 at h = 1/32", x, y).shows(format!(
        "With exact increments of W_ε the approximated scheme tends to the scheme, with order 1/2: measured {}. With the velocity of W_ε at one point \
         instead, its variance grows as h²/ε, and there is no limit.",
        all.iter().map(|arrows| number(order(&arrows.to_scheme))).collect::<Vec<_>>().join(", ")
    ));
    for (colour, arrows) in all.iter().enumerate() {
        figure = figure.with(Series::new(arrows.scheme, Look::Joined, colour, arrows.to_scheme.clone()));
    }
    let mut sampled = vec![];
    for eps in halvings(5..=14) {
        let error = apart(|path| {
            let noise = smooth(path, eps, Sampling::Left);
            Ok([end::<_, Midpoint>(&KUBO, STEP, noise)?, end::<_, Midpoint>(&KUBO, STEP, wiener(path))?])
        })?;
        sampled.push((eps, error));
    }
    // At ε = h both agree, which a logarithmic axis cannot show.
    sampled.retain(|point| point.1 > 1e-9);
    Ok(figure.with(Series::new("Midpoint, velocity at one point", Look::Joined, 4, sampled)))
}

fn to_system(all: &[Arrows]) -> Figure {
    let (x, y) = (Axis::logarithmic("h"), Axis::logarithmic("distance"));
    let mut figure = Figure::new("diagram-system", "X_n → X: h to 0", x, y).shows(
        "The quadrature decides here. The mid-point and the corrected left point converge to the Stratonovich solution. The left point without its \
         counter-term stays away from it, and converges to the system with drift Hamiltonian H₀ - D, D = σ² q p / 2.",
    );
    for (colour, arrows) in all.iter().enumerate() {
        figure = figure.with(Series::new(
            format!("{}, from X", arrows.scheme),
            Look::Joined,
            colour,
            arrows.to_system[0].clone(),
        ));
    }
    match all.first() {
        Some(arrows) => figure.with(Series::new(
            format!("{}, from H₀ - D", arrows.scheme),
            Look::Dashed,
            0,
            arrows.to_system[1].clone(),
        )),
        None => figure,
    }
}
