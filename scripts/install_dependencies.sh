#!/bin/sh
# Installs the Debian packages that building (and, with "test", testing) needs. Asks dpkg first, so that it needs
# neither root nor a network where everything is there already.
# usage: scripts/install_dependencies.sh [test]
set -eu

packages="cmake g++ ninja-build pkg-config
  libeigen3-dev libtbb-dev libnanoflann-dev libyaml-cpp-dev libfmt-dev libspdlog-dev
  libprotobuf-dev protobuf-compiler libembree-dev libcli11-dev nlohmann-json3-dev libpng-dev"
if [ "${1:-}" = test ]; then
  packages="$packages libgtest-dev libgmock-dev libbenchmark-dev libceres-dev clang-format clang-tidy python3"
fi

fail() {
  echo "scripts/install_dependencies.sh: $*" >&2
  exit 1
}

if ! command -v dpkg-query >/dev/null; then
  echo "not a Debian system: these packages, or your system's own, are needed:" $packages
  exit 0
fi

missing=
for package in $packages; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || fail "missing packages:$missing; become root, or install sudo, and run it again"
  as_root=sudo
fi

echo "installing:$missing"
apt="$as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Use-Pty=0"
$apt update || fail "'apt-get update' failed (its reason is above); missing packages:$missing"
$apt install -y --no-install-recommends $missing ||
  fail "'apt-get install' failed (its reason is above); missing packages:$missing"
