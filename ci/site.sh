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

# Links out of the book lead to the report next to it, or to files on the web page of the repository.
find "$site" -name '*.html' ! -name report.html -exec sed -Ei \
    -e 's#href="\.\./\.\./report/lavapipe\.html#href="report.html#g' \
    -e "s#href=\"\.\./\.\./\.\./([^\"]*)\"#href=\"$repository/blob/main/\1\"#g" \
    -e "s#href=\"\.\./\.\./([^\"]*)\.html([^\"]*)\"#href=\"$repository/blob/main/docs/\1.md\2\"#g" {} +
# Every address of a file has its file.
dead=$(grep -rhoE "$repository/blob/main/[^\"#]+" "$site" --include='*.html' | sort -u | sed "s#^$repository/blob/main/##" |
    while read -r path; do [ -e "$path" ] || echo "$path"; done)
[ -z "$dead" ] || die "links to files that do not exist: $dead"
