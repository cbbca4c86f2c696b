#!/usr/bin/env bash
# All checks of the repository, on a Debian machine with Rust and nothing else prepared; ci/release.sh has those that take
# hours, or what a release alone needs. A second run rebuilds nothing.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

step ci/setup.sh --tests
step cargo fmt --all --check
step cargo clippy "${checked[@]}" --all-targets -- -D warnings
# The program as the README builds it, and the libraries on the CPU.
step cargo clippy --profile ci --locked -p kugelblitz-cli -- -D warnings
step cargo clippy --profile ci --locked -p kugelblitz -p kugelblitz-judge --lib --no-default-features -- -D warnings
step env RUSTDOCFLAGS="-D warnings" cargo doc "${checked[@]}" --no-deps
step cargo test "${everything[@]}" --no-run
step ci/instructions.sh

target=$(target_folder)
# A driver may be installed for a device that this machine does not have.
probe=0
step "$target/ci/kugelblitz" probe || probe=$?
if [ "$probe" -eq 4 ]; then
    step ci/setup.sh --tests --software-driver
    step "$target/ci/kugelblitz" probe
elif [ "$probe" -ne 0 ]; then
    exit "$probe"
fi

tests=0
step ci/answers.sh "$target/ci/kugelblitz" || tests=$?

gpu_log=$target/ci/gpu-tests.log
rm -f "$gpu_log"
system_log=$target/system-driver.log
step into "$system_log" cargo test "${everything[@]}" --no-fail-fast || tests=$?
step ci/drivers.sh "$target/drivers.md" "$system_log" || tests=$?
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
