#!/usr/bin/env bash
# Measures speed against error on this machine and puts the result into docs/report/, which the guide shows.
#
#   ci/report.sh              docs/report/lavapipe.{html,md,svg} at a moderate size; docs/report/peers.md, if other
#                             renderers are installed
#   ci/report.sh NAME [ARG…]  docs/report/NAME.{html,md,svg}; ARG go to `kugelblitz report`
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name=${1:-lavapipe}
if [ $# -eq 0 ]; then set -- --size 640x360 --samples 16384; else shift; fi
commit=$(git rev-parse --short=12 HEAD)
git diff --quiet HEAD -- Cargo.toml Cargo.lock .cargo crates src shaders scenes || commit="$commit and changes"

KUGELBLITZ_COMMIT=$commit cargo build --release --locked -p kugelblitz-cli
mkdir -p docs/report
report=docs/report/$name
target/release/kugelblitz report "$@" -o "$report.html" -o "$report.md" -o "$report.svg"
[ "$name" = lavapipe ] || exit 0

peers=$(mktemp)
trap 'rm -f "$peers"' EXIT
if ci/peers.py target/release/kugelblitz >"$peers"; then
    cat "$peers" >docs/report/peers.md
else
    echo "ci/report.sh: docs/report/peers.md is left as it was" >&2
fi
