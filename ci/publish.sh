#!/usr/bin/env bash
# Creates the GitHub release of a tag: checks the artefacts, lists the checksums of all of them, and takes the notes from
# CHANGELOG.md. Needs `gh`, and its token in GH_TOKEN.
#
#   ci/publish.sh TAG FOLDER...             each FOLDER is target/dist/out/ of one run of ci/dist.sh
#   ci/publish.sh --dry-run TAG FOLDER...   does everything but create the release, and prints the notes
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'ci/publish.sh: %s\n' "$*" >&2; exit 1; }

dry_run=no
if [ "${1:-}" = --dry-run ]; then dry_run=yes; shift; fi
[ $# -ge 2 ] || die "expected a tag and at least one folder"
tag=$1
shift

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
[ "$tag" = "v$version" ] || die "expected the tag v$version, as in Cargo.toml, found $tag"

place=target/dist/release
rm -rf "$place"
mkdir -p "$place/files"

# The section of this version, without its heading, the empty lines around it and the links at the end of the file.
awk -v heading="## [$version]" '
    /^## / { inside = index($0, heading) == 1; next }
    !inside || /^\[[^]]*\]: / { next }
    NF { for (; started && empty > 0; empty--) print ""; empty = 0; started = 1; print; next }
    { empty++ }
' CHANGELOG.md >"$place/notes.md"
[ -s "$place/notes.md" ] || die "CHANGELOG.md has no section [$version]"

for folder in "$@"; do
    [ -d "$folder" ] || die "$folder is not a folder"
    if [ -f "$folder/SHA256SUMS" ]; then
        (cd "$folder" && sha256sum --check --strict --quiet SHA256SUMS) || die "$folder: wrong checksums"
    fi
    for file in "$folder"/*; do
        name=${file##*/}
        [ "$name" != SHA256SUMS ] || continue
        [ -f "$file" ] || die "$file is not a file"
        # Two machines may build the same file, but not two files of the same name.
        if [ -f "$place/files/$name" ]; then
            cmp -s "$file" "$place/files/$name" || die "two different files are called $name"
        fi
        cp "$file" "$place/files/"
    done
done
(cd "$place/files" && sha256sum -- * >../SHA256SUMS && mv ../SHA256SUMS .)

arguments=("$tag" --verify-tag --title "Kugelblitz $version" --notes-file "$place/notes.md")
# A version such as 0.2.0-rc.1.
[ "${version#*-}" = "$version" ] || arguments+=(--prerelease)
if [ "$dry_run" = yes ]; then
    cat "$place/notes.md"
    printf '\n%s\n' "Not created: gh release create ${arguments[*]}"
    cat "$place/files/SHA256SUMS"
    exit 0
fi
gh release create "${arguments[@]}" "$place"/files/*
