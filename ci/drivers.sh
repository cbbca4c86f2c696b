#!/usr/bin/env bash
# Runs the device's tests on each Vulkan driver that ci/setup.sh --tests has unpacked, and writes a table of
# drivers and tests.
#
#   ci/drivers.sh TABLE [LOG]    TABLE is the file to write; LOG has what `cargo test` printed on the system's own driver,
#                                which else runs the same tests here
#   ci/drivers.sh --full TABLE   also all of the matrix, whose work is the CPU's for the most part, and the program's tests
#
# At least two drivers must have run.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

full=no
if [ "$1" = --full ]; then full=yes; shift; fi
table=$1
system_log=${2:-}

# What depends on a driver: the proofs' assumptions, the certified pictures, and what else a device makes by itself.
tests=(drivers digests hard_cases tracers trees matrix)
# That comparisons can fail, and what drivers are seen through that are spoilt, is seen once, on the system's driver.
filters=("${tests[@]/%/::}" --skip mistakes --skip other_arithmetic --skip cpu_with --skip matrix::exact --skip finite)
# Of the window one test each on Wayland and X11.
window_tests=(wayland_shows_the_same_picture the_window_shows_what_render_draws)
if [ "$full" = yes ]; then
    program_tests=(trace explain digest cli)
    tests+=(light scenes "${program_tests[@]}")
    filters=(--skip mistakes)
fi

target=$(target_folder)
# Each line: a module of tests, and "41" for 41 passed or "3 of 41 FAILED".
counts() {
    awk '
        $1 == "test" && $3 == "..." {
            file = $2; if (!sub(/::.*/, "", file)) file = "window"
            all[file]++
            if ($4 == "FAILED") failed[file]++
            if ($4 ~ /^ignored/) all[file]--
        }
        END {
            for (file in all) print file, failed[file] ? failed[file] " of " all[file] " FAILED" : all[file]
        }' "$1"
}

# The tests on one driver; its name is "system" for the one that the loader finds by itself.
run_driver() {
    local name=$1 folder=$target/drivers/$1 shown failed=0
    if [ "$name" != system ]; then
        export VK_DRIVER_FILES=$folder/icd.json
        export LD_LIBRARY_PATH=$folder${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    fi
    # It has no Xlib surfaces.
    [ "$name" = swiftshader ] && shown=("${window_tests[0]}") || shown=("${window_tests[@]}")
    printf '\n== driver %s\n' "$name"
    "$target/ci/kugelblitz" probe >"$scratch/$name.probe" 2>/dev/null || {
        echo "it opens no device"
        return 1
    }
    cat "$scratch/$name.probe"
    if [ "$name" = system ] && [ -n "$system_log" ]; then
        cp "$system_log" "$scratch/$name.log"
        return 0
    fi
    # Light of the plain kernels takes SwiftShader's memory by gigabytes.
    [ "$name" != swiftshader ] || filters+=(--skip plain_kernels --skip one_session)
    on_driver "$name" --test device -- "${filters[@]}" || failed=1
    if [ "$full" = yes ]; then on_driver "$name" --test program -- "${program_tests[@]/%/::}" || failed=1; fi
    on_driver "$name" --lib gpu:: || failed=1
    on_driver "$name" --test window -- "${shown[@]}" || failed=1
    return "$failed"
}

on_driver() { cargo test "${everything[@]}" --no-fail-fast "${@:2}" 2>&1 | tee -a "$scratch/$1.log"; }

names=(system)
missing=()
for name in mesa-backports swiftshader; do
    if [ -f "$target/drivers/$name/icd.json" ]; then names+=("$name"); else missing+=("$name"); fi
done
status=0
for name in "${names[@]}"; do
    (run_driver "$name") || status=1
    [ ! -f "$scratch/$name.log" ] || counts "$scratch/$name.log" >"$scratch/$name.counts"
done

# The value of a line of `probe`.
fact() { sed -n "s/^  $2  *//p" "$scratch/$1.probe" | head -n 1; }

row() { printf '| %s |\n' "$(printf '%s\037' "$@" | sed 's/\x1f$//; s/\x1f/ | /g')"; }

each() {
    local cells=("$1") name
    for name in "${ran[@]}"; do cells+=("$("${@:2}" "$name")"); done
    row "${cells[@]}"
}
of_driver() { local value; value=$(fact "$2" "$1"); echo "${value:--}"; }
adapter() { head -n 1 "$scratch/$1.probe"; }
count() { local found; found=$(sed -n "s/^$1 //p" "$scratch/$2.counts" | head -n 1); echo "${found:--}"; }
n_digests() { count digests "$1" | sed "s/^[0-9]*$/all $(wc -l <tests/digests.txt)/"; }

ran=()
for name in "${names[@]}"; do [ ! -f "$scratch/$name.counts" ] || ran+=("$name"); done
mkdir -p "$(dirname "$table")"
{
    echo "# Drivers"
    echo
    echo "Written by \`ci/drivers.sh\`: what each Vulkan driver is and does by the self-test, how many tests"
    echo "passed on it, and whether the pictures of all scenes have the digests of \`tests/digests.txt\`. Tests"
    echo "in f64 ask nothing of a device that has none."
    echo
    each "" adapter
    row "---" "${ran[@]/*/---}"
    for what in driver 'f64 in shaders' 'certified kernel' 'f32, measured' 'f64, measured'; do
        each "$what" of_driver "$what"
    done
    each "digests" n_digests
    for test in "${tests[@]}" window; do each "test \`$test\`" count "$test"; done
} >"$table"
printf '\n%s drivers ran: %s; %s could not be had: %s\n' "${#ran[@]}" "${ran[*]}" \
    "${#missing[@]}" "${missing[*]:--}"
if [ "${#ran[@]}" -lt 2 ]; then
    echo "ci/drivers.sh: at least two drivers must run; ci/setup.sh --tests says why one is missing" >&2
    exit 1
fi
exit "$status"
