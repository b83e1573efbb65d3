#!/usr/bin/env bash
# Installs into a prefix, moves it, and uses what is there. install_test.sh SOURCE BUILD VERSION CONFIG
set -euo pipefail
source_dir=$1 build_dir=$2 version=$3 config=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "install_test: $*" >&2; exit 1; }

cmake --install "$build_dir" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
prefix=$work/moved

# Programs run and find their library beside them.
for program in fire3dv bullet_arm; do
  env -u LD_LIBRARY_PATH "$prefix/bin/$program" --help >"$work/help.txt" || fail "$program --help ended with $?"
  [ -s "$work/help.txt" ] || fail "$program --help says nothing"
done
"$prefix/bin/bullet_arm" --write-scene "$work/arm.glb"
[ "$(head -c 4 "$work/arm.glb")" = glTF ] || fail "bullet_arm wrote no glTF"

# Papers.
for paper in LICENSE NOTICE README.md CHANGELOG.md SPEC.md; do
  [ -n "$(find "$prefix/share/doc" -name "$paper")" ] || fail "$paper is not installed"
done

# A simulator's build finds the library, by CMake and by pkg-config.
cmake -S "$source_dir/examples/client_c" -B "$work/client_c" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/client_c" >/dev/null
"$work/client_c/client_c" shm://fire3dv-install-test-$$ 3 >/dev/null || fail "the client built by CMake ended with $?"
pc=$(dirname "$(find "$prefix" -name fire3dv-client.pc)")
found=$(PKG_CONFIG_PATH=$pc pkg-config --modversion fire3dv-client)
[ "$found" = "$version" ] || fail "pkg-config says version $found, not $version"

# What is shipped knows no path of the machine that built it. Other builds carry debug information and sanitizers.
if [ "$config" = Release ]; then
  if grep -rlF -e "$source_dir/" -e "$build_dir/" "$prefix" >"$work/paths.txt"; then
    fail "the path of the source or the build is in: $(tr '\n' ' ' <"$work/paths.txt")"
  fi
fi
echo "install_test: passed"
