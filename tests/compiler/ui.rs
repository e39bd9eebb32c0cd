//! What rustc says of mistakes: `GOLDEN=overwrite cargo test --test compiler ui -- --ignored` renews the messages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAMS: &str = "tests/ui/fail";

/// The library that this test was built with, and the folder of what it depends on.
fn library() -> [PathBuf; 2] {
    let arguments =
        ["test", "--workspace", "--test", "compiler", "--no-run", "--offline", "--message-format=json"];
    let output =
        Command::new(env!("CARGO")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let library = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap())
        .filter(|message| message["target"]["name"] == "wzvi" && message["profile"]["test"] == false)
        .find_map(|message| Some(PathBuf::from(message["filenames"].as_array()?.first()?.as_str()?)))
        .expect("the library is an artifact");
    let folder = library.parent().unwrap().to_owned();
    [library, folder]
}

/// Without numbers of lines of the library and of `core`, and with margins that do not depend on how long those are.
fn steady(message: &str) -> String {
    let (mut text, mut is_program) = (String::new(), false);
    for line in message.lines() {
        let inner = line.trim_start();
        let behind_number = inner.trim_start_matches(|c: char| c.is_ascii_digit());
        if let Some(place) = inner.strip_prefix("--> ").or(inner.strip_prefix("::: ")) {
            let place =
                place.rsplit_once("/library/").map_or(place.to_owned(), |(_, file)| format!("$RUST/{file}"));
            is_program = place.starts_with(PROGRAMS);
            let shown = if is_program { &place } else { place.split(':').next().unwrap_or_default() };
            text += &format!("  {} {shown}\n", &inner[..3]);
        } else if behind_number.trim_start().starts_with('|') {
            let number = if is_program { &inner[..inner.len() - behind_number.len()] } else { "" };
            text += &format!("{number:>2} {}\n", behind_number.trim_start());
        } else if inner.starts_with("= ") {
            text += &format!("   {inner}\n");
        } else if inner.len() < line.len() {
            // What goes on from the line before.
            text += &format!("           {inner}\n");
        } else {
            // What has no place is of the program, as suggestions are.
            is_program |= !line.starts_with("...");
            text += &format!("{line}\n");
        }
    }
    text
}

#[test]
#[ignore = "calls Cargo, for minutes: part of .ci/run"]
fn mistakes_are_reported_where_they_are() {
    let [library, dependencies] = library();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut programs: Vec<_> =
        fs::read_dir(root.join(PROGRAMS)).unwrap().map(|file| file.unwrap().path()).collect();
    programs.retain(|path| path.extension() == Some("rs".as_ref()));
    programs.sort();
    assert!(programs.len() > 10, "{programs:?}");
    let mut others = Vec::new();
    for program in programs {
        let output = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
            .args([
                "--edition=2024",
                "--emit=metadata",
                "--diagnostic-width=140",
                "-A",
                "dead_code",
                "--verbose",
            ])
            .arg("--out-dir")
            .arg(env!("CARGO_TARGET_TMPDIR"))
            .arg("-L")
            .arg(format!("dependency={}", dependencies.display()))
            .arg("--extern")
            .arg(format!("wzvi={}", library.display()))
            .arg(program.strip_prefix(root).unwrap())
            .current_dir(root)
            .output()
            .unwrap();
        assert!(!output.status.success(), "{} compiles", program.display());
        let said = String::from_utf8(output.stderr).unwrap();
        // The last lines count the errors and name their codes.
        let said = steady(said.split("\nerror: aborting due to").next().unwrap_or_default());
        let expected = program.with_extension("stderr");
        if std::env::var("GOLDEN").as_deref() == Ok("overwrite") {
            fs::write(expected, said).unwrap();
        } else if fs::read_to_string(&expected).unwrap_or_default() != said {
            others.push(format!("{} says\n{said}", program.display()));
        }
    }
    assert!(others.is_empty(), "{}", others.join("\n"));
}
