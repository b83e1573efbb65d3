#!/usr/bin/env bash
# Builds the Debian packages and the Python wheel (docs/install.md).
#
#   tools/package.sh [OUTPUT_DIR]            builds the preset release if needed; OUTPUT_DIR: build/packages, where
#                                            older packages are replaced
#   tools/package.sh --build DIR OUTPUT_DIR  packs this finished build, builds nothing
#   tools/package.sh --compression NAME ...  of the Debian packages: xz (default), gzip
#   tools/package.sh --cpu-driver ...        also builds the wheel fire3dv-cpu, of this machine's Mesa
#
# The Debian packages are for the distribution that they are built on. FIRE3DV_PACKAGE_MAINTAINER="NAME <E-MAIL>" in the
# environment names who distributes them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build= output= compression=xz cpu_driver=0
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build=${2:?--build needs a folder}; shift ;;
    --compression) compression=${2:?--compression needs a name}; shift ;;
    --cpu-driver) cpu_driver=1 ;;
    -h | --help) sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "package.sh: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) output=$1 ;;
  esac
  shift
done
output=${output:-build/packages}
die() { printf 'package.sh: %s\n' "$*" >&2; exit 1; }
for tool in cpack dpkg-deb dpkg-shlibdeps file go-md2man patchelf python3; do
  command -v "$tool" >/dev/null || die "$tool is missing: run tools/setup.sh"
done

if [ -z "$build" ]; then
  build=build/release
  cmake --preset release ${FIRE3DV_PACKAGE_MAINTAINER:+"-DFIRE3DV_PACKAGE_MAINTAINER=$FIRE3DV_PACKAGE_MAINTAINER"}
  targets=(fire3dv fire3dv-convert fire3dv-inspect fire3dv-record fire3dv-replay fire3dv_client fire3dv_client_inside
           fire3dv_manual_pages)
  known=$(cmake --build "$build" --target help)
  for optional in bullet_arm fire3dv-drake fire3dv-gazebo fire3dv-mujoco fire3dv-ros2; do
    ! grep -q "^$optional:" <<<"$known" || targets+=("$optional")
  done
  cmake --build "$build" --target "${targets[@]}"
fi
[ -e "$build/CPackConfig.cmake" ] || die "$build is not configured for packages: they need Debian or Ubuntu and the renderer"

# Dates in packages are the commit's, modes do not depend on the user: a build gives the same bytes each time.
umask 022
if [ -z "${SOURCE_DATE_EPOCH:-}" ]; then
  if [ -e .git ]; then  # not that of an outer repository
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || true)
  else  # an archive of git
    SOURCE_DATE_EPOCH=$(sed -n 's/^[0-9a-f]\+ \([0-9]\+\)$/\1/p' cmake/archive_commit.txt)
  fi
fi
[ -z "$SOURCE_DATE_EPOCH" ] || export SOURCE_DATE_EPOCH

mkdir -p "$output"
output=$(realpath "$output")
staging=$(mktemp -d)
trap 'rm -rf "$staging"' EXIT
cpack --config "$build/CPackConfig.cmake" -G DEB -B "$staging" -D CPACK_DEBIAN_COMPRESSION_TYPE="$compression" >"$staging/log.txt" 2>&1 ||
  { cat "$staging/log.txt" >&2; die "cpack failed"; }
# The system's own Python has the modules that setup.sh installs; the first one on the PATH need not.
/usr/bin/python3 tools/wheel.py "$build" "$staging"
[ $cpu_driver = 0 ] || /usr/bin/python3 tools/wheel.py --cpu "$staging"
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error "$staging"/*.deb || die "lintian reports errors"
fi
for package in "$staging"/*.deb "$staging"/*.whl; do  # apt install OUTPUT_DIR/*.deb takes one version of each
  name=$(basename "$package")
  case "$name" in
    *.deb) rm -f "$output/${name%%_*}"_*.deb ;;
    *.whl) rm -f "$output/${name%%-*}"-*.whl ;;
  esac
done
mv "$staging"/*.deb "$staging"/*.whl "$output"/
ls -l "$output"
