#!/usr/bin/env bash
# What Kugelblitz needs on a Debian machine beyond Rust. Installs only what is missing.
#
#   ci/setup.sh                     a linker, a Vulkan loader and driver, what the window opens
#                                   when it runs, rustfmt and clippy
#   ci/setup.sh --tests             also a display without a screen, a hand for its mouse, a Wayland
#                                   compositor, Python with environments, and two more Vulkan drivers,
#                                   unpacked into the build folder
#   ci/setup.sh --release           also a browser
#   ci/setup.sh --software-driver   Mesa's software driver even where another driver is installed
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'setup: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

want_software_driver=no
want_tests=no
want_release=no
for argument in "$@"; do
    case "$argument" in
        --software-driver) want_software_driver=yes ;;
        --tests) want_tests=yes ;;
        --release) want_release=yes ;;
        *) die "unknown argument $argument; there are --tests, --release and --software-driver" ;;
    esac
done

# Rust itself comes from the user: there is more than one way to install it.
command -v cargo >/dev/null && command -v rustc >/dev/null ||
    die "cargo and rustc are not in PATH; install Rust from https://rustup.rs first"
needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
found=$(rustc --version | cut -d' ' -f2)
[ "$(printf '%s\n' "$needed" "${found%%-*}" | sort -V | head -n 1)" = "$needed" ] ||
    die "Rust $found is too old; Kugelblitz needs $needed or later (rustup update)"

has_library() {
    PATH="$PATH:/usr/sbin:/sbin" ldconfig -p | grep -F "$1" >/dev/null
}
has_driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] ||
        compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/usr/local/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}
has_software_driver() { compgen -G '/usr/share/vulkan/icd.d/lvp_icd*.json' >/dev/null; }

packages=()
command -v cc >/dev/null || packages+=(gcc libc6-dev)
has_library libvulkan.so.1 || packages+=(libvulkan1)
if [ "$want_software_driver" = yes ]; then
    has_software_driver || packages+=(mesa-vulkan-drivers)
else
    has_driver || packages+=(mesa-vulkan-drivers)
fi

# The window opens these by name when it runs, so no package manager sees that it needs them.
has_library libX11.so.6 || packages+=(libx11-6)
has_library libX11-xcb.so.1 || packages+=(libx11-xcb1)
has_library libXcursor.so.1 || packages+=(libxcursor1)
has_library libXi.so.6 || packages+=(libxi6)
has_library libxkbcommon.so.0 || packages+=(libxkbcommon0)
has_library libxkbcommon-x11.so.0 || packages+=(libxkbcommon-x11-0)
if [ "$want_tests" = yes ]; then
    command -v Xvfb >/dev/null || packages+=(xvfb)
    command -v xdotool >/dev/null || packages+=(xdotool)
    command -v weston >/dev/null || packages+=(weston)
    python3 -c 'import ensurepip, venv' 2>/dev/null ||
        /usr/bin/python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
fi

if [ "$want_release" = yes ]; then
    command -v chromium >/dev/null || packages+=(chromium)
fi

if [ ${#packages[@]} -gt 0 ]; then
    command -v apt-get >/dev/null ||
        die "apt-get is not there to install ${packages[*]}; install what they are called here"
    as_root=(env DEBIAN_FRONTEND=noninteractive)
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null ||
            die "installing ${packages[*]} needs root; run as root: apt-get install ${packages[*]}"
        # Without a terminal nobody can type a password.
        if [ -t 0 ]; then as_root=(sudo "${as_root[@]}"); else as_root=(sudo -n "${as_root[@]}"); fi
    fi
    say "installing ${packages[*]}"
    # The lists of a bare machine are empty, those of an old one name packages that are gone.
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    if ! { "${as_root[@]}" apt-get -q update &&
        "${as_root[@]}" apt-get -q install -y --no-install-recommends "${packages[@]}"; } \
        >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        die "apt-get could not install ${packages[*]}; its last lines are above"
    fi
fi

# Only the tests need these, so a picture does not depend on them.
for component in rustfmt clippy; do
    subcommand=${component/rustfmt/fmt}
    cargo "$subcommand" --version >/dev/null 2>&1 && continue
    if command -v rustup >/dev/null && rustup component add "$component" >/dev/null 2>&1; then
        say "added the Rust component $component"
    else
        say "the Rust component $component is missing and could not be added; ci/test.sh needs it"
    fi
done

# The same bytes on every driver: the tests run on these as well. Each is one library and a file that
# names it, below drivers/ in the build folder; nothing of the system changes.
[ "$want_tests" = yes ] || exit 0
target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
drivers=$target/drivers
release=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release 2>/dev/null || true)
work=

# apt-get with lists and a cache of its own.
apt_apart() {
    apt-get -q -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache" \
        -o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null \
        -o Acquire::Languages=none -o Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false \
        -o APT::Sandbox::User=root -o Debug::NoLocking=true "$@"
}

prepare_apt() {
    local key=/usr/share/keyrings/debian-archive-keyring.gpg mirror=http://deb.debian.org
    work=$(mktemp -d)
    trap 'rm -rf "$work" "${log:-}"' EXIT
    mkdir -p "$work/lists/partial" "$work/cache/archives/partial"
    printf "deb [signed-by=$key] $mirror/%s main\n" "debian $release" "debian $release-backports" \
        "debian-security $release-security" >"$work/sources.list"
    apt_apart -o APT::Update::Error-Mode=any update >"$work/log" 2>&1
}

# Unpacks the driver LIBRARY, described by DESCRIPTION, of a package that apt-get is told to get.
fetch_driver() {
    local name=$1 library=$2 description=$3 folder=$drivers/$1 tree package found
    shift 3
    [ ! -f "$folder/icd.json" ] || return 0
    rm -rf "$folder"
    if [ -z "$work" ] && ! prepare_apt; then
        say "no driver $name: $(tail -n 1 "$work/log")"
        return 0
    fi
    tree=$work/$name
    mkdir -p "$tree" "$folder"
    rm -f "$work"/cache/archives/*.deb
    if ! (cd "$tree" && apt_apart "$@") >"$work/log" 2>&1; then
        say "no driver $name: $(tail -n 1 "$work/log")"
        return 0
    fi
    for package in "$tree"/*.deb "$work"/cache/archives/*.deb; do
        [ ! -f "$package" ] || dpkg-deb -x "$package" "$tree"
    done
    found=$(find "$tree" -name "$library" -print -quit)
    description=$(find "$tree" -name "$description" -print -quit)
    if [ -z "$found" ] || [ -z "$description" ]; then
        say "no driver $name: its package has no $library"
        return 0
    fi
    # Beside it, what it needs that the system lacks or has older; not what a browser has of its own.
    cp -P "$found" "$folder"
    find "$tree" -path '*-linux-gnu/lib*.so.*' -exec cp -P {} "$folder" \;
    if LD_LIBRARY_PATH=$folder ldd "$folder/$library" | grep 'not found' >"$work/log"; then
        say "no driver $name: $(head -n 1 "$work/log")"
        return 0
    fi
    # Last of all, so that a driver is whole where it is there.
    sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$folder/$library\"|" "$description" \
        >"$folder/icd.json"
    say "unpacked the driver $name"
}

if command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null && [ -n "$release" ]; then
    fetch_driver swiftshader libvk_swiftshader.so vk_swiftshader_icd.json download chromium-common
    fetch_driver mesa-backports libvulkan_lvp.so 'lvp_icd*.json' install --download-only -y \
        --no-install-recommends "mesa-vulkan-drivers/$release-backports"
else
    say "no more drivers: apt-get, dpkg-deb or the release's name is missing"
fi
