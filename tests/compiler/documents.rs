//! Documents: their links lead somewhere, their code is compiled and run, and the guide has all of its pages.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The documents that users read.
fn documents() -> Vec<PathBuf> {
    let in_folder = |folder: &str| {
        let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect::<Vec<_>>()
    };
    ["", "docs", "docs/guide", "examples"].into_iter().flat_map(in_folder).collect()
}

/// The text with what it includes, and without code.
fn text(document: &Path) -> String {
    let text = fs::read_to_string(document).unwrap();
    let mut prose = String::new();
    let mut is_code = false;
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
        } else if let Some(included) = line.strip_prefix("{{#include ") {
            let included = included.trim_end_matches("}}");
            prose += &self::text(&document.parent().unwrap().join(included));
        } else if !is_code {
            // Code within a line has no links.
            let outside = line.split('`').step_by(2).collect::<Vec<_>>();
            prose += &(outside.join("") + "\n");
        }
    }
    prose
}

/// What the links and pictures of a text lead to.
fn links(text: &str) -> Vec<String> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).filter(|target| !target.contains("://")).collect()
}

/// The anchors of the headings, as GitHub and mdBook name them.
fn anchors(document: &Path) -> BTreeSet<String> {
    let with_code = fs::read_to_string(document).unwrap();
    let mut text = with_code.clone();
    for line in with_code.lines() {
        if let Some(included) = line.strip_prefix("{{#include ") {
            let included = document.parent().unwrap().join(included.trim_end_matches("}}"));
            text += &fs::read_to_string(included).unwrap();
        }
    }
    let slug = |heading: &str| {
        let letters = heading.trim().to_lowercase().chars().collect::<Vec<_>>();
        let kept = letters.into_iter().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    text.lines().filter(|line| line.starts_with('#')).map(|line| slug(line.trim_start_matches('#'))).collect()
}

/// Without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            component => plain.push(component),
        }
    }
    plain
}

#[test]
fn every_link_leads_somewhere() {
    let mut broken = Vec::new();
    for document in documents() {
        for link in links(&text(&document)) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() {
                document.clone()
            } else {
                plain(&document.parent().unwrap().join(file))
            };
            let is_there = target.exists() && (anchor.is_empty() || anchors(&target).contains(anchor));
            if !is_there {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_guide_has_all_of_its_pages() {
    let guide = root().join("docs/guide");
    let summary = fs::read_to_string(guide.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<String> = links(&summary).into_iter().collect();
    let all = fs::read_dir(&guide).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let pages: BTreeSet<String> = all.filter(|name| name.ends_with(".md") && name != "SUMMARY.md").collect();
    assert_eq!(listed, pages);
}

/// All code that says it is Rust is compiled and run as a test of the documentation.
/// The book has the pages of the guide, and not what stands around it.
#[test]
fn the_guide_links_to_its_own_pages() {
    for document in documents().into_iter().filter(|document| document.parent().unwrap().ends_with("guide")) {
        for link in links(&text(&document)) {
            let page = link.split('#').next().unwrap();
            let is_outside = page.starts_with("..") && page.ends_with(".md");
            assert!(!is_outside, "{}: {link}", document.display());
        }
    }
}

#[test]
fn every_program_in_a_document_is_run() {
    let tested = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let name = document.strip_prefix(root()).unwrap().display().to_string();
        for fence in text.lines().filter_map(|line| line.strip_prefix("```rust")) {
            // Ranks of MPI need their launcher.
            let is_run = fence.is_empty() || name == "docs/cluster.md" && fence == ",no_run";
            assert!(is_run, "{name}: a block with `rust{fence}`");
            assert!(
                tested.contains(&format!("\"{name}\"")),
                "{name} is not among the documents of src/lib.rs"
            );
        }
    }
}

#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap().lines().count();
    assert!(lines <= 160, "{lines} lines");
}
