//! Documents: their links lead somewhere, their code is compiled and run, their sentences are short, and the guide has all of its pages.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::rooms::files;
use super::root;

/// The documents that users read.
fn documents() -> Vec<PathBuf> {
    let in_folder = |folder: &str| {
        let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect::<Vec<_>>()
    };
    ["", "docs", "docs/guide", "examples"].into_iter().flat_map(in_folder).collect()
}

fn guide() -> impl Iterator<Item = PathBuf> {
    documents().into_iter().filter(|document| document.parent().unwrap().ends_with("docs/guide"))
}

fn name(document: &Path) -> String {
    document.strip_prefix(root()).unwrap().display().to_string()
}

/// The lines outside of blocks of code.
fn lines(document: &Path) -> Vec<String> {
    let text = fs::read_to_string(document).unwrap();
    let mut is_code = false;
    let is_prose = |line: &&str| {
        let is_fence = line.trim_start().starts_with("```") && !line.trim_start()[3..].contains('`');
        is_code ^= is_fence;
        !is_code && !is_fence
    };
    text.lines().filter(is_prose).map(str::to_owned).collect()
}

/// A line with `word` in the place of each piece of code.
fn without_code(line: &str, word: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join(word)
}

/// What the links and pictures of a document lead to.
fn links(document: &Path) -> Vec<String> {
    let text = lines(document).iter().map(|line| without_code(line, "") + "\n").collect::<String>();
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).filter(|target| !target.contains("://")).collect()
}

/// The anchors of the headings, as GitHub and mdBook name them.
fn anchors(document: &Path) -> BTreeSet<String> {
    let slug = |heading: &str| {
        let letters = heading.trim().to_lowercase().chars().collect::<Vec<_>>();
        let kept = letters.into_iter().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    let lines = lines(document);
    lines.iter().filter(|line| line.starts_with('#')).map(|line| slug(line.trim_start_matches('#'))).collect()
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
        for link in links(&document) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() {
                document.clone()
            } else {
                plain(&document.parent().unwrap().join(file))
            };
            let is_there = target.exists() && (anchor.is_empty() || anchors(&target).contains(anchor));
            if !is_there {
                broken.push(format!("{}: {link}", name(&document)));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// A page is read where the repository is hosted and in the book: it is all there, and leads to other pages of the book and to pictures beside it.
#[test]
fn a_page_of_the_guide_is_the_same_in_the_book() {
    for page in guide() {
        let is_included = lines(&page).iter().any(|line| without_code(line, "").contains("{{"));
        assert!(!is_included, "{} includes a file", name(&page));
        for link in links(&page) {
            let file = link.split('#').next().unwrap();
            let is_in_the_book = !file.contains('/') || file.starts_with("../pictures/");
            assert!(is_in_the_book, "{}: {link}", name(&page));
        }
    }
}

#[test]
fn the_guide_has_all_of_its_pages() {
    let listed: BTreeSet<String> = links(&root().join("docs/guide/SUMMARY.md")).into_iter().collect();
    let file = |page: PathBuf| page.file_name().unwrap().to_str().unwrap().to_owned();
    let pages: BTreeSet<String> = guide().map(file).filter(|name| name != "SUMMARY.md").collect();
    assert_eq!(listed, pages);
}

/// All code that says it is Rust is compiled and run as a test of the documentation.
#[test]
fn every_program_in_a_document_is_run() {
    let tested = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let name = name(&document);
        for fence in text.lines().filter_map(|line| line.strip_prefix("```rust")) {
            // Ranks of MPI need their launcher.
            let is_run = match fence {
                "" | ",compile_fail" => true,
                ",no_run" => name == "docs/guide/cluster.md",
                _ => false,
            };
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
    assert!(lines <= 140, "{lines} lines");
}

/// Words of a sentence of the README and of the guide, at most.
const WORDS: usize = 30;

/// Sentences that are longer, by how they begin: the page and the first words.
const LONGER: [(&str, &str); 0] = [];

/// Sentences of a text: code and targets of links are one word each; a paragraph, an item of a list and a cell of a table end one.
fn sentences(document: &Path) -> Vec<String> {
    let mut texts = vec![String::new()];
    for line in lines(document) {
        let line = without_code(&line, "code").replace("\\|", " ");
        let begins = ["* ", "- ", "#", "|", ">"].iter().any(|mark| line.trim_start().starts_with(mark))
            || line.trim_start().split_once(". ").is_some_and(|(number, _)| number.parse::<u32>().is_ok());
        if begins || line.trim().is_empty() {
            texts.push(String::new());
        }
        for (n, cell) in line.split('|').enumerate() {
            if n > 0 {
                texts.push(String::new());
            }
            texts.last_mut().unwrap().push_str(cell);
            texts.last_mut().unwrap().push(' ');
        }
    }
    let mut sentences = Vec::new();
    for text in texts {
        // The text of a link stays, its target goes.
        let mut plain = String::new();
        for (n, part) in text.split("](").enumerate() {
            plain += if n == 0 { part } else { part.split_once(')').map_or("", |(_, rest)| rest) };
        }
        let plain = plain.replace("**", "").replace("? ", "?. ").replace("! ", "!. ");
        for sentence in plain.split(". ") {
            sentences.push(sentence.split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
    sentences
}

/// A path on the page begins at the root, at a module of a crate, or beside the page; a word of code is in some source.
#[test]
fn what_contributors_are_told_exists() {
    let sources = ["src", "wzvi-macros/src", "wzvi-runtime/src"].map(|folder| root().join(folder));
    let page = root().join("docs/guide/contributors.md");
    let places = [root(), sources[1].as_path(), sources[2].as_path(), page.parent().unwrap()];
    let texts = sources.iter().flat_map(|folder| files(folder));
    let all = texts.map(|file| fs::read_to_string(file).unwrap()).collect::<String>();
    let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let known: BTreeSet<_> = all.split(|letter| !is_word(letter)).collect();
    let is_known = |word: &str| {
        let word = word.trim_matches('_');
        word.len() < 2 || word.starts_with(|letter: char| letter.is_numeric()) || known.contains(word)
    };
    let is_path = |piece: &str| {
        (piece.contains('/') || piece.ends_with(".rs") || piece.ends_with(".md"))
            && piece.chars().all(|letter| is_word(letter) || "/.-".contains(letter))
    };
    let exists = |piece: &&str| match is_path(piece) {
        true => places.iter().any(|place| place.join(piece).exists()),
        false => piece.contains("cargo ") || piece.split(|letter| !is_word(letter)).all(is_known),
    };
    let lines = lines(&page);
    let pieces = lines.iter().flat_map(|line| line.split('`').skip(1).step_by(2));
    let missing: Vec<_> = pieces.filter(|piece| !exists(piece)).collect();
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn sentences_are_short() {
    let mut long = Vec::new();
    let mut unused = LONGER.to_vec();
    for document in guide().chain([root().join("README.md")]) {
        let page = name(&document);
        for sentence in sentences(&document) {
            let is_word = |word: &&str| word.chars().any(char::is_alphanumeric);
            let words = sentence.split(' ').filter(is_word).count();
            if words <= WORDS {
                continue;
            }
            match unused.iter().position(|(file, begin)| *file == page && sentence.starts_with(begin)) {
                Some(known) => drop(unused.remove(known)),
                None => long.push(format!("{page}, {words} words: {sentence}")),
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
    assert!(unused.is_empty(), "no longer there: {unused:?}");
}
