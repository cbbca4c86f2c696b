#!/usr/bin/env bash
# Prints the folder of a Rust toolchain that has the source of its standard library, which Windows' target is compiled with: no
# prebuilt one goes with zig's linker. rustup adds the source if it can. Otherwise, it comes from Debian's package of the same
# version, in a copy of the toolchain in the build folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

die() { printf 'ci/dist/toolchain.sh: %s\n' "$*" >&2; exit 1; }

sysroot=$(rustc --print sysroot)
source=lib/rustlib/src/rust/library
if [ -f "$sysroot/$source/Cargo.lock" ] || rustup component add rust-src >&2; then
    printf '%s\n' "$sysroot"
    exit 0
fi

target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
version=$(rustc --version | cut -d' ' -f2)
copy=$target/dist/toolchain-$version
if [ ! -f "$copy/$source/Cargo.lock" ]; then
    rm -rf "$copy"
    mkdir -p "$target/dist"
    # Hard links, if both folders are on one file system.
    cp -al "$sysroot" "$copy" 2>/dev/null || { rm -rf "$copy"; cp -a "$sysroot" "$copy"; }
    mirror=http://deb.debian.org/debian
    name=
    for suite in trixie-backports sid trixie; do
        name=$(curl -fsS "$mirror/dists/$suite/main/binary-all/Packages.xz" | xz -dc |
            sed -n "s|^Filename: \(.*/rust-src_${version}[^/]*\)$|\1|p" | tail -n 1)
        [ -z "$name" ] || break
    done
    [ -n "$name" ] || die "found no source of the standard library of Rust $version"
    curl -fsS -o "$copy/source.deb" "$mirror/$name"
    dpkg-deb -x "$copy/source.deb" "$copy/source"
    mkdir -p "$copy/${source%/library}"
    mv "$copy/source/usr/src/rustc-$version/library" "$copy/$source"
    rm -rf "$copy/source" "$copy/source.deb"
fi
printf '%s\n' "$copy"
