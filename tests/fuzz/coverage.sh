#!/bin/sh
# Which lines of core/src the corpora of the fuzzers reach, with clang and llvm-cov.
#
#   usage: sh tests/fuzz/coverage.sh
set -eu
cd "$(dirname "$0")/../.."
build=build/coverage
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_C_FLAGS="-fprofile-instr-generate -fcoverage-mapping" -DCMAKE_C_FLAGS_DEBUG="-O1" \
    -DPLIANT_BUILD_BRIDGE=OFF -DPLIANT_BUILD_DEMOS=OFF >$build.log
cmake --build $build --target fuzzers
objects=
for name in api obj tetgen; do
    LLVM_PROFILE_FILE=$build/$name.profraw $build/tests/fuzz/replay_$name tests/fuzz/corpus/$name.pack
    objects="$objects${objects:+ -object }$build/tests/fuzz/replay_$name"
done
tool=$(command -v llvm-cov || command -v llvm-cov-14)
"${tool%llvm-cov*}llvm-profdata${tool##*llvm-cov}" merge -o $build/all.profdata $build/*.profraw
# shellcheck disable=SC2086 # a list of words
"$tool" show $objects -instr-profile=$build/all.profdata core/src >$build/lines.txt
# shellcheck disable=SC2086
"$tool" report $objects -instr-profile=$build/all.profdata -show-region-summary=0 -show-branch-summary=0 core/src
