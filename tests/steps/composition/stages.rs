//! What the monitor of the energy allows for rounding follows from the stages that a step solves at once, not from its order.

use fixtures::small::Rotation;
use wzvi::prelude::*;
use wzvi::system::Discretized;

fn stages<E>() -> u32
where
    Rotation: Discretized<E>,
{
    <Rotation as Discretized<E>>::PROPERTIES.stages
}

#[test]
fn compositions_have_the_stages_of_their_parts() {
    assert_eq!([stages::<Verlet>(), stages::<Composed<Verlet, KahanLi8>>()], [0; 2]);
    assert_eq!([stages::<Midpoint>(), stages::<Composed<Midpoint, KahanLi8>>()], [1; 2]);
    assert_eq!(
        [stages::<Gauss<2>>(), stages::<Composed<Gauss<2>, Yoshida6>>(), stages::<Gauss<3>>()],
        [2, 2, 3]
    );
}

/// Where a step turns by nearly half a turn the motion is next to nothing, and rounding larger.
fn check_rounding<E>()
where
    Rotation: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    for exponent in [2, 4, 6] {
        let oscillator = Rotation { omega: 10.0_f64.powi(exponent) };
        let run = oscillator.simulate::<E>(1.0).start(State::new([1.0], [0.0])).steps(5000).run();
        assert!(run.is_ok(), "ωh = 1e{exponent}, {}: {:?}", std::any::type_name::<E>(), run.err());
    }
}

#[test]
fn rounding_is_no_alarm_of_compositions() {
    check_rounding::<Composed<Midpoint, Yoshida4>>();
    check_rounding::<Composed<Midpoint, KahanLi8>>();
    check_rounding::<Composed<Gauss<2>, Yoshida6>>();
}
