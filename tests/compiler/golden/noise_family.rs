// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(), noise = [|q, p, k| sigma * q[k]; self.sites], embedding = Midpoint)]
// pub struct Bath { pub sigma: f64, pub sites: usize }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [q[i]²/2] + Σ_(i=0..n - 1) [p[i]²/2]
  H_k = Σ_(i=0..sites - 1) [sigma q[i]]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = Σ_i P[i] Δq[i] - h H0(P, q_{1/2}) - Σ_k ΔW[k] H_k(P, q_{1/2})
  Δq = q' - q
  q_{1/2} = q + 1/2 Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[i] is the sum of
    P[i] h   for i = 0..n - 1
  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of
    -q_{1/2}[i] h/2   for i = 0..n - 1
    -sigma ΔW[i]/2   for i = 0..sites - 1
  p' = D2 L_d:  p'[i] = P[i] + the sum of
    -q_{1/2}[i] h/2   for i = 0..n - 1
    -sigma ΔW[i]/2   for i = 0..sites - 1

Step
  solve for v (then Δq): linear; a band is factored once, a wide matrix is iterated

Facts
  converges to the Stratonovich system; D = 0
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving
  {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]
  the noises commute up to a constant
  H0 is not a first integral

```
*/
pub struct Bath {
    pub sigma: f64,
    pub sites: usize,
}
#[allow(
    warnings,
    clippy::all,
    clippy::pedantic,
    clippy::nursery,
    clippy::restriction,
    clippy::cargo
)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, DVector, Facts, Gradient, Hamiltonian, Knowledge, Listed,
        NoiseClass, Number, Option, Ord, Range, Result, Scalar, Sized, State,
        StepFailure, bool, f64, i128, isize, str, u32, usize,
        compose::{Composes, Equations, General, Many, ROOM, Structure},
        elements::{
            Curvature, Elements, Given, InLoops, Loops, MomentumUpdate, Point,
            Quadrature, Run, Slopes, Stage, Sums, Unknowns,
        },
        elements::places::{Atom, Entries, Index, Loop, Name, Nest, Places, Slot},
        embedding::{Composed, Midpoint},
    };
    #[automatically_derived]
    impl Hamiltonian for Bath {
        type Vector = DVector<f64>;
        fn degrees(&self) -> usize {
            0
        }
        fn check(&self, degrees: usize) -> Result<(), StepFailure> {
            wzvi::elements::check(self, degrees)
        }
        fn noises(&self) -> usize {
            (self.sites as isize) as usize
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("sigma", self.sigma)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            wzvi::elements::evaluate(self, term, q, p, t)
        }
        fn differentiate<S: Scalar>(
            &self,
            term: usize,
            q: &[S],
            p: &[S],
            t: f64,
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            wzvi::elements::differentiate(self, term, q, p, t, by_q, by_p);
        }
        fn differentiate_noises(
            &self,
            dw: &[f64],
            state: &State<Self::Vector>,
            into: &mut Gradient<Self::Vector>,
        ) {
            wzvi::elements::differentiate_noises(self, dw, state, into);
        }
    }
    #[automatically_derived]
    impl Elements for Bath {
        const PLACES: Places = Places {
            components: 1,
            tables: &[Name { name: "sites", suffix: "" }],
            nests: &[
                Nest {
                    loops: &[
                        Loop {
                            start: Index {
                                terms: &[],
                                constant: 0,
                                name: Name { name: "0", suffix: "" },
                            },
                            end: Index {
                                terms: &[(Atom::Given(0, &[]), 1)],
                                constant: 0,
                                name: Name { name: "sites", suffix: "" },
                            },
                        },
                    ],
                    slots: &[
                        Slot::State {
                            index: Index {
                                terms: &[(Atom::Loop(0), 1)],
                                constant: 0,
                                name: Name { name: "i", suffix: "" },
                            },
                            is_natural: true,
                        },
                    ],
                },
            ],
        };
        fn entries(
            &self,
            table: usize,
            outer: &[usize],
            range: Range<usize>,
        ) -> Entries {
            match (table, outer) {
                (0usize, []) => Entries::of_integer((self.sites) as i128),
                _ => Entries::of_length(0),
            }
        }
        const FACTS: Facts = Facts {
            degrees: usize::MAX,
            noise: NoiseClass::Additive,
            conserves_energy: Knowledge::Refuted,
            commuting: Knowledge::Proven,
            is_damped: false,
            has_pieces: false,
        };
        const INTEGRALS: usize = 3;
        fn value<S: Scalar>(&self, part: usize, weight: f64, at: &Point<'_, S>) -> S {
            let sigma: f64 = self.sigma;
            let size = at.degrees() as isize;
            let mut value = S::from_f64(0.0);
            match part {
                0 => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        let (low, end): (isize, isize) = (0, size);
                        if low < end {
                            let i0 = low;
                            let len = (end - low) as usize;
                            let first0 = i0 as usize;
                            let s0 = &at.p[first0..first0 + len];
                            let s1 = &at.q[first0..first0 + len];
                            for place in 0..len {
                                let p_i = s0[place];
                                let q_i = s1[place];
                                b0 = b0 + (q_i * q_i + p_i * p_i) * 0.5;
                            }
                        }
                        total = total + b0;
                    }
                    value = value + total * S::from_f64(at.h);
                }
                1 => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        let (low, end): (isize, isize) = (
                            Ord::max(0, at.acting.start as isize),
                            Ord::min((self.sites as isize), at.acting.end as isize),
                        );
                        if low < end {
                            let i1 = low;
                            let len = (end - low) as usize;
                            let first0 = i1 as usize;
                            let s0 = &at.q[first0..first0 + len];
                            for place in 0..len {
                                let i1 = low + place as isize;
                                let q_i = s0[place];
                                let factor = at.increment(i1 as usize);
                                b0 = b0 + q_i * factor * sigma;
                            }
                        }
                        total = total + b0;
                    }
                    value = value + total;
                }
                _ => {}
            }
            value
        }
        const HAS_WINDOWS: bool = true;
        const HAS_ONE_VELOCITY: bool = true;
        type Exact = f64;
        type Usual = f64;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn slopes<
            S: Scalar,
            T: Number<S>,
            V: Given<S> + ?Sized,
            Q: Sums<S> + ?Sized,
            P: Sums<S> + ?Sized,
        >(
            &self,
            part: usize,
            weight: f64,
            at: &Point<'_, S, V>,
            wanted: Slopes,
            by_q: &mut Q,
            by_p: &mut P,
        ) {
            use Run as _;
            let sigma: f64 = self.sigma;
            let size = at.degrees() as isize;
            match part {
                0 => {
                    if wanted.by_q {
                        {
                            let factor = T::from_f64(at.h);
                            let (low, end): (isize, isize) = (0, size);
                            if low < end {
                                let i0 = low;
                                let len = (end - low) as usize;
                                let (skipped, len) = by_q.clip::<1, _>(len, [i0 as usize]);
                                if len > 0 {
                                    let low = low + skipped as isize;
                                    let i0 = low;
                                    let first0 = i0 as usize;
                                    let s0 = &at.q[first0..first0 + len];
                                    let mut b0 = by_q.run(first0, len);
                                    for place in 0..len {
                                        let q_i = T::of(s0[place]);
                                        b0.add(place, q_i * factor);
                                    }
                                }
                            }
                        }
                    }
                    if wanted.by_p {
                        {
                            let factor = T::from_f64(at.h);
                            let (low, end): (isize, isize) = (0, size);
                            if low < end {
                                let i0 = low;
                                let len = (end - low) as usize;
                                let (skipped, len) = by_p.clip::<1, _>(len, [i0 as usize]);
                                if len > 0 {
                                    let low = low + skipped as isize;
                                    let i0 = low;
                                    let first0 = i0 as usize;
                                    let s0 = &at.p[first0..first0 + len];
                                    let mut b0 = by_p.run(first0, len);
                                    for place in 0..len {
                                        let p_i = T::of(s0[place]);
                                        b0.add(place, p_i * factor);
                                    }
                                }
                            }
                        }
                    }
                }
                1 => {
                    if wanted.by_q {
                        {
                            let (low, end): (isize, isize) = (
                                Ord::max(0, at.acting.start as isize),
                                Ord::min((self.sites as isize), at.acting.end as isize),
                            );
                            if low < end {
                                let i1 = low;
                                let len = (end - low) as usize;
                                let (skipped, len) = by_q.clip::<1, _>(len, [i1 as usize]);
                                if len > 0 {
                                    let low = low + skipped as isize;
                                    let i1 = low;
                                    let first0 = i1 as usize;
                                    let mut b0 = by_q.run(first0, len);
                                    for place in 0..len {
                                        let i1 = low + place as isize;
                                        let factor = T::of(at.increment(i1 as usize));
                                        b0.add(place, factor * sigma);
                                    }
                                }
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        fn curvature<S: Scalar, C: Curvature<S>>(
            &self,
            part: usize,
            weight: f64,
            at: &Point<'_, S>,
            wanted: Slopes,
            into: &mut C,
        ) {
            let size = at.degrees() as isize;
            match part {
                0 => {
                    if wanted.by_q {
                        {
                            let factor = S::from_f64(at.h);
                            let (low, end): (isize, isize) = (0, size);
                            if low < end {
                                let i0 = low;
                                let len = (end - low) as usize;
                                for place in 0..len {
                                    let i0 = low + place as isize;
                                    into.add_qq(i0 as usize, i0 as usize, true, factor);
                                }
                            }
                        }
                    }
                    if wanted.by_p {
                        {
                            let factor = S::from_f64(at.h);
                            let (low, end): (isize, isize) = (0, size);
                            if low < end {
                                let i0 = low;
                                let len = (end - low) as usize;
                                for place in 0..len {
                                    let i0 = low + place as isize;
                                    into.add_pp(i0 as usize, i0 as usize, true, factor);
                                }
                            }
                        }
                    }
                }
                1 => if wanted.by_q {}
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl InLoops<Midpoint> for Bath {
        const ORDER: u32 = 2;
        const IS_CONSISTENT: bool = true;
        const QUADRATURE: Quadrature = Quadrature {
            stages: &[Stage::new([0.5, 0.5, 0.5], &[(0, 1.0), (1, 1.0)])],
            update: MomentumUpdate::Multiple(2.0),
            unknowns: Unknowns::Momenta,
            remembers: false,
            is_linear: true,
        };
    }
    #[automatically_derived]
    impl Listed<Midpoint> for Bath {
        type Scheme = Loops<Midpoint>;
        const TEXT: &'static str = "Midpoint\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [q[i]²/2] + Σ_(i=0..n - 1) [p[i]²/2]\n  H_k = Σ_(i=0..sites - 1) [sigma q[i]]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q_{1/2}) - Σ_k ΔW[k] H_k(P, q_{1/2})\n  Δq = q' - q\n  q_{1/2} = q + 1/2 Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i] is the sum of\n    P[i] h   for i = 0..n - 1\n  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of\n    -q_{1/2}[i] h/2   for i = 0..n - 1\n    -sigma ΔW[i]/2   for i = 0..sites - 1\n  p' = D2 L_d:  p'[i] = P[i] + the sum of\n    -q_{1/2}[i] h/2   for i = 0..n - 1\n    -sigma ΔW[i]/2   for i = 0..sites - 1\n\nStep\n  solve for v (then Δq): linear; a band is factored once, a wide matrix is iterated\n\nFacts\n  converges to the Stratonovich system; D = 0\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving\n  {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]\n  the noises commute up to a constant\n  H0 is not a first integral\n";
    }
    #[automatically_derived]
    impl<W: Composes<Midpoint, General>> Listed<Composed<Midpoint, W>> for Bath {
        type Scheme = <General as Structure<
            Midpoint,
        >>::Steps<Many<Midpoint, General, W>>;
        const TEXT: &'static str = Equations::<
            Self,
            Midpoint,
            General,
            W,
            { 1083 + ROOM },
        >::ALL;
    }
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as at, binding as b0, binding as by_p, binding as by_q,
        binding as degrees, binding as dw, binding as end, binding as factor,
        binding as first0, binding as i0, binding as i1, binding as index,
        binding as into, binding as len, binding as low, binding as outer, binding as p,
        binding as p_i, binding as part, binding as place, binding as q, binding as q_i,
        binding as range, binding as s0, binding as s1, binding as sigma,
        binding as size, binding as skipped, binding as state, binding as t,
        binding as table, binding as term, binding as total, binding as value,
        binding as wanted, binding as weight,
    };
};
#[allow(
    warnings,
    clippy::all,
    clippy::pedantic,
    clippy::nursery,
    clippy::restriction,
    clippy::cargo
)]
const _: () = {
    #[automatically_derived]
    impl ::wzvi::__private::checks::Checked for Bath {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(::core::marker::PhantomData::<Midpoint>);
            {
                ::wzvi::__private::checks::of_state::<
                    &[::core::primitive::f64],
                    _,
                >(|q: &[f64], p: &[f64]| {
                    (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>()
                });
            }
            {
                let sigma = self.sigma;
                ::wzvi::__private::checks::family::<
                    &[::core::primitive::f64],
                    _,
                >(|q, p, k| sigma * q[k]);
            }
        }
    }
};
