#!/usr/bin/env bash
# Which tests see mistakes: those of tests/device/matrix/spoilings.toml, and each constant of its bounds halved. Prints a
# table, and those that no test sees and no comment explains.
#
#   ci/spoilings.sh                        all, with the tests matrix, lemmas and lib
#   ci/spoilings.sh --match 'bound|sky'    those whose name has a match
#   ci/spoilings.sh --tests 'matrix lib'   these tests; `lib` are the library's own
#   ci/spoilings.sh --factor 0             constants times this
#
# A scratch copy of the commit has a switch for each, so that it is built once; a variable of the environment says which
# one is on. Where it does not build so, mistakes that are not of constants are built one by one.
# The build folder is CARGO_TARGET_DIR, else target/spoilings. A test that takes ten minutes has seen it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

match=. tests="matrix lemmas lib" factor=0.5
while [ $# -gt 0 ]; do
    case $1 in
    --match) match=$2 ;;
    --tests) tests=$2 ;;
    --factor) factor=$2 ;;
    *) sed -n '2,13s/^# \?//p' "$0" >&2; exit 2 ;;
    esac
    shift 2
done
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target/spoilings}
scratch=$(mktemp -d)
trap 'git worktree remove --force "$scratch/tree"; rm -rf "$scratch"' EXIT
git worktree add --quiet --detach "$scratch/tree" HEAD
python3 - "$scratch/tree" "$match" "$tests" "$factor" <<'PYTHON'
import json, os, pathlib, re, subprocess, sys, tomllib

tree, match, tests, factor = pathlib.Path(sys.argv[1]), re.compile(sys.argv[2]), sys.argv[3].split(), sys.argv[4]
PACKAGES = "--workspace --exclude kugelblitz-python --exclude kugelblitz-benches".split()
# What the numbers of a row are multiplied by: 1 where it is not switched on.
SWITCH = """
#[doc(hidden)]
#[allow(missing_docs)]
pub fn spoilt(row: usize) -> f64 {
    static ON: std::sync::LazyLock<Option<(usize, f64)>> = std::sync::LazyLock::new(|| {
        let text = std::env::var("KUGELBLITZ_SPOILT").ok()?;
        let (row, factor) = text.split_once(' ')?;
        Some((row.parse().ok()?, factor.parse().ok()?))
    });
    ON.map_or(1.0, |(on, factor)| if on == row { factor } else { 1.0 })
}
"""
BEGIN = r"^(?P<begin> *(?:pub(?:\(\w+\))? )?)"
NUMBER = re.compile(BEGIN + r"const (?P<name>\w+): (?P<kind>f64|f32) = (?P<one>1\.0 [+-] )?(?P<value>[^;]*);", re.M)
PART = re.compile(r"\b(offset|direction): (\d[\d.]*)(?=[^\n]*\})")
CONSTANT = re.compile(BEGIN + r"const (?P<name>\w+): (?P<kind>[^=\n]+) =\s(?P<value>.*?);$", re.M | re.S)
NOT_CODE = BEGIN + r"use [^;]*;|//[^\n]*"
rows = []


class Row:
    """A line of the table. `comment` may say why no test sees it."""

    def __init__(self, name, comment="", spoiling=None):
        self.number, self.name, self.spoiling = len(rows), name, spoiling
        self.fits, self.is_built, self.is_explained = True, False, False
        self.explain(comment)
        rows.append(self)

    def explain(self, comment):
        reasons = ("no test", "not covered by a test")
        self.is_explained |= any(reason in words(comment) for reason in reasons)


def words(comment):
    return re.sub(r"\s*//[/!]?\s*", " ", comment).lower()


def comment_above(text, at):
    return re.search(r"(^ *//.*\n)*\Z", text[: text.rfind("\n", 0, at) + 1], re.M).group()


def with_factors(file, text):
    """The text with a switch for each constant of a bound. In a sum with 1 the 1 stays."""
    code, *unit_tests = re.split(r"(?m)^(?=#\[cfg\(test\)\]\nmod \w+ \{)", text, maxsplit=1)
    stem = file.removeprefix("src/").removesuffix(".rs")

    def number(found):
        begin, name, kind, one, value = found.groups(default="")
        comment = comment_above(code, found.start("name"))
        if any(phrase in words(comment) for phrase in ("no bound", "not a bound")):
            return found.group()
        # A trait's is a function in all its places; half of nothing is nothing.
        row = "usize::MAX" if value == "0.0" else Row(f"{stem}: {name} = {one}{value}", comment).number
        return f"{begin}const {name}: {kind} = {one}crate::spoilt({row}) as {kind} * ({value});"

    def part(found):
        line = code[code.rfind("\n", 0, found.start()) + 1 :].split("\n")[0]
        row = Row(f"{stem}: {found[1]} of {line[line.rindex('{') :].rstrip(',;')}", comment_above(code, found.start()))
        return f"{found[1]}: crate::spoilt({row.number}) * {found[2]}"

    code = NUMBER.sub(number, code)
    code = PART.sub(part, code)
    return "".join([code, *unit_tests])


def with_switch(texts, row):
    """The texts with a mistake behind its switch."""
    file, find, halve = (row.spoiling.get(key) for key in ["file", "find", "halve"])
    text = texts.get(file, "")
    row.fits = text.count(find) == 1 and (not halve or find.count(halve) == 1)
    if not row.fits:
        return texts
    row.explain(comment_above(text, text.index(find)))
    if halve:
        new = find.replace(halve, f"(crate::spoilt({row.number}) * {halve})")
    else:
        new = f"if crate::spoilt({row.number}) != 1.0 {{ {row.spoiling['replace']} }} else {{ {find} }}"
        new = new if find.endswith((";", "}")) else f"({new})"
    return {**texts, file: text.replace(find, new)}


