# Shared part of demos/run.sh and tests/run.sh, to be sourced by them from the root of the project: installs what is
# missing, then configures and builds a preset. POSIX sh.

packages=$(sed '/^#/d' cmake/packages.txt)

say() { printf '== %s\n' "$*"; }

is_there() { # KIND NAME
    case $1 in
    command) command -v "$2" >/dev/null 2>&1 ;;
    module) command -v pkg-config >/dev/null 2>&1 && pkg-config --exists "$2" ;;
    file)
        for file in $2; do [ -e "$file" ] && return 0; done
        return 1
        ;;
    esac
}

missing_packages() {
    echo "$packages" | while read -r package kind name; do
        [ -z "$package" ] || is_there "$kind" "$name" || echo "$package"
    done | sort -u | tr '\n' ' '
}

install_missing() {
    missing=$(missing_packages)
    [ -n "$missing" ] || return 0
    if ! command -v apt-get >/dev/null 2>&1; then
        echo "missing, by the names of Debian's packages: $missing" >&2
        echo "install them with this system's package manager, then run this again" >&2
        exit 1
    fi
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null 2>&1; then
            echo "missing packages: $missing" >&2
            echo "run this as root: apt-get install --no-install-recommends $missing" >&2
            exit 1
        fi
        as_root='sudo'
    fi
    say "installing $missing"
    log=$(mktemp)
    # shellcheck disable=SC2086 # a list of words
    if ! { $as_root apt-get -o DPkg::Lock::Timeout=120 update &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 install -y --no-install-recommends $missing; } >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        rm -f "$log"
        echo "apt-get could not install: $missing" >&2
        exit 1
    fi
    rm -f "$log"
    missing=$(missing_packages)
    if [ -n "$missing" ]; then
        echo "installed, but still not usable: $missing" >&2
        exit 1
    fi
}

# Configures and builds a preset, or one target of it; cheap when nothing has changed.
build_preset() { # PRESET [TARGET]
    say "building preset $1"
    log=build/$1.log
    mkdir -p build
    if ! cmake --preset "$1" >"$log" 2>&1; then
        cat "$log" >&2
        echo "cmake --preset $1 failed" >&2
        exit 1
    fi
    cmake --build --preset "$1" -j "$(nproc 2>/dev/null || echo 2)" ${2:+--target "$2"}
}
