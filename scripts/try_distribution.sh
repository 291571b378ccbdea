#!/bin/sh
# Builds the command in a tree of another Debian (or Ubuntu) and labels a recording there: everything from that
# system's packages, which scripts/install_dependencies.sh installs. Needs root, debootstrap and a mirror.
# usage: scripts/try_distribution.sh SUITE [FOLDER]
#   SUITE   bookworm, trixie (Debian) or jammy, noble (Ubuntu)
#   FOLDER  of the tree (default build/try/SUITE); kept, so that a second run is short
# MIRROR names the mirror; default: that of this system's apt for Debian, else archive.ubuntu.com.
set -eu
cd "$(dirname "$0")/.."
suite=${1:?usage: scripts/try_distribution.sh SUITE [FOLDER]}
tree=${2:-$PWD/build/try/$suite}
jobs=${JOBS:-$(nproc)}

fail() {
  echo "scripts/try_distribution.sh: $*" >&2
  exit 1
}
[ "$(id -u)" -eq 0 ] || fail "debootstrap and chroot need root"
# What is mounted in the tree is seen by this script alone, and gone with it, however it ends.
[ -n "${MAPLESS_OWN_MOUNTS:-}" ] || exec env MAPLESS_OWN_MOUNTS=1 unshare --mount "$PWD/scripts/try_distribution.sh" "$@"
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"

case $suite in
jammy | noble) mirror=${MIRROR:-http://archive.ubuntu.com/ubuntu} components=main,universe ;;
*)
  configured=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 2>/dev/null | grep -m 1 '/debian/*$' || true)
  mirror=${MIRROR:-${configured:-http://deb.debian.org/debian}} components=main ;;
esac
mirror=${mirror%/}  # some mirrors refuse //

if [ ! -e "$tree/.complete" ]; then
  wget -q -T 20 -t 1 -O /dev/null "$mirror/dists/$suite/Release" ||
    fail "$mirror has no $suite, or cannot be reached from here; another mirror: MIRROR=http://..."
  mkdir -p "$tree"
  debootstrap --variant=minbase --components="$components" --include=ca-certificates "$suite" "$tree" "$mirror" >"$tree.log" 2>&1 ||
    { tail -n 3 "$tree.log"; fail "no tree of $suite from $mirror; is its key in /usr/share/keyrings \
(packages debian-archive-keyring, ubuntu-keyring)?"; }
  touch "$tree/.complete"
fi

# The sources as they are now; and the names of hosts, as this system finds them.
rm -rf "$tree/mapless/sources"
mkdir -p "$tree/mapless/sources"
tar --exclude=./build --exclude=./out --exclude=./.git --create . | tar --extract --directory "$tree/mapless/sources"
cp -L /etc/resolv.conf "$tree/etc/resolv.conf"
[ ! -r /etc/ssl/certs/ca-certificates.crt ] || cp -L /etc/ssl/certs/ca-certificates.crt "$tree/etc/ssl/certs/"

cat >"$tree/mapless/try.sh" <<'END'
#!/bin/sh
set -eu
cd /mapless/sources
export LC_ALL=C
. /etc/os-release && echo "$PRETTY_NAME"
scripts/install_dependencies.sh >/mapless/install.log 2>&1 || { tail -n 5 /mapless/install.log && exit 1; }
c++ --version | head -n 1
cmake --version | head -n 1
cmake --preset release -B /mapless/build -DMAPLESS_BUILD_TESTS=OFF -DMAPLESS_BUILD_BENCHMARKS=OFF >/mapless/build.log ||
  { tail -n 20 /mapless/build.log && exit 1; }
cmake --build /mapless/build -j "$JOBS" --target mapless_command >>/mapless/build.log ||
  { grep -E -A 3 'error|FAILED' /mapless/build.log | head -n 60 && exit 1; }
mapless=/mapless/build/apps/mapless/mapless
rm -rf /mapless/recording /mapless/result
"$mapless" simulate highway --sensor VLP-16 --duration-s 2 -o /mapless/recording
"$mapless" detect /mapless/recording -o /mapless/result >/dev/null
"$mapless" evaluate /mapless/recording /mapless/result | head -n 12
END
chmod +x "$tree/mapless/try.sh"

mount -t proc proc "$tree/proc"
chroot "$tree" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root JOBS="$jobs" /mapless/try.sh
