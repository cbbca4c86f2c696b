#!/usr/bin/env bash
# Compares Kugelblitz with other programs and prints the tables of docs/guide/src/comparison.md.
#
#   benches/peers/run.sh KUGELBLITZ            times, on a machine with nothing else to do
#   benches/peers/run.sh KUGELBLITZ accuracy   wrong pixels of Embree
#
# Variables: PYTHON, a Python with numpy, scipy and ovito; ROUNDS; SIZE of the pictures; COUNTS of spheres. Needs g++ and
# Debian's libembree-dev. Without ovito, tachyon or povray, their rows have dashes.
set -euo pipefail

[ $# -ge 1 ] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2; }
kugelblitz=$(realpath "$1")
what=${2:-speed}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
python=${PYTHON:-python3}
size=${SIZE:-1280x720}
read -ra counts <<<"${COUNTS:-10000 100000 1000000}"

read -r load _ </proc/loadavg
if [ "$what" = speed ] && awk "BEGIN { exit !($load > 0.3) }"; then
    echo "run.sh: the machine is busy (load $load): these times mean nothing" >&2
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
g++ -O3 -march=native -fno-math-errno -fno-trapping-math -std=c++17 "$here/embree_spheres.cpp" \
    -o "$folder/embree_spheres" -lembree3 -lpthread
if [ "$what" = speed ]; then
    for count in "${counts[@]}"; do
        "$kugelblitz" generate --count "$count" --seed 1 -o "$folder/cloud_$count.npy" \
            --scene "$folder/cloud_$count.toml" -q
    done
    (cd "$folder" && "$python" "$here/../../examples/drum.py")
fi
"$python" "$here/measure.py" "$what" "$folder" "$kugelblitz" "${ROUNDS:-5}" "$size" "${counts[@]}"
