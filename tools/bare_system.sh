# Minimal Debian systems in folders, for scripts that try this project on bare machines. Sourced, not run, by scripts that
# define say and die; needs root. Mounts are those of the caller's mount namespace (enter_mount_namespace).
. "$(dirname "${BASH_SOURCE[0]}")/apt_mirror.sh"

# Runs the script again where its mounts are seen by itself and its children alone, so that none is left behind.
enter_mount_namespace() { # the script and its arguments
  [ "$(id -u)" = 0 ] || die "run as root: chroot and mounts need it"
  [ "${FIRE3DV_BARE_MACHINE:-}" = entered ] || FIRE3DV_BARE_MACHINE=entered exec unshare --mount -- "$@"
}

# Makes a minimal system of the suite bookworm or trixie in a folder that does not exist, or checks the one there, and
# mounts what programs need.
open_bare_system() { # suite, folder
  local suite=$1 directory=$2 mirror special file
  if [ ! -e "$directory" ]; then
    command -v debootstrap > /dev/null || die "debootstrap is missing: apt-get install debootstrap"
    mirror=$(mirror_of_release "$(. /etc/os-release; echo "${VERSION_CODENAME:-}")")
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
}

in_bare_system() { # folder, command with arguments
  local directory=$1
  shift
  chroot "$directory" /usr/bin/env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive ${http_proxy:+http_proxy="$http_proxy"} \
    ${https_proxy:+https_proxy="$https_proxy"} "$@"
}
