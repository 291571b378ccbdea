#!/bin/sh
# Installs the packages that building needs, on Debian 12 and 13 and on Ubuntu 22.04 and 24.04; with "test" also those
# that testing needs, with "docs" those of the reference, with "fuzz" those of make fuzz, with "package" those of a Debian
# package. Only what is missing is installed: it needs neither root nor a network where all is there. On other systems
# it says what to install.
# usage: scripts/install_dependencies.sh [test] [docs] [fuzz] [package]
set -eu

packages="cmake g++ ninja-build pkg-config
  libeigen3-dev libtbb-dev libnanoflann-dev libyaml-cpp-dev libfmt-dev
  libprotobuf-dev protobuf-compiler libcli11-dev nlohmann-json3-dev libcairo2-dev zlib1g-dev"
# Without the first the simulator is left out, without the others mapless live.
optional="libembree-dev cyclonedds-dev cyclonedds-tools"

fail() {
  echo "scripts/install_dependencies.sh: $*" >&2
  exit 1
}

system=unknown
[ ! -r /etc/os-release ] || system=$(. /etc/os-release && echo "${ID:-unknown} ${VERSION_ID:-}")
[ "$system" != "ubuntu 22.04" ] || optional="libembree-dev" # it has no Cyclone DDS 0.10
case $system in
"debian 12" | "ubuntu 22.04") clang_tools="clang-format clang-tidy" ;; # version 14, as .clang-format wants it
"ubuntu 24.04") clang_tools="clang-format-14 clang-tidy-14" ;;
*) clang_tools="clang-format clang-tidy" ;; # another version: the check of the formatting is left out
esac
# The runtime of the sanitizers and libFuzzer, where it is a package of its own.
case $system in
"debian 12") fuzzer=libclang-rt-14-dev ;;
"debian 13") fuzzer=libclang-rt-19-dev ;;
"ubuntu 24.04") fuzzer=libclang-rt-18-dev ;;
*) fuzzer= ;;
esac

for purpose in "$@"; do
  case $purpose in
  test) packages="$packages libgtest-dev libgmock-dev libbenchmark-dev libceres-dev $clang_tools python3 python3-venv
    python3-dev binutils" ;;
  docs) packages="$packages doxygen" ;;
  fuzz) packages="$packages clang $fuzzer" ;;
  package) packages="$packages dpkg-dev file" ;; # both for cpack: the packages that the libraries are in
  *) fail "$purpose: no such purpose; use test, docs, fuzz, package, several or none" ;;
  esac
done

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "scripts/install_dependencies.sh knows Debian 12 and 13 and Ubuntu 22.04 and 24.04; this is $system." >&2
  echo "Install what these Debian packages hold, then go on (CMake names what it does not find):" $packages $optional >&2
  exit 0
fi
case $system in
"debian 12" | "debian 13" | "ubuntu 22.04" | "ubuntu 24.04") ;;
*) echo "scripts/install_dependencies.sh: $system is not tried; taking the package names of Debian 12" >&2 ;;
esac

missing_of() {
  for package in "$@"; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || printf ' %s' "$package"
  done
}
# shellcheck disable=SC2086  # lists of packages
missing=$(missing_of $packages)
# shellcheck disable=SC2086
missing_optional=$(missing_of $optional)
[ -n "$missing$missing_optional" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    [ -n "$missing" ] || exit 0
    fail "missing packages:$missing; become root, or install sudo, and run it again"
  fi
  as_root=sudo
fi

apt="$as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Use-Pty=0"
echo "installing:$missing$missing_optional"
if ! $apt update; then
  [ -n "$missing" ] || exit 0
  fail "'apt-get update' failed (its reason is above); missing packages:$missing"
fi
for package in $missing_optional; do
  $apt install -y --no-install-recommends "$package" ||
    echo "without $package: the build will have no $([ "$package" = libembree-dev ] && echo simulator || echo 'mapless live')" >&2
done
# shellcheck disable=SC2086
[ -z "$missing" ] || $apt install -y --no-install-recommends $missing ||
  fail "'apt-get install' failed (its reason is above); missing packages:$missing"
