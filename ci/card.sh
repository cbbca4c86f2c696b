#!/usr/bin/env bash
# Tries Kugelblitz on the Vulkan device of this machine, and writes a page about it. Builds nothing:
# the program and the campaigns' executables may come from elsewhere. Takes at most ten minutes; what
# is there already is not done again, so that a run that was stopped goes on.
#
#   ci/card.sh [--program PATH] [--campaign PATH]… [--device NAME] [--minutes N] [--out DIR]
#
#   --program PATH    the program; else target/release/kugelblitz
#   --campaign PATH   the test executable `device`, whose matrix is run with fresh seeds until
#                     their minutes are over
#   --device NAME     part of an adapter's name; else the best one
#   --minutes N       for the campaigns; else 5
#   --out DIR         for the results; else target/card
#
# The page is DIR/page.md; to keep it, copy it to docs/devices/NAME.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'card: %s\n' "$*" >&2; exit 1; }
say() { printf 'card: %s\n' "$*" >&2; }

program=target/release/kugelblitz
campaigns=()
device=gpu
minutes=5
out=target/card
while [ $# -gt 0 ]; do
    case "$1" in
        --program | --campaign | --device | --minutes | --out)
            [ $# -ge 2 ] || die "$1 wants a value" ;;
        *) die "unknown argument $1; the head of this file names them" ;;
    esac
    case "$1" in
        --program) program=$2 ;;
        --campaign) campaigns+=("$2") ;;
        --device) device=$2 ;;
        --minutes) minutes=$2 ;;
        --out) out=$2 ;;
    esac
    shift 2
done
for file in "$program" "${campaigns[@]}"; do
    [ -x "$file" ] || die "$file is no executable"
done
[[ $minutes =~ ^[0-9]+$ ]] || die "--minutes wants a number"
mkdir -p "$out"

# Those who open a device by themselves take the same one.
[ "$device" = gpu ] || export WGPU_ADAPTER_NAME=$device

# Runs a step into FILE, unless it was done there before. Its exit code goes to the file's end.
failed=0
step() {
    local file=$out/$1 code=0
    shift
    if [ "$(tail -n 1 "$file" 2>/dev/null)" != "exit code 0" ]; then
        say "$*"
        "$@" >"$file.part" 2>&1 </dev/null || code=$?
        printf 'exit code %s\n' "$code" >>"$file.part"
        mv "$file.part" "$file"
    fi
    [ "$(tail -n 1 "$file")" = "exit code 0" ] || failed=$((failed + 1))
}

scenes() { find scenes -name '*.toml' ! -path 'scenes/clouds/*' | LC_ALL=C sort; }

verify_all() {
    local scene code=0
    while read -r scene; do
        "$program" verify "$scene" --device "$device" --all-kernels --size 320x180 || code=$?
        echo
    done < <(scenes)
    return "$code"
}

compare_digests() { "$program" digest --check tests/digests.txt --device "$device" --quiet; }

run_campaigns() {
    local end=$((SECONDS + minutes * 60)) n=0 campaign
    while [ "$SECONDS" -lt "$end" ]; do
        for campaign in "${campaigns[@]}"; do
            KUGELBLITZ_SEED=$RANDOM KUGELBLITZ_DEVICE=1 "$campaign" --nocapture matrix:: || return
            n=$((n + 1))
        done
    done
    echo "$n campaigns with seeds of their own"
}

# NAME SCENE PICTURE: the median of nine runs; a PNG needs ids alone, a NPY also t and normals.
time_one() {
    local ms
    ms=$("$program" render "$2" --device "$device" --size 1920x1080 --json --quiet --repeat 9 \
        -o "$scratch/$3" |
        awk '/"ms_runs"/ { inside = 1 }
            inside && /"(trace|refine|decide)"/ { gsub(/[^0-9.]/, "", $2); run += $2 }
            inside && /}/ { print run; run = 0 }' |
        sort -g | sed -n 5p)
    awk -v name="$1" -v ms="$ms" \
        'BEGIN { printf "%-36s %9.3f ms  %9.1f Mrays/s\n", name, ms, 1920 * 1.08 / ms }'
}

time_all() {
    local n
    echo "1920 x 1080, certified, tracing with what f32 left undecided, median of nine runs"
    time_one "figure 1, ids" scenes/figure1.toml x.png
    time_one "figure 1, ids, t and normals" scenes/figure1.toml x.npy
    for n in 10000 100000 1000000; do
        "$program" generate --distribution uniform --count "$n" --seed 1 --quiet \
            -o "$scratch/$n.npy" --scene "$scratch/$n.toml"
        time_one "$n spheres, ids" "$scratch/$n.toml" x.png
        time_one "$n spheres, ids, t and normals" "$scratch/$n.toml" x.npy
    done
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

step probe.txt "$program" probe
step verify.txt verify_all
step digests.txt compare_digests
step times.txt time_all
[ ${#campaigns[@]} -eq 0 ] || step campaigns.txt run_campaigns
step report.txt "$program" report --device "$device" --rounds 1 -o "$out/report.html" -o "$out/report.md"

{
    echo "# $(head -n 1 "$out/probe.txt")"
    echo
    echo "Made by \`ci/card.sh\` on $(date -u +%F), $("$program" --version)."
    for part in probe times digests campaigns; do
        [ -e "$out/$part.txt" ] || continue
        printf '\n## %s\n\n```text\n' "${part^}"
        grep -v '^exit code 0$' "$out/$part.txt"
        echo '```'
    done
    printf '\n## Promises\n\n```text\n'
    grep -E 'promises|^scenes/|^error' "$out/verify.txt" || true
    echo '```'
    if [ -e "$out/report.md" ]; then
        printf '\n## Speed against error\n\n'
        cat "$out/report.md"
    fi
} >"$out/page.md"

if [ "$failed" -gt 0 ]; then
    say "$failed steps failed; see $out"
    exit 1
fi
say "all is well; the page is $out/page.md"
