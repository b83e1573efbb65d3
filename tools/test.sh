#!/usr/bin/env bash
# Installs packages, builds and runs the tests. Starts from a bare machine; tools/setup.sh lists supported systems.
#
#   tools/test.sh          runs the tests that CI runs
#   tools/test.sh --long   also runs the long tests, and all CPU-side tests with sanitizers
#
# All tests run in a Release build with warnings as errors, the CPU-side tests then in a build with AddressSanitizer and
# UndefinedBehaviorSanitizer. The last lines are CTest's summary of the first run.
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
# The reader of MJCF, and tests that link all readers, take a seventh of the build with sanitizers. Readers work on the
# user's own files, in a process of their own.
sanitized=(-L '^cpu$')
unsanitized='^(mujoco_.*|mjcf_.*|read_mjcf|read_sdf|mesh_scene|robot_(mujoco.*|adf|kdl|joints))_test$'
if [ $long = 1 ]; then unsanitized=; else sanitized+=(-E "$unsanitized"); fi

say() { printf '\n== %s\n' "$*"; }
now() { date +%s.%N; }
seconds_since() { awk -v from="$1" -v to="$(now)" 'BEGIN { printf "%.1f", to - from }'; }
jobs=$(nproc)

say "set-up"
start=$(now)
tools/setup.sh --peers
setup_seconds=$(seconds_since "$start")

say "prerequisites of the tests"
tools/check_test_machine.sh

say "includes: each file includes the standard headers that it uses"
tools/check_includes.py

say "structure: include directions, opening comments, folder sizes, Markdown lines"
tools/check_tree.py

say "build: Release, warnings are errors"
start=$(now)
cmake --preset ci
cmake --build --preset ci

# The second build uses what the tests leave of the processors: many of them wait.
say "build: the CPU-side tests with AddressSanitizer and UndefinedBehaviorSanitizer, beside the tests"
cmake --preset dev -DCMAKE_CXX_FLAGS_DEBUG="-Og -g1"  # line numbers for stack traces; full -g takes a tenth longer
mapfile -t targets < <(tools/test_times.py --targets-of cpu ${unsanitized:+--without "$unsanitized"} build/dev)
[ ${#targets[@]} -gt 0 ] || { echo "test.sh: no test has the label cpu" >&2; exit 1; }
sanitizer_build=build/dev/build.txt
nice -n 19 cmake --build --preset dev --target "${targets[@]}" > "$sanitizer_build" 2>&1 &
sanitizer_build_pid=$!
trap 'kill "$sanitizer_build_pid" 2> /dev/null || true' EXIT
build_seconds=$(seconds_since "$start")

# A test that fails runs once more: some depend on the load of the machine. Such tests are listed as unsteady.
say "tests: all"
failed=()
# CTest's summary is printed after the time table, at the end of the output.
summary=build/ci/tests/summary.txt
log=build/ci/tests/log.txt
rm -f "$summary" "$log"
ctest --test-dir build/ci -j "$jobs" "${selection[@]}" --repeat until-pass:2 --output-on-failure --no-tests=error 2>&1 |
  tee "$log" |
  awk -v summary="$summary" '/^[0-9]+% tests passed/ { held = 1 } held { print > summary; next } { print; fflush() }' ||
  failed+=("tests")

say "tests: CPU side, sanitizers"
start=$(now)
wait "$sanitizer_build_pid" || { tail -n 100 "$sanitizer_build"; echo "test.sh: failed: build with sanitizers"; exit 1; }
trap - EXIT
build_seconds=$(awk -v begun="$build_seconds" -v waited="$(seconds_since "$start")" 'BEGIN { print begun + waited }')
start=$(now)
sanitizer_log=build/dev/tests/log.txt
ctest --test-dir build/dev -j "$jobs" "${sanitized[@]}" "${selection[@]}" --repeat until-pass:2 --output-on-failure \
  --no-tests=error 2>&1 | tee "$sanitizer_log" || failed+=("tests with sanitizers")
sanitizer_seconds=$(seconds_since "$start")

tools/test_times.py --setup "$setup_seconds" --builds "$build_seconds" --sanitizers "$sanitizer_seconds" \
  --log "$log" build/ci || failed+=("the table of times")
unsteady=$(for each in "$sanitizer_log" "$log"; do
  awk '/\*\*\*(Failed|Timeout)/ { for (i = 1; i < NF; ++i) if ($i ~ /^#[0-9]+:$/) print $(i + 1) }' "$each" | sort | uniq -c |
    awk '$1 == 1 { printf " %s", $2 }'
done)
[ -z "$unsteady" ] || say "unsteady, failed at the first try:$unsteady"
if [ ${#failed[@]} -gt 0 ]; then
  [ -f "$summary" ] && cat "$summary"
  (IFS=,; echo "test.sh: failed: ${failed[*]}")
  exit 1
fi
echo
# Tests that did not run come first, so that the output ends with the counts.
awk '/^The following tests did not run:/ { rest = 1 } rest' "$summary"
awk '/^The following tests did not run:/ { exit } NF' "$summary"
