"""Two labellers, each in a container, as the launch file starts them: one with its own odometry, one with tf.

A car passes a lidar that stands: clouds come back with all their fields, the car moves and the yard does not.
"""

import array
import os
import pathlib
import sys
import unittest

import launch
import launch.actions
import launch.launch_description_sources
import launch_testing.actions
import launch_testing.asserts
import launch_testing.markers
import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2, PointField
from std_srvs.srv import Empty, Trigger
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection3DArray

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import passing_car  # noqa: E402

# Beside other tests and robots of the network.
os.environ["ROS_DOMAIN_ID"] = str(60 + os.getpid() % 40)

CLOUDS = 40
FIRST_NS = 1_790_000_000_000_000_000
NS_PER_S = 1_000_000_000
LABELS = ["object_id", "moving", "probability"]
LONGEST_WAIT_S = 60
MODES = ("own", "tf")


@pytest.mark.launch_test
@launch_testing.markers.keep_alive
def generate_test_description():
    source = launch.launch_description_sources.PythonLaunchDescriptionSource(
        str(HERE.parent / "launch" / "labeller.launch.py")
    )
    nodes = [
        launch.actions.GroupAction(
            [
                launch.actions.IncludeLaunchDescription(
                    source,
                    launch_arguments={
                        "namespace": mode,
                        "points": "/points",
                        "sensor": "VLP-16",
                        "motion": mode,
                    }.items(),
                )
            ]
        )
        for mode in MODES
    ]
    return launch.LaunchDescription([*nodes, launch_testing.actions.ReadyToTest()])


def stamp_of(message):
    return message.header.stamp.sec * NS_PER_S + message.header.stamp.nanosec


def cloud_message(points, ns):
    message = PointCloud2()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(ns, NS_PER_S)
    message.header.frame_id = "lidar"
    message.height, message.width = 1, len(points)
    message.fields = [PointField(name=n, offset=o, datatype=d, count=1) for n, o, d in passing_car.FIELDS]
    message.point_step, message.row_step = points.itemsize, points.nbytes
    message.data = array.array("B", points.tobytes())
    message.is_dense = True
    return message


class TestLabeller(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rclpy.init()

    @classmethod
    def tearDownClass(cls):
        rclpy.shutdown()

    def setUp(self):
        self.node = rclpy.create_node("driver")
        self.received = {}
        for mode in MODES:
            self.read(f"/{mode}/points_labelled", PointCloud2)
            self.read(f"/{mode}/objects", Detection3DArray)
            self.read(f"/{mode}/odometry", Odometry)
        self.read("/diagnostics", DiagnosticArray)
        self.points = self.node.create_publisher(PointCloud2, "/points", qos_profile_sensor_data)
        once = QoSProfile(
            depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        self.frames = self.node.create_publisher(TFMessage, "/tf_static", once)
        place = TransformStamped()
        place.header.frame_id, place.child_frame_id = "odom", "lidar"
        place.transform.rotation.w = 1.0
        self.frames.publish(TFMessage(transforms=[place]))

    def tearDown(self):
        self.node.destroy_node()

    def read(self, topic, kind):
        self.received[topic] = []
        self.node.create_subscription(kind, topic, self.received[topic].append, 50)

    def spin_until(self, condition, what):
        end = self.node.get_clock().now().nanoseconds + LONGEST_WAIT_S * NS_PER_S
        while not condition():
            rclpy.spin_once(self.node, timeout_sec=0.05)
            self.assertLess(self.node.get_clock().now().nanoseconds, end, what)

    def drive(self):
        """Publishes the clouds at the pace of a sensor; the truth by their stamps."""
        truth = {FIRST_NS + k * passing_car.TURN_NS: passing_car.cloud(k) for k in range(CLOUDS)}
        waiting = [cloud_message(points, ns) for ns, (points, _) in truth.items()]
        timer = self.node.create_timer(0.1, lambda: waiting and self.points.publish(waiting.pop(0)))
        self.spin_until(lambda: not waiting, "the clouds are not published")
        self.node.destroy_timer(timer)
        return truth

    def check_labels(self, messages, truth):
        moving, car = [], []
        for message in messages:
            points, is_car = truth[stamp_of(message)]
            names = [field.name for field in message.fields]
            self.assertEqual(names, [name for name, _, _ in passing_car.FIELDS] + LABELS)
            self.assertEqual((message.header.frame_id, message.width), ("lidar", len(points)))
            data = np.frombuffer(bytes(message.data), np.uint8).reshape(-1, message.point_step)
            original = points.view(np.uint8).reshape(-1, points.itemsize)
            np.testing.assert_array_equal(data[:, : points.itemsize], original)
            at = {field.name: field.offset for field in message.fields}
            moving.append(data[:, at["moving"]] == 1)
            car.append(is_car)
        moving, car = np.concatenate(moving), np.concatenate(car)
        self.assertGreater((moving & car).sum(), 0.8 * car.sum(), "points of the car are not found")
        self.assertGreater((moving & car).sum(), 0.8 * moving.sum(), "points of the yard are taken to move")

    def test_a_passing_car(self):
        self.spin_until(
            lambda: self.points.get_subscription_count() == len(MODES), "the labellers do not appear"
        )
        truth = self.drive()
        for mode in MODES:
            labelled = self.received[f"/{mode}/points_labelled"]
            # The labels of the last cloud need a next one; best effort may lose some.
            self.spin_until(
                lambda labelled=labelled: len(labelled) >= 3 * CLOUDS // 4, f"{mode}: clouds are missing"
            )
            self.check_labels(labelled, truth)
            objects = self.received[f"/{mode}/objects"]
            self.assertTrue(any(message.detections for message in objects))
            self.assertEqual({message.header.frame_id for message in objects}, {"odom"})
        self.assertTrue(self.received["/own/odometry"])
        self.assertFalse(self.received["/tf/odometry"])
        names = {f"/{mode}/labeller: labels" for mode in MODES}
        found = self.received["/diagnostics"]
        self.spin_until(
            lambda: names <= {status.name for message in found for status in message.status},
            "a labeller publishes no diagnostics",
        )

    def test_reset_is_a_service(self):
        client = self.node.create_client(Empty, "/own/labeller/reset")
        self.spin_until(client.service_is_ready, "no service reset")
        answer = client.call_async(Empty.Request())
        self.spin_until(answer.done, "reset does not answer")

    def test_save_static_map_is_a_service(self):
        client = self.node.create_client(Trigger, "/own/labeller/save_static_map")
        self.spin_until(client.service_is_ready, "no service save_static_map")
        answer = client.call_async(Trigger.Request())
        self.spin_until(answer.done, "save_static_map does not answer")
        self.assertFalse(answer.result().success)
        self.assertIn("static_map_file", answer.result().message)


@launch_testing.post_shutdown_test()
class TestEnd(unittest.TestCase):
    def test_exit_codes(self, proc_info):
        launch_testing.asserts.assertExitCodes(proc_info)
