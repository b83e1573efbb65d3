#!/usr/bin/env bash
# Installation test: installs into a prefix, moves it, and runs the programs there.
# install_programs_test.sh SOURCE BUILD CONFIG
set -euo pipefail
source_dir=$1 build_dir=$2 config=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "install_programs: $*" >&2; exit 1; }

cmake --install "$build_dir" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
prefix=$work/moved

# The programs run and find their library relative to themselves.
for program in fire3dv fire3dv-convert fire3dv-inspect fire3dv-record fire3dv-replay bullet_arm; do
  env -u LD_LIBRARY_PATH "$prefix/bin/$program" --help >"$work/help.txt" || fail "$program --help ended with $?"
  [ -s "$work/help.txt" ] || fail "$program --help says nothing"
done
[ ! -e "$prefix/bin/fire3dv-bench" ] || fail "fire3dv-bench is installed: it measures the project itself"
"$prefix/bin/bullet_arm" --write-scene "$work/arm.glb"
[ "$(head -c 4 "$work/arm.glb")" = glTF ] || fail "bullet_arm wrote no glTF"
loaded=$(ldd "$prefix/bin/bullet_arm" | awk '/libfire3dv-client/ { print $3 }')
case $(realpath "$loaded") in
  "$(realpath "$prefix")"/*) ;;
  *) fail "bullet_arm takes the client library from ${loaded:-nowhere}" ;;
esac

"$(dirname "${BASH_SOURCE[0]}")/run_paths_test.py" --outside "$source_dir" --outside "$build_dir" "$prefix" ||
  fail "a library search path is wrong"

# Shaders are embedded: an image is drawn without access to the source or the build.
(cd "$work" && "$prefix/bin/fire3dv" arm.glb --headless --size 64x36 --camera camera_front --frames 1 --out images 2>"$work/log.txt") ||
  { cat "$work/log.txt" >&2; fail "fire3dv ended with $?"; }
[ "$(head -c 4 "$work/images/frame_000000.png" | tail -c 3)" = PNG ] || fail "fire3dv wrote no PNG"

# The renderer finds the converter in its own folder.
"$prefix/bin/fire3dv" "$source_dir/tests/assets/robots/arm_description/urdf/arm.urdf" --headless --size 64x36 --frames 1 \
  --cache off --out "$work/described" 2>"$work/log.txt" || { cat "$work/log.txt" >&2; fail "fire3dv with a URDF ended with $?"; }
[ -s "$work/described/frame_000000.png" ] || fail "fire3dv wrote no PNG of a URDF"

if command -v go-md2man >/dev/null; then
  for page in fire3dv fire3dv-render fire3dv-doctor fire3dv-convert fire3dv-drake fire3dv-inspect fire3dv-record fire3dv-replay bullet_arm; do
    grep -q '^\.SH OPTIONS' "$prefix/share/man/man1/$page.1" || fail "the manual page $page(1) is not installed"
  done
fi
for paper in LICENSE NOTICE README.md CHANGELOG.md SPEC.md SPEC-transport.md SPEC-record.md; do
  [ -n "$(find "$prefix/share/doc" -name "$paper")" ] || fail "$paper is not installed"
done

# The desktop finds the viewer: the entry's program and icons are there.
entry=$prefix/share/applications/fire3dv.desktop
[ -s "$entry" ] || fail "the desktop entry is not installed"
[ -x "$prefix/bin/$(sed -n 's/^Exec=\([^ ]*\).*/\1/p' "$entry")" ] || fail "the desktop entry starts another program"
icon=$(sed -n 's/^Icon=//p' "$entry")
for file in scalable/apps/$icon.svg 128x128/apps/$icon.png; do
  [ -s "$prefix/share/icons/hicolor/$file" ] || fail "the icon $file is not installed"
done
if command -v desktop-file-validate >/dev/null; then
  desktop-file-validate "$entry" || fail "the desktop entry is invalid"
fi

# Release files contain no path of the build machine. Other builds carry debug information and
# sanitizers.
if [ "$config" = Release ]; then
  if grep -rlF -e "$source_dir/" -e "$build_dir/" "$prefix" >"$work/paths.txt"; then
    fail "the path of the source or the build is in: $(tr '\n' ' ' <"$work/paths.txt")"
  fi
fi
echo "install_programs: passed"
