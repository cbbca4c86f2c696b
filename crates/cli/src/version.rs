//! What `kugelblitz --version` tells: version and commit.

use std::sync::LazyLock;

/// The commit that the program was built from; `None` in a source archive.
pub const COMMIT: Option<&str> = option_env!("KUGELBLITZ_COMMIT");

/// The version and the commit, a line each.
pub fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let commit = COMMIT.unwrap_or("unknown");
        format!("{}\ncommit {commit}", env!("CARGO_PKG_VERSION"))
    });
    &LONG
}
