#!/usr/bin/env bash
# Sets up, builds and passes the tests. Works alone on a bare machine; see tools/setup.sh for which.
#
#   tools/test.sh          what CI runs
#   tools/test.sh --long   the long tests too
#
# The CPU-side tests run first in a build with AddressSanitizer and UndefinedBehaviorSanitizer, then every test in a
# Release build in which warnings are errors. The last lines are CTest's own summary of that run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

long=0
for argument in "$@"; do
  case "$argument" in
    --long) long=1 ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "test.sh: unknown option $argument (there is --long)" >&2; exit 2 ;;
  esac
done
[ $long = 1 ] && selection=() || selection=(-LE '^long$')

say() { printf '\n== %s\n' "$*"; }
now() { date +%s.%N; }
seconds_since() { awk -v from="$1" -v to="$(now)" 'BEGIN { printf "%.1f", to - from }'; }
jobs=$(nproc)

say "set-up"
start=$(now)
tools/setup.sh
setup_seconds=$(seconds_since "$start")

say "what the tests cannot do without"
tools/check_test_machine.sh

say "includes: each file includes the standard headers of what it uses"
tools/check_includes.py

say "build: Release, warnings are errors"
start=$(now)
cmake --preset ci
cmake --build --preset ci

say "build: the CPU-side tests with AddressSanitizer and UndefinedBehaviorSanitizer"
cmake --preset dev -DCMAKE_CXX_FLAGS_DEBUG="-Og -g1"  # lines for traces; all of -g takes a tenth longer
mapfile -t targets < <(tools/test_times.py --targets-of cpu build/dev)
[ ${#targets[@]} -gt 0 ] || { echo "test.sh: no test has the label cpu" >&2; exit 1; }
cmake --build --preset dev --target "${targets[@]}"
build_seconds=$(seconds_since "$start")

say "tests: CPU side, sanitizers"
failed=()
start=$(now)
ctest --test-dir build/dev -j "$jobs" -L '^cpu$' "${selection[@]}" --output-on-failure --no-tests=error ||
  failed+=("tests with sanitizers")
sanitizer_seconds=$(seconds_since "$start")

say "tests: all"
# CTest's summary is held back until the times are printed, so that it is what the run ends with.
summary=build/ci/tests/summary.txt
log=build/ci/tests/log.txt
rm -f "$summary" "$log"
ctest --test-dir build/ci -j "$jobs" "${selection[@]}" --output-on-failure --no-tests=error 2>&1 | tee "$log" |
  awk -v summary="$summary" '/^[0-9]+% tests passed/ { held = 1 } held { print > summary; next } { print; fflush() }' ||
  failed+=("tests")

tools/test_times.py --setup "$setup_seconds" --builds "$build_seconds" --sanitizers "$sanitizer_seconds" \
  --log "$log" build/ci || failed+=("the table of times")
if [ ${#failed[@]} -gt 0 ]; then
  [ -f "$summary" ] && cat "$summary"
  (IFS=,; echo "test.sh: failed: ${failed[*]}")
  exit 1
fi
echo
# What this machine does not let tests try comes first, so that the run ends with the counts.
awk '/^The following tests did not run:/ { rest = 1 } rest' "$summary"
awk '/^The following tests did not run:/ { exit } NF' "$summary"
