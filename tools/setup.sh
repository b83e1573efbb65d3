#!/usr/bin/env bash
# Installs the packages that FIRE-3DV needs for build, run time and tests. Needs root or sudo and asks nothing. Changes
# nothing (not even the package index) when all packages are installed.
#
#   tools/setup.sh            installs what the build and most tests need
#   tools/setup.sh --peers    installs also the programs and libraries that tests talk to; tools/test.sh does this
#   tools/setup.sh --check    lists missing packages; exit code 1 if there are any
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/apt_mirror.sh"

packages=(
  # build
  build-essential cmake ninja-build pkg-config git ca-certificates ccache
  glslang-tools spirv-tools flatbuffers-compiler
  # libraries; docs/dependencies.md lists their uses
  libvulkan-dev libglm-dev libtinygltf-dev libflatbuffers-dev libasio-dev libboost-dev libpng-dev libglfw3-dev
  libssl-dev libsodium-dev libcli11-dev libstb-dev nlohmann-json3-dev libmeshoptimizer-dev libzstd-dev liblz4-dev
  libwebp-dev libjpeg-dev libdraco-dev libopenexr-dev
  libassimp-dev libyaml-cpp-dev liburdfdom-dev libconsole-bridge-dev libtinyxml2-dev
  libavformat-dev libavcodec-dev libavutil-dev libswscale-dev libhdf5-dev libsqlite3-0
  libimgui-dev fonts-dejavu-core  # panels and their font
  # example simulator
  libbullet-dev
  # tests
  libgtest-dev vulkan-validationlayers vulkan-tools xvfb xauth libxtst6 strace python3
  iproute2 openssl  # network namespaces, two hosts on one machine, and their certificate
  python3-numpy python3-pip python3-setuptools python3-venv python3-wheel  # Python package: arrays, installation with pip
  python3-yaml  # files of containers/
  python3-h5py  # reads HDF5 data sets in a test
  go-md2man  # manual pages
  patchelf  # wheels: search paths of carried libraries
  libegl1 libxext6  # wheels: carried for NVIDIA's driver
  ffmpeg     # video of the demo
  file       # packages: CPack finds programs with it
)
# Optional, installed where the distribution has them. MuJoCo: examples/two_simulators and adapters/mujoco, which are
# skipped without it. EGL and OpenGL: comparison with MuJoCo's own renderer.
# KDL: oracle of a test. libsdformat (Debian 12, not 13): fire3dv-convert's SDF reader. ZeroMQ and protobuf:
# adapters/gazebo. Cyclone DDS: adapters/ros2. Dask: the test of examples/dask.
optional_packages=(libmujoco-dev libegl-dev libopengl-dev liborocos-kdl-dev libsdformat-dev
  libzmq3-dev libprotobuf-dev protobuf-compiler cyclonedds-dev cyclonedds-tools python3-distributed)
# With --peers: programs and libraries of others that tests talk to, where the distribution has them. ignition-transport
# for adapters/gazebo; Fast DDS, ROS 2's other DDS library, and tf2 of ROS 1 as oracle for adapters/ros2; Chromium for the
# live view's page; clang-format 14 (Debian 12) and universal-ctags for the checks of format and structure; MyST (and by
# it Sphinx) for the site; validators of packages and of their desktop files.
peer_packages=(libignition-transport-dev libignition-msgs-dev libfastrtps-dev libtf2-dev chromium clang-format-14 universal-ctags
  python3-myst-parser lintian appstream desktop-file-utils shared-mime-info)
mesa_packages=(mesa-vulkan-drivers)

check=0
for argument in "$@"; do
  case "$argument" in
    --peers) optional_packages+=("${peer_packages[@]}") ;;
    --check) check=1 ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) printf 'setup: unknown option %s (there are --peers and --check)\n' "$argument" >&2; exit 2 ;;
  esac
done

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: %s\n' "$*" >&2; exit 1; }

manual_list() {
  cat >&2 <<TEXT
setup: this system is not one that the script installs packages on (Debian 12 and 13, Ubuntu 24.04 are).
Install by hand, then run again with FIRE3DV_SKIP_SETUP=1:
  - a C++20 compiler (g++ 12 or newer), CMake 3.25, Ninja, pkg-config, git
  - glslangValidator, spirv-val, flatc with the FlatBuffers headers of the same version (2.0 or newer)
  - Vulkan loader and headers 1.3, Vulkan Memory Allocator 3 (header vk_mem_alloc.h), GLM 0.9.9, GLFW 3.3,
    Dear ImGui 1.86 to 1.90 (with a pkg-config file), the font DejaVu Sans
  - tinygltf 2.7 or newer, stb_image, libwebp 1.2, libjpeg-turbo 2.1, OpenEXR 3.1, nlohmann-json, meshoptimizer 0.18, Draco 1.5, libpng, standalone Asio 1.22, Boost.Interprocess and Boost.Beast 1.74 (headers),
    OpenSSL 3, libsodium, zstd, lz4,
    CLI11 2, assimp 5.2, yaml-cpp 0.7, urdfdom 3 or 4, console_bridge 1, TinyXML-2 9,
    FFmpeg 5.1 (libavformat, libavcodec, libavutil, libswscale; with x264, x265, SVT-AV1), HDF5 1.10 (data sets)
  - optional: go-md2man for the manual pages; Eclipse Cyclone DDS 0.10 with idlc for ROS 2; libsdformat 12 for SDF files
  - for the example and the tests: Bullet 3, GoogleTest, Vulkan validation layers, Xvfb, libXtst, strace, Python 3 with NumPy, pip, setuptools and venv, iproute2, openssl, ffmpeg; for the comparison with MuJoCo's renderer: EGL and libOpenGL
  - without a GPU: Mesa's lavapipe 24.1 or newer (ray queries)
TEXT
  exit 1
}

