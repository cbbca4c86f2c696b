#!/usr/bin/env bash
# Runs the tests that open a Vulkan device on each driver that ci/setup.sh --tests has unpacked, and
# writes a table of drivers and tests.
#
#   ci/drivers.sh TABLE [LOG]  TABLE is the file to write; LOG has what `cargo test` printed on the
#                              system's own driver, which else runs the same tests here
#
# At least two drivers must have run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

table=$1
system_log=${2:-}

# What depends on a driver: parity, the proofs' assumptions, the certified pictures, and the commands.
tests=(drivers digests parity proposals hard_cases hard_scenes hierarchy promise campaign certified scenes
    orthographic light light_campaign trace explain cli)
# Of the window one test each on Wayland and X11.
window_tests=(wayland_shows_the_same_picture the_window_shows_what_render_draws)

target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Each line: a test's file, and "41" for 41 passed or "3 of 41 FAILED".
counts() {
    awk '
        $1 == "Running" { file = $2; sub(/.*\//, "", file); sub(/\.rs$/, "", file) }
        /^test result:/ {
            passed = $4; failed = $6
            print file, failed == 0 ? passed : failed " of " passed + failed " FAILED"
        }' "$1"
}

# The tests on one driver; its name is "system" for the one that the loader finds by itself.
run_driver() {
    local name=$1 folder=$target/drivers/$1 test arguments=() shown failed=0
    for test in "${tests[@]}"; do arguments+=(--test "$test"); done
    if [ "$name" != system ]; then
        export VK_DRIVER_FILES=$folder/icd.json
        export LD_LIBRARY_PATH=$folder${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    fi
    # It has no Xlib surfaces.
    [ "$name" = swiftshader ] && shown=("${window_tests[0]}") || shown=("${window_tests[@]}")
    printf '\n== driver %s\n' "$name"
    "$target/release/kugelblitz" probe >"$work/$name.probe" 2>/dev/null || {
        echo "it opens no device"
        return 1
    }
    cat "$work/$name.probe"
    if [ "$name" = system ] && [ -n "$system_log" ]; then
        cp "$system_log" "$work/$name.log"
        return 0
    fi
    cargo test --release --locked --features view --no-fail-fast "${arguments[@]}" 2>&1 |
        tee "$work/$name.log" || failed=1
    cargo test --release --locked --features view --lib gpu:: 2>&1 | tee "$work/$name.unit" || failed=1
    cargo test --release --locked --features view --test view -- "${shown[@]}" 2>&1 |
        tee -a "$work/$name.log" || failed=1
    return "$failed"
}

names=(system)
missing=()
for name in mesa-backports swiftshader; do
    if [ -f "$target/drivers/$name/icd.json" ]; then names+=("$name"); else missing+=("$name"); fi
done
status=0
for name in "${names[@]}"; do
    (run_driver "$name") || status=1
    [ ! -f "$work/$name.log" ] || counts "$work/$name.log" >"$work/$name.counts"
done

# The value of a line of `probe`.
fact() { sed -n "s/^  $2  *//p" "$work/$1.probe" | head -n 1; }

row() { printf '| %s |\n' "$(printf '%s\037' "$@" | sed 's/\x1f$//; s/\x1f/ | /g')"; }

each() {
    local cells=("$1") name
    for name in "${ran[@]}"; do cells+=("$("${@:2}" "$name")"); done
    row "${cells[@]}"
}
of_driver() { local value; value=$(fact "$2" "$1"); echo "${value:--}"; }
adapter() { head -n 1 "$work/$1.probe"; }
count() { local found; found=$(sed -n "s/^$1 //p" "$work/$2.counts" | head -n 1); echo "${found:--}"; }
n_digests() { count digests "$1" | sed "s/^[0-9]*$/all $(wc -l <tests/digests.toml)/"; }

ran=()
for name in "${names[@]}"; do [ ! -f "$work/$name.counts" ] || ran+=("$name"); done
mkdir -p "$(dirname "$table")"
{
    echo "# Drivers"
    echo
    echo "Written by \`ci/drivers.sh\`: what each Vulkan driver is and does by the self-test, how many tests"
    echo "passed on it, and whether the pictures of all scenes have the digests of \`tests/digests.toml\`. Tests"
    echo "in f64 ask nothing of a device that has none."
    echo
    each "" adapter
    row "---" "${ran[@]/*/---}"
    for what in driver 'f64 in shaders' 'certified kernel' 'f32, measured' 'f64, measured'; do
        each "$what" of_driver "$what"
    done
    each "digests" n_digests
    for test in "${tests[@]}" view; do each "test \`$test\`" count "$test"; done
} >"$table"
printf '\n%s drivers ran: %s; %s could not be had: %s\n' "${#ran[@]}" "${ran[*]}" \
    "${#missing[@]}" "${missing[*]:--}"
if [ "${#ran[@]}" -lt 2 ]; then
    echo "ci/drivers.sh: at least two drivers must run; ci/setup.sh --tests says why one is missing" >&2
    exit 1
fi
exit "$status"
