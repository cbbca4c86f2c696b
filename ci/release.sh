#!/usr/bin/env bash
# What a release needs beyond ci/test.sh, in hours: thousands of scenes, all drivers in full, what users' profile makes, the book, the
# browser, long use of the window, other platforms, licences, the artefacts, and which tests see mistakes.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

step ci/setup.sh --tests --release
step ci/test.sh

pages=(--profile ci --locked -p kugelblitz-tests --features pages --test pages)
step cargo clippy "${pages[@]}" -- -D warnings
step cargo test "${pages[@]}"
step cargo test --profile ci --locked -p kugelblitz --lib --no-default-features
# The program that users build makes the same bytes.
step cargo test --release --locked -p kugelblitz-cli
step cargo test --release --locked -p kugelblitz-tests --test device -- digests::
step ci/drivers.sh --full docs/devices/drivers.md

step env KUGELBLITZ_SCENES=5000 KUGELBLITZ_DEVICE=100 cargo test "${everything[@]}" --test device -- --nocapture matrix::
step cargo test "${everything[@]}" --test device -- --ignored trees::
step cargo test "${everything[@]}" --test window -- --ignored use_leaves_memory --nocapture
step ci/platforms.sh
step ci/licenses.sh
step ci/workflows.sh
step ci/site.sh
step ci/dist.sh
step ci/spoilings.sh
echo "all green"
