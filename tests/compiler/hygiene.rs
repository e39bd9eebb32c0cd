//! Generated code in the worst surroundings: `tests/hygiene` is a crate without a prelude, with `wzvi` under another
//! name, with everything shadowed and with every lint denied. Clippy reads it where there is a clippy.

use std::process::Command;

#[test]
#[ignore = "calls Cargo, for minutes: part of .ci/run"]
fn generated_code_depends_on_nothing_around_it() {
    let cargo = || Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let has_clippy =
        cargo().args(["clippy", "--version"]).output().is_ok_and(|output| output.status.success());
    let output = cargo()
        .arg(if has_clippy { "clippy" } else { "check" })
        .args(["--offline", "--quiet", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/hygiene/Cargo.toml"))
        // That of clippy for the workspace, where most of the dependencies are.
        .arg("--target-dir")
        .arg(concat!(env!("CARGO_TARGET_TMPDIR"), "/.."))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
