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
  H0 = q²/2 + p²/2
  H1 = q p sigma

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (q_i²/2 + P²/2) - sigma q_i P ΔW - sigma² q_i P ΔW²/2
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = sigma q_i ΔW + P h + sigma² q_i ΔW²/2
  p_i = -D1 L_d:  P = p_i + δp,  δp = -sigma P ΔW - q_i h - sigma² P ΔW²/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  solve for δp: linear
  assign Δq

Facts
  converges to the Stratonovich system; D = q p sigma²/2
  {H1, H0} = q² sigma - p² sigma
  H0 is not a first integral

```
*/
pub struct Multiplicative {
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
        usize, embedding::{Corrected, DeltaPlus},
    };
    #[automatically_derived]
    impl Hamiltonian for Multiplicative {
        type Vector = SVector<f64, 1>;
        fn degrees(&self) -> usize {
            1
        }
        fn noises(&self) -> usize {
            1
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("sigma", self.sigma)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            match (term, q, p) {
                (0, &[q], &[p]) => (q * q + p * p) * 0.5,
                (1, &[q], &[p]) => {
                    let sigma: f64 = self.sigma;
                    q * p * sigma
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
                (0, &[q], &[p]) => wzvi::gradient(by_q, by_p, [q], [p]),
                (1, &[q], &[p]) => {
                    let sigma: f64 = self.sigma;
                    wzvi::gradient(by_q, by_p, [p * sigma], [q * sigma])
                }
                _ => {
                    by_q.fill(S::from_f64(f64::NAN));
                    by_p.fill(S::from_f64(f64::NAN));
                }
            }
        }
    }
    const _: () = {
        type Prepared<K> = [K; 2];
        type Memory<S> = PhantomData<S>;
        #[inline(always)]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Prepared<K>,
            h: f64,
            q: [S; 1],
            p: [S; 1],
            dw: [S; 1],
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p], [dw]) = (q, p, dw);
            let [sigma, half_sigma] = *prepared;
            let product = dw * (dw * half_sigma + 1.0) * sigma;
            let inverse_pivot = wzvi::reciprocal::<S>(product + 1.0)?;
            let product2 = inverse_pivot * (p * product + q * h);
            let node_p = p - product2;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[q * product + node_p * h], [-product2]],
                [node_p],
                Effort::fast(0),
            );
            if !next.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            Ok(())
        }
        #[automatically_derived]
        impl Discretized<Corrected<DeltaPlus>> for Multiplicative {
            const PLAN: Plan = Plan {
                solver: Solver::Linear,
                unknowns: 1,
                order: 1,
                noise: NoiseClass::Multiplicative,
                consistent: true,
                conserves_energy: Knowledge::Refuted,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "Corrected<DeltaPlus>\n\nHamiltonians\n  H0 = q²/2 + p²/2\n  H1 = q p sigma\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (q_i²/2 + P²/2) - sigma q_i P ΔW - sigma² q_i P ΔW²/2\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = sigma q_i ΔW + P h + sigma² q_i ΔW²/2\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -sigma P ΔW - q_i h - sigma² P ΔW²/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  solve for δp: linear\n  assign Δq\n\nFacts\n  converges to the Stratonovich system; D = q p sigma²/2\n  {H1, H0} = q² sigma - p² sigma\n  H0 is not a first integral\n";
            const KEPT_ENERGY: KeptEnergy = KeptEnergy::Point(0f64);
            type Prepared = Prepared<f64>;
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = Compensation<S, 1>;
            type Carry<S: Scalar> = Plain;
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                let sigma: f64 = self.sigma;
                if sigma.is_nan() {
                    return Err(ConfigError::Parameter);
                }
                Ok([sigma, 0.5 * sigma])
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
                solve::<
                    S,
                    f64,
                    C,
                    { CAREFUL },
                >(prepared, h, *q, *p, dw, carry, &mut next)?;
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
                >(prepared, h, *q, *p, dw, carry, &mut next)?;
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
                let sigma: f64 = self.sigma;
                let difference = p
                    * (q_end - q_start
                        - (dw * (0.5 * sigma) + 1.0) * (q_start * dw) * sigma)
                    - (q_start * q_start + p * p) * (0.5 * h);
                difference
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
                let sigma: f64 = self.sigma;
                let sum = dw * (0.5 * sigma) + 1.0;
                LagrangianGradient::from_components(
                    [-(p * (dw * sum * sigma + 1.0) + q_start * h)],
                    [p],
                    [q_end - q_start - p * h - sum * (q_start * dw) * sigma],
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
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as after, binding as before, binding as beside, binding as by_p,
        binding as by_q, binding as carry, binding as difference, binding as dw,
        binding as h, binding as half_sigma, binding as index, binding as inverse_pivot,
        binding as memory, binding as next, binding as node_p, binding as p,
        binding as prepared, binding as product, binding as product2, binding as q,
        binding as q_end, binding as q_start, binding as segment, binding as sigma,
        binding as sum, binding as systems, binding as t, binding as term,
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
    impl ::wzvi::__private::checks::Checked for Multiplicative {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Corrected<::wzvi::embedding::DeltaPlus>,
            >(::core::marker::PhantomData::<Corrected<DeltaPlus>>);
            {
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| 0.5 * p * p + 0.5 * q * q);
            }
            {
                let sigma = self.sigma;
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| sigma * q * p);
            }
        }
    }
};
