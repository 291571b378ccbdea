#!/bin/sh
# Checks ros2/mapless_ros: its file of parameters is what the command prints, its launch files run (with stand-ins of
# launch), and its sources compile. Where ROS 2 is there (a sourced setup.bash: AMENT_PREFIX_PATH), colcon builds it upon
# the library of the build that the command is of, and runs its launch tests; else the sources are compiled against
# tests/ros2_stubs, the part of ROS 2's interface that they use: that finds wrong uses of mapless, and not a wrong memory
# of ROS 2.
# usage: scripts/check_ros2.sh MAPLESS_COMMAND [COMPILER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
package=ros2/mapless_ros

"$1" config --ros2 | diff - $package/config/labeller.yaml ||
  { echo "$package/config/labeller.yaml is not what 'mapless config --ros2' prints: write it anew" >&2 && exit 1; }
for python in $package/launch/*.py $package/test/*.py; do
  python3 -c 'import ast, sys; ast.parse(open(sys.argv[1]).read(), sys.argv[1])' "$python"
done
PYTHONDONTWRITEBYTECODE=1 python3 tests/ros2_stubs/check_launch.py $package
# colcon, where it builds both, must build the library first.
grep -q '"dependencies": \["mapless"\]' $package/colcon.pkg

if [ -n "${AMENT_PREFIX_PATH:-}" ] && command -v colcon >/dev/null; then
  cmake --install "$(dirname "$1")/../.." --prefix "$work/mapless" >"$work/install.log"
  export CMAKE_PREFIX_PATH="$work/mapless${CMAKE_PREFIX_PATH:+:$CMAKE_PREFIX_PATH}"
  set -- --base-paths $package --build-base "$work/build" --install-base "$work/install"
  colcon --log-base "$work/log" build "$@"
  colcon --log-base "$work/log" test "$@" --return-code-on-test-failure --event-handlers console_direct+
  exit 0
fi
# The headers that the packages of package.xml have, of Humble and later.
for header in builtin_interfaces/msg/time diagnostic_msgs/msg/diagnostic_array geometry_msgs/msg/transform_stamped \
  nav_msgs/msg/odometry rclcpp/rclcpp rclcpp/serialization rclcpp_components/register_node_macro rosbag2_cpp/reader \
  rosbag2_cpp/writer rosbag2_storage/storage_options sensor_msgs/msg/imu sensor_msgs/msg/point_cloud2 \
  std_msgs/msg/float64 std_srvs/srv/empty std_srvs/srv/trigger tf2_msgs/msg/tf_message vision_msgs/msg/detection3_d_array \
  visualization_msgs/msg/marker_array; do
  mkdir -p "$work/$(dirname "$header")"
  echo '#include "ros2.hpp"' >"$work/$header.hpp"
done
for source in $package/src/*.cpp; do
  "${2:-c++}" -std=c++20 -fsyntax-only -Wall -Wextra -Werror -Wno-unused-const-variable -Wno-missing-field-initializers \
    -isystem tests/ros2_stubs -isystem "$work" -isystem /usr/include/eigen3 -Iinclude "$source"
done
echo "mapless_ros compiles against the stubs of ROS 2 (no ROS 2 here)"
