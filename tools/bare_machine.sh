#!/usr/bin/env bash
# Runs the demo, the tests or a command on a bare machine: a folder with nothing but Debian's minimal system in it, which
# is entered with chroot. Needs root, debootstrap and the network. The commit that is checked out is cloned into the
# folder; changes that are not committed do not take part.
#
#   tools/bare_machine.sh SUITE DIR demo [OPTION...]     runs tools/demo.sh there
#   tools/bare_machine.sh SUITE DIR tests [OPTION...]    runs tools/test.sh there
#   tools/bare_machine.sh SUITE DIR -- COMMAND [ARG...]  runs a command in the clone, as root
#
# SUITE is bookworm (Debian 12) or trixie (Debian 13). DIR is made if it does not exist; one of an earlier run is used as it
# is (packages that were installed there stay, the clone is renewed). The last line says what ran, on which system, at which
# commit, for how long. Exit status: that of the command.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/tools/bare_system.sh"

usage() { echo "bare_machine.sh: $*; tools/bare_machine.sh --help prints the usage" >&2; exit 2; }
say() { printf 'bare_machine.sh: %s\n' "$*"; }
die() { echo "bare_machine.sh: $*" >&2; exit 1; }

case "${1:-}" in -h | --help) sed -n '2,14s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
[ $# -ge 3 ] || usage "a suite, a folder and what to run are needed"
suite=$1 what=$3
[[ $suite =~ ^(bookworm|trixie)$ ]] || usage "the suite is bookworm or trixie, not '$suite'"
directory=$(bare_directory "$2")
enter_mount_namespace "${BASH_SOURCE[0]}" "$@"
shift 3
case "$what" in
  demo) command=(tools/demo.sh "$@") ;;
  tests) command=(tools/test.sh "$@") ;;
  --) [ $# -gt 0 ] || usage "a command must follow --"; command=("$@") what=$* ;;
  *) usage "'$what' is neither demo nor tests nor --" ;;
esac
open_bare_system "$suite" "$directory"

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
in_bare_system "$directory" \
  bash -c 'cd /root/fire-3dv && exec "$@"' bash "${command[@]}" < /dev/null || status=$?
say "$what on Debian $(cat "$directory/etc/debian_version") at $commit: $([ $status = 0 ] && echo passed || echo "failed ($status)")" \
  "after $(($(date +%s) - start)) s"
exit $status
