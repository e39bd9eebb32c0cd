//! Builds of one program, and the seconds that they take.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

pub(crate) const REPETITIONS: u32 = 2;

pub(crate) fn cargo(command: &str, folder: &Path) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(folder).args([command, "--release", "--offline", "--quiet"]);
    cargo
}

pub(crate) fn forced(again: u32) -> [String; 3] {
    ["--".into(), "--cfg".into(), format!("again_{}_{again}", std::process::id())]
}

/// Seconds of the fastest of some builds, after one that builds what it depends on.
pub(crate) fn best(mut build: impl FnMut(u32) -> Command) -> Result<f64, Box<dyn Error>> {
    let mut fastest = f64::INFINITY;
    for again in 0..=REPETITIONS {
        let (start, before) = (Instant::now(), processor());
        let status = build(again).status()?;
        if !status.success() {
            return Err(format!("a build failed: {status}").into());
        }
        if again > 0 {
            let clock = start.elapsed().as_secs_f64();
            fastest = fastest.min(before.zip(processor()).map_or(clock, |(before, after)| after - before));
        }
    }
    Ok(fastest)
}

/// Seconds of the processor that the children of this process took: fields 16 and 17 of `/proc/self/stat`, in hundredths.
fn processor() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = fields.split_whitespace().skip(13).take(2).map(|field| field.parse::<f64>().ok());
    Some(0.01 * ticks.sum::<Option<f64>>()?)
}

/// The folder of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().skip(1).take(1).collect()
}

/// A package with one program, under `target/wzvi/compile`.
pub(crate) fn package(name: &str, program: &str) -> Result<PathBuf, Box<dyn Error>> {
    let root = root();
    let folder = root.join("target/wzvi/compile").join(name);
    std::fs::create_dir_all(folder.join("src"))?;
    let manifest = format!(
        "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n\
         [dependencies]\nwzvi = {{ path = {root:?}, default-features = false }}\n"
    );
    std::fs::write(folder.join("Cargo.toml"), manifest)?;
    std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock"))?;
    std::fs::write(folder.join("src/main.rs"), program)?;
    Ok(folder)
}
