// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q, noise = |q, p| sigma * q * p, embedding = Corrected<DeltaPlus>)]
// pub struct Multiplicative { pub sigma: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Corrected<DeltaPlus>

Hamiltonians
  H0 = p²/2 + q²/2
  H1 = sigma q p

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 + q_i²/2) - sigma q_i P ΔW - sigma² q_i P ΔW²/2
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P + sigma q_i ΔW + sigma² q_i ΔW²/2
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h q_i - sigma P ΔW - sigma² P ΔW²/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  solve for δp: linear
  assign Δq

Facts
  converges to the Stratonovich system; D = sigma² q p/2
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving
  {H1, H0} = sigma q² - sigma p²
  H0 is not a first integral

```
*/
pub struct Multiplicative {
    pub sigma: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, ConfigError, Constant, ConstantsIn, Discretized,
        Effort, Err, Facts, Knowledge, LiftParameter, NoiseClass, Number, Ok, Option,
        PhantomData, PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme, Sized,
        Solution, Solver, StateSum, StepFailure, Straight, StraightLine, bool, f64, str,
        usize, compose::General,
        elements::{
            ElementInput, Elements, EvaluationPoint, MomentumUpdate, Partials,
            Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::{Corrected, DeltaPlus},
        gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Multiplicative {
        const FACTS: Facts = Facts {
            noise: NoiseClass::Multiplicative,
            conserves_energy: Knowledge::Refuted,
            has_weak_order_two: false,
            ..Facts::autonomous(1)
        };
        type Shape = Fixed<1>;
        type Structure = General;
        type Vector = SVector<f64, 1>;
        fn noises(&self) -> usize {
            1
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("sigma", self.sigma)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let sigma = at.parameter(0, self.sigma);
            match role {
                Role::Drift => {
                    let q = at.q[0];
                    let p = at.p[0];
                    (p * p + q * q) * 0.5 * S::of_constant(at.h)
                }
                Role::Noise if at.acting.contains(&0) => {
                    let sigma = S::of_constant(sigma);
                    let q = at.q[0];
                    let p = at.p[0];
                    sigma * (q * p) * at.increment(0)
                }
                Role::CounterTerm => {
                    let sigma_squared = S::of_constant(sigma * sigma);
                    let q = at.q[0];
                    let p = at.p[0];
                    sigma_squared * (q * p) * at.increment(0) * at.increment(0) * weight
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
            let sigma = at.parameter(0, self.sigma);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, p * factor);
                    }
                    if partials.by_q {
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, q * factor);
                    }
                }
                Role::Noise if at.acting.contains(&0) => {
                    if (partials.by_q || partials.by_p) {
                        let sigma = T::of_constant(sigma);
                        let factor = T::of(at.increment(0));
                        let q = T::of(at.q[0]);
                        let p = T::of(at.p[0]);
                        by_q.add(0, sigma * (p * factor));
                        by_p.add(0, sigma * (q * factor));
                    }
                }
                Role::CounterTerm => {
                    if (partials.by_q || partials.by_p) {
                        let sigma_squared = T::of_constant(sigma * sigma);
                        let factor = T::of(at.increment(0)) * T::of(at.increment(0))
                            * weight;
                        let q = T::of(at.q[0]);
                        let p = T::of(at.p[0]);
                        by_q.add(0, sigma_squared * (p * factor));
                        by_p.add(0, sigma_squared * (q * factor));
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl StraightLine<Corrected<DeltaPlus>, 1, 1> for Multiplicative {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Linear, 1, 1, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[
                QuadraturePoint::new(
                    [0.0, 1.0, 0.0],
                    &[
                        Role::Drift.times(1.0),
                        Role::Noise.times(1.0),
                        Role::CounterTerm.times(0.5),
                    ],
                ),
            ],
            MomentumUpdate::Multiple(1.0),
        );
        type Prepared = Reals<2>;
        type Memory<S: Scalar> = PhantomData<S>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let sigma = lift(0, self.sigma);
            if sigma.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            Ok([sigma, sigma * 0.5])
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn solve<S: ComputesWith<K>, K: Constant, C: StateSum<S>, const CAREFUL: bool>(
            prepared: &ConstantsIn<Self::Prepared, K>,
            t: K,
            h: K,
            coordinates: [S; 1],
            momenta: [S; 1],
            increments: [S; 1],
            memory: &mut Self::Memory<S>,
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p], [dw]) = (coordinates, momenta, increments);
            let [sigma, half_sigma] = *prepared;
            let product = dw * (dw * half_sigma + 1.0) * sigma;
            let inverse_pivot = wzvi::usable::<S>(product + 1.0)?.recip();
            let product2 = inverse_pivot * (p * product + q * h);
            let delta_p = -product2;
            let node_p = p - product2;
            let delta_q = q * product + node_p * h;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[delta_q], [delta_p]],
                Effort::fast(0),
            );
            next.ensure_finite()
        }
    }
    #[automatically_derived]
    impl Discretized<Corrected<DeltaPlus>> for Multiplicative {
        type Scheme = Straight<Corrected<DeltaPlus>, 1, 1>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Corrected<DeltaPlus>\n\nHamiltonians\n  H0 = p²/2 + q²/2\n  H1 = sigma q p\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 + q_i²/2) - sigma q_i P ΔW - sigma² q_i P ΔW²/2\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P + sigma q_i ΔW + sigma² q_i ΔW²/2\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h q_i - sigma P ΔW - sigma² P ΔW²/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  solve for δp: linear\n  assign Δq\n\nFacts\n  converges to the Stratonovich system; D = sigma² q p/2\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving\n  {H1, H0} = sigma q² - sigma p²\n  H0 is not a first integral\n";
    }
    wzvi::bindings! {
        at by_p by_q carry coordinates delta_p delta_q dw factor h half_sigma increments
        index inverse_pivot lift memory momenta next node_p p partials prepared product
        product2 q role sigma sigma_squared t weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Multiplicative {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Corrected<::wzvi::embedding::DeltaPlus>,
            >(checks::PhantomData::<Corrected<DeltaPlus>>);
            checks::of_state::<checks::f64, _>(|q, p| 0.5 * p * p + 0.5 * q * q);
            {
                let sigma = self.sigma;
                checks::of_state::<checks::f64, _>(|q, p| sigma * q * p);
            }
        }
    }
};
