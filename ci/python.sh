#!/usr/bin/env bash
# Builds the Python package as a wheel and tests it as it is installed: in an empty environment, outside of
# the source tree. What it downloads stays in the build folder, so that a second run needs no network.
#
#   ci/python.sh            builds the wheel; build the program first: `cargo build --profile ci -p kugelblitz-cli`
#   ci/python.sh --reuse    with the program of ci/test.sh; fails where the wheel is not built of what the tests were built of
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'ci/python.sh: %s\n' "$*" >&2; exit 1; }
said=$SECONDS
took() { printf 'ci/python.sh: %s s %s\n' "$((SECONDS - said))" "$*"; said=$SECONDS; }

reuse=${1:-}
[ -z "$reuse" ] || [ "$reuse" = --reuse ] || die "unknown argument $reuse; there is --reuse"
root=$PWD
target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
[ -d "$target" ] || die "cargo metadata names no target directory"
place=$target/python

# Of several Pythons, the first that is new enough and can make environments.
python=
for name in python3 python3.{14,13,12,11,10} /usr/bin/python3; do
    if "$name" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
        python=$(command -v "$name")
        break
    fi
done
[ -n "$python" ] || die "no Python 3.10 or later with venv is there; ci/setup.sh --tests installs one"

# All packages, once for each state of the list.
state=$({ "$python" --version; cat python/requirements.txt; } | sha256sum | cut -d' ' -f1)
if [ "$(cat "$place/state" 2>/dev/null)" != "$state" ]; then
    rm -rf "$place"
    mkdir -p "$place"
    "$python" -m venv "$place/tools"
    "$place/tools/bin/pip" -q --disable-pip-version-check download --only-binary :all: \
        -d "$place/packages" -r python/requirements.txt
    "$place/tools/bin/pip" -q --disable-pip-version-check install --no-index \
        --find-links "$place/packages" maturin twine
    echo "$state" >"$place/state"
    took "fetched packages"
fi

# The features of the tests, so that only the bindings are compiled.
rm -rf "$place/wheel" "$target"/maturin/pyo3-config-*
"$place/tools/bin/maturin" build --profile ci --locked --manifest-path python/Cargo.toml \
    --features as-tested,extension-module --interpreter "$place/tools/bin/python" --out "$place/wheel" \
    2>&1 | tee "$place/build.log"
if [ -n "$reuse" ] && grep -q 'Compiling kugelblitz v' "$place/build.log"; then
    die "the library was compiled a second time: the package's feature as-tested gives a dependency other \
features than the tests do (compare cargo tree -e features of both)"
fi
wheels=("$place"/wheel/*.whl)
took "built ${wheels[0]##*/}"

# The source package has every file that the wheel is built from; ci/dist.sh builds its wheel from there.
rm -rf "$place/sdist"
"$place/tools/bin/maturin" sdist --manifest-path python/Cargo.toml --out "$place/sdist" 2>"$place/sdist.log" ||
    { cat "$place/sdist.log"; die "no source package"; }
sources=("$place"/sdist/*.tar.gz)
lacks=$(comm -23 <(git ls-files src shaders crates/{cli,judge,report}/{src,Cargo.toml} crates/cli/build.rs python/src | sort) \
    <(tar tzf "${sources[0]}" | cut -d/ -f2- | sort))
[ -z "$lacks" ] || die "${sources[0]##*/} lacks $lacks"
"$place/tools/bin/twine" check --strict "${wheels[@]}" "${sources[0]}"
took "packed ${sources[0]##*/}"

# As maturin calls cargo, so that the bindings' dependencies stay as they are.
configurations=("$target"/maturin/pyo3-config-*.txt)
PYO3_BUILD_EXTENSION_MODULE=1 PYO3_CONFIG_FILE=${configurations[0]} PYO3_PYTHON=$place/tools/bin/python \
    cargo clippy -q --profile ci --locked -p kugelblitz-python --all-targets \
    --features as-tested,extension-module -- -D warnings
took "clippy"

rm -rf "$place/environment"
"$python" -m venv "$place/environment"
"$place/environment/bin/pip" -q --disable-pip-version-check install --no-index \
    --find-links "$place/packages" "kugelblitz[test] @ file://${wheels[0]}"
took "installed it into an empty environment"

elsewhere=$(mktemp -d)
trap 'rm -rf "$elsewhere"' EXIT
cd "$elsewhere"
KUGELBLITZ=$target/ci/kugelblitz "$place/environment/bin/python" -m pytest -p no:cacheprovider \
    -c "$root/python/pyproject.toml" --durations 5 "$root/python/tests"
took "tests"
