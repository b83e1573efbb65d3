#!/usr/bin/env bash
# Builds the site from the documents, public headers and docstrings of the tree: static files that work on any web server and
# from the disk, without network. Needs Debian's python3-myst-parser, which brings Sphinx (tools/setup.sh --peers installs it).
#
#   tools/site.sh OUT       writes the site to the folder OUT; a former site there is replaced
#   tools/site.sh --check   builds it and checks its pages, groups and links
#   tools/site.sh --links   checks the links of all Markdown files without building; needs Python and NumPy alone
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
python=/usr/bin/python3  # Debian's, which its modules are installed for
"$python" -c 'import numpy' 2>/dev/null && { [ "${1:-}" = --links ] || "$python" -c 'import myst_parser, sphinx' 2>/dev/null; } || {
  echo "site.sh: python3-myst-parser or python3-numpy is missing: tools/setup.sh --peers installs them" >&2
  exit 3
}
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)" exec "$python" -m site_tools "$@"
