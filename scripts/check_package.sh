#!/bin/sh
# Installs a build into a folder of its own and uses it as a stranger would:
# - examples/, and the program of README.md, with all layers; both run on a scene that SCENE_MAKER makes, the program
#   with and without the scene's poses;
# - tests/package, a shared library upon mapless::detection alone, with the packages that this layer does not need made
#   unfindable; no symbol of mapless but its exceptions may show in it.
# usage: scripts/check_package.sh BUILD_FOLDER [SCENE_MAKER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
jobs=${JOBS:-$(nproc)}

fail() {
  echo "scripts/check_package.sh: $*" >&2
  exit 1
}
build() { # SOURCE BUILD OPTION...
  source=$1 folder=$2
  shift 2
  cmake -S "$source" -B "$folder" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" "$@"
  cmake --build "$folder" -j "$jobs"
}

cmake --install "$1" --prefix "$work/prefix" >/dev/null

build tests/package "$work/shared" -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_Protobuf=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON -DCMAKE_DISABLE_FIND_PACKAGE_nanoflann=ON
shown=$(nm -D -C --defined-only "$work/shared/liblabeller.so")
echo "$shown" | grep -q ' Labeller::add' || fail "the shared library does not show its own interface"
if echo "$shown" | grep 'mapless::' | grep -vE 'mapless::(v1::)?[A-Za-z]*Error\b'; then
  fail "the shared library shows these symbols of mapless"
fi
ldd "$work/shared/liblabeller.so" | grep -E 'embree|protobuf|yaml' && fail "the shared library needs these"
"$work/shared/run_labeller"

mkdir "$work/readme"
sed -n '/^```cpp$/,/^```$/p' README.md | grep -v '^```' >"$work/readme/label.cpp"
cat >"$work/readme/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(readme LANGUAGES CXX)
find_package(mapless REQUIRED)
add_executable(label label.cpp)
target_link_libraries(label PRIVATE mapless::mapless)
END
build "$work/readme" "$work/label"
build examples "$work/examples"
[ -n "${2:-}" ] || exit 0

"$2" "$work/scene" --scans 20
"$work/examples/detect_folder" "$work/scene" | tee "$work/lines"
[ "$(grep -c '^scan ' "$work/lines")" -eq 20 ] || fail "examples: expected a line for each of 20 scans"
grep -q '[1-9][0-9]* objects' "$work/lines" || fail "examples: no moving object found in a scene that has some"
for poses in with without; do
  [ $poses = with ] || rm "$work/scene/trajectory.txt"
  "$work/label/label" "$work/scene" | tee "$work/lines"
  [ "$(grep -c '^scan ' "$work/lines")" -eq 20 ] || fail "README, $poses poses: expected a line for each of 20 scans"
done
