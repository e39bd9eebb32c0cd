//! The same closures where the size is a literal, a const generic or that of a slice, from one site to many.

use fixtures::wave;
use wzvi::plan::Knowledge;
use wzvi::prelude::*;
use wzvi::scalar::Rounded;
use wzvi::state::Vector;

/// Every spelling of a system.
macro_rules! spellings {
    ($($system:ident),*) => {$(
        mod $system {
            use wzvi::prelude::*;
            fixtures::$system!(Slices, [], &[f64], sites);
            fixtures::$system!(Generic, [<const N: usize>], [f64; N], N);
            fixtures::$system!(Sites1, [], [f64; 1], 1);
            fixtures::$system!(Sites16, [], [f64; 16], 16);
            fixtures::$system!(Sites17, [], [f64; 17], 17);

            pub(super) fn check<E>(facts: Option<super::Facts>, is_alone_special: bool)
            where
                Slices: super::Driven<E>,
                Sites1: Discretized<E>, Sites16: Discretized<E>, Sites17: Discretized<E>,
                Generic<1>: Discretized<E>, Generic<17>: Discretized<E>,
            {
                let name = stringify!($system);
                spellings!(@size name, facts, is_alone_special, E, Sites1 1, Sites16 16, Sites17 17);
                // A generic size is never written out: what is between differs by its number alone.
                spellings!(@size name, facts, is_alone_special, E, Generic<1> 1, Generic<17> 17);
            }

            /// In lanes, beside paths of slices.
            #[allow(dead_code, reason = "where there is noise")]
            pub(super) fn check_ensembles<E>()
            where
                Slices: super::Driven<E>,
                Generic<17>: super::Driven<E>,
                Sites16: super::Driven<E>,
                Sites17: super::Driven<E>,
            {
                let (a, s, name) = (0.7, 0.4, stringify!($system));
                if <Slices as Discretized<E>>::PLAN.solver == Solver::Explicit {
                    let in_lanes = [
                        <Slices as Discretized<E>>::PROPERTIES.in_lanes,
                        <Generic<17> as Discretized<E>>::PROPERTIES.in_lanes,
                        <Sites16 as Discretized<E>>::PROPERTIES.in_lanes,
                        <Sites17 as Discretized<E>>::PROPERTIES.in_lanes,
                    ];
                    assert_eq!(in_lanes, [true; 4], "{name}");
                }
                for sites in [1, 2, 16, 17, 64] {
                    let slices = Slices { a, s, sites };
                    let check = super::Ensemble::<E, _>::new(name, &slices, sites);
                    match sites {
                        16 => check.other(&Sites16 { a, s, sites }, "literal"),
                        17 => {
                            check.other(&Sites17 { a, s, sites }, "literal");
                            check.other(&Generic::<17> { a, s, sites }, "const generic");
                        }
                        _ => {}
                    }
                }
            }
        }
    )*};
    (@size $name:ident, $facts:ident, $special:ident, $scheme:ty, $($spelling:ident $(<$size:literal>)? $sites:literal),*) => {$(
        {
            let (a, s, sites) = (0.7, 0.4, $sites);
            let other = $spelling $(::<$size>)? { a, s, sites };
            let slices = Slices { a, s, sites };
            let facts = $facts.filter(|_| !$special || sites > 1);
            let check = super::Comparison::<$scheme>::new($name, &slices, sites);
            check.plan::<$spelling $(<$size>)?>(facts, stringify!($spelling));
            check.plan::<Slices>(facts, "slice");
            check.other(&other, stringify!($spelling));
        }
    )*};
}

spellings!(kubo, chain, pairs, pushed);

/// A system with a scheme that ensembles run.
trait Driven<E>: Discretized<E> + Sync {}
impl<E, H: Discretized<E> + Sync> Driven<E> for H {}

const H: f64 = 0.05;
const STEPS: usize = 20;
const PATHS: u64 = 37;

/// What is known of a scheme at any size: its solver, the noise, and whether the system keeps its energy.
type Facts = (Solver, NoiseClass, Knowledge);

/// A path of slices, to which the other spellings are compared.
struct Comparison<E> {
    name: String,
    sites: usize,
    path: Vec<f64>,
    /// What rounding may have done to it.
    bound: f64,
    scheme: std::marker::PhantomData<E>,
}

impl<E> Comparison<E> {
    fn new<H: Discretized<E>>(name: &str, slices: &H, sites: usize) -> Self {
        let name = format!("{sites} sites of {name}, {}", std::any::type_name::<E>());
        let (path, bound) = (path::<E, H>(slices, sites), bound::<E, H>(slices, sites));
        Self { name, sites, path, bound, scheme: std::marker::PhantomData }
    }

    /// What is known of the scheme; `expected` where it is the same at every size.
    fn plan<H: Discretized<E>>(&self, expected: Option<Facts>, spelling: &str) {
        let (plan, name) = (H::PLAN, &self.name);
        let Some((solver, noise, conserves_energy)) = expected else { return };
        assert_eq!(
            (plan.solver, plan.noise, plan.conserves_energy),
            (solver, noise, conserves_energy),
            "{name}, {spelling}"
        );
        assert_eq!((plan.consistent, plan.commuting), (true, Knowledge::Proven), "{name}, {spelling}");
        // As many as there are sites, if the compiler knows.
        let known = match plan.unknowns {
            _ if solver == Solver::Explicit => 0,
            usize::MAX => usize::MAX,
            _ => self.sites,
        };
        assert_eq!(plan.unknowns, known, "{name}, {spelling}");
    }

