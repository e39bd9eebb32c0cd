#![allow(clippy::unwrap_used, reason = "a test that unwraps says what it expects")]

use std::io::Write;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;
use std::sync::Barrier;

use super::*;

/// An empty folder of the test's own.
fn folder_of(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("wzvi-file-{test}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn put(path: &Path, text: &str) -> Result<(), FileError> {
    replace(path, |file| file.write_all(text.as_bytes()))
}

/// Many writers of names that differ after the dot only, and of one name: each file is whole, none is in
/// another's way.
#[test]
fn writers_do_not_meet() {
    let folder = folder_of("meet");
    let barrier = Barrier::new(8);
    std::thread::scope(|scope| {
        for writer in 0..8 {
            let (folder, barrier) = (&folder, &barrier);
            scope.spawn(move || {
                let text = writer.to_string().repeat(100_000);
                for _ in 0..20 {
                    barrier.wait();
                    put(&folder.join(format!("stats.{writer}")), &text).unwrap();
                    put(&folder.join("shared"), &text).unwrap();
                }
            });
        }
    });
    for writer in 0..8 {
        let text = fs::read_to_string(folder.join(format!("stats.{writer}"))).unwrap();
        assert_eq!(text, writer.to_string().repeat(100_000));
    }
    let shared = fs::read_to_string(folder.join("shared")).unwrap();
    assert!(shared.len() == 100_000 && shared.bytes().all(|byte| byte == shared.as_bytes()[0]));
    assert_eq!(names(&folder).len(), 9);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn links_are_followed_and_permissions_stay() {
    let folder = folder_of("links");
    fs::create_dir(folder.join("far")).unwrap();
    let real = folder.join("far").join("real");
    symlink("far/real", folder.join("inner")).unwrap();
    symlink("inner", folder.join("link")).unwrap();
    // If there is no file yet, the link says where it goes.
    put(&folder.join("link"), "one").unwrap();
    assert_eq!(fs::read_to_string(&real).unwrap(), "one");
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    put(&folder.join("link"), "two").unwrap();
    assert_eq!(fs::read_to_string(&real).unwrap(), "two");
    assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    assert!(fs::symlink_metadata(folder.join("link")).unwrap().is_symlink());
    assert_eq!(names(&folder), ["far", "inner", "link"]);
    assert_eq!(names(&folder.join("far")), ["real"]);
    symlink("circle", folder.join("circle")).unwrap();
    assert!(
        put(&folder.join("circle"), "three").unwrap_err().to_string().contains("too many symbolic links")
    );
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_is_no_regular_file_is_refused() {
    let folder = folder_of("special");
    let refused = |path: &Path, expected: &str| match put(path, "text") {
        Err(FileError::Special { found, .. }) => assert_eq!(found, expected),
        other => panic!("{}: {other:?}", path.display()),
    };
    refused(&folder, "a folder");
    refused(Path::new("/dev/null"), "a device");
    symlink("/dev/full", folder.join("full")).unwrap();
    refused(&folder.join("full"), "a device");
    let pipe = folder.join("pipe");
    if Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()) {
        refused(&pipe, "a pipe");
    }
    let kept = folder.join("kept");
    fs::write(&kept, "mine").unwrap();
    fs::set_permissions(&kept, fs::Permissions::from_mode(0o444)).unwrap();
    let error = put(&kept, "text").unwrap_err();
    assert!(error.to_string().contains("it is read-only"), "{error}");
    assert_eq!(fs::read_to_string(&kept).unwrap(), "mine");
    assert!(fs::metadata("/dev/null").unwrap().permissions().mode() & 0o666 == 0o666);
    fs::remove_dir_all(folder).unwrap();
}

/// A write that fails, and one that is given up: the old content stays, nothing else does.
#[test]
fn a_failure_leaves_nothing_behind() {
    let folder = folder_of("failure");
    let path = folder.join("file");
    put(&path, "old").unwrap();
    let failing = |file: &mut BufWriter<File>| {
        file.write_all(b"new")?;
        Err(io::Error::other("no more"))
    };
    assert!(replace(&path, failing).unwrap_err().to_string().contains("no more"));
    drop(Staged::write(&path, |file| file.write_all(b"new")).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(&folder), ["file"]);
    // A name as long as the system allows.
    put(&folder.join("n".repeat(255)), "long").unwrap();
    fs::remove_dir_all(folder).unwrap();
}

/// Only parts that a dead writer of the same file left are removed.
#[test]
fn parts_of_the_dead_only() {
    let folder = folder_of("parts");
    let path = folder.join("run");
    let alive = Staged::write(&path, |file| file.write_all(b"magic 1")).unwrap();
    let dead = format!("{}{:016x}{PART}", prefix(&path), 1);
    let foreign = format!("{}{:016x}{PART}", prefix(&path), 2);
    let other = format!("{}{:016x}{PART}", prefix(&folder.join("other")), 3);
    fs::write(folder.join(&dead), "mag").unwrap();
    fs::write(folder.join(&foreign), "mine").unwrap();
    fs::write(folder.join(&other), "magic 2").unwrap();
    fs::write(folder.join("run.1.part"), "magic").unwrap();
    remove_parts(&path, b"magic ");
    let left = names(&folder);
    assert!(!left.contains(&dead), "{left:?}");
    assert!([&foreign, &other, "run.1.part"].iter().all(|name| left.contains(&name.to_string())), "{left:?}");
    alive.publish().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "magic 1");
    fs::remove_dir_all(folder).unwrap();
}
