#!/bin/sh
# compile.sh COMPILER AMALGAMATION WORK HELLO: everything, and cloth alone, without a warning; both run hello_core.
# Not optimised: scene_hashes_amalgamated is, with the same warnings.
set -eu
compiler=$1 from=$2 work=$3 hello=$4
rm -rf "$work"
mkdir -p "$work/pliant"
cp "$from/pliant.h" "$work/pliant/pliant.h" # the program says <pliant/pliant.h>
off="-DPLIANT_FEATURES_CLUSTERS=0 -DPLIANT_FEATURES_CUT=0 -DPLIANT_FEATURES_SELF_COLLISION=0" # and so no files
off="$off -DPLIANT_FEATURES_IMPLICIT=0 -DPLIANT_FEATURES_XPBD=0 -DPLIANT_FEATURES_THREADS=0"
for kind in all cloth; do
    flags=-O0
    [ $kind = all ] || flags="$flags $off"
    "$compiler" -std=c17 -Wall -Wextra -Werror $flags -c "$from/pliant.c" -o "$work/$kind.o"
    "$compiler" -O2 -I"$work" "$hello" "$work/$kind.o" -lm -lpthread -o "$work/$kind"
    line=$("$work/$kind")
    echo "$kind: $line, $(wc -c <"$work/$kind.o") bytes"
    test "$line" = "corner after 1.5 s: y = -0.52 m"
done
test "$(wc -c <"$work/cloth.o")" -lt "$(wc -c <"$work/all.o")"