    fn other<H: Discretized<E>>(&self, other: &H, spelling: &str) {
        let (name, bound) = (&self.name, self.bound);
        for (a, b) in self.path.iter().zip(path::<E, H>(other, self.sites)) {
            let apart = (a - b).abs();
            assert!(apart <= 2.0 * bound, "{name}, {spelling}: {a} {b} are {apart:.1e} apart, {bound:.1e}");
        }
    }
}

/// The same of an ensemble.
struct Ensemble<E, H> {
    comparison: Comparison<E>,
    means: Vec<f64>,
    system: std::marker::PhantomData<H>,
}

impl<E, H: Driven<E>> Ensemble<E, H> {
    fn new(name: &str, slices: &H, sites: usize) -> Self {
        let (comparison, means) = (Comparison::new(name, slices, sites), means::<E, H>(slices, sites));
        Self { comparison, means, system: std::marker::PhantomData }
    }

    fn other<O: Driven<E>>(&self, other: &O, spelling: &str) {
        let Comparison { name, sites, bound, .. } = &self.comparison;
        for (a, b) in self.means.iter().zip(means::<E, O>(other, *sites)) {
            assert!((a - b).abs() <= 2.0 * bound, "{name}, {spelling}: means {a} {b}, {bound:.1e}");
        }
    }
}

fn start<V: Vector>(n: usize) -> State<V> {
    fixtures::extremes::state(&wave(n, 1.0, 0.2), &wave(n, 1.0, 1.1))
}

fn increments(processes: usize, step: usize) -> Vec<f64> {
    wave(processes, H.sqrt(), step as f64)
}

/// The end of a path with given increments.
fn path<E, H: Discretized<E>>(system: &H, sites: usize) -> Vec<f64> {
    let mut stepper = system.stepper::<E>(H).unwrap().plain();
    let mut state = start::<H::Vector>(sites);
    for step in 0..STEPS {
        stepper.step(&mut state, &increments(system.noises(), step)).unwrap();
    }
    state.q.components().iter().chain(state.p.components()).copied().collect()
}

/// What rounding may have done to it: in each step what it does to one from there ([`Rounded`]), and what was done
/// before, which grows by less than half in a step.
fn bound<E, H: Discretized<E>>(system: &H, sites: usize) -> f64 {
    let prepared = system.prepare(H).unwrap();
    let state = start::<H::Vector>(sites);
    let exact = |numbers: &[f64]| numbers.iter().copied().map(Rounded::exact).collect::<Vec<_>>();
    let [mut q, mut p] = [exact(state.q.components()), exact(state.p.components())];
    let mut bound = 0.0_f64;
    for step in 0..STEPS {
        let dw = exact(&increments(system.noises(), step));
        for number in q.iter_mut().chain(&mut p) {
            number.error = 0.0;
        }
        let t = step as f64 * H;
        system.advance(&prepared, t, H, &mut q, &mut p, &dw, &mut Default::default()).unwrap();
        bound = 1.5 * bound + q.iter().chain(&p).fold(0.0, |most, x| x.error.max(most));
    }
    bound
}

/// Means over an ensemble at its end: paths are known by their numbers, whatever runs them.
fn means<E, H: Driven<E>>(system: &H, sites: usize) -> Vec<f64> {
    let last = sites - 1;
    let run = system.ensemble::<E>(H).start(start(sites)).paths(PATHS).steps(STEPS as u64).threads(1);
    let run = if system.noises() > 0 { run.seed(5) } else { run };
    let run = run
        .observe("q", move |state| state.q.components()[last])
        .observe("p", |state| state.p.components()[0])
        .run()
        .unwrap();
    vec![run.mean("q").unwrap(), run.mean("p").unwrap()]
}

#[test]
fn sites_that_are_not_coupled() {
    kubo::check::<Midpoint>(None, false);
    kubo::check_ensembles::<Midpoint>();
}

#[test]
fn a_chain() {
    // In straight lines each site is solved by itself, in loops all of them are at once.
    chain::check::<Midpoint>(Some((Solver::Newton, NoiseClass::None, Knowledge::Proven)), false);
}

#[test]
fn all_pairs() {
    // A site alone is an oscillator.
    pairs::check::<DeltaPlus>(Some((Solver::Explicit, NoiseClass::None, Knowledge::Proven)), true);
    pairs::check::<Midpoint>(Some((Solver::Newton, NoiseClass::None, Knowledge::Proven)), true);
}

#[test]
fn additive_noise() {
    pushed::check::<DeltaPlus>(Some((Solver::Explicit, NoiseClass::Additive, Knowledge::Refuted)), false);
    pushed::check::<Midpoint>(Some((Solver::Newton, NoiseClass::Additive, Knowledge::Refuted)), false);
    pushed::check_ensembles::<DeltaPlus>();
}
