// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)], embedding = [Midpoint, Uncorrected<DeltaPlus>], invariant = |q, p| q * q + p * p)]
// pub struct Kubo { pub a: f64, pub sigma: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = a (p² + q²)/2
  H1 = sigma (p² + q²)/2

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h a (P² + q_{i+1/2}²)/2 - sigma ΔW (P² + q_{i+1/2}²)/2
  Δq = q_{i+1} - q_i
  q_{i+1/2} = q_i + Δq/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW
  p_i = -D1 L_d:  P = p_i + δp,  δp = (-h a q_{i+1/2} - sigma q_{i+1/2} ΔW)/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: linear (then Δq)

Facts
  converges to the Stratonovich system; D = 0
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving
  {H1, H0} = 0
  H0 is a first integral: kept by the step to rounding
  first integral p² + q²: kept by the step to rounding
  each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one

```

```text
Uncorrected<DeltaPlus>

Hamiltonians
  H0 = a (p² + q²)/2
  H1 = sigma (p² + q²)/2

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h a (P² + q_i²)/2 - sigma ΔW (P² + q_i²)/2
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h a q_i - sigma q_i ΔW
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

Facts
  converges to another system, with drift Hamiltonian H0 - D; D = sigma² q p/2
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → the system with H0 - D, not X: not asymptotically preserving
  {H1, H0} = 0
  H0 is a first integral: of the system, and not kept by what the step converges to in general
  first integral p² + q²: of the system, and not kept by what the step converges to in general
  each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one

