#!/bin/sh
# Builds the core for AArch64 with Debian's cross compiler and runs its C tests under qemu: those that compare the
# instruction sets compare NEON with plain C there. Not part of tests/run.sh; needs apt and takes some ten minutes.
#
#   usage: sh tests/aarch64.sh
set -eu
cd "$(dirname "$0")/.."
build=build/aarch64
root=$PWD/$build/root # libraries for AArch64, unpacked, not installed

say() { printf '== %s\n' "$*"; }

say "tools"
apt-get install -y --no-install-recommends cmake ninja-build pkg-config gcc-aarch64-linux-gnu g++-aarch64-linux-gnu \
    libc6-dev-arm64-cross qemu-user-static >/dev/null
if ! [ -d "$root" ]; then
    mkdir -p "$build/packages"
    known=$(dpkg --print-foreign-architectures)
    dpkg --add-architecture arm64
    apt-get update >/dev/null
    (cd "$build/packages" && apt-get download libcmocka0:arm64 libcmocka-dev:arm64 libccd2:arm64 libccd-dev:arm64)
    case " $known " in
    *arm64*) ;;
    *) dpkg --remove-architecture arm64 && apt-get update >/dev/null ;;
    esac
    for package in "$build"/packages/*.deb; do
        dpkg -x "$package" "$root"
    done
fi

say "building"
export PKG_CONFIG_SYSROOT_DIR="$root" PKG_CONFIG_LIBDIR="$root/usr/lib/aarch64-linux-gnu/pkgconfig"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Linux \
    -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DPLIANT_BUILD_BRIDGE=OFF -DPLIANT_BUILD_DEMOS=OFF -DPLIANT_INSTALL=OFF \
    "-DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64-static;-L;/usr/aarch64-linux-gnu;-E;LD_LIBRARY_PATH=$root/usr/lib/aarch64-linux-gnu" \
    "-DCMAKE_EXE_LINKER_FLAGS=-Wl,--allow-shlib-undefined" >/dev/null
cmake --build "$build"

say "testing"
ctest --test-dir "$build" -L unit -j 2 --output-on-failure
