#!/usr/bin/env bash
# Checks the licences and sources of all dependencies that a release contains, and looks up known vulnerabilities if their
# database can be reached.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

PATH=$(ci/dist/tools.sh cargo-deny)
deny=(cargo deny --workspace --exclude kugelblitz-tests --exclude kugelblitz-benches --config ci/deny.toml)
"${deny[@]}" --offline check licenses bans sources
if "${deny[@]}" fetch db 2>/dev/null; then
    "${deny[@]}" --offline check advisories
else
    echo "ci/licenses.sh: advisories not checked, their database cannot be reached" >&2
fi
