//! States and trajectories in the formats of serde.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::step::StepInfo;

use super::systems::{PENDULUM, bits};

type Path = Trajectory<SVector<f64, 1>, Midpoint>;

#[test]
fn there_and_back() {
    let state = State::<SVector<f64, 2>>::new([0.1, -0.0], [1e-300, 3.0]).at(0.7);
    let text = serde_json::to_string(&state).unwrap();
    assert_eq!(text, r#"{"q":[0.1,-0.0],"p":[1e-300,3.0],"t":0.7}"#);
    assert_eq!(serde_json::from_str::<State<SVector<f64, 2>>>(&text).unwrap(), state);
    let info =
        PENDULUM.stepper::<Midpoint>(0.1).unwrap().step(&mut State::new([0.1], [0.2]), &[0.0, 0.1]).unwrap();
    let text = serde_json::to_string(&info).unwrap();
    assert_eq!(serde_json::from_str::<StepInfo>(&text).unwrap(), info);
}

#[test]
fn trajectories_are_checked() {
    let path = PENDULUM.run(Wiener::seed(1), 7, 3).run().unwrap();
    let value = serde_json::to_value(&path).unwrap();
    let back: Path = serde_json::from_value(value.clone()).unwrap();
    assert_eq!(bits(&back), bits(&path));
    type Change = fn(&mut serde_json::Value);
    let changes: [(Change, &str); 4] = [
        (|value| value["states"] = serde_json::json!([]), "at least its start"),
        (|value| value["increments"] = serde_json::json!([0.5]), "one increment per interval"),
        (|value| value["last"]["t"] = serde_json::json!(9.0), "is the end of the trajectory"),
        (|value| value["processes"] = serde_json::json!(u64::MAX), "one increment per interval"),
    ];
    for (change, expected) in changes {
        let mut changed = value.clone();
        change(&mut changed);
        let error = serde_json::from_value::<Path>(changed).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
