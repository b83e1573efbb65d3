#!/usr/bin/env bash
# Makes all files of a release in one folder: source archive, Debian packages, wheels, bill of materials (SPDX 2.3), release
# notes, checksums.
#
#   tools/release.sh OUTPUT_DIR              builds the preset release if needed; OUTPUT_DIR must be empty or missing
#   tools/release.sh --build DIR OUTPUT_DIR  packs this finished build of the same commit
#   tools/release.sh --cpu-driver ...        with the wheel fire3dv-cpu
#   tools/release.sh --further ...           on a further Debian release: only its packages, bill of materials and checksums.
#                                            Source archive, wheels and notes are those of the oldest
#   tools/release.sh --check [BUILD]         makes no packages: versions, public interface and notes agree, the bill of
#                                            materials of BUILD is well-formed
#
# The same commit gives the same bytes on the same machine (CONTRIBUTING.md, "Release"). The tree must have no changes, its
# commit the tag vVERSION.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build= output= check=0 further=0 package_options=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build=${2:?--build needs a folder}; package_options+=(--build "$2"); shift ;;
    --cpu-driver) package_options+=(--cpu-driver) ;;
    --further) further=1 ;;
    --check) check=1 ;;
    -h | --help) sed -n '2,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "release.sh: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) output=$1 ;;
  esac
  shift
done
die() { printf 'release.sh: %s\n' "$*" >&2; exit 1; }

commit=$(git rev-parse HEAD) || die "a release is made of a commit: this is no git checkout"
version=$(tools/version.py)
archive=fire3dv-$version
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH LC_ALL=C.UTF-8 TZ=UTC PYTHONDONTWRITEBYTECODE=1
umask 022

tools/version.py --check || die "versions differ"
tools/public_api.py --check || die "the public interface is not the stored one"

is_tagged=$(git tag --points-at HEAD --list "v$version")
if [ -n "$is_tagged" ] && grep -q "^## $version, not yet released" CHANGELOG.md; then
  die "CHANGELOG.md has no date for $version, which is tagged"
fi

if [ $check = 1 ]; then
  tools/version.py --notes >/dev/null
  if [ -n "$output" ]; then
    bill=$(mktemp)
    trap 'rm -f "$bill"' EXIT
    tools/packaging_tools/sbom.py --commit "$commit" --out "$bill" "$output"
  fi
  echo "release.sh: $version of ${commit:0:12} can be released"
  exit 0
fi

[ -n "$output" ] || die "name the folder of the release (see --help)"
[ -z "$(git status --porcelain --untracked-files=no)" ] || die "the tree has changes that are not committed"
[ -n "$is_tagged" ] || die "HEAD has no tag v$version: git tag v$version makes it that release (CONTRIBUTING.md, \"Release\")"
[ -z "$(ls -A "$output" 2>/dev/null)" ] || die "$output is not empty"
mkdir -p "$output"
output=$(realpath "$output")
# Not through ccache: it gives the compiler relative paths, which the messages of assertions then name.
[ -n "$build" ] || cmake --preset release -DFIRE3DV_CCACHE=OFF
tools/package.sh "${package_options[@]}" "$output"
build=${build:-build/release}
built=$("$build/bin/fire3dv" --version | head -n 1)
head=$(git rev-parse --short=12 HEAD)
[ "$built" = "fire3dv $version (commit $head)" ] ||
  die "$build is of another commit, or of changed files: it says \"$built\", HEAD is $head"
package_version=$(dpkg-deb -f "$output"/fire3dv_*.deb Version)
distribution=${package_version##*+}
[ "$package_version" = "$version-1+$distribution" ] ||
  die "the packages have the version $package_version, which is no release: configure $build again, now that the tag exists"
if [ $further = 1 ]; then
  rm "$output"/*.whl
else
  git -c tar.umask=0022 archive --format=tar --prefix="$archive/" "$commit" | xz -6 -T1 >"$output/$archive.tar.xz"
fi
tools/packaging_tools/sbom.py --commit "$commit" --out "$output/$archive-$distribution.spdx.json" "$build" "$output"/*
[ $further = 1 ] || tools/version.py --notes >"$output/RELEASE_NOTES.md"
(cd "$output" && sha256sum -- * >"SHA256SUMS-$distribution")
ls -l "$output"
