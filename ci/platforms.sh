#!/usr/bin/env bash
# Checks that the programs compile for Windows and macOS: those of their targets that are installed
# (`rustup target add x86_64-pc-windows-gnu aarch64-apple-darwin`). Apple's wants clang, for one
# dependency's assembly. ci/test.sh leaves this out: each target compiles all dependencies anew.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

libraries=$(rustc --print sysroot)/lib/rustlib
checked=0
for target in x86_64-pc-windows-gnu x86_64-pc-windows-msvc aarch64-apple-darwin x86_64-apple-darwin; do
    [ -d "$libraries/$target/lib" ] || continue
    printf '== %s\n' "$target"
    # cc's name for the compiler of this target.
    case "$target" in *-apple-*) export "CC_${target//-/_}=clang" ;; esac
    cargo check --locked -p kugelblitz-cli -p kugelblitz-view --target "$target"
    checked=$((checked + 1))
done
printf '%s platforms checked\n' "$checked"
[ "$checked" -gt 0 ]