```
*/
pub struct Kubo {
    pub a: f64,
    pub sigma: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, ConfigError, Constant, ConstantsIn, Discretized,
        Effort, Err, Facts, LiftParameter, NoiseClass, Number, Ok, Option, PhantomData,
        PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme, Sized, Solution, Solver,
        StateSum, StepFailure, Straight, StraightLine, bool, f64, str, usize,
        compose::General,
        elements::{
            ElementInput, Elements, EvaluationPoint, MomentumUpdate, Partials,
            Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::{DeltaPlus, Midpoint, Uncorrected},
        gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Kubo {
        const FACTS: Facts = Facts {
            noise: NoiseClass::Multiplicative,
            ..Facts::autonomous(1)
        };
        type Shape = Fixed<1>;
        type Structure = General;
        type Vector = SVector<f64, 1>;
        fn noises(&self) -> usize {
            1
        }
        fn invariants(&self) -> usize {
            1
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("a", self.a), ("sigma", self.sigma)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let a = at.parameter(0, self.a);
            let sigma = at.parameter(1, self.sigma);
            match role {
                Role::Drift => {
                    let half_a = S::of_constant(a * 0.5);
                    let q = at.q[0];
                    let p = at.p[0];
                    (p * p + q * q) * half_a * S::of_constant(at.h)
                }
                Role::Noise if at.acting.contains(&0) => {
                    let half_sigma = S::of_constant(sigma * 0.5);
                    let q = at.q[0];
                    let p = at.p[0];
                    (p * p + q * q) * half_sigma * at.increment(0)
                }
                Role::Integral(0) => {
                    let q = at.q[0];
                    let p = at.p[0];
                    p * p + q * q
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
            let a = at.parameter(0, self.a);
            let sigma = at.parameter(1, self.sigma);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let a = T::of_constant(a);
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, a * (p * factor));
                    }
                    if partials.by_q {
                        let a = T::of_constant(a);
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, a * (q * factor));
                    }
                }
                Role::Noise if at.acting.contains(&0) => {
                    if partials.by_p {
                        let sigma = T::of_constant(sigma);
                        let factor = T::of(at.increment(0));
                        let p = T::of(at.p[0]);
                        by_p.add(0, sigma * (p * factor));
                    }
                    if partials.by_q {
                        let sigma = T::of_constant(sigma);
                        let factor = T::of(at.increment(0));
                        let q = T::of(at.q[0]);
                        by_q.add(0, sigma * (q * factor));
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 1, 1> for Kubo {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Linear, 1, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[
                QuadraturePoint::new(
                    [0.5, 0.5, 0.5],
                    &[Role::Drift.times(1.0), Role::Noise.times(1.0)],
                ),
            ],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = Reals<2>;
        type Memory<S: Scalar> = PhantomData<S>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let a = lift(0, self.a);
            let sigma = lift(1, self.sigma);
            if a.magnitude().is_nan() || sigma.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            Ok([sigma, h * a])
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
            let [sigma, a_h] = *prepared;
            let sum = dw * sigma + a_h;
            let inverse_pivot = wzvi::reciprocal_above_one::<S>(sum * sum * 0.25 + 1.0);
            let sum2 = q + p * (sum * 0.5);
            let product = sum * inverse_pivot;
            let node_p = p - sum2 * (product * 0.5);
            let delta_q = sum * node_p;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[delta_q], [-(sum2 * product)]],
                Effort::fast(0),
            );
            next.ensure_finite()
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Kubo {
        type Scheme = Straight<Midpoint, 1, 1>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = a (p² + q²)/2\n  H1 = sigma (p² + q²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h a (P² + q_{i+1/2}²)/2 - sigma ΔW (P² + q_{i+1/2}²)/2\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = q_i + Δq/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW\n  p_i = -D1 L_d:  P = p_i + δp,  δp = (-h a q_{i+1/2} - sigma q_{i+1/2} ΔW)/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: linear (then Δq)\n\nFacts\n  converges to the Stratonovich system; D = 0\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving\n  {H1, H0} = 0\n  H0 is a first integral: kept by the step to rounding\n  first integral p² + q²: kept by the step to rounding\n  each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one\n";
    }
    #[automatically_derived]
    impl StraightLine<Uncorrected<DeltaPlus>, 1, 1> for Kubo {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Explicit, 0, 1, false);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[
                QuadraturePoint::new(
                    [0.0, 1.0, 0.0],
                    &[Role::Drift.times(1.0), Role::Noise.times(1.0)],
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
            let a = lift(0, self.a);
            let sigma = lift(1, self.sigma);
            if a.magnitude().is_nan() || sigma.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            Ok([sigma, h * a])
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
            let [sigma, a_h] = *prepared;
            let sum = dw * sigma + a_h;
            let product = q * sum;
            let delta_p = -product;
            let node_p = p - product;
            let delta_q = sum * node_p;
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
    impl Discretized<Uncorrected<DeltaPlus>> for Kubo {
        type Scheme = Straight<Uncorrected<DeltaPlus>, 1, 1>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Uncorrected<DeltaPlus>\n\nHamiltonians\n  H0 = a (p² + q²)/2\n  H1 = sigma (p² + q²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h a (P² + q_i²)/2 - sigma ΔW (P² + q_i²)/2\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h a q_i - sigma q_i ΔW\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nFacts\n  converges to another system, with drift Hamiltonian H0 - D; D = sigma² q p/2\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → the system with H0 - D, not X: not asymptotically preserving\n  {H1, H0} = 0\n  H0 is a first integral: of the system, and not kept by what the step converges to in general\n  first integral p² + q²: of the system, and not kept by what the step converges to in general\n  each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one\n";
    }
    wzvi::bindings! {
        a a_h at by_p by_q carry coordinates delta_p delta_q dw factor h half_a
        half_sigma increments index inverse_pivot lift memory momenta next node_p p
        partials prepared product q role sigma sum sum2 t weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Kubo {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            checks::is_same::<
                ::wzvi::embedding::Uncorrected<::wzvi::embedding::DeltaPlus>,
            >(checks::PhantomData::<Uncorrected<DeltaPlus>>);
            {
                let a = self.a;
                checks::of_state::<checks::f64, _>(|q, p| 0.5 * a * (q * q + p * p));
            }
            {
                let sigma = self.sigma;
                checks::of_state::<checks::f64, _>(|q, p| 0.5 * sigma * (q * q + p * p));
            }
            checks::of_state::<checks::f64, _>(|q, p| q * q + p * p);
        }
    }
};
