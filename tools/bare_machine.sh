#!/usr/bin/env bash
# Runs the demo, the tests or a command on a bare machine: a folder with nothing but Debian's minimal system in it, which
# is entered with chroot. Needs root, debootstrap and the network. The commit that is checked out is cloned into the
# folder; changes that are not committed do not take part.
#
#   tools/bare_machine.sh SUITE DIR demo [OPTION...]     runs tools/demo.sh there
#   tools/bare_machine.sh SUITE DIR tests [OPTION...]    runs tools/test.sh there
#   tools/bare_machine.sh SUITE DIR -- COMMAND [ARG...]  runs a command in the clone, as root
#
# SUITE is bookworm (Debian 12) or trixie (Debian 13). DIR is made if it does not exist; an existing one is used as it is
# (packages that were installed there stay, the clone is renewed). The last line says what ran, on which system, at which
# commit, for how long. Exit status: that of the command.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/tools/apt_mirror.sh"
. /etc/os-release

usage() { echo "bare_machine.sh: $*; tools/bare_machine.sh --help prints the usage" >&2; exit 2; }
say() { printf 'bare_machine.sh: %s\n' "$*"; }
die() { echo "bare_machine.sh: $*" >&2; exit 1; }

case "${1:-}" in -h | --help) sed -n '2,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
[ $# -ge 3 ] || usage "a suite, a folder and what to run are needed"
[ "$(id -u)" = 0 ] || die "run as root: chroot and mounts need it"
if [ "${FIRE3DV_BARE_MACHINE:-}" != entered ]; then
  # Mounts are seen by this process and its children alone, so that none is left behind.
  FIRE3DV_BARE_MACHINE=entered exec unshare --mount -- "${BASH_SOURCE[0]}" "$@"
fi
suite=$1 directory=$2 what=$3
shift 3
[[ $suite =~ ^(bookworm|trixie)$ ]] || usage "the suite is bookworm or trixie, not '$suite'"
case "$what" in
  demo) command=(tools/demo.sh "$@") ;;
  tests) command=(tools/test.sh "$@") ;;
  --) [ $# -gt 0 ] || usage "a command must follow --"; command=("$@") what=$* ;;
  *) usage "'$what' is neither demo nor tests nor --" ;;
esac
if [ ! -e "$directory" ]; then
  command -v debootstrap > /dev/null || die "debootstrap is missing: apt-get install debootstrap"
  mirror=$(mirror_of_release "${VERSION_CODENAME:-}")
  [ -n "$mirror" ] || die "no apt source for the main section of this machine's release found in /etc/apt"
  say "making a minimal $suite in $directory"
  debootstrap --variant=minbase "$suite" "$directory" "$mirror" > "$directory.log" 2>&1 || {
    tail -n 5 "$directory.log" >&2
    die "debootstrap failed; its log is $directory.log"
  }
  printf 'Types: deb\nURIs: %s\nSuites: %s %s-updates\nComponents: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n' \
    "$mirror" "$suite" "$suite" > "$directory/etc/apt/sources.list.d/debian.sources"
  : > "$directory/etc/apt/sources.list"
fi
[ -x "$directory/usr/bin/apt-get" ] || die "$directory is not a Debian system: name a folder that does not exist yet"
grep -q "^VERSION_CODENAME=$suite\$" "$directory/etc/os-release" || die "$directory has another system than $suite"

for special in proc dev sys; do mount --rbind "/$special" "$directory/$special"; done
mount -t tmpfs -o size=50% tmpfs "$directory/dev/shm"  # not this machine's: its segments are no business of the bare one
for file in resolv.conf hosts; do cp "/etc/$file" "$directory/etc/$file"; done

commit=$(git -C "$root" rev-parse --short HEAD)
clone=$directory/root/fire-3dv
rm -rf "$clone/.git-source" && mkdir -p "$clone"
# The clone is made outside, since a bare machine has no git; files that are the same keep their times for incremental builds.
git -c safe.directory='*' clone -q --no-hardlinks "$root" "$clone/.git-source"
rm -rf "$clone/.git" && mv "$clone/.git-source/.git" "$clone/.git" && rm -rf "$clone/.git-source"
git_in_clone() { git -c safe.directory='*' -C "$clone" "$@"; }
git_in_clone update-index -q --refresh || true
git_in_clone reset -q --hard HEAD
git_in_clone clean -fdq  # what an earlier clone had; ignored files, such as builds, stay

say "running ${command[*]} on Debian $(cat "$directory/etc/debian_version") at commit $commit"
start=$(date +%s) status=0
chroot "$directory" /usr/bin/env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
  LANG=C.UTF-8 ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
  bash -c 'cd /root/fire-3dv && exec "$@"' bash "${command[@]}" < /dev/null || status=$?
say "$what on Debian $(cat "$directory/etc/debian_version") at $commit: $([ $status = 0 ] && echo passed || echo "failed ($status)")" \
  "after $(($(date +%s) - start)) s"
exit $status
