# What the scripts of checks share; to be sourced. Each step says how many seconds it took.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

# A shell without a login does not read what rustup wrote into the profile.
command -v cargo >/dev/null || PATH="${CARGO_HOME:-${HOME:-/root}/.cargo}/bin:$PATH"

# For a script's own files; gone in the end, when the steps are told with their seconds.
scratch=$(mktemp -d)
trap 'table_of_steps; rm -rf "$scratch"' EXIT

# Mesa complains where this is missing, which is usual on machines without a desktop.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    export XDG_RUNTIME_DIR=$scratch/runtime
    mkdir -m 700 "$XDG_RUNTIME_DIR"
fi

# One selection of packages and features for all that is checked, and one for all that is built and tested, so that
# nothing is built twice. The wheel has its turn in ci/python.sh.
checked=(--profile ci --locked --workspace --exclude kugelblitz-python)
everything=("${checked[@]}" --exclude kugelblitz-benches)

took=()
step() {
    local began=$SECONDS status=0
    printf '\n== %s\n' "$*"
    "$@" || status=$?
    took+=("$(printf '%5d s  %s' $((SECONDS - began)) "$*")")
    printf '== %s s\n' $((SECONDS - began))
    return "$status"
}

# A command whose output goes into a file as well.
into() { "${@:2}" 2>&1 | tee "$1"; }

table_of_steps() {
    [ "${#took[@]}" -gt 0 ] || return 0
    printf '\n'
    printf '%s\n' "${took[@]}"
    printf '%5d s  in all\n' "$SECONDS"
}

# The folder of builds.
target_folder() {
    local found
    found=$(cargo metadata --format-version 1 --no-deps --locked |
        sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
    [ -n "$found" ] || { echo "cargo metadata names no target directory" >&2; exit 1; }
    printf '%s\n' "$found"
}
