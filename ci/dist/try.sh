#!/usr/bin/env bash
# Tries the artefacts of ci/dist.sh as users do: try.sh FOLDER VERSION [NAME…], of archive, wheel and windows. Needs root for the
# first one, which runs in an empty Debian 11.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

die() { printf 'ci/dist/try.sh: %s\n' "$*" >&2; exit 1; }

out=$(realpath "$1")
version=$2
shift 2
[ $# -gt 0 ] || set -- archive wheel windows
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
digests=$PWD/tests/digests.txt
# What every build has to draw, byte for byte.
picture=(render lit/figure1 --size 320x180 -o picture.png)

as_root() { if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi; }

need() {
    local package missing=()
    for package in "$@"; do dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package"); done
    [ "${#missing[@]}" -eq 0 ] || as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -q install -y --no-install-recommends "${missing[@]}" >/dev/null
}

# Compares a picture with the one that the archive's program draws.
same_picture() {
    [ -f "$place/expected.png" ] || {
        tar xzf "$out/kugelblitz-$version-x86_64-linux.tar.gz" -C "$place"
        (cd "$place" && "./kugelblitz-$version-x86_64-linux/kugelblitz" "${picture[@]}" -q && mv picture.png expected.png)
    }
    cmp "$1" "$place/expected.png" || die "$1 has other bytes"
}

# The archive in a Debian 11 (glibc 2.31) with nothing installed, then with a software driver.
archive() {
    need debootstrap
    local old=$place/debian name=kugelblitz-$version-x86_64-linux
    as_root debootstrap --variant=minbase bullseye "$old" http://deb.debian.org/debian >"$place/log" 2>&1 ||
        { tail "$place/log"; die "no Debian 11"; }
    inside() { as_root chroot "$old" /bin/sh -ec "$1"; }
    as_root tar xzf "$out/$name.tar.gz" -C "$old/opt"
    as_root cp "$digests" "$old/opt/$name/digests.txt"
    inside "cd /opt/$name && ./kugelblitz ${picture[*]}"
    same_picture "$old/opt/$name/picture.png"
    inside "cd /opt/$name && ./kugelblitz render lit/figure1 -o none.png --device gpu" 2>&1 && die "found a GPU in an empty root"
    inside "cd /opt/$name && ./kugelblitz digest --check digests.txt -q"
    as_root env DEBIAN_FRONTEND=noninteractive chroot "$old" apt-get -q install -y --no-install-recommends \
        libvulkan1 mesa-vulkan-drivers >"$place/log" 2>&1 || { tail "$place/log"; die "no driver in Debian 11"; }
    inside "cd /opt/$name && ./kugelblitz probe && rm picture.png && ./kugelblitz ${picture[*]} --device gpu"
    same_picture "$old/opt/$name/picture.png"
    as_root rm -rf "$old"
}

# The wheel in fresh environments of the oldest and the newest Python here: module, command, and no driver.
wheel() {
    local python name oldest='' newest=''
    for name in 3.{10,11,12,13,14,15}; do
        for python in "$(command -v "python$name")" "$HOME"/.pyenv/versions/*/bin/"python$name"; do
            "$python" -c 'import ensurepip, venv' 2>/dev/null || continue
            oldest=${oldest:-$python}
            newest=$python
        done
    done
    [ -n "$oldest" ] || die "no Python 3.10 or later"
    for python in "$oldest" "$newest"; do
        rm -rf "$place/environment" "$place/work"
        mkdir "$place/work"
        "$python" -m venv "$place/environment"
        (
            cd "$place/work"
            bin=$place/environment/bin
            began=$(date +%s%N)
            "$bin/pip" -q --disable-pip-version-check install "$out"/kugelblitz-"$version"-*manylinux*.whl
            "$bin/python" -c '
import kugelblitz as kb
import numpy as np
scene = kb.Scene(np.random.default_rng(1).random((1000, 3)), radius=0.02)
scene.render(size=(320, 180)).save("cloud.png")
hits = scene.trace([[0.5, 0.5, 9.0]], [[0.0, 0.0, -1.0]])
print(kb.__version__, hits.id)
'
            printf '%s: installed, imported and drawn in %s ms\n' "$("$bin/python" --version)" \
                $((($(date +%s%N) - began) / 1000000))
            "$bin/kugelblitz" "${picture[@]}"
            same_picture picture.png
            VK_DRIVER_FILES=/nonexistent "$bin/python" -m kugelblitz "${picture[@]}" -q
            same_picture picture.png
            [ "$("$bin/kugelblitz" -V)" = "kugelblitz $version" ]
            "$bin/kugelblitz" render nosuch.toml -o no.png 2>error && die "drew a scene that does not exist"
            grep -F nosuch.toml error
        )
        [ "$oldest" != "$newest" ] || break
    done
}

# The programs for Windows under Wine: pictures, digests and errors, without a GPU.
windows() {
    need wine64
    local folder=$place/kugelblitz-$version-x86_64-windows wine=/usr/lib/wine/wine64
    python3 -m zipfile -e "$out/kugelblitz-$version-x86_64-windows.zip" "$place"
    cp "$digests" "$folder/digests.txt"
    PATH=$(ci/dist/tools.sh python) python3 -m ziglang cc -target x86_64-windows-gnu -shared \
        -o "$folder/bcryptprimitives.dll" ci/dist/bcryptprimitives.c -ladvapi32
    export WINEPREFIX=$place/wine WINEDEBUG=-all
    cd "$folder"
    "$wine" kugelblitz.exe --version
    "$wine" kugelblitz.exe "${picture[@]}" --device cpu
    same_picture picture.png
    "$wine" kugelblitz.exe digest --check digests.txt -q --device cpu
    "$wine" kugelblitz.exe generate --count 1000 -o cloud.npy
    "$wine" kugelblitz.exe render cloud.npy -o cloud.png --device cpu
    "$wine" kugelblitz.exe verify figure1 --size 160x90 --device cpu
    "$wine" kugelblitz.exe render nosuch.toml -o no.png && die "drew a scene that does not exist"
    "$wine" kugelblitz-view.exe --version
    cd - >/dev/null
}

for name in "$@"; do
    printf '\n-- %s\n' "$name"
    "$name"
done
