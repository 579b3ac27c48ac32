#!/bin/sh
# Compares the binary interface of the shared core with that of the last tag, or of the revision that is named: while the
# name of the library stays (libpliant.so.0.1), what was there has to stay as it is; functions may come. Exit status 77:
# there is no tag yet.
#
#   usage: sh packaging/abi.sh [REVISION]
set -eu
cd "$(dirname "$0")/.."
say() { printf '== %s\n' "$*"; }

revision=${1:-$(git describe --tags --abbrev=0 2>/dev/null || true)}
if [ -z "$revision" ]; then
    echo "there is no tag to compare with"
    exit 77
fi
out=build/abi
rm -rf "$out"
mkdir -p "$out/before"
git archive "$revision" | tar -x -C "$out/before"

build() { # SOURCE BUILD: with what debuggers read, which has the types
    cmake -S "$1" -B "$2" -G Ninja -DCMAKE_BUILD_TYPE=Debug "-DCMAKE_C_FLAGS_DEBUG=-g -O1" -DBUILD_SHARED_LIBS=ON \
        -DPLIANT_BUILD_BRIDGE=OFF -DPLIANT_BUILD_DEMOS=OFF -DPLIANT_BUILD_TESTS=OFF -DPLIANT_BUILD_PYTHON=OFF >"$2.log"
    cmake --build "$2" >>"$2.log" || { tail -n 20 "$2.log" >&2; exit 1; }
}
soname() { objdump -p "$1/core/libpliant.so" | sed -n 's/^ *SONAME *//p'; }

say "building $revision and this tree"
build "$out/before" "$out/build-before"
build . "$out/build-now"
if [ "$(soname "$out/build-before")" != "$(soname "$out/build-now")" ]; then
    echo "$(soname "$out/build-before") has become $(soname "$out/build-now"): its interface may change"
    exit 0
fi
say "comparing $(soname "$out/build-now")"
if abidiff --no-added-syms --headers-dir1 "$out/before/core/include" --headers-dir2 core/include \
    "$out/build-before/core/libpliant.so" "$out/build-now/core/libpliant.so" >"$out/abidiff.txt"; then
    echo "nothing of $revision has changed"
else
    cat "$out/abidiff.txt"
    exit 1
fi
