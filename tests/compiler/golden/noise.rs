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
  L_d = P Δq - a h (P² + q_{i+1/2}²)/2 - sigma ΔW (P² + q_{i+1/2}²)/2
  Δq = q_{i+1} - q_i
  q_{i+1/2} = Δq/2 + q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = a P h + sigma P ΔW
  p_i = -D1 L_d:  P = p_i + δp,  δp = (-a q_{i+1/2} h - sigma q_{i+1/2} ΔW)/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: linear (then Δq)

Facts
  converges to the Stratonovich system; D = 0
  {H1, H0} = 0
  H0 is a first integral: kept by the step to rounding
  first integral p² + q²: kept by the step to rounding

```

```text
Uncorrected<DeltaPlus>

Hamiltonians
  H0 = a (p² + q²)/2
  H1 = sigma (p² + q²)/2

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - a h (P² + q_i²)/2 - sigma ΔW (P² + q_i²)/2
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = a P h + sigma P ΔW
  p_i = -D1 L_d:  P = p_i + δp,  δp = -a q_i h - sigma q_i ΔW
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

Facts
  converges to another system, with drift Hamiltonian H0 - D; D = q p sigma²/2
  {H1, H0} = 0
  H0 is a first integral: of the system, and not kept by what the step converges to in general
  first integral p² + q²: of the system, and not kept by what the step converges to in general

