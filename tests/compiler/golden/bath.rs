// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py) + 0.25 * (x - y).powi(4), damping = [[gamma, 0.1], [0.1, gamma]], temperature = kt, embedding = Baoab)]
// pub struct Heated { pub m: f64, pub gamma: f64, pub kt: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Baoab

Hamiltonians
  H0 = (px²/m + py²)/2 + (x - y)^4/4

Step
  kick of h/2:  p <- p - h/2 ∂V/∂q
  drift of h/2:  q <- q + h/2 M⁻¹ p
  friction and noise of h: p <- E p + R ξ, E = exp(-h Γ M⁻¹), R Rᵀ = kT (M - E M Eᵀ)
  drift of h/2:  q <- q + h/2 M⁻¹ p
  kick of h/2:  p <- p - h/2 ∂V/∂q
  driven by the increments of the noises, then √h times the normals ξ of each part with friction
  a free particle diffuses with D = kT/(m γ) (γh/2) coth(γh/2), too fast by (γh)²/12, and so is a slow passage where friction is large; Gjf has it right

Facts
  H0 is not a first integral

```
*/
pub struct Heated {
    pub m: f64,
    pub gamma: f64,
    pub kt: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, Constant, ConstantsIn, Discretized, Facts, FnMut,
        Knowledge, Labels, LiftParameter, Number, Option, Reals, SVector, Scalar, Scheme,
        Sized, Some, Variables, bool, f64, str, usize, bath::{Friction, Splitting},
        compose::Nystrom,
        elements::{
            ElementInput, Elements, EvaluationPoint, FieldAt, HessianBlock, PairColumns,
            Partials, Role, Sums,
        },
        embedding::Baoab, gauss::{Field, Fixed},
    };
    #[automatically_derived]
    impl Elements for Heated {
        const FACTS: Facts = Facts {
            conserves_energy: Knowledge::Refuted,
            is_damped: true,
            bath: Some(Friction {
                is_heated: true,
                is_matrix: true,
                ..Friction::ALONE
            }),
            ..Facts::autonomous(2)
        };
        type Shape = Fixed<2>;
        type Structure = Nystrom;
        type Vector = SVector<f64, 2>;
        fn variables(&self) -> Variables {
            Variables {
                q: Labels::Each(&["x", "y"]),
                p: Labels::Each(&["px", "py"]),
                t: "t",
                invariants: &[],
                observables: &[],
            }
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("m", self.m), ("gamma", self.gamma), ("kt", self.kt)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let m = at.parameter(0, self.m);
            let kt = at.parameter(2, self.kt);
            match role {
                Role::Drift => {
                    let inverse_m = S::of_constant(m.recip());
                    let x = at.q[0];
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    let difference = x - y;
                    let difference_squared = difference * difference;
                    ((inverse_m * (px * px) + py * py) * 0.5
                        + difference_squared * difference_squared * 0.25)
                        * S::of_constant(at.h)
                }
                Role::Temperature => {
                    let kt = S::of_constant(kt);
                    kt * S::of_constant(at.h)
                }
                _ => S::from_f64(0.0),
            }
        }
        type CommonRange = f64;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn gradient<S: Scalar, T: Number<S>>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
            partials: Partials,
            by_q: &mut (impl Sums<S> + ?Sized),
            by_p: &mut (impl Sums<S> + ?Sized),
        ) {
            let m = at.parameter(0, self.m);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let inverse_m = T::of_constant(m.recip());
                        let factor = T::of_constant(at.h);
                        let px = T::of(at.p[0]);
                        let py = T::of(at.p[1]);
                        by_p.add(0, inverse_m * (px * factor));
                        by_p.add(1, py * factor);
                    }
                    if partials.by_q {
                        let factor = T::of_constant(at.h);
                        let x = T::of(at.q[0]);
                        let y = T::of(at.q[1]);
                        let difference = x - y;
                        let product = factor * (difference * (difference * difference));
                        by_q.add(0, product);
                        by_q.add(1, -product);
                    }
                }
                _ => {}
            }
        }
        fn hessian<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
            partials: Partials,
            into: &mut impl FnMut(HessianBlock, [usize; 2], bool, S),
        ) {
            let gamma = at.parameter(1, self.gamma);
            match role {
                Role::Friction => {
                    if partials.by_q {
                        let gamma = S::of_constant(gamma);
                        let factor = S::of_constant(at.h);
                        let minus = -(factor * gamma);
                        let minus2 = -(factor * 0.1);
                        into(HessianBlock::QP, [0, 0], true, minus);
                        into(HessianBlock::QP, [0, 1], true, minus2);
                        into(HessianBlock::QP, [1, 0], true, minus2);
                        into(HessianBlock::QP, [1, 1], true, minus);
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Field for Heated {
        const IS_NYSTROM: bool = true;
        const IN_LANES: bool = true;
        type Noises = Fixed<0>;
        type Parameters = Reals<1>;
        fn parameters<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
        ) -> ConstantsIn<Self::Parameters, K> {
            [lift(0, self.m)]
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn step_gradient<
            K: Constant,
            S: ComputesWith<K>,
            const BY_Q: bool,
            const BY_P: bool,
        >(
            &self,
            parameters: &ConstantsIn<Self::Parameters, K>,
            ([t, h], [coordinates, momenta], increments): FieldAt<'_, S>,
            [by_q,
            by_p,
            ]: [&mut [S]; 2],
            _: &mut PairColumns,
        ) {
            let [m] = *parameters;
            let (&[x, y], &[px, py], &[]) = (coordinates, momenta, increments) else {
                return wzvi::gauss::unfit(by_q, by_p);
            };
            let difference = x - y;
            let product = h * (difference * (difference * difference));
            if BY_Q {
                by_q.copy_from_slice(&[product, -product]);
            }
            if BY_P {
                by_p.copy_from_slice(&[px * h * m.recip(), py * h]);
            }
        }
    }
    #[automatically_derived]
    impl Discretized<Baoab> for Heated {
        type Scheme = Splitting<Baoab>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Baoab\n\nHamiltonians\n  H0 = (px²/m + py²)/2 + (x - y)^4/4\n\nStep\n  kick of h/2:  p <- p - h/2 ∂V/∂q\n  drift of h/2:  q <- q + h/2 M⁻¹ p\n  friction and noise of h: p <- E p + R ξ, E = exp(-h Γ M⁻¹), R Rᵀ = kT (M - E M Eᵀ)\n  drift of h/2:  q <- q + h/2 M⁻¹ p\n  kick of h/2:  p <- p - h/2 ∂V/∂q\n  driven by the increments of the noises, then √h times the normals ξ of each part with friction\n  a free particle diffuses with D = kT/(m γ) (γh/2) coth(γh/2), too fast by (γh)²/12, and so is a slow passage where friction is large; Gjf has it right\n\nFacts\n  H0 is not a first integral\n";
    }
    wzvi::bindings! {
        at by_p by_q coordinates difference difference_squared factor gamma h increments
        index into inverse_m kt lift m minus minus2 momenta parameters partials product
        px py role t weight x y
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Heated {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<::wzvi::embedding::Baoab>(checks::PhantomData::<Baoab>);
            {
                let m = self.m;
                checks::of_state::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y], [px, py]| {
                    0.5 * (px * px / m + py * py) + 0.25 * (x - y).powi(4)
                });
            }
            {
                let gamma = self.gamma;
                let _ = [[gamma, 0.1], [0.1, gamma]];
            }
            {
                let kt = self.kt;
                let _ = kt;
            }
        }
    }
};
