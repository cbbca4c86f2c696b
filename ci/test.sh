#!/usr/bin/env bash
# All checks of the repository, on a Debian machine with Rust and nothing else prepared.
# A second run rebuilds nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

# A shell without a login does not read what rustup wrote into the profile.
command -v cargo >/dev/null || PATH="${CARGO_HOME:-${HOME:-/root}/.cargo}/bin:$PATH"

step() {
    printf '\n== %s\n' "$*"
    "$@"
}

step ci/setup.sh --tests

# Mesa complains where this is missing, which is usual on machines without a desktop.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    XDG_RUNTIME_DIR=$(mktemp -d)
    export XDG_RUNTIME_DIR
    trap 'rm -rf "$XDG_RUNTIME_DIR"' EXIT
fi

# One profile and one lock file for everything, so that nothing is built twice.
step cargo fmt --all --check
step cargo clippy --release --locked --features view --all-targets -- -D warnings
# The library that traces on the CPU, and the program without its window.
step cargo clippy --release --locked --no-default-features --all-targets -- -D warnings
step cargo clippy --release --locked -- -D warnings
step env RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --features view --no-deps
step ci/instructions.sh
# Builds the program as well, with the features that the tests' dependencies ask for: a plain build
# would compile the largest dependencies a second time.
step cargo test --release --locked --features view --no-run

target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
[ -d "$target" ] || { echo "ci/test.sh: cargo metadata names no target directory" >&2; exit 1; }

# A driver may be installed for a device that this machine does not have.
probe=0
step "$target/release/kugelblitz" probe || probe=$?
if [ "$probe" -eq 4 ]; then
    step ci/setup.sh --tests --software-driver
    step "$target/release/kugelblitz" probe
elif [ "$probe" -ne 0 ]; then
    exit "$probe"
fi

gpu_log="$target/gpu-tests.log"
rm -f "$gpu_log"
tests=0
system_log="$target/system-driver.log"
step cargo test --release --locked --features view --no-fail-fast 2>&1 | tee "$system_log" || tests=$?
# The table that is checked in is renewed by `ci/drivers.sh docs/devices/drivers.md`.
step ci/drivers.sh "$target/drivers.md" "$system_log" || tests=$?
step cargo test --release --locked --no-default-features --no-fail-fast || tests=$?
step ci/python.sh --reuse || tests=$?

# Each line: a test, "on", its adapter and driver. Absence is a failure.
printf '\n== GPU tests\n'
if [ ! -s "$gpu_log" ]; then
    echo "0 GPU tests ran: no Vulkan device was opened" >&2
    exit 1
fi
cut -d' ' -f3- "$gpu_log" | sort -u | while read -r device; do
    printf '%s GPU tests ran on %s\n' "$(grep -F " on $device" "$gpu_log" | sort -u | wc -l)" "$device"
done
if [ "$tests" -ne 0 ]; then
    echo "tests failed; the list is above" >&2
    exit "$tests"
fi
echo "all green"
