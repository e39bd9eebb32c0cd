//! What the files hold, and errors that name the path.

use fixtures::folder;
use std::fs;

use wzvi::error::Error;
use wzvi::report::write_file;

use super::estimators::kubo;

#[test]
fn a_target_that_is_no_folder_is_named() {
    let file = folder!("no-folder").join("file");
    fs::write(&file, b"").unwrap();
    let target = file.join("report");
    let error = kubo().paths(3).run().unwrap().write(&target).unwrap_err();
    assert!(error.to_string().contains(&*target.to_string_lossy()), "{error}");
    let error: Error = write_file(&target.join("x"), b"").unwrap_err().into();
    assert!(error.to_string().contains(&*target.to_string_lossy()), "{error}");
}

#[test]
fn every_number_is_in_the_files() {
    let folder = folder!("numbers");
    let report = kubo().paths(20).observe("q", |state| state.q[0]).run().unwrap();
    report.write(&folder).unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("measurements.json")).unwrap()).unwrap();
    let cells = json["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 15);
    assert_eq!(cells[0]["errors"].as_array().unwrap().len(), 20);
    assert_eq!(cells[0]["times"].as_array().unwrap().len(), 2);
    assert_eq!(cells[0]["strong"]["value"].as_f64(), Some(report.cells[0].strong.value));
    assert_eq!(json["machine"]["wzvi"], env!("CARGO_PKG_VERSION"));
    assert!(json["machine"]["processor"].is_string() && json["machine"]["cores"].as_u64() >= Some(1));
    let csv = fs::read_to_string(folder.join("measurements.csv")).unwrap();
    assert_eq!(csv.lines().count(), 16);
    assert!(csv.lines().next().unwrap().ends_with("weak_error_q,weak_standard_error_q"), "{csv}");
    let svg = fs::read_to_string(folder.join("error-order.svg")).unwrap();
    assert!(svg.contains("slope 1.") || svg.contains("slope 0.9"), "the slope is drawn");
    assert!(fs::read(folder.join("error-time.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn points_measured_elsewhere_are_shown_or_refused() {
    let folder = folder!("overlay");
    let path = folder.join("points.csv");
    fs::write(&path, "name,seconds,error\n# by hand\nother, 1e-3, 0.25\nother,2e-3,0.125\n").unwrap();
    let report = kubo().paths(3).overlay_csv(&path).run().unwrap();
    assert_eq!(report.overlay.len(), 2);
    let figure = &report.figures("x")[0];
    assert!(figure.series.iter().any(|series| {
        series.name == "other (elsewhere)" && series.points == [(1e-3, 0.25), (2e-3, 0.125)]
    }));
    for (text, what) in [("a,1,2\nb,1", "line 2"), ("a,1,2\nb,-1,2", "`-1`"), ("a,1,2\nb,x,2", "`x`")] {
        fs::write(&path, text).unwrap();
        let error = kubo().paths(3).overlay_csv(&path).run().unwrap_err().to_string();
        assert!(error.contains(what) && error.contains("points.csv"), "{error}");
    }
    let gone = kubo().overlay_csv(folder.join("gone.csv")).run().unwrap_err();
    assert!(gone.to_string().contains("gone.csv"), "{gone}");
}
