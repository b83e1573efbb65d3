# Minimal Debian systems in folders, for scripts that try this project on bare machines. Sourced, not run, by scripts that
# define say and die; needs root. Mounts are those of the caller's mount namespace (enter_mount_namespace).
. "$(dirname "${BASH_SOURCE[0]}")/apt_mirror.sh"

# Runs the script again where its mounts are seen by itself and its children alone, so that none is left behind.
enter_mount_namespace() { # the script and its arguments
  [ "$(id -u)" = 0 ] || die "run as root: chroot and mounts need it"
  [ "${FIRE3DV_BARE_MACHINE:-}" = entered ] || FIRE3DV_BARE_MACHINE=entered exec unshare --mount -- "$@"
}

# A made system carries this file. No other folder may be changed or emptied: a mistyped one could be somebody's system.
BARE_MARK=.fire3dv-bare

# Prints the absolute path of a folder, without a slash at its end; dies unless it is missing or a made system.
bare_directory() { # folder
  local directory
  directory=$(realpath -ms -- "$1")
  if [ "$directory" -ef / ] || { { [ -e "$directory" ] || [ -L "$directory" ]; } && [ ! -f "$directory/$BARE_MARK" ]; }; then
    die "$directory is no system that this script has made: name a folder that does not exist yet"
  fi
  printf '%s\n' "$directory"
}

# Makes a minimal system in a folder that does not exist; does nothing where it is made. An interrupted start leaves FOLDER.new,
# which the next one removes. Call it in a private mount namespace: debootstrap mounts /proc there.
make_bare_system() { # suite, folder of bare_directory, mirror ("": this machine's), options of debootstrap
  local suite=$1 directory=$2 mirror=$3 script=() scripts=/usr/share/debootstrap/scripts
  shift 3
  [ ! -e "$directory" ] || return 0
  command -v debootstrap > /dev/null || die "debootstrap is missing: apt-get install debootstrap"
  mirror=${mirror:-$(mirror_of_release "$(. /etc/os-release; echo "${VERSION_CODENAME:-}")")}
  [ -n "$mirror" ] || die "no apt source for the main section of this machine's release found in /etc/apt"
  bare_directory "$directory.new" > /dev/null
  rm -rf --one-file-system "$directory.new"
  install -d -m 755 "$directory.new"
  : > "$directory.new/$BARE_MARK"
  if [ ! -e "$scripts/$suite" ]; then  # a release newer than this debootstrap
    case "$*" in *--keyring=*ubuntu*) script=("$scripts/gutsy") ;; *) script=("$scripts/sid") ;; esac
  fi
  say "making a minimal $suite in $directory"
  debootstrap --variant=minbase "$@" "$suite" "$directory.new" "$mirror" "${script[@]}" > "$directory.log" 2>&1 || {
    tail -n 5 "$directory.log" >&2
    die "debootstrap failed; its log is $directory.log"
  }
  case "$suite" in bookworm | trixie)  # with updates, and in the format that scripts change
    printf 'Types: deb\nURIs: %s\nSuites: %s %s-updates\nComponents: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n' \
      "$mirror" "$suite" "$suite" > "$directory.new/etc/apt/sources.list.d/debian.sources"
    : > "$directory.new/etc/apt/sources.list" ;;
  esac
  mv -T "$directory.new" "$directory"
}

# Makes a minimal system of the suite bookworm or trixie where it is missing, and mounts what programs need.
open_bare_system() { # suite, folder of bare_directory
  local suite=$1 directory=$2 special file
  make_bare_system "$suite" "$directory" ""
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
