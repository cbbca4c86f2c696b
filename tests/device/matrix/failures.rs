//! What was found wrong, collected over all scenes, and said so that it can be seen again.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;

use kugelblitz_tests::build_folder;

/// A number that is not the true one.
pub struct Failure {
    pub family: &'static str,
    /// The scene: `crowd-1-7` of family, seed and number.
    pub scene: String,
    /// The scene file.
    pub text: String,
    /// How the program was asked.
    pub way: String,
    /// Where, what was found, and what is true.
    pub what: String,
    /// Shows the same with the program, in the folder of the scene files.
    pub command: String,
}

/// The name of a scene's file there: `crowd-1-7.toml`, or `scenes-hard-touching.toml` of one that is a file itself.
pub fn file_of(scene: &str) -> String {
    format!("{}.toml", scene.trim_end_matches(".toml").replace('/', "-"))
}

/// Failures that are told in full.
const TOLD: usize = 6;

/// What all failures of `n_scenes` have in common, and some of them; `None` if there are none. Their scenes are written into
/// the folder `matrix` of the builds.
pub fn told(failures: &[Failure], n_scenes: usize) -> Option<String> {
    if failures.is_empty() {
        return None;
    }
    let folder = build_folder().join("matrix");
    fs::create_dir_all(&folder).expect("a folder for scenes");
    for failure in failures {
        let path = folder.join(file_of(&failure.scene));
        fs::write(path, &failure.text).expect("a scene file");
    }
    let scenes: BTreeSet<&str> = failures.iter().map(|failure| &*failure.scene).collect();
    let counted = |of: fn(&Failure) -> &str| {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        failures.iter().for_each(|failure| *counts.entry(of(failure)).or_default() += 1);
        let counts: Vec<String> = counts.iter().map(|(name, n)| format!("{name} {n}")).collect();
        counts.join(", ")
    };
    let mut text = format!(
        "{} wrong in {} of {n_scenes} scenes\nfamilies: {}\nways: {}\nscene files: {}\n",
        failures.len(),
        scenes.len(),
        counted(|failure| failure.family),
        counted(|failure| &failure.way),
        folder.display()
    );
    for Failure { scene, way, what, command, .. } in failures.iter().take(TOLD) {
        let _ = writeln!(text, "KUGELBLITZ_CASE={scene}, {way}: {what}\n    {command}");
    }
    Some(text)
}
