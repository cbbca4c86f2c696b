#!/usr/bin/env bash
# Installs tools that only releases need into the build folder, in pinned versions. Prints the PATH with them.
#
#   ci/dist/tools.sh python           maturin, twine, auditwheel, zig and cargo-zigbuild
#   ci/dist/tools.sh cargo-deny …     Rust programs, each built once
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

die() { printf 'ci/dist/tools.sh: %s\n' "$*" >&2; exit 1; }

# Without associative arrays, which macOS' bash does not have.
known="cargo-about@0.9.3 cargo-cyclonedx@0.5.9 cargo-deny@0.20.2 mdbook@0.5.4"

[ $# -gt 0 ] || die "expected names of tools: python, $known"
target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
tools=$target/dist/tools
mkdir -p "$tools/bin"

install_python() {
    local state
    state=$({ python3 --version; cat ci/dist/tools.txt python/requirements.txt; } | sha256sum)
    [ "$(cat "$tools/python/state" 2>/dev/null)" != "$state" ] || return 0
    rm -rf "$tools/python"
    python3 -m venv "$tools/python"
    "$tools/python/bin/pip" -q --disable-pip-version-check install --only-binary :all: \
        -c python/requirements.txt -r ci/dist/tools.txt maturin twine >&2
    echo "$state" >"$tools/python/state"
}

install_rust() {
    local tool features=
    for tool in $known; do [ "${tool%@*}" != "$1" ] || break; done
    [ "${tool%@*}" = "$1" ] || die "unknown tool $1; known are python, $known"
    [ "$1" != cargo-about ] || features=cli
    grep -qF "\"${tool/@/ } " "$tools/.crates.toml" 2>/dev/null && return 0
    CARGO_TARGET_DIR=$tools/build cargo install -q --locked --root "$tools" "$tool" --features "$features" >&2
}

for name in "$@"; do
    if [ "$name" = python ]; then install_python; else install_rust "$name"; fi
done
printf '%s\n' "$tools/bin:$tools/python/bin:$PATH"
