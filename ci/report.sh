#!/usr/bin/env bash
# Measures speed against error on this machine and puts the result into docs/report/ and README.md.
#
#   ci/report.sh              docs/report/lavapipe.{html,md,svg}, and the README's table from it
#   ci/report.sh NAME [ARG…]  docs/report/NAME.{html,md,svg}; ARG go to `kugelblitz report`
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name=${1:-lavapipe}
[ $# -eq 0 ] || shift
commit=$(git rev-parse --short=12 HEAD)
git diff --quiet HEAD -- Cargo.toml Cargo.lock src shaders scenes || commit="$commit and changes"

KUGELBLITZ_COMMIT=$commit cargo build --release --locked
mkdir -p docs/report
report=docs/report/$name
target/release/kugelblitz report --peers "$@" -o "$report.html" -o "$report.md" -o "$report.svg"

# The README shows the one of lavapipe, between its two marks.
if [ "$name" = lavapipe ]; then
    readme=$(mktemp)
    trap 'rm -f "$readme"' EXIT
    awk -v table="$report.md" '
        /^<!-- end of the report -->$/ { inside = 0 }
        !inside
        /^<!-- begin of the report, made by ci\/report.sh -->$/ {
            inside = 1
            print ""
            while ((getline line < table) > 0) print line
            print ""
        }' README.md >"$readme"
    cat "$readme" >README.md
fi