def with_functions(texts):
    """The texts with functions for the constants that have a switch, and for those that are made of these."""
    # The modules that have one by this name, and the names that are a trait's.
    homes, of_traits, before = {}, set(), None
    stem = lambda file: pathlib.Path(file.removesuffix("/mod.rs")).stem
    any_of = lambda names: "|".join(names) or "(?!)"

    while texts != before:
        before, texts = texts, dict(texts)
        for file, text in texts.items():

            def define(found):
                begin, name, kind, value = found.groups()
                if not re.search(rf"crate::spoilt\(|\b({any_of(homes)})\(\)", value):
                    return found.group()
                homes.setdefault(name, set()).add(stem(file))
                return f"#[allow(non_snake_case, missing_docs)]\n{begin}fn {name}() -> {kind} {{ {value} }}"

            def declare(found):
                of_traits.add(found[2])
                return f"#[allow(non_snake_case)]\n{found[1]}fn {found[2]}() -> f64;"

            text = re.sub(r"^const _: .*?;$", "", CONSTANT.sub(define, text), flags=re.M)
            here = any_of(name for name in homes if f"fn {name}()" in text)
            texts[file] = re.sub(rf"^( *)const ({here}): f64;", declare, text, flags=re.M)
        mention = re.compile(rf"{NOT_CODE}|(?P<path>(?:(?:\w+|<[^<>\n]*>)::)*)\b(?P<name>{any_of(homes)})\b(?![(:])", re.M)
        for file, text in texts.items():
            parents = {"super": stem(str(pathlib.Path(file.removesuffix("/mod.rs")).parent)), "self": stem(file)}
            modules = lambda path: {parents.get(word, word) for word in re.findall(r"\w+", path)}
            imported = {name for name in homes if f"fn {name}()" in text}
            # What a module uses its children may use from there.
            for use in re.findall(r"\buse ([^;]*);", text):
                found = {name for name in homes if modules(use) & homes[name] and (name in modules(use) or "*" in use)}
                imported |= found
                for name in found:
                    homes[name].add(stem(file))

            def call(found):
                path, name = found["path"], found["name"]
                if not name:
                    is_ours = False
                elif path and re.search(r"([A-Z]\w*|f32|f64|>)::$", path):
                    is_ours = name in of_traits
                else:
                    is_ours = modules(path) & homes[name] if path else name in imported
                return f"{path}{name}()" if is_ours else found.group()

            texts[file] = mention.sub(call, text)
    return texts


def write(texts):
    texts = with_functions(dict(texts))
    texts["src/lib.rs"] += SWITCH
    for file, text in texts.items():
        if (tree / file).read_text() != text:
            (tree / file).write_text(text)


def cargo(test, *words, spoilt=""):
    folder = "library" if (tree / f"tests/library/{test}.rs").exists() else "device"
    which = ["--lib"] if test == "lib" else ["--test", folder]
    command = ["timeout", "600", "cargo", "test", "--profile", "ci", "--locked", *PACKAGES, *which, *words]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True, env={**os.environ, "KUGELBLITZ_SPOILT": spoilt})


def trouble():
    """What the compiler says, if the tests do not build."""
    for test in tests:
        built = cargo(test, "--no-run")
        if built.returncode:
            return built.stderr


def failed(test, spoilt=""):
    """The test's functions that fail; none where it takes too long."""
    words = [] if test == "lib" else ["--", f"{test}::"]
    done = cargo(test, "--no-fail-fast", *words, spoilt=spoilt)
    found = set(re.findall(r"^test (.*) \.\.\. FAILED$", done.stdout, re.M))
    return None if done.returncode == 124 else found or ({"it ends"} if done.returncode else set())


def says(test, row):
    """What a test says of the spoilt program, and of how many of its functions failed that do not fail anyway."""
    found = failed(test, f"{row.number} {factor}")
    if found is None:
        return "seen (too long)"
    found -= anyway[test]
    if found:
        print(f"{row.name}: {' '.join(sorted(found))}", file=sys.stderr, flush=True)
    return f"seen ({len(found)})" if found else "no"


texts = {str(path.relative_to(tree)): path.read_text()
         for folder in ["src", "tests"] for path in sorted((tree / folder).rglob("*.rs"))}
listed = tomllib.loads((tree / "tests/device/matrix/spoilings.toml").read_text())
for file in listed["constants"]:
    texts[file] = with_factors(file, texts[file])
spoilt = texts
for spoiling in listed["spoiling"]:
    spoilt = with_switch(spoilt, Row(spoiling["name"], spoiling=spoiling))
write(spoilt)
if trouble():
    for row in rows:
        row.is_built = row.spoiling is not None
    write(texts)
    if said := trouble():
        sys.exit(said)

# In a copy with switches the list no longer fits the source, for one.
anyway = {test: failed(test) or set() for test in tests}
print("| spoiling | " + " | ".join(tests) + " | reason |")
print("| --- " * (len(tests) + 2) + "|")
unseen = []
for row in rows:
    if not match.search(row.name):
        continue
    if row.is_built:
        write(with_switch(texts, row))
    if not row.fits:
        answers = ["does not fit"] * len(tests)
    elif row.is_built and trouble():
        answers = ["does not build"] * len(tests)
    else:
        answers = [says(test, row) for test in tests]
    is_seen = any(answer.startswith("seen") for answer in answers)
    reason = "beside it" if row.is_explained and not is_seen else ""
    print(f"| {row.name} | " + " | ".join(answers) + f" | {reason} |", flush=True)
    if not is_seen and not row.is_explained:
        unseen.append(row.name)
print()
print(f"Unseen without a reason: {'; '.join(unseen) or 'none'}.")
PYTHON
