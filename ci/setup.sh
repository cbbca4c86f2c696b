#!/usr/bin/env bash
# What Kugelblitz needs on a Debian machine beyond Rust. Installs only what is missing.
#
#   ci/setup.sh                     a linker, a Vulkan loader and driver, what the window opens
#                                   when it runs, rustfmt and clippy
#   ci/setup.sh --tests             also a display without a screen, a hand for its mouse, and a
#                                   Wayland compositor
#   ci/setup.sh --software-driver   Mesa's software driver even where another driver is installed
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'setup: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

want_software_driver=no
want_tests=no
for argument in "$@"; do
    case "$argument" in
        --software-driver) want_software_driver=yes ;;
        --tests) want_tests=yes ;;
        *) die "unknown argument $argument; there are --tests and --software-driver" ;;
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
