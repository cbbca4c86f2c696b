#!/usr/bin/env bash
# Installs the oldest Rust that Cargo.toml allows, with rustup, and makes it the default. CI uses this version everywhere: a
# newer one has new warnings, and other counts of instructions.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

version=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
rustup toolchain install "$version" --profile minimal --component clippy --component rustfmt --no-self-update
rustup default "$version"
