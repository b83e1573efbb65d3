#!/usr/bin/env bash
# Cross-builds for aarch64 (Jetson, IGX) with Debian's compiler what needs no Vulkan: protocol, transports, client library,
# the programs that inspect, record and replay; then runs the tests of wire, transports, client library and Python package
# under qemu-user. Needs root on Debian 12 or 13. It adds the architecture arm64 and its libraries to the system, so that a
# bare machine is the place for it:
#
#   tools/bare_machine.sh bookworm DIR -- tools/cross_arm64.sh [--build-only]
#
# The build is in build/arm64; `ctest --preset arm64 -R NAME` runs a test again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build_only=0
case "${1:-}" in
  "") ;;
  --build-only) build_only=1 ;;
  -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
  *) echo "cross_arm64.sh: unknown option $1 (see --help)" >&2; exit 2 ;;
esac
say() { printf 'cross_arm64.sh: %s\n' "$*"; }
die() { echo "cross_arm64.sh: $*" >&2; exit 1; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT
logged() { "$@" > "$log" 2>&1 < /dev/null || { tail -n 20 "$log" >&2; die "failed: $*"; }; }
[ "$(id -u)" = 0 ] || die "run as root: packages are installed"

dpkg --add-architecture arm64
logged apt-get -q update
python=$(apt-cache depends python3 | sed -n 's/.*Depends: \(python3\.[0-9]*\)$/\1/p' | head -n 1)
packages=(
  crossbuild-essential-arm64 cmake ninja-build pkg-config git ca-certificates ccache file flatbuffers-compiler
  python3 qemu-user-static libasio-dev libcli11-dev libglm-dev nlohmann-json3-dev "lib$python-stdlib:arm64" libexpat1:arm64
)
for library in libboost libbullet libflatbuffers libgtest libjpeg liblz4 libpng libsodium libssl libzstd; do
  packages+=("$library-dev:arm64")
done
say "installing packages"
logged env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${packages[@]}"

logged cmake --preset arm64
tests=$(cmake --build --preset arm64 --target help | sed -n 's/^\(\(transport\|client\)_[a-z_]*test\): phony$/\1/p')
# shellcheck disable=SC2086
cmake --build --preset arm64 --target fire3dv_client fire3dv-inspect fire3dv-record fire3dv-replay client_c client_cpp \
  stream_dump wire_test conformance_test robot_test stream_test $tests
file -L build/arm64/bin/fire3dv-inspect | grep -q 'ARM aarch64' || die "build/arm64/bin/fire3dv-inspect is not for aarch64"
[ $build_only = 0 ] || exit 0

# Two tests watch a process with ptrace, which qemu-user lacks. Emulated ends are slow: Network.SlowListenerGetsNewest may need
# another try on a loaded machine.
ctest --preset arm64 --repeat until-pass:3 -R '^(wire|conformance|robot|stream|client|(transport|client)_.*)_test$|^client_exports$' \
  -E '^(client_hot_path|transport_shm_steps)_test$'

# The Python package, with an interpreter for aarch64: it cannot be installed beside this machine's own.
(cd build/arm64 && logged apt-get download -q "$python-minimal:arm64" && dpkg -x "$python"-minimal_*_arm64.deb python)
qemu=$(command -v qemu-aarch64-static)
printf '#!/bin/sh\nexec %s %s/build/arm64/tests/stream_dump "$@"\n' "$qemu" "$PWD" > build/arm64/stream_dump.sh
chmod +x build/arm64/stream_dump.sh
for scheme in shm tcp; do
  PYTHONHOME=/usr PYTHONPATH=adapters/generic/python PYTHONDONTWRITEBYTECODE=1 \
    FIRE3DV_CLIENT_LIBRARY=build/arm64/lib/libfire3dv-client.so.0 \
    "$qemu" "build/arm64/python/usr/bin/$python" -W ignore tests/e2e/python/python_module_test.py \
    "$PWD/build/arm64/stream_dump.sh" "$scheme" || die "the Python package fails over $scheme"
done
say "built for aarch64; tests of wire, transports, client library and Python package passed under qemu-user"
