#!/usr/bin/env bash
# Builds the web site into target/site: the guide as a book, the report next to it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'ci/site.sh: %s\n' "$*" >&2; exit 1; }

PATH=$(ci/dist/tools.sh mdbook)
site=$PWD/target/site
repository=$(sed -n 's/^repository = "\(.*\)"/\1/p' Cargo.toml)
rm -rf "$site"
mdbook build docs/guide --dest-dir "$site" 2>&1 | tee target/site.log
! grep -E 'WARN|ERROR' target/site.log || die "mdBook warns, see above"
cp docs/report/lavapipe.html "$site/report.html"

# Links out of the book lead to files of the repository, and so to its web page.
find "$site" -name '*.html' ! -name report.html -exec \
    sed -Ei "s#(href|src)=\"(\.\./)+([A-Za-z][^\":]*)\"#\1=\"$repository/blob/main/\3\"#g" {} +
