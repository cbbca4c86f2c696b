#!/usr/bin/env bash
# Builds everything that a release offers into target/dist/out, on a Debian machine with Rust, and tries it. docs/releasing.md
# describes each file.
#
#   ci/dist.sh             all steps below but `native`, in this order
#   ci/dist.sh STEP…       linux wheel windows crates sbom again try sums
#   ci/dist.sh native      an archive and a wheel for this machine only, without cross compilation
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

die() { printf 'ci/dist.sh: %s\n' "$*" >&2; exit 1; }

root=$PWD
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
target=$(target_folder)
place=$target/dist
out=$place/out
mkdir -p "$out"
git diff --quiet HEAD || echo "ci/dist.sh: there are uncommitted changes; a release is built from a clean checkout" >&2

# Equal bytes in every folder and at every time: no paths, and the date of the commit.
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
KUGELBLITZ_COMMIT=$(git rev-parse --short=12 HEAD)
RUSTFLAGS="--remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}/registry/src=registry --remap-path-prefix=$root=kugelblitz"
export SOURCE_DATE_EPOCH KUGELBLITZ_COMMIT RUSTFLAGS
build=$place/build

linux=x86_64-unknown-linux-gnu
# The oldest C library that programs and wheels run with, as in manylinux2014.
glibc=2.17

# Fills the folder $1 with what goes along with the program $3 of the package $2.
add_texts() {
    local folder=$1 package=$2 program=$3
    sed "s/@PROGRAM@/$program/g; s/@VERSION@/$version/g" ci/dist/INSTALL.md >"$folder/INSTALL.md"
    cp LICENSE-MIT LICENSE-APACHE CHANGELOG.md "$folder"
    { echo 'ignore-dev-dependencies = true'
      sed -n '/^allow = \[/,/^\]/{s/^allow/accepted/;p;}' ci/deny.toml; } >"$scratch/about.toml"
    cargo about -L error generate --offline --locked -m "crates/$package/Cargo.toml" -c "$scratch/about.toml" \
        ci/dist/licenses.hbs -o "$scratch/licenses.txt"
    # Own crates are listed once for each of their licence files.
    sed '$!N; /^\(  kugelblitz.*\)\n\1$/!P; D' "$scratch/licenses.txt" >"$folder/LICENSES-DEPENDENCIES.txt"
}

