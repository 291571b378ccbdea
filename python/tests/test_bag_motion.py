"""Angular velocity and speed from topics of a bag, written by rosbags, for the odometry."""

import numpy as np
import pytest

import mapless

rosbags = pytest.importorskip("rosbags")

from mapless.readers.bag_motion import measurements_of_bag  # noqa: E402
from mapless.readers.bags import open_reader  # noqa: E402
from mapless.readers.options import Options  # noqa: E402
from test_bag_poses import MOUNT, header, make, transform, vector, write  # noqa: E402

NS = (50_000_000, 150_000_000)


def imu(stamp_ns, frame, turn, measures_turns=True):
    nine = np.zeros(9)
    return "sensor_msgs/msg/Imu", make(
        "sensor_msgs/msg/Imu",
        header=header(stamp_ns, frame),
        orientation=vector("Quaternion", (0, 0, 0, 1)),
        orientation_covariance=nine,
        angular_velocity=vector("Vector3", turn),
        angular_velocity_covariance=nine if measures_turns else np.array([-1.0, *nine[1:]]),
        linear_acceleration=vector("Vector3", (0, 0, 9.81)),
        linear_acceleration_covariance=nine,
    )


def twist(stamp_ns, frame, linear, angular):
    inner = make("geometry_msgs/msg/Twist", linear=vector("Vector3", linear), angular=vector("Vector3", angular))
    kind = "geometry_msgs/msg/TwistStamped"
    return kind, make(kind, header=header(stamp_ns, frame), twist=inner)


def wheels(stamp_ns, frame, linear, angular):
    kind, stamped = twist(stamp_ns, frame, linear, angular)
    pose = make("geometry_msgs/msg/Pose", position=vector("Point", (0, 0, 0)), orientation=vector("Quaternion", (0, 0, 0, 1)))
    none = np.zeros(36)
    return "nav_msgs/msg/Odometry", make(
        "nav_msgs/msg/Odometry",
        header=header(stamp_ns, "odom"),
        child_frame_id=frame,
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=none),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=stamped.twist, covariance=none),
    )


# The lidar lies at (1, 0, 2) of the base and is turned by a quarter about z: its x is the y of the base.
STATIC = ("/tf_static", 0, transform(0, "base", "lidar", *MOUNT))


def measurements(folder, **options):
    reader = open_reader(folder)
    return measurements_of_bag(reader, str(folder), Options(**options), "lidar", (0, 100_000_000))


def test_turns_are_about_the_axes_of_the_lidar(scans, tmp_path):
    messages = [("/imu", ns, imu(ns, "base", (0.1, 0.2, 0.3))) for ns in NS]
    found, notes = measurements(write(tmp_path / "drive", scans[:2], [STATIC, *messages]), imu_topic="/imu")
    assert [one.stamp_ns for one in found] == list(NS)
    for one in found:
        np.testing.assert_allclose(one.angular_velocity, (0.2, -0.1, 0.3), atol=1e-12)
    assert notes == ["motion: 2 angular velocities of frame lidar from topic /imu, for the odometry"]


def test_turns_in_the_frame_of_the_clouds_need_no_transforms(scans, tmp_path):
    messages = [("/imu", ns, imu(ns, "lidar", (0.1, 0.2, 0.3))) for ns in NS]
    found, _ = measurements(write(tmp_path / "drive", scans[:2], messages), imu_topic="/imu")
    np.testing.assert_allclose(found[0].angular_velocity, (0.1, 0.2, 0.3), atol=1e-12)


@pytest.mark.parametrize("kind", [twist, wheels])
def test_speeds_are_those_of_the_lidar_on_a_rigid_vehicle(kind, scans, tmp_path):
    """At 3 m/s along x and 2 rad/s about z, a lidar 1 m in front of the middle of the axle moves sideways with 2 m/s."""
    messages = [("/wheels", ns, kind(ns, "base", (3, 0, 0), (0, 0, 2))) for ns in NS]
    found, _ = measurements(write(tmp_path / "drive", scans[:2], [STATIC, *messages]), speed_topic="/wheels")
    assert [one.angular_velocity for one in found] == [None, None]
    np.testing.assert_allclose([one.speed for one in found], np.sqrt(13), atol=1e-12)


