#!/usr/bin/env bash
# Puts MeshLab's sources (for the headers) into FOLDER/source, from the Debian mirror that this
# machine uses. System settings of apt are left alone.
#   tests/meshlab/sources.sh FOLDER
set -euo pipefail
folder=$(realpath -m "$1")
[ -d "$folder/source/src/common" ] && exit 0
mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep -E '/debian/?$' | head -1)
[ -n "$mirror" ] || { echo "apt has no Debian mirror"; exit 1; }
apt=$folder/apt
mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
echo "deb-src $mirror sid main" >"$apt/sources.list"
options=(-o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$apt/lists" -o Dir::Cache="$apt/cache" -o Acquire::Check-Valid-Until=false
    -o APT::Sandbox::User=root)
apt-get "${options[@]}" -qq update
(cd "$apt" && apt-get "${options[@]}" -qq source --tar-only --download-only meshlab)
archive=$(ls "$apt"/meshlab_*.orig.tar.xz)
# Debian's newest: tested with this one; another one is worth a word, not a stop.
tested=d22c98d362f2a284e481af8dbfc272b2222f5b9c67b3cf8bec57d1c3161886f4
echo "$tested  $archive" | sha256sum --check --status || echo "note: $(basename "$archive") is not the MeshLab this was tested with"
mkdir -p "$folder/source"
tar -xf "$archive" -C "$folder/source" --strip-components=1
