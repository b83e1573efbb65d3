#!/usr/bin/env bash
# Mutation test of the test suite: plants each fault of tests/mutations.txt in a copy of the tree and expects the tests
# named there to fail. Takes long; CI runs --applies only.
#
#   tools/check_mutations.sh [REGEX]     only lines that match
#   tools/check_mutations.sh --applies   only checks that each line still changes its file
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
only=${1:-.}
copy=$PWD/build/mutations/tree
build=$PWD/build/mutations/build

die() { echo "check_mutations.sh: $*" >&2; exit 1; }

rows() { # regular expression; family~tests~file~expression~what
  grep -v '^#' tests/mutations.txt | grep -E -- "$1" | sed 's/ *| */~/; s/ *| */~/; s/ *| */~/; s/ | \([^|]*\)$/~\1/'
}

if [ "$only" = --applies ]; then
  count=0
  while IFS='~' read -r _ _ file expression what; do
    [ -f "$file" ] || die "$file is not there: $what"
    ! sed "$expression" "$file" | cmp -s - "$file" || die "$file: the expression changes nothing: $expression"
    count=$((count + 1))
  done < <(rows .)
  echo "$count faults can be planted"
  [ $count -gt 0 ]
  exit
fi

mkdir -p "$copy"
exec 9>"$PWD/build/mutations/lock"
flock -n 9 || die "another run is at work in build/mutations: wait for it"

# Changed files are copied with a new modification time, so that faults of an interrupted run are rebuilt.
while IFS= read -r -d '' file; do
  [ ! -f "$file" ] || cmp -s "$file" "$copy/$file" || cp --parents "$file" "$copy"
done < <(git ls-files -z --cached --others --exclude-standard)
cmake -S "$copy" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release >"$build.log" 2>&1 || { cat "$build.log"; die "cannot configure"; }

run_tests() { # family, regular expression; 0 = passed, 2 = does not build
  local targets
  mapfile -t targets < <(tools/test_times.py --targets-matching "$2" "$build")
  [[ $1 != e2e* ]] || targets+=(fire3dv bullet_arm e2e_publisher e2e_rude_client e2e_attacker fire3dv-impair fire3dv-motion)
  [[ $1 != *"two simulators" ]] || targets+=(fire3dv-inspect two_simulators_scene two_simulators_bullet two_simulators_mujoco)
  [[ $1 != *packages ]] || targets+=(fire3dv-convert fire3dv-inspect fire3dv-record fire3dv-replay fire3dv-drake fire3dv-gazebo fire3dv-mujoco fire3dv-ros2 fire3dv_client_inside fire3dv_manual_pages)
  [ ${#targets[@]} -eq 0 ] || cmake --build "$build" --target "${targets[@]}" >"$build.log" 2>&1 || return 2
  ctest --test-dir "$build" -R "$2" --no-tests=error >"$build.log" 2>&1
}

missed=0 caught=0
while IFS='~' read -r family tests file expression what; do
  printf '%-20s %s: %s\n' "$family" "$file" "$what"
  run_tests "$family" "$tests" || { tail -n 30 "$build.log"; die "$tests fails without a fault planted"; }
  sed -i "$expression" "$copy/$file"
  cmp -s "$file" "$copy/$file" && die "$file: the expression changes nothing: $expression"
  code=0
  run_tests "$family" "$tests" || code=$?
  cp "$file" "$copy/$file"  # with a new modification time
  if [ $code = 2 ]; then
    tail -n 30 "$build.log"
    die "$file does not build with the fault planted"
  elif [ $code = 0 ]; then
    echo "  MISSED by $tests"
    missed=$((missed + 1))
  else
    echo "  caught by $tests"
    caught=$((caught + 1))
  fi
done < <(rows "$only")
echo "$caught faults caught, $missed missed"
[ $missed = 0 ] && [ $caught -gt 0 ]
