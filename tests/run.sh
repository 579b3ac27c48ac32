#!/bin/sh
# Runs all tests: installs what is missing (Debian, with apt), builds, runs every test of the release preset, then the
# unit tests again under AddressSanitizer and UBSan, but for those that only take long, the corpora of the fuzzers
# also under those of clang, tests with threads under ThreadSanitizer, and some scenes in a browser. Exit status 0 when
# all passed.
#
#   usage: sh tests/run.sh
set -eu
cd "$(dirname "$0")/.."
. cmake/bootstrap.sh

# Tests of the window need a screen, and this one is not looked at.
packages="$packages
xvfb            command Xvfb
clang           command clang
abigail-tools   command abidiff
python3-cffi    file    /usr/lib/python3/dist-packages/cffi/__init__.py
python3-numpy   file    /usr/lib/python3/dist-packages/numpy/__init__.py
python3-pytest  file    /usr/lib/python3/dist-packages/pytest/__init__.py
libclang-rt-dev file    /usr/lib/*/lib/clang/*/lib/linux/libclang_rt.asan-*.a"

passed=0
failed=0

run_tests() { # PRESET [PATTERN]
    say "testing preset $1"
    log=build/$1-tests.log
    ctest --preset "$1" -j 2 ${2:+-R "$2"} 2>&1 | tee "$log"
    # "97% tests passed, 2 tests failed out of 67"; without that line the tests did not run.
    summary=$(sed -n 's/^[0-9]*% tests passed, \([0-9]*\) tests\{0,1\} failed out of \([0-9]*\)$/\1 \2/p' "$log")
    if [ -z "$summary" ]; then
        echo "ctest --preset $1 ran no tests" >&2
        exit 1
    fi
    failed=$((failed + ${summary% *}))
    passed=$((passed + ${summary#* } - ${summary% *}))
}

install_missing
mkdir -p build
sh demos/web.sh --install >build/web-install.log 2>&1 & # beside the builds: it waits for the disk
installing=$!
build_preset release
build_preset asan
wait $installing || {
    cat build/web-install.log >&2
    exit 1
}
# Beside the other tests, as much of it runs on one core. Scenes of each kind and solver; `sh demos/web.sh --test` runs
# all.
sh demos/web.sh --test Cloth Bunny Collide2 ClusterStackMixed FoldingCloth TetraCube >build/web-tests.log 2>&1 &
browsing=$!
trap 'kill $browsing 2>/dev/null || true' EXIT
run_tests release
run_tests asan
build_preset ubsan-clang fuzzers
run_tests ubsan-clang '^fuzz_corpus_'
build_preset tsan
run_tests tsan
if wait $browsing; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
trap - EXIT
cat build/web-tests.log

printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]