# Adds manual pages, completions and scenes, written by the native program $2.
add_extras() {
    local folder=$1 program=$2 shell
    "$program" man --dir "$folder/man/man1" -q
    mkdir "$folder/completions" "$folder/man/man5"
    mv "$folder"/man/man1/*.5 "$folder/man/man5"
    for shell in bash zsh fish; do "$program" completions "$shell" >"$folder/completions/kugelblitz.$shell"; done
    git archive HEAD scenes | tar -x -f - -C "$folder"
}

# Packs the folder $1 as $1.tar.gz.
pack() {
    tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw \
        -C "$(dirname "$1")" -c "$(basename "$1")" | gzip -9 -n >"$out/$(basename "$1").tar.gz"
}

fresh_folder() { rm -rf "$1"; mkdir -p "$1"; }

# Archives for Linux: the program, and the window.
linux() {
    PATH=$(ci/dist/tools.sh python cargo-about)
    local folder=$place/archive/kugelblitz-$version-x86_64-linux built=$build/$linux/release
    cargo zigbuild --target-dir "$build" --release --locked -p kugelblitz-cli --target "$linux.$glibc"
    fresh_folder "$folder"
    cp "$built/kugelblitz" "$folder"
    add_texts "$folder" cli kugelblitz
    add_extras "$folder" "$folder/kugelblitz"
    pack "$folder"

    folder=$place/archive/kugelblitz-view-$version-x86_64-linux
    cargo zigbuild --target-dir "$build" --release --locked -p kugelblitz-view --target "$linux.$glibc"
    fresh_folder "$folder"
    cp "$built/kugelblitz-view" "$folder"
    add_texts "$folder" view kugelblitz-view
    pack "$folder"
}

# The source package of the Python module, and from it the wheel, which also contains the command.
wheel() {
    PATH=$(ci/dist/tools.sh python)
    local source=$place/sdist
    fresh_folder "$source"
    rm -f "$out"/kugelblitz-*.whl "$out/kugelblitz-$version.tar.gz"
    maturin sdist --manifest-path python/Cargo.toml --out "$out"
    tar xzf "$out/kugelblitz-$version.tar.gz" -C "$source" --strip-components 1
    # Without --locked: the lock file also has packages that this part of the workspace does not use.
    maturin build --target-dir "$build" --release --zig --target $linux \
        --compatibility manylinux2014 --manifest-path "$source/python/Cargo.toml" --out "$out"
    twine check --strict "$out"/*.whl "$out/kugelblitz-$version.tar.gz"
    auditwheel show "$out"/kugelblitz-"$version"-*.whl | grep -F manylinux_2_17_x86_64 ||
        die "the wheel needs a newer C library than $glibc"
}

# The program and the window for Windows, compiled on Linux with zig's C library and a standard library built from source.
windows() {
    PATH=$(ci/dist/tools.sh python cargo-about)
    local windows=x86_64-pc-windows-gnu folder=$place/archive/kugelblitz-$version-x86_64-windows toolchain
    toolchain=$(ci/dist/toolchain.sh)
    (
        PATH=$toolchain/bin:$PATH
        export RUSTC_BOOTSTRAP=1 CARGO=$toolchain/bin/cargo
        cargo zigbuild --target-dir "$build" --release --locked -p kugelblitz-cli -p kugelblitz-view --target $windows \
            -Zbuild-std=std,panic_unwind
    )
    fresh_folder "$folder"
    cp "$build/$windows/release"/kugelblitz{,-view}.exe "$folder"
    add_texts "$folder" view kugelblitz
    git archive HEAD scenes | tar -x -f - -C "$folder"
    ci/dist/zip.py "$folder" "$out/kugelblitz-$version-x86_64-windows.zip" "$SOURCE_DATE_EPOCH"
}

# The packages for crates.io, each built once from its archive.
crates() {
    rm -f "$out"/*.crate
    cargo package --workspace --exclude kugelblitz-tests --exclude kugelblitz-benches --exclude kugelblitz-python \
        --locked --target-dir "$build" 2>&1 | tee "$scratch/crates.log"
    ! grep -n '^warning' "$scratch/crates.log" || die "cargo package warns, see above"
    cp "$build"/package/*-"$version".crate "$out"
}

# Bills of materials in CycloneDX format. The wheel contains its own.
sbom() {
    PATH=$(ci/dist/tools.sh cargo-cyclonedx)
    local name
    rm -f "$out"/*.cdx.json
    for name in cli view; do
        cargo cyclonedx -q --manifest-path "crates/$name/Cargo.toml" --format json --spec-version 1.5 --target $linux \
            --no-build-deps --override-filename kugelblitz-release.cdx
        mv "crates/$name/kugelblitz-release.cdx.json" "$out/kugelblitz-$name-$version.cdx.json"
        git ls-files -o '*kugelblitz-release.cdx.json' | xargs -r rm
    done
}

# Builds the archives for Linux once more, from a clone in another folder: equal bytes, or a failure.
again() {
    local clone=$scratch/elsewhere file
    git clone -q --no-hardlinks "$root" "$clone"
    git -C "$clone" checkout -q "$(git rev-parse HEAD)"
    mkdir -p "$clone/target/dist"
    ln -s "$place/tools" "$clone/target/dist/tools"
    (cd "$clone" && env -u RUSTFLAGS ci/dist.sh linux)
    for file in "$clone"/target/dist/out/*.tar.gz; do
        cmp "$file" "$out/$(basename "$file")"
    done
}

# Checksums of all files.
sums() {
    (cd "$out" && rm -f SHA256SUMS && sha256sum -- * >"$scratch/sums" && mv "$scratch/sums" SHA256SUMS && ls -l)
}

# For machines that the steps above do not cover.
native() {
    local name folder
    name=kugelblitz-$version-$(uname -m)-$(uname -s | tr '[:upper:]' '[:lower:]')
    folder=$place/archive/$name
    PATH=$(ci/dist/tools.sh python cargo-about)
    cargo build --target-dir "$build" --release --locked -p kugelblitz-cli
    fresh_folder "$folder"
    cp "$build/release/kugelblitz" "$folder"
    add_texts "$folder" cli kugelblitz
    add_extras "$folder" "$folder/kugelblitz"
    tar -C "$place/archive" -cz -f "$out/$name.tar.gz" "$name"
    maturin build --target-dir "$build" --release --locked --manifest-path python/Cargo.toml --out "$out"
}

try() { ci/dist/try.sh "$out" "$version"; }

[ $# -gt 0 ] || set -- linux wheel windows crates sbom again try sums
for name in "$@"; do
    case "$name" in
        linux | wheel | windows | crates | sbom | again | try | sums | native) ;;
        *) die "unknown step $name" ;;
    esac
done
# Each step runs in a new process: bash ignores failures inside a function that `step` calls.
if [ $# -eq 1 ]; then
    "$1"
else
    for name in "$@"; do step ci/dist.sh "$name"; done
fi
