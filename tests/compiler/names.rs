//! Names and comments: a type name is defined once in its crate, a comment names what it is about, and a line of
//! comment ends by column 110.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::rooms::files;
use super::root;

/// A line of comment ends by this column.
const WIDTH: usize = 110;

/// Names that two types of one crate have, and why.
const SHARED: [(&str, &str, &str); 2] = [
    ("wzvi-runtime", "Lambda", "the paper's λ: of a function on a time scale, and of an embedding"),
    (
        "wzvi-runtime",
        "Table",
        "users write `compose::Table` for coefficients, and get a `table::Table` of results",
    ),
];

/// The first sentences of comments that leave their noun to the reader.
const WITHOUT_NOUN: [&str; 3] = ["That of ", "Those of ", "Of "];

/// The first words of comments whose noun is hidden in a clause.
const CLAUSES: [&str; 3] = ["What ", "Which ", "Whose "];

/// What follows `The same` where the noun is missing.
const AFTER_THE_SAME: [&str; 14] =
    ["as", "at", "by", "for", "from", "if", "in", "of", "on", "to", "where", "with", "without", "beside"];

/// The lines of a file before its tests.
fn lines(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    text.split("#[cfg(test)]\nmod tests {").next().unwrap().lines().map(str::to_owned).collect()
}

/// The name of the type that a line defines; types of a trait or an `impl` are indented.
fn defined(line: &str) -> Option<&str> {
    let code = line.trim_start();
    let code = match code.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.strip_prefix(' ')?,
        None => code,
    };
    let (kind, rest) = code.split_once(' ')?;
    let is_type = matches!(kind, "struct" | "enum" | "trait" | "union");
    let is_alias = kind == "type" && !line.starts_with(' ');
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    ((is_type || is_alias) && name.starts_with(char::is_uppercase)).then_some(name)
}

#[test]
fn a_type_name_is_defined_once() {
    let mut shared = Vec::new();
    for krate in ["wzvi-runtime", "wzvi-macros"] {
        let mut names = BTreeMap::<String, Vec<String>>::new();
        for file in files(&root().join(krate).join("src")) {
            for (number, line) in lines(&file).iter().enumerate() {
                if let Some(name) = defined(line) {
                    names.entry(name.to_owned()).or_default().push(place(&file, number));
                }
            }
        }
        shared.extend(
            names
                .into_iter()
                .filter(|(_, places)| places.len() > 1)
                .map(|(name, places)| (krate, name, places)),
        );
    }
    let (allowed, refused): (Vec<_>, Vec<_>) = shared
        .into_iter()
        .partition(|(krate, name, _)| SHARED.iter().any(|(of, shared, _)| of == krate && shared == name));
    assert!(refused.is_empty(), "these names have several definitions: {refused:#?}");
    assert_eq!(allowed.len(), SHARED.len(), "a name of the list is defined once again: strike it out");
}

fn place(file: &Path, number: usize) -> String {
    format!("{}:{}", file.strip_prefix(root()).unwrap().display(), number + 1)
}

/// The comments of a file: paragraphs with the number of their first line, without blocks of code and tables.
fn paragraphs(file: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(file).unwrap();
    let (mut all, mut is_code, mut is_open) = (Vec::<(usize, String)>::new(), false, false);
    for (number, line) in text.lines().enumerate() {
        let Some(comment) = line.trim_start().strip_prefix("//") else {
            (is_code, is_open) = (false, false);
            continue;
        };
        let comment = comment.trim_start_matches(['/', '!']).trim();
        if comment.starts_with("```") {
            is_code = !is_code;
        }
        if is_code || comment.is_empty() || comment.starts_with("```") || comment.starts_with('|') {
            is_open = false;
        } else if is_open && let Some((_, open)) = all.last_mut() {
            open.push(' ');
            open.push_str(comment);
        } else {
            all.push((number, comment.to_owned()));
            is_open = true;
        }
    }
    all
}

/// Whether a sentence begins with a genitive or a pronoun whose noun stands elsewhere.
fn lacks_noun(sentence: &str) -> bool {
    WITHOUT_NOUN.iter().any(|start| sentence.starts_with(start))
        || sentence.strip_prefix("The same").is_some_and(|rest| {
            let word = rest.split_whitespace().next().unwrap_or_default();
            rest.starts_with(|c: char| !c.is_whitespace()) && !rest.starts_with(char::is_alphanumeric)
                || rest.is_empty()
                || AFTER_THE_SAME.contains(&word.trim_end_matches(|c: char| !c.is_alphanumeric()))
        })
}

/// The sources whose comments are read: those of the crates that are published.
fn sources() -> Vec<PathBuf> {
    ["wzvi-runtime/src", "wzvi-macros/src", "src"]
        .iter()
        .flat_map(|folder| files(&root().join(folder)))
        .collect()
}

#[test]
fn comments_have_their_nouns() {
    let mut refused = Vec::new();
    for file in sources() {
        for (number, paragraph) in paragraphs(&file) {
            if CLAUSES.iter().any(|start| paragraph.starts_with(start)) {
                refused.push(format!("{}: {paragraph}", place(&file, number)));
            }
            let sentences = paragraph.split_inclusive(['.', ':', '?']).map(str::trim_start);
            refused.extend(
                sentences
                    .filter(|sentence| lacks_noun(sentence))
                    .map(|sentence| format!("{}: {sentence}", place(&file, number))),
            );
        }
    }
    assert!(refused.is_empty(), "{} sentences begin without their noun: {refused:#?}", refused.len());
}

#[test]
fn comments_are_narrow() {
    let mut refused = Vec::new();
    for file in sources() {
        let text = fs::read_to_string(&file).unwrap();
        let mut is_code = false;
        for (number, line) in text.lines().enumerate() {
            let comment = line.trim_start();
            is_code = comment.starts_with("//")
                && (is_code != comment.trim_start_matches(['/', '!', ' ']).starts_with("```"));
            let words = comment.trim_start_matches(['/', '!', ' ']);
            // Tables and formulas keep their lines; a code span or an address is not broken.
            let may_break = words.split('`').step_by(2).any(|prose| prose.trim_end().contains(' '));
            if comment.starts_with("//")
                && !is_code
                && !words.starts_with('|')
                && may_break
                && line.chars().count() > WIDTH
            {
                refused.push(place(&file, number));
            }
        }
    }
    assert!(refused.is_empty(), "{} lines of comment end beyond column {WIDTH}: {refused:#?}", refused.len());
}

#[test]
fn tests_that_a_source_names_exist() {
    for file in sources() {
        for (number, paragraph) in paragraphs(&file) {
            let Some(tests) = paragraph.strip_prefix("Tested by ") else { continue };
            for test in tests.split('`').skip(1).step_by(2) {
                assert!(root().join(test).is_file(), "{}: there is no `{test}`", place(&file, number));
            }
        }
    }
}

#[test]
fn sentences_without_a_noun_are_recognised() {
    for sentence in [
        "The same with the time.",
        "That of the system.",
        "Those of a step.",
        "Of `n` paths.",
        "The same, later.",
    ] {
        assert!(lacks_noun(sentence), "{sentence}");
    }
    for sentence in ["The same path, later.", "That is why.", "Often.", "The sameness of things.", "Offsets."]
    {
        assert!(!lacks_noun(sentence), "{sentence}");
    }
}
