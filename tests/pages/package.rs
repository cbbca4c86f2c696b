//! The packaged crates have all that they are built, tested and used with.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use kugelblitz_tests::root;

/// The packages with their folders, and the names in there of what they need whole.
const PACKAGES: [(&str, &str, &[&str]); 5] = [
    (
        "kugelblitz",
        "",
        &["ci", "examples", "scenes", "shaders", "src", "CHANGELOG.md", "CONTRIBUTING.md"],
    ),
    ("kugelblitz-cli", "crates/cli", &["src", "tests", "build.rs"]),
    ("kugelblitz-judge", "crates/judge", &["examples", "src"]),
    ("kugelblitz-report", "crates/report", &["src"]),
    ("kugelblitz-view", "crates/view", &["src"]),
];

/// Files that each package has.
const EVERYWHERE: [&str; 2] = ["Cargo.toml", "README.md"];

/// The paths, from `folder` on, of a file or of all files below a folder there.
fn files_at(folder: &Path, name: &Path) -> Vec<String> {
    if !folder.join(name).is_dir() {
        return vec![name.to_str().unwrap().to_string()];
    }
    let entries = fs::read_dir(folder.join(name)).unwrap();
    let below = |entry: fs::DirEntry| files_at(folder, &name.join(entry.file_name()));
    entries.map(Result::unwrap).flat_map(below).collect()
}

/// The files of `folder` that a package with these paths lacks.
fn missing(packaged: &BTreeSet<&str>, folder: &str, whole: &[&str]) -> Vec<String> {
    let needed = whole.iter().flat_map(|name| files_at(&root().join(folder), Path::new(name)));
    let needed = needed.chain(EVERYWHERE.map(String::from));
    needed.filter(|path| !packaged.contains(path.as_str())).collect()
}

#[test]
fn packages_lack_no_file() {
    for (package, folder, whole) in PACKAGES {
        let output = Command::new(env!("CARGO"))
            .args(["package", "-p", package, "--list", "--offline", "--allow-dirty"])
            .current_dir(root())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let packaged: BTreeSet<&str> = text.lines().collect();
        assert_eq!(missing(&packaged, folder, whole), [""; 0], "{package}");

        for left_out in EVERYWHERE.into_iter().chain(whole.iter().copied()) {
            let mut packaged = packaged.clone();
            packaged.retain(|path| !Path::new(path).starts_with(left_out));
            assert_ne!(missing(&packaged, folder, whole), [""; 0], "{package}: {left_out}");
        }
    }
}