```
*/
pub struct Kubo {
    pub a: f64,
    pub sigma: f64,
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
        self as wzvi, Beside, Carry, Compensation, ConfigError, Constant, Discretized,
        Effort, Err, Hamiltonian, KeptEnergy, Knowledge, LagrangianGradient, Lanes,
        NoiseClass, Ok, Option, Over, PhantomData, Plain, Plan, Result, SVector, Scalar,
        Segment, Solution, Solver, Some, State, StepFailure, Vector, bool, f64, str,
        usize, compose::{Composes, Equations, General, ROOM, Structure},
        embedding::{Composed, DeltaPlus, Midpoint, Uncorrected},
    };
    #[automatically_derived]
    impl Hamiltonian for Kubo {
        type Vector = SVector<f64, 1>;
        fn degrees(&self) -> usize {
            1
        }
        fn noises(&self) -> usize {
            1
        }
        fn invariants(&self) -> usize {
            1
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("a", self.a), ("sigma", self.sigma)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            match (term, q, p) {
                (0, &[q], &[p]) => {
                    let a: f64 = self.a;
                    (p * p + q * q) * (0.5 * a)
                }
                (1, &[q], &[p]) => {
                    let sigma: f64 = self.sigma;
                    (p * p + q * q) * (0.5 * sigma)
                }
                _ => S::from_f64(f64::NAN),
            }
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
            match (term, q, p) {
                (0, &[q], &[p]) => {
                    let a: f64 = self.a;
                    wzvi::gradient(by_q, by_p, [q * a], [p * a])
                }
                (1, &[q], &[p]) => {
                    let sigma: f64 = self.sigma;
                    wzvi::gradient(by_q, by_p, [q * sigma], [p * sigma])
                }
                _ => {
                    by_q.fill(S::from_f64(f64::NAN));
                    by_p.fill(S::from_f64(f64::NAN));
                }
            }
        }
        fn invariant(&self, index: usize, state: &State<Self::Vector>) -> f64 {
            match (index, Vector::components(&state.q), Vector::components(&state.p)) {
                (0, &[q], &[p]) => p * p + q * q,
                _ => f64::NAN,
            }
        }
    }
    const _: () = {
        type Prepared<K> = [K; 2];
        type Memory<S> = PhantomData<S>;
        #[inline(always)]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Prepared<K>,
            q: [S; 1],
            p: [S; 1],
            dw: [S; 1],
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p], [dw]) = (q, p, dw);
            let [sigma, a_h] = *prepared;
            let sum = dw * sigma + a_h;
            let inverse_pivot = wzvi::reciprocal_above_one::<S>(sum * sum * 0.25 + 1.0);
            let sum2 = q + p * (sum * 0.5);
            let product = sum * inverse_pivot;
            let node_p = p - sum2 * (product * 0.5);
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[sum * node_p], [-(sum2 * product)]],
                [node_p],
                Effort::fast(0),
            );
            if !next.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            Ok(())
        }
        #[automatically_derived]
        impl Discretized<Midpoint> for Kubo {
            const PLAN: Plan = Plan {
                solver: Solver::Linear,
                unknowns: 1,
                order: 2,
                noise: NoiseClass::Multiplicative,
                consistent: true,
                conserves_energy: Knowledge::Proven,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = a (p² + q²)/2\n  H1 = sigma (p² + q²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - a h (P² + q_{i+1/2}²)/2 - sigma ΔW (P² + q_{i+1/2}²)/2\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = Δq/2 + q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = a P h + sigma P ΔW\n  p_i = -D1 L_d:  P = p_i + δp,  δp = (-a q_{i+1/2} h - sigma q_{i+1/2} ΔW)/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: linear (then Δq)\n\nFacts\n  converges to the Stratonovich system; D = 0\n  {H1, H0} = 0\n  H0 is a first integral: kept by the step to rounding\n  first integral p² + q²: kept by the step to rounding\n";
            type Prepared = Prepared<f64>;
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = Compensation<S, 1>;
            type Carry<S: Scalar> = Plain;
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                if a.is_nan() || sigma.is_nan() {
                    return Err(ConfigError::Parameter);
                }
                Ok([sigma, h * a])
            }
            #[inline(always)]
            fn advance_carrying<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
                &self,
                prepared: &Self::Prepared,
                t: f64,
                h: f64,
                q: &mut [S],
                p: &mut [S],
                dw: &[S],
                memory: &mut Self::Memory<S>,
                carry: &mut C,
            ) -> Result<Effort, StepFailure> {
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                let dw = wzvi::increments(dw)?;
                let mut next = Solution::nowhere();
                solve::<S, f64, C, { CAREFUL }>(prepared, *q, *p, dw, carry, &mut next)?;
                Ok(next.store(q, p, carry))
            }
            type Beside<const L: usize> = Prepared<Lanes<{ L }>>;
            fn beside<const L: usize>(
                systems: [&Self; L],
                prepared: [&Self::Prepared; L],
            ) -> Option<Self::Beside<{ L }>> {
                Some(Beside::beside(prepared))
            }
            #[inline(always)]
            fn advance_beside<const L: usize>(
                beside: &Self::Beside<{ L }>,
                t: f64,
                h: f64,
                q: &mut [Lanes<{ L }>],
                p: &mut [Lanes<{ L }>],
                dw: &[Lanes<{ L }>],
                memory: &mut Self::Memory<Lanes<{ L }>>,
            ) -> Result<Effort, StepFailure> {
                let (prepared, carry) = (beside, &mut Plain);
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                let dw = wzvi::increments(dw)?;
                let mut next = Solution::nowhere();
                solve::<
                    Lanes<{ L }>,
                    Lanes<{ L }>,
                    Plain,
                    false,
                >(prepared, *q, *p, dw, carry, &mut next)?;
                Ok(next.store(q, p, carry))
            }
            fn discrete_lagrangian(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> f64 {
                let h = segment.h;
                let (&[q_start], &[q_end], &[p], &[dw]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return f64::NAN;
                };
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                let product = (q_start + q_end) * 0.5;
                p * (q_end - q_start)
                    - (dw * sigma + a * h) * (p * p + product * product) * 0.5
            }
            fn discrete_lagrangian_gradient(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> LagrangianGradient<Self::Vector> {
                let h = segment.h;
                let (&[q_start], &[q_end], &[p], &[dw]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return LagrangianGradient::not_a_number();
                };
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                let sum = dw * sigma + a * h;
                let product = sum * ((q_start + q_end) * 0.5) * 0.5;
                LagrangianGradient::from_components(
                    [-(p + product)],
                    [p - product],
                    [q_end - q_start - p * sum],
                )
            }
            fn step_momentum(
                &self,
                before: &State<Self::Vector>,
                after: &State<Self::Vector>,
                h: f64,
                dw: &[f64],
            ) -> Self::Vector {
                before.p + (after.p - before.p) * 0.5
            }
        }
    };
    const _: () = {
        type Prepared<K> = [K; 2];
        type Memory<S> = PhantomData<S>;
        #[inline(always)]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Prepared<K>,
            q: [S; 1],
            p: [S; 1],
            dw: [S; 1],
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p], [dw]) = (q, p, dw);
            let [sigma, a_h] = *prepared;
            let sum = dw * sigma + a_h;
            let product = q * sum;
            let node_p = p - product;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[sum * node_p], [-product]],
                [node_p],
                Effort::fast(0),
            );
            if !next.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            Ok(())
        }
        #[automatically_derived]
        impl Discretized<Uncorrected<DeltaPlus>> for Kubo {
            const PLAN: Plan = Plan {
                solver: Solver::Explicit,
                unknowns: 0,
                order: 1,
                noise: NoiseClass::Multiplicative,
                consistent: false,
                conserves_energy: Knowledge::Proven,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "Uncorrected<DeltaPlus>\n\nHamiltonians\n  H0 = a (p² + q²)/2\n  H1 = sigma (p² + q²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - a h (P² + q_i²)/2 - sigma ΔW (P² + q_i²)/2\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = a P h + sigma P ΔW\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -a q_i h - sigma q_i ΔW\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nFacts\n  converges to another system, with drift Hamiltonian H0 - D; D = q p sigma²/2\n  {H1, H0} = 0\n  H0 is a first integral: of the system, and not kept by what the step converges to in general\n  first integral p² + q²: of the system, and not kept by what the step converges to in general\n";
            const KEPT_ENERGY: KeptEnergy = KeptEnergy::Point(0f64);
            type Prepared = Prepared<f64>;
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = Compensation<S, 1>;
            type Carry<S: Scalar> = Plain;
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                if a.is_nan() || sigma.is_nan() {
                    return Err(ConfigError::Parameter);
                }
                Ok([sigma, h * a])
            }
            #[inline(always)]
            fn advance_carrying<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
                &self,
                prepared: &Self::Prepared,
                t: f64,
                h: f64,
                q: &mut [S],
                p: &mut [S],
                dw: &[S],
                memory: &mut Self::Memory<S>,
                carry: &mut C,
            ) -> Result<Effort, StepFailure> {
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                let dw = wzvi::increments(dw)?;
                let mut next = Solution::nowhere();
                solve::<S, f64, C, { CAREFUL }>(prepared, *q, *p, dw, carry, &mut next)?;
                Ok(next.store(q, p, carry))
            }
            type Beside<const L: usize> = Prepared<Lanes<{ L }>>;
            fn beside<const L: usize>(
                systems: [&Self; L],
                prepared: [&Self::Prepared; L],
            ) -> Option<Self::Beside<{ L }>> {
                Some(Beside::beside(prepared))
            }
            #[inline(always)]
            fn advance_beside<const L: usize>(
                beside: &Self::Beside<{ L }>,
                t: f64,
                h: f64,
                q: &mut [Lanes<{ L }>],
                p: &mut [Lanes<{ L }>],
                dw: &[Lanes<{ L }>],
                memory: &mut Self::Memory<Lanes<{ L }>>,
            ) -> Result<Effort, StepFailure> {
                let (prepared, carry) = (beside, &mut Plain);
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                let dw = wzvi::increments(dw)?;
                let mut next = Solution::nowhere();
                solve::<
                    Lanes<{ L }>,
                    Lanes<{ L }>,
                    Plain,
                    false,
                >(prepared, *q, *p, dw, carry, &mut next)?;
                Ok(next.store(q, p, carry))
            }
            fn discrete_lagrangian(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> f64 {
                let h = segment.h;
                let (&[q_start], &[q_end], &[p], &[dw]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return f64::NAN;
                };
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                p * (q_end - q_start)
                    - (dw * sigma + a * h) * (p * p + q_start * q_start) * 0.5
            }
            fn discrete_lagrangian_gradient(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> LagrangianGradient<Self::Vector> {
                let h = segment.h;
                let (&[q_start], &[q_end], &[p], &[dw]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return LagrangianGradient::not_a_number();
                };
                let a: f64 = self.a;
                let sigma: f64 = self.sigma;
                let sum = dw * sigma + a * h;
                LagrangianGradient::from_components(
                    [-(p + q_start * sum)],
                    [p],
                    [q_end - q_start - p * sum],
                )
            }
            fn step_momentum(
                &self,
                before: &State<Self::Vector>,
                after: &State<Self::Vector>,
                h: f64,
                dw: &[f64],
            ) -> Self::Vector {
                after.p
            }
        }
    };
    wzvi::composition! {
        [impl < W : Composes < Midpoint, General > > Discretized < Composed < Midpoint, W
        > > for Kubo] Composed < Midpoint, W >, < General as Structure < Midpoint >>
        ::Sequence, < W as Composes < Midpoint, General > > ::ORDER, Equations:: < Self,
        Midpoint, General, W, { 676 + ROOM } > ::ALL, < W as Composes < Midpoint, General
        > > ::substeps()
    }
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as a, binding as a_h, binding as after, binding as before,
        binding as beside, binding as by_p, binding as by_q, binding as carry,
        binding as dw, binding as h, binding as index, binding as inverse_pivot,
        binding as memory, binding as next, binding as node_p, binding as p,
        binding as prepared, binding as product, binding as q, binding as q_end,
        binding as q_start, binding as segment, binding as sigma, binding as state,
        binding as sum, binding as sum2, binding as systems, binding as t,
        binding as term,
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
    impl ::wzvi::__private::checks::Checked for Kubo {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(::core::marker::PhantomData::<Midpoint>);
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Uncorrected<::wzvi::embedding::DeltaPlus>,
            >(::core::marker::PhantomData::<Uncorrected<DeltaPlus>>);
            {
                let a = self.a;
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| 0.5 * a * (q * q + p * p));
            }
            {
                let sigma = self.sigma;
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| 0.5 * sigma * (q * q + p * p));
            }
            {
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| q * q + p * p);
            }
        }
    }
};
