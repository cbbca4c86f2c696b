#!/usr/bin/env bash
# Counts the instructions that work on several numbers at once in each hot function of the library, and the calls that it makes.
# Fails where one has less than nine tenths of the instructions in ci/instructions.txt: then the compiler no longer finds its
# numbers side by side; or many more calls: then these go through memory.
# `ci/instructions.sh --renew` writes the table anew, after code was moved or made shorter on purpose.
# shellcheck source=ci/steps.sh
source "$(dirname "${BASH_SOURCE[0]}")/steps.sh"

if [ "$(uname -m)" != x86_64 ]; then
    echo "not counted on $(uname -m): the table is of x86_64"
    exit 0
fi
table=ci/instructions.txt

# The library that the tests are built of.
[ -z "${RUSTFLAGS:-}" ] || { echo "ci/instructions.sh: RUSTFLAGS takes the place of .cargo/config.toml" >&2; exit 1; }
library=$(cargo test -q "${everything[@]}" --no-run --message-format json |
    sed -n 's/.*"filenames":\["\([^"]*libkugelblitz-[0-9a-f]*\.rlib\)".*/\1/p' | tail -n 1)

# Each function's packed sums, products, quotients, roots and extremes, and its calls.
objdump -d --no-show-raw-insn "$library" | awk '
    /^[0-9a-f]+ <.*>:$/ { if (name) print packed, calls, name; name = $2; packed = calls = 0 }
    $2 ~ /^v?(add|sub|mul|div|sqrt|min|max)p[sd]$/ { packed++ }
    $2 == "call" { calls++ }
    END { print packed, calls, name }
' >"$scratch/functions"

# Lines of a table: what it is, how many instructions and calls were seen, what the names of its versions contain, and how many
# there are now.
count() {
    while read -r what packed calls pattern; do
        case $what in '' | '#'*) continue ;; esac
        now=$(awk -v pattern="$pattern" '
            $3 ~ pattern { packed += $1; calls += $2 } END { print packed + 0, calls + 0 }' "$scratch/functions")
        echo "$what $packed $calls $pattern $now"
    done <"$1"
}

check() {
    count "$1" | awk '
        { printf "%-28s %5d packed instructions, %5d seen before; %4d calls, %4d before\n", $1, $5, $2, $6, $3 }
        $5 * 10 < $2 * 9 { print "  less than nine tenths of the instructions"; bad = 1 }
        $6 > $3 * 3 / 2 + 4 { print "  half as many calls again"; bad = 1 }
        END { exit bad || NR == 0 }'
}

if [ "${1:-}" = --renew ]; then
    grep '^#' "$table" >"$scratch/table"
    count "$table" | awk '{ print $1, $5, $6, $4 }' >>"$scratch/table"
    cp "$scratch/table" "$table"
fi
check "$table"
# The comparison can fail: for more instructions than there are, for fewer calls, and for a function that is gone.
awk '!/^#/ { $2 = int($2 * 1.2) + 1 } 1' "$table" >"$scratch/more"
awk '!/^#/ { $3 = int($3 / 2) - 5 } 1' "$table" >"$scratch/fewer"
awk '!/^#/ { $4 = "no_function" } 1' "$table" >"$scratch/gone"
for wrong in more fewer gone; do
    if check "$scratch/$wrong" >/dev/null; then
        echo "ci/instructions.sh: a table that is wrong was not refused" >&2
        exit 1
    fi
done
