#!/usr/bin/env bash
# Installs packages, builds and runs the tests. Starts from a bare machine; tools/setup.sh lists supported systems.
#
#   tools/test.sh          runs the tests that CI runs
#   tools/test.sh --long   also runs the long tests, and the CPU-side tests in both builds
#
# Tests that draw, and those of whole programs, run in a Release build; the CPU-side tests (label cpu) in a build with
# AddressSanitizer and UndefinedBehaviorSanitizer. Warnings are errors in both. The last lines are CTest's summaries.
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
# Labels that each build leaves out. The Release build leaves the CPU-side tests to the sanitizers; those with the label
# heavy, which take long to build with sanitizers, have the label cpu in the sanitizer build alone.
if [ $long = 1 ]; then
  cpu_tests=ON release_without=none sanitizers_without=none
else
  cpu_tests=OFF release_without='cpu|long' sanitizers_without='heavy|long'
fi

say() { printf '\n== %s\n' "$*"; }
jobs=$(nproc)
times=build/ci/times.txt  # NAME CPU_SECONDS WALL_SECONDS of each part
mkdir -p build/ci && rm -f "$times"

# Runs a command as a part of the time table.
part() {
  local name=$1 start status=0
  shift
  start=$(date +%s.%N)
  (
    "$@" || status=$?
    # The last line has the processor time of finished child processes: user, system. Not in a pipe: that is a process
    # of its own, without children.
    times > "$times.$name"
    awk -v name="$name" -v start="$start" -v end="$(date +%s.%N)" '
      function seconds(text) { split(text, p, /[ms]/); return p[1] * 60 + p[2] }
      END { print name, seconds($1) + seconds($2), end - start }' "$times.$name" >> "$times"
    exit $status
  )
}

# Runs CTest and stores its summary, which is printed at the end. A test that fails runs once more: some depend on the
# load of the machine. Such tests are listed as unsteady.
failed=() logs=() summaries=()
tests() {
  local name=$1 log=$2/$1.log
  summaries+=("$2/$1.summary") logs+=("$log")
  shift
  part "$name" run_ctest "$log" "${summaries[-1]}" --test-dir "$@" || failed+=("$name tests")
}
run_ctest() {
  local log=$1 summary=$2
  shift 2
  rm -f "$summary"
  ctest "$@" --repeat until-pass:2 --output-on-failure --no-tests=error 2>&1 | tee "$log" |
    awk -v summary="$summary" '/^[0-9]+% tests passed/ { held = 1 } held { print > summary; next } { print; fflush() }'
}

say "set-up"
part set-up tools/setup.sh --peers

say "prerequisites of the tests"
tools/check_test_machine.sh
echo "This is commit $(git rev-parse --short HEAD 2> /dev/null || echo unknown). Bare machines tried so far:"
grep -v '^#' tests/bare_machines.txt

say "includes: each file includes the standard headers that it uses"
tools/check_includes.py

say "structure: include directions, opening comments, folder sizes, Markdown lines"
tools/check_tree.py

say "format: .clang-format"
tools/check_format.sh

say "build: Release, warnings are errors"
cmake --preset ci -DFIRE3DV_CPU_TESTS=$cpu_tests
part build cmake --build --preset ci

# The second build uses what the tests leave of the processors: many of them wait.
say "build: the CPU-side tests with AddressSanitizer and UndefinedBehaviorSanitizer, beside the tests"
cmake --preset dev -DCMAKE_CXX_FLAGS_DEBUG="-Og -g1"  # line numbers for stack traces; full -g takes a tenth longer
# What the Release build leaves to the sanitizers must exist there.
listed() { ctest --test-dir "$1" -N -L "$2" | awk '/^ *Test +#/ { print $3 }' | sort; }
lost=$(comm -23 <(listed build/ci '^cpu$') <(listed build/dev '^cpu$') | grep -v '_long$' || true)
[ -z "$lost" ] || { echo "test.sh: no build runs these tests with the label cpu: $lost" >&2; exit 1; }
mapfile -t targets < <(tools/test_times.py --targets-of cpu --without "$sanitizers_without" build/dev)
[ ${#targets[@]} -gt 0 ] || { echo "test.sh: no test has the label cpu" >&2; exit 1; }
sanitizer_build=build/dev/build.txt
part sanitizer-build nice -n 19 cmake --build --preset dev --target "${targets[@]}" > "$sanitizer_build" 2>&1 &
sanitizer_build_pid=$!
trap 'kill "$sanitizer_build_pid" 2> /dev/null || true' EXIT

# End-to-end tests wait for programs, windows and networks most of the time.
say "tests: end to end"
tests e2e build/ci -L '^e2e$' -LE "^($release_without)\$" -j $((jobs + 1))
say "tests: images"
tests render build/ci -L '^render$' -LE "^(e2e|$release_without)\$" -j "$jobs"
say "tests: others of the Release build"
tests unit build/ci -LE "^(render|e2e|$release_without)\$" -j "$jobs"

say "tests: CPU side, sanitizers"
wait "$sanitizer_build_pid" || { tail -n 100 "$sanitizer_build"; echo "test.sh: failed: build with sanitizers"; exit 1; }
trap - EXIT
tests sanitizers build/dev -L '^cpu$' -LE "^($sanitizers_without)\$" -j "$jobs"

tools/test_times.py --budget "$times" || failed+=("the table of times")
unsteady=$(for each in "${logs[@]}"; do
  awk '/\*\*\*(Failed|Timeout)/ { for (i = 1; i < NF; ++i) if ($i ~ /^#[0-9]+:$/) print $(i + 1) }' "$each" | sort | uniq -c |
    awk '$1 == 1 { printf " %s", $2 }'
done)
[ -z "$unsteady" ] || say "unsteady, failed at the first try:$unsteady"
# What a test said that failed twice, once more: it lies far above in the output.
for each in "${logs[@]}"; do
  [ ! -f "$each" ] || awk '
    / Test +#[0-9]+: / {
      name = ""
      for (i = 1; i < NF; ++i) if ($i ~ /^#[0-9]+:$/ && /\*\*\*/) name = $(i + 1)
      if (name != "") { ++failures[name]; length_of[name] = 0 }
      next
    }
    /^ +Start +[0-9]+: / { next }
    name != "" { text[name, ++length_of[name]] = $0 }
    END {
      for (name in failures) if (failures[name] > 1) {
        print "\n== " name " failed twice; the end of what it said:"
        for (i = length_of[name] > 40 ? length_of[name] - 39 : 1; i <= length_of[name]; ++i) print text[name, i]
      }
    }' "$each"
done
# Tests that did not run come first, so that the output ends with the counts.
for each in "${summaries[@]}"; do
  [ ! -f "$each" ] || awk '/^The following tests did not run:/ { rest = 1 } rest' "$each"
done
for each in "${summaries[@]}"; do
  [ ! -f "$each" ] || awk '/^The following tests did not run:/ { exit } NF' "$each"
done
if [ ${#failed[@]} -gt 0 ]; then
  (IFS=,; echo "test.sh: failed: ${failed[*]}")
  exit 1
fi
