#!/bin/sh
# Looks for faults with libFuzzer for MINUTES, in two processes: random calls of the public interface in both, and for
# half of the time the readers of OBJ and TetGen files and of files of worlds and bridges in one of them. Installs what
# is missing (Debian, with apt) and builds first. Prints what was run; an input that finds something is kept in
# build/fuzz/findings, and the exit status is 1 then. tests/fuzz/README.md says how to go on from there.
#
#   usage: sh tests/fuzz.sh MINUTES
set -eu
case ${1:-} in
'' | *[!0-9]*)
    echo "usage: sh tests/fuzz.sh MINUTES" >&2
    exit 2
    ;;
esac
seconds=$(($1 * 60))
cd "$(dirname "$0")/.."
. cmake/bootstrap.sh

packages="$packages
clang           command clang
libclang-rt-dev file    /usr/lib/*/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a"
install_missing
build_preset fuzz fuzzers

programs=build/fuzz/tests/fuzz
findings=build/fuzz/findings
mkdir -p "$findings"
for name in api obj tetgen world bridge; do
    if [ ! -d "build/fuzz/corpus/$name" ]; then
        mkdir -p "build/fuzz/corpus/$name"
        "$programs/replay_$name" --unpack "tests/fuzz/corpus/$name.pack" "build/fuzz/corpus/$name"
    fi
done

# Files of the present format: those of the corpus may be of a former one.
"$programs/make_worlds" build/fuzz/corpus/world
"$programs/make_bridges" build/fuzz/corpus/bridge

run() { # NAME LOG SECONDS MOST_BYTES [OPTION...]
    [ "$3" -gt 0 ] || return 0
    name=$1 log=$2 time=$3 most=$4
    shift 4
    "$programs/fuzz_$name" -max_total_time="$time" -max_len="$most" -len_control=0 -timeout=60 -reload=30 \
        -print_final_stats=1 "$@" -artifact_prefix="$findings/$name-" "build/fuzz/corpus/$name" \
        >"build/fuzz/$log.log" 2>&1
}
readers() {
    run obj obj $((seconds / 8)) 4096 && run tetgen tetgen $((seconds / 8)) 4096 &&
        run world world $((seconds / 8)) 65536 -entropic=0 && # which would take half of the time
        run bridge bridge $((seconds / 8)) 16384 -entropic=0
}

say "fuzzing for $1 minutes"
rm -f build/fuzz/*.log
run api api-1 "$seconds" 1024 &
first=$!
(readers && run api api-2 $((seconds - seconds / 8 * 4)) 1024) &
second=$!
trap 'kill $first $second 2>/dev/null || true' INT TERM
status=0
wait $first || status=1
wait $second || status=1

sum_of() { # PATTERN FILE...: the sum of the numbers that the pattern of sed finds
    pattern=$1
    shift
    sed -n "s/$pattern/\\1/p" "$@" 2>/dev/null | awk '{ sum += $1 } END { printf "%d", sum }'
}
executions='^stat::number_of_executed_units: *\([0-9]*\)$'
echo "api: $(sum_of "$executions" build/fuzz/api-*.log) executions," \
    "$(sum_of '^api: .* \([0-9]*\) of at least 20 calls.*$' build/fuzz/api-*.log) sequences of at least 20 calls"
for name in obj tetgen world bridge; do
    echo "$name: $(sum_of "$executions" "build/fuzz/$name.log") executions"
done
if [ "$status" -ne 0 ]; then
    grep -h -m 3 -e '^finding:' -e 'ERROR: ' -e 'runtime error:' build/fuzz/*.log || true
    echo "findings: see build/fuzz/*.log, inputs are in $findings"
    exit 1
fi
echo "0 findings"
