# The package mirror of this machine, for scripts that need packages of another release. Sourced, not run.

# Prints the mirror that the machine's apt sources name for a release (a code name such as bookworm); nothing if none.
mirror_of_release() {
  apt-get indextargets --format '$(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
    awk -v release="$1" '$2 == release && $3 == "main" { sub("/$", "", $1); print $1; exit }'
}
