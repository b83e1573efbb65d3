#!/usr/bin/env bash
# Tries the Debian packages on a bare machine, a folder with nothing but Debian's minimal system in it: installation with
# apt, the README's quick start as an ordinary user with Mesa's CPU driver, upgrade from an older version, removal and purge.
# Needs root, debootstrap and the network.
#
#   tools/bare_packages.sh SUITE DIR PACKAGES [OLDER]
#
# SUITE is bookworm (Debian 12) or trixie (Debian 13); DIR is made if it does not exist, or is of an earlier run. PACKAGES is
# a folder of tools/package.sh, built on that suite; OLDER is one of an older version (default: PACKAGES with a lower version
# and one file more). The last line says what passed, with the size of the installation. Exit status 1: something failed;
# the line before says what.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/tools/bare_system.sh"

usage() { echo "bare_packages.sh: $*; tools/bare_packages.sh --help prints the usage" >&2; exit 2; }
say() { printf 'bare_packages.sh: %s\n' "$*"; }
die() { echo "bare_packages.sh: $*" >&2; exit 1; }

case "${1:-}" in -h | --help) sed -n '2,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
[ $# = 3 ] || [ $# = 4 ] || usage "a suite, a folder and the folder of the packages are needed"
suite=$1 packages=$3 older=${4:-}
[[ $suite =~ ^(bookworm|trixie)$ ]] || usage "the suite is bookworm or trixie, not '$suite'"
directory=$(bare_directory "$2")
enter_mount_namespace "${BASH_SOURCE[0]}" "$@"
ls "$packages"/*.deb > /dev/null 2>&1 || die "$packages holds no packages: tools/package.sh $packages builds them"
open_bare_system "$suite" "$directory"
log=$directory.packages.log
: > "$log"
start=$(date +%s)

inside() { in_bare_system "$directory" "$@" >> "$log" 2>&1 < /dev/null || { tail -n 20 "$log" >&2; die "failed: $* (all output: $log)"; }; }
apt() { inside apt-get -y -q -o Dpkg::Use-Pty=0 "$@"; }
as_user() { inside runuser -u tester -- env HOME=/home/tester bash -ec "cd; $1"; }
# Paths of the system, without what changes by itself: indices, caches and logs of apt, dpkg and ldconfig.
paths() {
  (cd "$directory" && find . -xdev \( -path ./proc -o -path ./sys -o -path ./dev -o -path ./tmp -o -path ./home -o -path ./packages \
    -o -path ./var/lib/apt -o -path ./var/lib/dpkg -o -path ./var/cache -o -path ./var/log -o -path ./etc/apt \) -prune -o -print | sort)
}
names=()
for package in "$packages"/*.deb; do names+=("$(dpkg-deb -f "$package" Package)"); done
installed() { in_bare_system "$directory" dpkg-query -W -f '${db:Status-Status} ${Package}\n' | sed -n 's/^installed //p' | sort; }
expect_version() { # folder
  local package name version
  for package in "$1"/*.deb; do
    name=$(dpkg-deb -f "$package" Package) version=$(dpkg-deb -f "$package" Version)
    [ "$(in_bare_system "$directory" dpkg-query -W -f '${db:Status-Status} ${Version}' "$name")" = "installed $version" ] ||
      die "$name $version is not installed"
  done
}

rm -rf "$directory/packages" && mkdir -p "$directory/packages/new" "$directory/packages/old"
cp "$packages"/*.deb "$directory/packages/new"
if [ -n "$older" ]; then
  cp "$older"/*.deb "$directory/packages/old"
else  # the same with version 0.0.1, also in what they demand of each other, and a file that the newer ones lack
  for package in "$packages"/*.deb; do
    unpacked=$(mktemp -d) name=$(dpkg-deb -f "$package" Package) version=$(dpkg-deb -f "$package" Version)
    dpkg-deb -R "$package" "$unpacked"
    sed -i "s/\\<$version/0.0.1-1/g" "$unpacked/DEBIAN/control"
    echo older > "$unpacked/usr/share/doc/$name/older-file"
    dpkg-deb -Znone --root-owner-group -b "$unpacked" "$directory/packages/old/${name}_0.0.1.deb" >> "$log"
    rm -rf "$unpacked"
  done
fi
for package in "$directory"/packages/old/*.deb; do
  dpkg --compare-versions "$(dpkg-deb -f "$package" Version)" lt "$(dpkg-deb -f "$(ls "$directory"/packages/new/fire3dv_*.deb)" Version)" ||
    die "$package is no older version"
done

apt update
[ -e "$directory/home/tester" ] || inside useradd -m tester
if [ "$suite" = bookworm ]; then  # its own Mesa has no CPU driver that can be used (docs/install.md)
  sed "s/^Suites:.*/Suites: bookworm-backports/" "$directory/etc/apt/sources.list.d/debian.sources" > "$directory/etc/apt/sources.list.d/backports.sources"
  apt update
fi
paths > "$log.before"
installed > "$log.packages"
bytes_before=$(du -sxB1 "$directory" | cut -f1)

say "older version: installation"
inside bash -c 'apt-get -y -q install /packages/old/*.deb'
expect_version "$directory/packages/old"
if [ "$suite" = bookworm ]; then
  apt install -t bookworm-backports mesa-vulkan-drivers
  inside apt-mark auto mesa-vulkan-drivers  # removed with the package that recommends it
fi

say "upgrade"
inside bash -c 'apt-get -y -q install /packages/new/*.deb'
expect_version "$directory/packages/new"
left=$(find "$directory/usr/share/doc" -name older-file)
[ -z "$left" ] || die "files of the older version remain: $left"
apt clean
size=$((($(du -sxB1 "$directory" | cut -f1) - bytes_before) / 1000000))

say "quick start, as an ordinary user"
quick_start=$(date +%s)
as_user 'rm -rf images arm.* && bullet_arm --write-scene arm.glb
  fire3dv arm.glb --listen shm://demo --headless --size 320x180 --camera camera_front --wait-for-stream --frames 10 --out images &
  bullet_arm --to shm://demo --loop & simulator=$!
  wait %1; kill $simulator
  ls images/frame_000009.png
  [ "$(sha256sum images/*.png | cut -d" " -f1 | sort -u | wc -l)" -gt 1 ] || { echo "all images are the same"; exit 1; }'
say "10 images of the moving arm after $(($(date +%s) - quick_start)) s"
as_user 'cat > arm.py <<END
import fire3dv
with fire3dv.Renderer("arm.glb") as renderer, renderer.stream() as stream:
    stream.describe(["sphere_00"])
    stream.publish(0, fire3dv.pose((0, 1, 0.5), quaternion=(0, 0, 0, 1)))
    view = fire3dv.look_at(eye=(1.5, 1.2, 2), target=(0, 0.5, 0))
    request = stream.request_image(64, 48, fx=60, parent_from_camera=view)
    request.wait().save("arm.png")
END
  python3 -W ignore arm.py && ls arm.png'
for program in "$directory"/usr/bin/fire3dv* "$directory/usr/bin/bullet_arm"; do as_user "$(basename "$program") --version"; done

say "removal"
apt purge "${names[@]}"
# Also what packages that were there before recommend or suggest, such as apt ca-certificates.
apt autoremove --purge -o APT::AutoRemove::RecommendsImportant=false -o APT::AutoRemove::SuggestsImportant=false
[ "$suite" != bookworm ] || inside rm /etc/apt/sources.list.d/backports.sources
paths > "$log.after"
left=$(installed | comm -13 "$log.packages" - | tr '\n' ' ')
[ -z "$left" ] || die "packages remain: $left"
[ ! -e "$directory/var/lib/dpkg/info/fire3dv.list" ] || die "dpkg still knows fire3dv"
left=$(diff "$log.before" "$log.after" || true)
[ -z "$left" ] || die "files differ from those before the installation (<: lost, >: left):"$'\n'"$left"
rm "$log.before" "$log.after" "$log.packages"
say "packages on Debian $(cat "$directory/etc/debian_version"): $(dpkg-deb -f "$directory"/packages/new/fire3dv_*.deb Version)" \
  "passed after $(($(date +%s) - start)) s; installed with all that they need and recommend: $size MB"
