#!/usr/bin/env bash
# Runs a command in a Debian unstable tree that compiles for other systems: Rust with the source of its standard library, MinGW for
# Windows, and Wine. Made once, in target/cache; this repository is /moulage in it.
#   release/tree.sh COMMAND...    as root, with debootstrap installed
set -euo pipefail
repository=$(realpath "$(dirname "$0")/..")
tree=$repository/target/cache/tree
packages="rustc cargo rust-src g++-mingw-w64-x86-64-posix lld cmake make wine wine64"
made=$tree/etc/moulage-packages
mkdir -p "$repository/target/cache"

make_tree() {
    rm -rf --one-file-system "$tree"
    mkdir -p "$tree"
    debootstrap --variant=minbase --include=ca-certificates sid "$tree" || return
    # Where a network has authorities of its own, cargo needs them.
    cp /etc/ssl/certs/ca-certificates.crt "$tree/etc/ssl/certs/"
    DEBIAN_FRONTEND=noninteractive chroot "$tree" apt-get install -y -qq --no-install-recommends $packages || return
    mkdir "$tree/moulage"
    echo "$packages" >"$made"
}
if [ "$(cat "$made" 2>/dev/null)" != "$packages" ]; then
    echo "making a Debian tree with compilers: some minutes" >&2
    make_tree >"$tree.log" 2>&1 || { tail -20 "$tree.log" >&2; exit 1; }
fi

# What is mounted is gone with the command.
export tree repository
exec unshare --mount --propagation private bash -c '
    mount --bind "$repository" "$tree/moulage"
    mount --rbind /dev "$tree/dev"
    mount -t proc proc "$tree/proc"
    exec chroot "$tree" env -i HOME=/root TERM=dumb PATH=/usr/bin:/bin:/usr/lib/wine LANG=C.UTF-8 WINEDEBUG=-all XDG_RUNTIME_DIR=/tmp \
        CARGO_HOME=/moulage/target/cache/cargo CARGO_TARGET_DIR=/moulage/target/cross \
        bash -c "cd /moulage && exec \"\$@\"" tree "$@"' tree "$@"
