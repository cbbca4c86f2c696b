//! Tells the program which commit it is built from: the one in KUGELBLITZ_COMMIT, else that of the checkout.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=KUGELBLITZ_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    if let Some(commit) = std::env::var("KUGELBLITZ_COMMIT").ok().or_else(checked_out) {
        println!("cargo::rustc-env=KUGELBLITZ_COMMIT={commit}");
    }
}

/// `None` in a source archive, also one that lies in a repository of something else.
fn checked_out() -> Option<String> {
    if !Path::new("../../.git").exists() {
        return None;
    }
    // Each commit and checkout adds a line to it.
    println!("cargo::rerun-if-changed={}", git(&["rev-parse", "--git-path", "logs/HEAD"])?);
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
