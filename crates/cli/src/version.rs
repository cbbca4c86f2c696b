//! What `kugelblitz --version` tells: version, commit, features.

use std::sync::LazyLock;

/// The commit that the program was built from; `None` in a source archive.
pub const COMMIT: Option<&str> = option_env!("KUGELBLITZ_COMMIT");

const FEATURES: &str = if cfg!(feature = "view") { "gpu, view" } else { "gpu" };

/// The version with commit and features, a line each.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let commit = COMMIT.unwrap_or("unknown");
        format!("{}\ncommit {commit}\nfeatures {FEATURES}", env!("CARGO_PKG_VERSION"))
    });
    &LONG
}
