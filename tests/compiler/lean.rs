//! What a scene does not use is not there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::root;

const MOST_CRATES: usize = 20;
/// For the first example: those of the default build, and of plots as SVG.
const MOST_CRATES_OF_KUBO: usize = 35;

const DETERMINISTIC: &str = r#"
use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint)]
struct Pendulum;

fn main() -> Result<(), wzvi::Error> {
    let mut stepper = Pendulum.stepper::<Midpoint>(0.1)?;
    let mut state = State::new([2.0], [0.0]);
    for _ in 0..1000 {
        stepper.step(&mut state, &[])?;
    }
    println!("{state:?}");
    Ok(())
}
"#;

fn cargo(folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO")).args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "cargo {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// The crates that a user of the facade compiles, macros included.
fn crates(features: &[&str]) -> BTreeSet<String> {
    let tree = ["tree", "--offline", "-p", "wzvi", "-e", "normal", "--prefix", "none", "--format", "{p}"];
    let output = cargo(root(), &[&tree, features].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

#[test]
fn the_default_build_is_small() {
    let crates = crates(&[]);
    assert!(crates.contains("wzvi") && crates.contains("nalgebra"), "{crates:?}");
    assert!(crates.len() <= MOST_CRATES, "{} crates: {crates:?}", crates.len());
}

/// The first command of the README builds what its example needs, build scripts included, and not what the tests need.
#[test]
fn the_first_example_is_built_from_few_crates() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    assert!(
        manifest.contains("default-members = [\".\"]"),
        "a command without a package builds the tests, too"
    );
    assert!(
        manifest.contains("name = \"kubo\"\nrequired-features = [\"svg\"]"),
        "the features of the example"
    );
    let crates = crates(&["--features", "svg", "-e", "normal,build,dev"]);
    assert!(crates.contains("plotters"), "{crates:?}");
    assert!(crates.len() <= MOST_CRATES_OF_KUBO, "{} crates: {crates:?}", crates.len());
}

#[test]
fn without_noise_no_random_number_generator_is_compiled() {
    let crates = crates(&["--no-default-features"]);
    assert!(!crates.iter().any(|name| name.contains("rand") || name.contains("chacha")), "{crates:?}");
}

/// Builds `source` as a program outside of the workspace; the path of its binary.
fn build(name: &str, source: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(folder.join("src")).unwrap();
    let manifest = format!(
        "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n\
         [dependencies]\nwzvi = {{ path = {:?} }}\n\n\
         [profile.dev]\ndebug = \"none\"\nincremental = false\ncodegen-units = 4\nbuild-override.codegen-units = 4\n",
        root()
    );
    std::fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    std::fs::write(folder.join("src/main.rs"), source).unwrap();
    // The versions of the workspace: nothing is downloaded.
    std::fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    // That of the workspace, where most of what it depends on is.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
    cargo(&folder, &["build", "--offline", "--target-dir", target.to_str().unwrap()]);
    target.join("debug").join(name)
}

#[test]
#[ignore = "calls Cargo, for minutes: part of .ci/release"]
fn a_deterministic_binary_holds_no_random_number_generator() {
    let bytes = std::fs::read(build("lean_pendulum", DETERMINISTIC)).unwrap();
    let holds = |word: &str| bytes.windows(word.len()).any(|window| window == word.as_bytes());
    // The symbol table is there: the check below means something.
    assert!(holds("13lean_pendulum"));
    // Mangled paths carry the length of a crate's name; the constant of ChaCha is data.
    for word in ["11rand_chacha", "9rand_core", "ChaCha", "12wzvi_runtime5noise", "expand 32-byte k"] {
        assert!(!holds(word), "the binary mentions {word}");
    }
}
