//! The scenes that come along with the library.

use std::path::Path;

macro_rules! scenes {
    ($($path:literal),+ $(,)?) => {
        /// The lecture's scenes, the hard ones, and those that are hard to light: their paths below `scenes/`, and their texts.
        pub const SHIPPED_SCENES: &[(&str, &str)] =
            &[$(($path, include_str!(concat!("../../scenes/", $path)))),+];
    };
}

scenes! {
    "figure1.toml",
    "figure2.toml",
    "figure3.toml",
    "figure4.toml",
    "figure5.toml",
    "inside.toml",
    "orthographic.toml",
    "hard/far_1e4.toml",
    "hard/far_1e6.toml",
    "hard/far_1e8.toml",
    "hard/tiny.toml",
    "hard/huge_ground.toml",
    "hard/grazing.toml",
    "hard/touching.toml",
    "hard/coincident.toml",
    "hard/coincident_far.toml",
    "hard/inside_nested.toml",
    "hard/distant_1e2.toml",
    "hard/distant_1e4.toml",
    "hard/distant_1e6.toml",
    "hard/near_parallel.toml",
    "lit/figure1.toml",
    "lit/figure2.toml",
    "lit/hard/contacts.toml",
    "lit/hard/contacts_1e-3.toml",
    "lit/hard/contacts_1e-6.toml",
    "lit/hard/contacts_1e3.toml",
    "lit/hard/contacts_moved.toml",
    "lit/hard/contacts_on_ball.toml",
    "lit/hard/shells.toml",
    "lit/hard/terminator.toml",
    "lit/hard/low_sun.toml",
    "lit/hard/along_subnormal.toml",
    "lit/hard/along_1e-324.toml",
    "lit/hard/along_1e-400.toml",
    "lit/hard/along_leaning.toml",
    "lit/hard/bright_eyes.toml",
    "lit/hard/bright_sky.toml",
    "lit/hard/faint_light.toml",
    "lit/hard/byte_edge.toml",
    "lit/hard/far_light.toml",
    "lit/hard/coincident_floor.toml",
    "lit/hard/galaxy.toml",
    "lit/hard/galaxy_shadow.toml",
    "lit/hard/galaxy_balls.toml",
    "lit/hard/beyond_f64.toml",
}

/// Returns the text of the built-in scene with this name: `figure1`, `hard/tiny`, or the same with `.toml`.
pub(super) fn shipped_scene(name: &Path) -> Option<&'static str> {
    let is_it = |path: &str| Path::new(path) == name || Path::new(path).with_extension("") == name;
    SHIPPED_SCENES.iter().find(|(path, _)| is_it(path)).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_scene_file_is_forgotten() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut on_disk = BTreeSet::new();
        // Scenes of `lit` that need a data file are not built in.
        for folder in ["", "hard/", "lit/", "lit/hard/"] {
            for entry in std::fs::read_dir(root.join(folder)).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                let needs_data = || {
                    let text = std::fs::read_to_string(root.join(folder).join(&name)).unwrap();
                    text.contains("[[spheres]]")
                };
                if name.ends_with(".toml") && !needs_data() {
                    on_disk.insert(format!("{folder}{name}"));
                }
            }
        }
        let listed: BTreeSet<_> = SHIPPED_SCENES.iter().map(|(path, _)| path.to_string()).collect();
        assert_eq!(listed, on_disk);
    }
}
