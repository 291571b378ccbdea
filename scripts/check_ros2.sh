#!/bin/sh
# Checks ros2/mapless_ros: its file of parameters is what the command prints, its launch files are Python, and its sources
# compile. Where ROS 2 is there (AMENT_PREFIX_PATH), colcon builds it upon the installed mapless; else the sources are
# compiled against tests/ros2_stubs, the part of ROS 2's interface that they use: that finds wrong uses of mapless, and
# not a wrong memory of ROS 2.
# usage: scripts/check_ros2.sh MAPLESS_COMMAND [COMPILER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
package=ros2/mapless_ros

"$1" config --ros2 | diff - $package/config/labeller.yaml ||
  { echo "$package/config/labeller.yaml is not what 'mapless config --ros2' prints: write it anew" >&2 && exit 1; }
for launch in $package/launch/*.py; do
  python3 -c 'import ast, sys; ast.parse(open(sys.argv[1]).read(), sys.argv[1])' "$launch"
done

if [ -n "${AMENT_PREFIX_PATH:-}" ] && command -v colcon >/dev/null; then
  colcon --log-base "$work/log" build --base-paths $package --build-base "$work/build" --install-base "$work/install"
  exit 0
fi
# A header of ROS 2 for each that the sources include.
grep -hoE '#include <(rclcpp|rclcpp_components|rosbag2_cpp|[a-z0-9_]+_msgs|std_srvs)/[^>]*>' $package/src/* |
  sed 's/.*<\(.*\)>/\1/' | sort -u | while read -r header; do
  mkdir -p "$work/$(dirname "$header")"
  echo '#include "ros2.hpp"' >"$work/$header"
done
for source in $package/src/*.cpp; do
  "${2:-c++}" -std=c++20 -fsyntax-only -Wall -Wextra -Werror -Wno-unused-const-variable -Wno-missing-field-initializers \
    -isystem tests/ros2_stubs -isystem "$work" -isystem /usr/include/eigen3 -Iinclude "$source"
done
echo "mapless_ros compiles against the stubs of ROS 2 (no ROS 2 here)"
