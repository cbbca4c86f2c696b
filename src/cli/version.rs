//! What `kugelblitz --version` tells: version, commit, features.

use std::sync::LazyLock;

use git_version::git_version;

/// The commit that the program was built from: the one that the build was told of
/// (`KUGELBLITZ_COMMIT=$(git rev-parse HEAD) cargo build`), else that of the checkout; `None` in a source
/// archive.
pub const COMMIT: Option<&str> = match option_env!("KUGELBLITZ_COMMIT") {
    Some(commit) => Some(commit),
    None => match CHECKED_OUT.is_empty() {
        true => None,
        false => Some(CHECKED_OUT),
    },
};

/// `--exclude=*`: no tag stands in for it.
const CHECKED_OUT: &str =
    git_version!(args = ["--always", "--abbrev=12", "--exclude=*"], fallback = "");

/// The features that are built in, each with whether it is.
const FEATURES: [(&str, bool); 3] =
    [("cli", true), ("gpu", cfg!(feature = "gpu")), ("view", cfg!(feature = "view"))];

/// The version with commit and features, a line each.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let built_in: Vec<&str> =
            FEATURES.iter().filter(|(_, is_in)| *is_in).map(|(name, _)| *name).collect();
        format!(
            "{}\ncommit {}\nfeatures {}",
            env!("CARGO_PKG_VERSION"),
            COMMIT.unwrap_or("unknown"),
            built_in.join(", ")
        )
    });
    &LONG
}
