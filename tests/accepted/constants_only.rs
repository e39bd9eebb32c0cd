//! Hamiltonians at the edge: no momenta, no coordinates, no state at all, no finite value.

use wzvi::prelude::*;

macro_rules! systems {
    ($($name:ident: $drift:expr;)*) => {
        $(
            #[hamiltonian(drift = $drift, embedding = [DeltaPlus, Midpoint, DeltaMinus])]
            struct $name;
        )*
        #[test]
        fn compiles_and_runs() {
            $(
                let mut state = State::new([0.5], [1.0]);
                // An error or a step, no panic and no NaN; what is infinite from the start may refuse to be prepared.
                let outcome = $name.stepper::<Midpoint>(0.1).map(|mut stepper| stepper.step(&mut state, &[]));
                if matches!(outcome, Ok(Ok(_))) {
                    assert!(state.q[0].is_finite() && state.p[0].is_finite());
                } else {
                    assert_eq!((state.q[0], state.p[0], state.t), (0.5, 1.0, 0.0));
                }
                let _ = ($name.stepper::<DeltaPlus>(0.1), $name.stepper::<DeltaMinus>(0.1), $name.energy(&state));
            )*
        }
    };
}

systems! {
    Constant: |_, _| 1.0;
    Zero: |q, p| 0.0 * q * p;
    Free: |_, p| 0.5 * p * p;
    Static: |q, _| 0.5 * q * q;
    Linear: |q, p| q + p;
    ZeroToMinusOne: |q, p| 0.0f64.powi(-1) * q + p;
    Infinity: |q, p| 1e308 * 10.0 * q + p;
    Huge: |q, p| 1e308 * q * 1e308 * p;
    Tiny: |q, p| 1e-400 * q + p;
    LargePower: |q, p| q.powi(i32::MIN) + p.powi(2147483647);
    NotANumber: |q, p| f64::NAN + q * p;
    RootOfMinusOne: |q, p| (-1.0f64).sqrt() * q + p;
    LogarithmOfZero: |q, p| 0.0f64.ln() + q * p;
    KnownBranch: |q, p| if 1.0 < 2.0 { q * p } else { 1.0 / 0.0 };
    Comparison: |q, p| if q > q { q } else { p };
}
