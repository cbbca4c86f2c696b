#!/usr/bin/env bash
# Counts the instructions that work on several numbers at once in each hot function of the library, and fails where
# one has less than nine tenths of those in ci/instructions.txt: then the compiler no longer finds its numbers side by side.
# `ci/instructions.sh --renew` writes the table anew, after code was moved or made shorter on purpose.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ "$(uname -m)" != x86_64 ]; then
    echo "not counted on $(uname -m): the table is of x86_64"
    exit 0
fi
table=ci/instructions.txt
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# One unit, so that nothing is left for the linker to put in its place, nor kept from an earlier build; and names that tell
# types.
CARGO_INCREMENTAL=0 cargo rustc --release --locked --lib --no-default-features -- \
    --emit "asm=$folder/library.s" -C codegen-units=1 -C symbol-mangling-version=v0

# Each function's packed sums, products, quotients, roots and extremes.
awk '
    /^_R[^ ]*:$/ { name = substr($0, 1, length($0) - 1); packed = 0 }
    /^\tv?(add|sub|mul|div|sqrt|min|max)p[sd]\t/ { packed++ }
    /^\t\.cfi_endproc/ { print packed, name; name = "" }
' "$folder/library.s" >"$folder/functions"

# Lines of a table: what it is, how many were seen, and what the names of its versions contain.
count() {
    while read -r what seen pattern; do
        case $what in '' | '#'*) continue ;; esac
        now=$(awk -v pattern="$pattern" '$2 ~ pattern { sum += $1 } END { print sum + 0 }' "$folder/functions")
        echo "$what $seen $now $pattern"
    done <"$1"
}

check() {
    count "$1" | awk '
        { printf "%-28s %5d packed instructions, %5d seen before\n", $1, $3, $2 }
        $3 * 10 < $2 * 9 { print "  less than nine tenths of them"; bad = 1 }
        END { exit bad || NR == 0 }'
}

if [ "${1:-}" = --renew ]; then
    grep '^#' "$table" >"$folder/table"
    count "$table" | awk '{ print $1, $3, $4 }' >>"$folder/table"
    cp "$folder/table" "$table"
fi
check "$table"
# The comparison can fail: for more than there are, and for a function that is gone.
awk '!/^#/ { $2 = int($2 * 1.2) + 1 } 1' "$table" >"$folder/more"
awk '!/^#/ { $3 = "no_function" } 1' "$table" >"$folder/gone"
for wrong in more gone; do
    if check "$folder/$wrong" >/dev/null; then
        echo "ci/instructions.sh: a table that is wrong was not refused" >&2
        exit 1
    fi
done
