#!/usr/bin/env bash
# A look before a commit: format, lints, the library's own tests, scenes against the oracle and digests on the CPU.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

engine=(--profile ci --locked -p kugelblitz -p kugelblitz-tests)
step cargo fmt --all --check
step cargo clippy "${engine[@]}" --all-targets -- -D warnings
step cargo test -q "${engine[@]}" --lib
step env KUGELBLITZ_SCENES=17 cargo test -q "${engine[@]}" --test device -- \
    matrix::the_cpu digests::digests_on_the_cpu
