//! The error for a machine without a Vulkan device.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;

use crate::error::{Error, Hint, Message, Setting};
use crate::plain::Shown;
use crate::words::list;

/// Returns the next step if no Vulkan driver works.
pub(super) fn install_hint() -> Hint {
    let text = "install a Vulkan driver (Debian: `apt install mesa-vulkan-drivers` brings a software one), or use {}, which \
                needs none";
    Hint::new(text, [cpu()])
}

fn cpu() -> Setting {
    Setting::text("device", "cpu")
}

/// Environment variables that limit the Vulkan loader to some drivers. The loader reads the second one only if the first one
/// is not set. `VK_ADD_DRIVER_FILES` is not one of them: it only adds drivers.
const VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Creates the error for a machine on which the Vulkan loader finds no device.
pub fn no_device() -> Error {
    let set: Vec<_> =
        VARIABLES.iter().filter_map(|&name| Some((name, env::var_os(name)?))).collect();
    Error::NoAdapter(Message::new(problem(&set), advice(&set)))
}

/// Describes the cause: the variable that the loader reads, if one is set, with its value and the paths that do not exist.
fn problem(set: &[(&str, OsString)]) -> String {
    let problem = "no Vulkan device found";
    let Some((name, value)) = set.first() else { return problem.into() };
    let paths: Vec<PathBuf> =
        env::split_paths(value).filter(|path| *path != PathBuf::new()).collect();
    let missing: Vec<&PathBuf> =
        paths.iter().filter(|path| matches!(path.try_exists(), Ok(false))).collect();
    let value = value.to_string_lossy().shown();
    let state = match (missing.len(), paths.len()) {
        (0, _) => "and no other driver is used".into(),
        (1, 1) => "which does not exist".into(),
        (n_missing, n_paths) if n_missing == n_paths => "and none of these files exists".into(),
        (n_missing, _) => {
            let names = list(&quoted(missing.iter().map(|path| path.shown())));
            format!("where {names} {} not exist", if n_missing == 1 { "does" } else { "do" })
        }
    };
    format!("{problem} with `{name}={value}`, {state}")
}

fn quoted(names: impl Iterator<Item = String>) -> Vec<String> {
    names.map(|name| format!("`{name}`")).collect()
}

/// Returns the next step for [`problem`].
fn advice(set: &[(&str, OsString)]) -> Hint {
    if set.is_empty() {
        return install_hint();
    }
    let names = list(&quoted(set.iter().map(|(name, _)| name.to_string())));
    Hint::new("{} needs no driver", [cpu()]).after(format!("unset {names}, or correct the paths; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(set: &[(&'static str, &[&str])]) -> [String; 2] {
        let value =
            |(name, paths): &(&'static str, &[&str])| (*name, env::join_paths(*paths).unwrap());
        let set: Vec<_> = set.iter().map(value).collect();
        [problem(&set), advice(&set).to_string()]
    }

    #[test]
    fn the_cause_is_the_variable_that_limits_the_drivers() {
        let here = env::current_exe().unwrap();
        let here = here.to_str().unwrap();
        let separator = if cfg!(windows) { ';' } else { ':' };
        let install = install_hint().to_string();
        let unset =
            "unset `VK_DRIVER_FILES`, or correct the paths; `device = \"cpu\"` needs no driver";
        let unset_both = unset.replace("`,", "` and `VK_ICD_FILENAMES`,");
        let [new, old] = VARIABLES;
        let both = format!("/no.json{separator}{here}");
        for (set, state, help) in [
            (&[][..], String::new(), install.as_str()),
            (&[(new, &["/no.json"][..])], format!("`{new}=/no.json`, which does not exist"), unset),
            (
                &[(old, &["/no.json"])],
                format!("`{old}=/no.json`, which does not exist"),
                &unset.replace(new, old),
            ),
            (
                &[(new, &["/no.json"]), (old, &[here])],
                format!("`{new}=/no.json`, which does not exist"),
                &unset_both,
            ),
            (
                &[(new, &["/no.json", "/nor.json"])],
                format!("`{new}=/no.json{separator}/nor.json`, and none of these files exists"),
                unset,
            ),
            (
                &[(new, &["/no.json", here])],
                format!("`{new}={both}`, where `/no.json` does not exist"),
                unset,
            ),
            (
                &[(new, &["/a.json", here, "/b.json"])],
                format!(
                    "`{new}=/a.json{separator}{here}{separator}/b.json`, where `/a.json` and `/b.json` do not exist"
                ),
                unset,
            ),
            (&[(new, &[here])], format!("`{new}={here}`, and no other driver is used"), unset),
        ] {
            let problem = match &state[..] {
                "" => "no Vulkan device found".into(),
                state => format!("no Vulkan device found with {state}"),
            };
            assert_eq!(message(set), [problem, help.to_string()]);
        }
    }

    #[test]
    fn a_value_cannot_steer_a_terminal() {
        let [problem, _] = message(&[(VARIABLES[0], &["/\u{1b}[31m.json"])]);
        assert!(problem.contains("/\\u{1b}[31m.json"), "{problem}");
    }
}