[ "${FIRE3DV_SKIP_SETUP:-0}" = 1 ] && { say "skipped (FIRE3DV_SKIP_SETUP=1)"; exit 0; }
command -v apt-get >/dev/null && command -v dpkg-query >/dev/null && [ -r /etc/os-release ] || manual_list
. /etc/os-release
case "${ID:-}-${VERSION_ID:-}" in
  debian-12) mesa_from=bookworm-backports; vma_from=trixie ;;  # its lavapipe lacks ray queries, and it has no VMA
  debian-13) mesa_from=; vma_from= ;;
  ubuntu-24.04) mesa_from=; vma_from= ;;
  *) manual_list ;;
esac
vma_package=libvulkan-memory-allocator-dev

# Version of a package for this machine's own architecture; others may be installed, too.
installed_version() {
  dpkg-query -W -f '${Architecture} ${db:Status-Status} ${Version}\n' "$1" 2>/dev/null |
    awk -v own="$(dpkg --print-architecture)" '$2 == "installed" && ($1 == own || $1 == "all") { print $3; exit }'
}
installed() { [ -n "$(installed_version "$1")" ]; }
mesa_is_new_enough() { # ray queries on lavapipe came with Mesa 24.1
  installed mesa-vulkan-drivers &&
    dpkg --compare-versions "$(installed_version mesa-vulkan-drivers)" ge 24.1
}

missing=()
for package in "${packages[@]}" "$vma_package"; do installed "$package" || missing+=("$package"); done
known_to_apt() { apt-cache show "$1" >/dev/null 2>&1; }
for package in "${optional_packages[@]}"; do installed "$package" || ! known_to_apt "$package" || missing+=("$package"); done
mesa_missing=0
mesa_is_new_enough || mesa_missing=1

if [ ${#missing[@]} -eq 0 ] && [ $mesa_missing -eq 0 ]; then say "everything is installed"; exit 0; fi
[ $mesa_missing -eq 1 ] && mesa_text=" ${mesa_packages[*]}(>=24.1)" || mesa_text=
[ $check = 1 ] && { say "missing: ${missing[*]}$mesa_text"; exit 1; }

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || die "run as root, or install sudo: packages are missing: ${missing[*]}$mesa_text"
  as_root=(sudo)
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt_get() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a \
    apt-get -qq -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" >"$log" 2>&1 </dev/null
}
apt() {
  apt_get "$@" && return
  tail -n 30 "$log" >&2
  die "apt-get $1 failed: the reason is above"
}
# An unreachable package source is no reason to stop; missing packages are reported later.
apt_update() { apt_get update || { tail -n 5 "$log" >&2; say "some package lists could not be read; continuing without them"; }; }

add_source() { # suite, pin lines
  local file=/etc/apt/sources.list.d/fire3dv-$1.sources
  local mirror; mirror=$(mirror_of_release "$VERSION_CODENAME")
  [ -n "$mirror" ] || die "no apt source for $VERSION_CODENAME main found in /etc/apt: add one, then run again"
  printf 'Types: deb\nURIs: %s\nSuites: %s\nComponents: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n' \
    "$mirror" "$1" | "${as_root[@]}" tee "$file" >/dev/null
}
pin() { # file, package, release, priority
  printf 'Package: %s\nPin: release n=%s\nPin-Priority: %s\n\n' "$2" "$3" "$4" |
    "${as_root[@]}" tee -a "/etc/apt/preferences.d/$1" >/dev/null
}

say "installing, which takes a minute or two: ${missing[*]:-}$mesa_text"
apt_update
if [ -n "$mesa_from" ] && [ $mesa_missing -eq 1 ]; then
  apt-cache policy mesa-vulkan-drivers | grep "$mesa_from" >/dev/null || add_source "$mesa_from"
fi
if [ -n "$vma_from" ] && ! installed "$vma_package"; then
  "${as_root[@]}" rm -f /etc/apt/preferences.d/fire3dv
  pin fire3dv '*' "$vma_from" -1                # blocks other packages of the newer release
  pin fire3dv "$vma_package" "$vma_from" 500    # headers only, identical on all architectures
  add_source "$vma_from"
fi
apt_update
for package in "${optional_packages[@]}"; do
  installed "$package" || [[ " ${missing[*]:-} " == *" $package "* ]] || ! known_to_apt "$package" || missing+=("$package")
done
# --no-install-recommends: a rendering machine needs no desktop.
[ ${#missing[@]} -eq 0 ] || apt install -y --no-install-recommends "${missing[@]}"
if [ $mesa_missing -eq 1 ]; then
  if [ -n "$mesa_from" ]; then
    # Libraries that share files with the driver must have the same version.
    for package in libgl1-mesa-dri libegl-mesa0 libglx-mesa0 libgbm1 libglapi-mesa; do
      installed "$package" && mesa_packages+=("$package")
    done
    apt install -y --no-install-recommends -t "$mesa_from" "${mesa_packages[@]}"
  else
    apt install -y --no-install-recommends "${mesa_packages[@]}"
  fi
fi
mesa_is_new_enough || die "mesa-vulkan-drivers is $(installed_version mesa-vulkan-drivers); 24.1 or newer is needed for ray queries on lavapipe"
say "done"
