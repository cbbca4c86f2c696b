//! The packaged crate has all that it is built, tested and used with.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use kugelblitz_tests::root;

/// Folders that a package needs whole.
const WHOLE: [&str; 5] = ["ci", "examples", "scenes", "shaders", "src"];

/// The paths of all files below a folder of the repository.
fn files_below(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let below = |entry: fs::DirEntry| {
        let path = folder.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => files_below(&path),
            false => vec![path.to_str().unwrap().to_string()],
        }
    };
    entries.map(Result::unwrap).flat_map(below).collect()
}

/// The files of the repository that a package with these paths lacks.
fn missing(packaged: &BTreeSet<&str>) -> Vec<String> {
    let others = ["Cargo.toml", "Cargo.lock", "README.md", "CHANGELOG.md", "CONTRIBUTING.md"];
    let all = WHOLE.iter().flat_map(|folder| files_below(Path::new(folder)));
    let all = all.chain(others.map(String::from));
    all.filter(|path| !packaged.contains(path.as_str())).collect()
}

#[test]
fn the_package_lacks_no_file() {
    let output = Command::new(env!("CARGO"))
        .args(["package", "-p", "kugelblitz", "--list", "--offline", "--allow-dirty"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let packaged: BTreeSet<&str> = text.lines().collect();
    assert_eq!(missing(&packaged), [""; 0]);

    for left_out in ["shaders/ray.wgsl", "scenes/figure1.toml", "src/report/page/page.css"] {
        let mut packaged = packaged.clone();
        assert!(packaged.remove(left_out), "{left_out}");
        assert_eq!(missing(&packaged), [left_out]);
    }
}
