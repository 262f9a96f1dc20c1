#!/bin/sh
# Tries the two commands of README on a Debian 12 that has nothing else: in a folder that debootstrap
# fills, with the files of the last commit. Needs root, debootstrap and 4 GB; the folder goes away.
#   tools/fresh.sh [COMMAND...]     without one: tools/demo.sh, then tools/test.sh
set -eu
cd "$(dirname "$0")/.."
command -v debootstrap >/dev/null || tools/setup.sh debootstrap
root=$(mktemp -d "${TMPDIR:-/tmp}/cpinn_fresh_XXXXXX")
leave() {
    umount "$root/proc" "$root/dev/pts" "$root/dev/shm" "$root/dev" 2>/dev/null || true
    rm -rf --one-file-system "$root"
}
trap leave EXIT
trap 'exit 130' INT TERM

echo "fresh: an empty Debian 12"
debootstrap --variant=minbase bookworm "$root" >"$root.log" 2>&1 || {
    tail -n 5 "$root.log"
    exit 1
}
rm "$root.log"
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mount --bind /dev "$root/dev"
mount -t tmpfs tmpfs "$root/dev/shm"
mount --bind /dev/pts "$root/dev/pts"
mount -t proc proc "$root/proc"
mkdir "$root/cpinn"
git archive HEAD | tar -x -C "$root/cpinn"

# inside COMMAND...: with an environment that has nothing of this one
inside() {
    echo "fresh: $*"
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
        chroot "$root" sh -c 'cd /cpinn && exec "$@"' sh "$@"
}
if [ $# -gt 0 ]; then
    inside "$@"
else
    inside tools/demo.sh
    inside tools/test.sh
fi
