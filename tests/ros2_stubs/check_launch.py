#!/usr/bin/env python3
"""Runs the launch files of mapless_ros with stand-ins of launch and launch_ros: each makes its description, and an
argument of labeller.launch.py becomes a parameter that config/labeller.yaml has, only where it is given.

usage: check_launch.py PACKAGE_FOLDER
"""

import pathlib
import re
import runpy
import sys
from unittest import mock

PACKAGE = pathlib.Path(sys.argv[1]).resolve()
MODULES = ["ament_index_python", "ament_index_python.packages", "launch", "launch.actions", "launch.conditions"]
MODULES += ["launch.launch_description_sources", "launch.substitutions", "launch_ros", "launch_ros.actions"]
MODULES += ["launch_ros.descriptions", "launch_ros.parameter_descriptions"]


def stand_ins():
    modules = {name: mock.MagicMock() for name in MODULES}
    modules["ament_index_python.packages"].get_package_share_directory = lambda _: str(PACKAGE)
    modules["launch"].LaunchDescription = list
    modules["launch.actions"].DeclareLaunchArgument = lambda name, default_value, description: (name, default_value)
    modules["launch.actions"].OpaqueFunction = lambda function: function
    modules["launch_ros.descriptions"].ComposableNode = dict
    modules["launch_ros.actions"].ComposableNodeContainer = dict

    class LaunchConfiguration(str):
        def perform(self, context):
            return context[self]

    modules["launch.substitutions"].LaunchConfiguration = LaunchConfiguration
    return modules


def parameters_of(description, **given):
    """Of the node: the file, and the values that take precedence."""
    declared = dict(item for item in description if isinstance(item, tuple))
    [function] = [item for item in description if callable(item) and not isinstance(item, mock.Mock)]
    [container] = function(declared | given)
    [node] = container["composable_node_descriptions"]
    return node["parameters"]


def main():
    with mock.patch.dict(sys.modules, stand_ins()):
        made = {
            path.name: runpy.run_path(str(path))["generate_launch_description"]()
            for path in sorted((PACKAGE / "launch").glob("*.py"))
        }
    assert len(made) == 5 and all(made.values()), made
    labeller = made["labeller.launch.py"]
    config = str(PACKAGE / "config" / "labeller.yaml")
    assert parameters_of(labeller) == [config], "an argument that is not given hides the value of the file"
    given = {"sensor": "VLP-16", "motion": "tf", "publish_tf": "true", "base_frame": "base_link"}
    given |= {"clock_offset_s": "0.02", "pose_wait_s": "2", "params": "mine.yaml"}
    wanted = {"sensor": "VLP-16", "motion": "tf", "publish_tf": True, "base_frame": "base_link"}
    wanted |= {"clock_offset_s": 0.02, "pose_wait_s": 2.0}
    assert parameters_of(labeller, **given) == ["mine.yaml", wanted], parameters_of(labeller, **given)
    known = re.findall(r"^    (\w+):", pathlib.Path(config).read_text(), re.MULTILINE)
    assert set(wanted) <= set(known), f"not in labeller.yaml: {set(wanted) - set(known)}"


if __name__ == "__main__":
    main()
