#!/usr/bin/env bash
# What a release needs beyond ci/test.sh, in hours: thousands of scenes, all drivers in full, what users' profile makes, the book, the
# browser, the package, long use of the window, other platforms, and which tests see mistakes.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

step ci/setup.sh --tests --release
step ci/test.sh

pages=(--profile ci --locked -p kugelblitz-tests --features pages --test pages)
step cargo clippy "${pages[@]}" -- -D warnings
# The packages have all files that they are built, tested and used with.
packages_are_whole() {
    local package lacks
    declare -A files=(
        [kugelblitz]="ci examples scenes shaders src Cargo.toml README.md CHANGELOG.md CONTRIBUTING.md"
        [kugelblitz-judge]="crates/judge" [kugelblitz-report]="crates/report" [kugelblitz-view]="crates/view"
        [kugelblitz-cli]="crates/cli"
    )
    for package in "${!files[@]}"; do
        # shellcheck disable=SC2086
        lacks=$(comm -23 <(git ls-files ${files[$package]} | sed "s|^crates/${package#kugelblitz-}/||" | sort) \
            <(cargo package -p "$package" --list --offline --allow-dirty | sort))
        [ -z "$lacks" ] || { printf 'the package %s lacks:\n%s\n' "$package" "$lacks"; return 1; }
    done
}
step packages_are_whole
step cargo test "${pages[@]}"
step cargo test --profile ci --locked -p kugelblitz --lib --no-default-features
# The program that users build makes the same bytes.
step cargo test --release --locked -p kugelblitz-cli
step cargo test --release --locked -p kugelblitz-tests --test device -- digests::
step ci/drivers.sh --full docs/devices/drivers.md

step env KUGELBLITZ_SCENES=5000 KUGELBLITZ_DEVICE=100 cargo test "${everything[@]}" --test device -- --nocapture matrix::
step cargo test "${everything[@]}" --test device -- --ignored trees::
step env KUGELBLITZ_ROUNDS=20 cargo test "${everything[@]}" --test window -- use_leaves_memory --nocapture
step ci/platforms.sh
step ci/spoilings.sh
echo "all green"