@pytest.mark.parametrize(
    ("options", "others", "message"),
    [
        ({"imu_topic": "/gyro"}, [("/imu", 0, imu(0, "lidar", (0, 0, 0)))], "--imu-topic /gyro: .*sensor_msgs/Imu: /imu$"),
        ({"speed_topic": "/imu"}, [("/imu", 0, imu(0, "lidar", (0, 0, 0)))], "--speed-topic /imu: not one .*: none$"),
        ({"imu_topic": "/imu"}, [("/imu", 0, imu(0, "top", (0, 0, 0)))], "place frame top on lidar.* are none; .*--imu"),
        ({"imu_topic": "/imu"}, [STATIC, ("/imu", 0, imu(0, "top", (0, 0, 0)))], "/tf_static are base -> lidar"),
        ({"imu_topic": "/imu"}, [("/imu", 0, imu(0, "lidar", (0, 0, 57)))], "57 rad/s.*are they degrees"),
        ({"imu_topic": "/imu"}, [("/imu", 0, imu(0, "lidar", (0, 0, np.nan)))], "not finite"),
        ({"imu_topic": "/imu"}, [("/imu", 0, imu(0, "lidar", (0, 0, 0), False))], "measures no angular velocity"),
        ({"imu_topic": "/imu"}, [("/imu", 0, imu(9 * 10**9, "lidar", (0, 0, 0)))], "from 9.000 to 9.000 s; both need one"),
        ({"speed_topic": "/v"}, [("/v", 0, twist(0, "lidar", (8000, 0, 0), (0, 0, 0)))], "8000 m/s.*metres a second"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(options, others, message, scans, tmp_path):
    folder = write(tmp_path / "drive", scans[:2], others)
    with pytest.raises(mapless.InputError, match=message) as refused:
        measurements(folder, **options)
    assert "\n" not in str(refused.value)


def test_the_command_takes_them_as_it_takes_the_files(scans, tmp_path):
    """The same bytes as with --imu and --speed: that the odometry uses them, other tests show."""
    turns = [0.3 * np.sin(ns * 1e-8) for ns in NS]
    messages = [("/imu", ns, imu(ns, "lidar", (0, 0, turn))) for ns, turn in zip(NS, turns, strict=True)]
    messages += [("/wheels", ns, twist(ns, "lidar", (5, 0, 0), (0, 0, 0))) for ns in NS]
    bag = write(tmp_path / "drive", scans, messages)
    (tmp_path / "imu.csv").write_text(
        "time_s,x_rad_s,y_rad_s,z_rad_s\n" + "".join(f"{ns * 1e-9:.9f},0,0,{turn!r}\n" for ns, turn in zip(NS, map(float, turns)))
    )
    (tmp_path / "speed.csv").write_text("time_s,speed_m_s\n" + "".join(f"{ns * 1e-9:.9f},5\n" for ns in NS))
    topics = {"imu_topic": "/imu", "speed_topic": "/wheels"}
    by_topic = mapless.detect(bag, tmp_path / "topic", sensor="VLP-16", **topics)
    by_file = mapless.detect(bag, tmp_path / "file", sensor="VLP-16", imu=tmp_path / "imu.csv", speed=tmp_path / "speed.csv")
    recording = mapless.open(bag, sensor="VLP-16", **topics)
    detector = mapless.OnlineDetector("VLP-16")
    detector.add_measurements(recording.measurements)
    pushed = [f for scan in recording for f in detector.push(scan)] + detector.flush()
    for f in pushed:
        np.testing.assert_array_equal(f.label, by_file.label(f.scan))
    without = mapless.detect(bag, tmp_path / "without", sensor="VLP-16")
    np.testing.assert_array_equal(by_topic.trajectory(), by_file.trajectory())
    assert (by_topic.trajectory() != without.trajectory()).any()
    with pytest.raises(mapless.CommandError, match="their topics.*poses are given as well.*--odometry"):
        mapless.detect(bag, tmp_path / "posed", sensor="VLP-16", stationary=True, **topics)
