//! Rooms of the code: each imports only those above it in the table of its crate's `lib.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::root;

/// What each room of a crate, a file or a folder of its `src`, names of the others; tests and comments apart.
fn imports(krate: &str) -> BTreeMap<String, BTreeSet<String>> {
    let src = root().join(krate).join("src");
    let mut rooms = BTreeMap::<String, BTreeSet<String>>::new();
    for file in files(&src) {
        let room = file.strip_prefix(&src).unwrap().components().next().unwrap().as_os_str();
        let room = room.to_str().unwrap().trim_end_matches(".rs").to_owned();
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap().lines();
        let code = code.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
        let named = code.split("crate::").skip(1).map(|rest| {
            assert!(!rest.starts_with('{'), "{}: one room in each `use`", file.display());
            rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap().to_owned()
        });
        rooms.entry(room.clone()).or_default().extend(named.filter(|named| *named != room));
    }
    rooms.remove("lib");
    let known: BTreeSet<_> = rooms.keys().cloned().collect();
    rooms.values_mut().for_each(|named| named.retain(|named| known.contains(named)));
    rooms
}

pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of_entry = |path: PathBuf| match path.is_dir() {
        true if path.ends_with("tests") => Vec::new(),
        true => files(&path),
        false if path.ends_with("tests.rs") || path.extension().is_none_or(|ending| ending != "rs") => {
            Vec::new()
        }
        false => vec![path],
    };
    entries.flat_map(of_entry).collect()
}

/// Every room of the crate is in the table of `lib.rs`, and imports only rooms above it.
fn imports_what_stands_above(krate: &str) {
    let lib = fs::read_to_string(root().join(krate).join("src/lib.rs")).unwrap();
    let rows = lib.lines().filter_map(|line| line.strip_prefix("//! | `")?.split(" |").next());
    let order: Vec<_> =
        rows.flat_map(|row| row.split(", ")).map(|room| room.trim_matches('`').to_owned()).collect();
    let rooms = imports(krate);
    assert_eq!(rooms.keys().collect::<BTreeSet<_>>(), order.iter().collect());
    for (place, room) in order.iter().enumerate() {
        let below: Vec<_> = order[place..].iter().filter(|other| rooms[room].contains(*other)).collect();
        assert!(below.is_empty(), "`{room}` imports {below:?}, which stand below it in the table of lib.rs");
    }
}

#[test]
fn the_run_time_imports_what_stands_above() {
    imports_what_stands_above("wzvi-runtime");
}

#[test]
fn the_compiler_imports_what_stands_above() {
    imports_what_stands_above("wzvi-macros");
}
