#!/usr/bin/env bash
# Installs those of the named Debian packages that are missing: bash scripts/packages.sh NAME ...
set -euo pipefail
missing=()
for package in "$@"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
if ((${#missing[@]} == 0)); then exit 0; fi
as_root=()
if [[ $(id -u) != 0 ]]; then
  command -v sudo > /dev/null || { echo "packages: missing: ${missing[*]}; there is no sudo: install them as root, then run this again" >&2; exit 1; }
  as_root=(sudo)
fi
echo "packages: installing ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
