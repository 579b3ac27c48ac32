#!/bin/sh
# compile_bridge.sh COMPILER AMALGAMATION WORK HELLO PROGRAM: the bridge in one file, without a warning, with the core's
# that compile.sh has made in WORK; HELLO with both says what PROGRAM says, which is HELLO with the libraries.
set -eu
compiler=$1 from=$2 work=$3 hello=$4 program=$5
mkdir -p "$work/pliant_bullet"
cp "$from/pliant_bullet.h" "$work/pliant_bullet/pliant_bullet.h" # the program says <pliant_bullet/pliant_bullet.h>
flags="$(pkg-config --cflags bullet | sed 's/-I/-isystem /g') -I$from -I$work -std=c++17 -O1"
# shellcheck disable=SC2086 # lists of words
"$compiler" $flags -Wall -Wextra -Werror -c "$from/pliant_bullet.cpp" -o "$work/bridge.o"
# shellcheck disable=SC2046,SC2086
"$compiler" $flags "$hello" "$work/bridge.o" "$work/all.o" $(pkg-config --libs bullet) -lm -lpthread -o "$work/hello_bullet"
"$work/hello_bullet" >"$work/hello_bullet.txt"
"$program" >"$work/expected.txt"
test "$(wc -l <"$work/expected.txt")" = 7
diff "$work/expected.txt" "$work/hello_bullet.txt"
echo "equal output, $(wc -c <"$work/bridge.o") bytes"
