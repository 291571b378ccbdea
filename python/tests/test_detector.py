"""OnlineDetector: arrays in, labels out."""

import csv
import ctypes
import threading
import time

import numpy as np
import pytest

import mapless


def labels_of(detector, scans, **arguments):
    found = [f for scan in scans for f in detector.push(scan, **arguments)]
    return found + detector.flush()


def push_arrays(detector, scans, points=lambda scan: scan.points, **arguments):
    found = []
    for scan in scans:
        found += detector.push(
            points(scan), time=scan.time_s, ring=scan.ring, stamp_ns=scan.stamp_ns, **arguments
        )
    return found + detector.flush()


def test_labels_of_scans_are_those_of_the_command(scans, native_result):
    found = labels_of(mapless.OnlineDetector(), scans)
    assert [f.scan for f in found] == native_result.scans
    for f in found:
        np.testing.assert_array_equal(f.label, native_result.label(f.scan))
    assert sum(f.moving.sum() for f in found) > 0


def test_probabilities_are_those_of_the_command_and_unknown_without_a_return(drive, scans, tmp_path):
    found = labels_of(mapless.OnlineDetector(), scans)
    result = mapless.detect(drive, tmp_path / "out", odometry=True, probability=True)
    for f in found:
        assert f.probability.dtype == np.float32
        np.testing.assert_array_equal(f.probability, result.probability(f.scan))
        np.testing.assert_array_equal(np.isnan(f.probability), f.label == 0)
    assert np.mean(np.concatenate([f.probability[f.moving] for f in found])) > 0.8
    assert np.isnan(labels_of(mapless.OnlineDetector(profile="paper"), scans[:9])[3].probability).all()


def test_the_state_of_the_motion_is_that_of_the_command(scans, native_result):
    with (native_result.path / "poses.csv").open(newline="") as file:
        expected = [row["motion_state"] for row in csv.DictReader(file)]
    found = labels_of(mapless.OnlineDetector(), scans)
    assert [f.motion_state for f in found] == expected


def test_scans_that_contradict_each_other_are_warned_of_once(scans):
    detector = mapless.OnlineDetector("VLP-16")
    with pytest.warns(RuntimeWarning) as warned:
        for k, scan in enumerate(scans):
            given = scans[{5: 4, 10: 9}.get(k, k)]  # the driver gives scans 4 and 9 once more
            detector.push(given.points, time=given.time_s, ring=given.ring, stamp_ns=scan.stamp_ns)
    assert [str(w.message) for w in warned] == [
        "mapless: doubtful scans: scan 5: the same points as the scan before it, to the bit"
    ]


def test_points_of_a_scan_without_motion_have_no_labels(scans):
    def few_points(scan):
        return np.where(np.arange(len(scan))[:, None] % 400 == 0, scan.points, np.float32("nan"))

    found = push_arrays(mapless.OnlineDetector("VLP-16"), scans[:9], few_points)
    lost = [f for f in found if f.motion_state == "lost"]
    assert lost
    assert not any(f.label.any() for f in lost)


@pytest.mark.parametrize("per_second", [1e3, 1e6, 1e9])
@pytest.mark.parametrize("epoch_s", [0, 1_790_000_000])
def test_floating_times_in_other_units_are_recognised(per_second, epoch_s, scans):
    scan = scans[0]
    time = (epoch_s + scan.time_s) * per_second
    found = mapless.OnlineDetector("VLP-16")
    found.push(scan.points, time=time, ring=scan.ring, stamp_ns=epoch_s * 10**9)
    assert found.flush()[0].stamp_ns == pytest.approx(epoch_s * 10**9, abs=500)  # what a float64 of the epoch resolves


def test_results_have_the_order_and_length_of_the_input_and_outlive_the_detector(scans):
    found = labels_of(mapless.OnlineDetector(), scans)
    for f, scan in zip(found, scans, strict=True):
        no_return = ~np.isfinite(scan.points).all(axis=1)
        assert f.label.shape == f.object.shape == f.stages.shape == f.moving.shape == (len(scan),)
        assert f.moving.dtype == np.bool_
        assert (f.label[no_return] == 0).all()
        assert set(np.unique(f.label[~no_return] & 0xFFFF)) <= {9, 251}
        np.testing.assert_array_equal(f.moving, f.object != 0)
        assert {o.id for o in f.objects} == set(np.unique(f.object)) - {0}
        assert f.stamp_ns == scan.stamp_ns
    label = found[5].label
    expected = label.copy()
    del found, f
    np.testing.assert_array_equal(label, expected)


def test_the_type_and_the_layout_of_points_do_not_matter(scans):
    few = scans[:7]
    expected = push_arrays(mapless.OnlineDetector("VLP-16"), few)
    dtype = np.dtype([("intensity", "u1"), ("x", "f4"), ("y", "f4"), ("z", "f4"), ("ring", "u2"), ("t", "u4")])

    def structured(scan):
        cloud = np.zeros(len(scan), dtype)  # packed: x, y, z, ring and t are not aligned
        for i, name in enumerate("xyz"):
            cloud[name] = scan.points[:, i]
        cloud["ring"] = scan.ring
        cloud["t"] = np.nan_to_num(scan.time_s) * 1e9 + 0.5
        return cloud

    wide = [np.float64, np.asfortranarray, lambda p: np.hstack([p, p])[:, :5], lambda p: np.repeat(p, 2, axis=0)[::2]]
    for convert in wide:
        found = push_arrays(mapless.OnlineDetector("VLP-16"), few, lambda scan: convert(scan.points))  # noqa: B023
        for f, e in zip(found, expected, strict=True):
            np.testing.assert_array_equal(f.label, e.label)
    detector = mapless.OnlineDetector("VLP-16")
    found = [f for scan in few for f in detector.push(structured(scan), stamp_ns=scan.stamp_ns)] + detector.flush()
    for f, e in zip(found, expected, strict=True):
        np.testing.assert_array_equal(f.label, e.label)


def test_points_given_backwards_come_out_backwards(scans, poses):
    few = scans[:6]
    forward = push_arrays(mapless.OnlineDetector("VLP-16"), few, trajectory=poses)
    detector = mapless.OnlineDetector("VLP-16")
    backward = []
    for scan in few:
        arguments = {"time": scan.time_s[::-1], "ring": scan.ring[::-1], "stamp_ns": scan.stamp_ns}
        backward += detector.push(scan.points[::-1], trajectory=poses, **arguments)
    backward += detector.flush()
    for f, b in zip(forward, backward, strict=True):
        np.testing.assert_array_equal(f.label == 0, b.label[::-1] == 0)
        assert (f.moving != b.moving[::-1]).mean() < 1e-3


def test_an_unknown_sensor_is_recovered_from_the_first_eight_scans(scans):
    detector = mapless.OnlineDetector()
    buffer = np.empty_like(scans[0].points)  # a driver that uses one buffer for every scan
    found = []
    for scan in scans:
        np.copyto(buffer, scan.points)
        now = detector.push(buffer, time=scan.time_s, ring=scan.ring, stamp_ns=scan.stamp_ns)
        assert (detector.sensor == "") == (scan.stamp_ns < scans[7].stamp_ns)
        found += now
    found += detector.flush()
    assert [len(f.label) for f in found] == [len(scan) for scan in scans]
    assert detector.notes


def test_given_poses_replace_the_odometry(scans, poses):
    for f in labels_of(mapless.OnlineDetector(), scans[:6], trajectory=poses):
        np.testing.assert_allclose(f.pose, poses.pose_at(f.stamp_ns), atol=1e-9)
    matrices = np.stack([poses.pose_at(scan.stamp_ns) for scan in scans[:6]])
    sampled = mapless.Trajectory(np.array([scan.stamp_ns for scan in scans[:6]]), matrices)
    np.testing.assert_allclose(sampled.pose_at(scans[3].stamp_ns), matrices[3], atol=1e-9)
    with pytest.raises(mapless.TrajectoryDomainError):
        sampled.pose_at(scans[0].stamp_ns - 1)
    with pytest.raises(mapless.ParameterError, match="one pose per stamp"):
        mapless.Trajectory(np.arange(5), matrices)


def test_parameters_are_keywords():
    assert mapless.OnlineDetector(forward_gap=0).latency == 0
    assert mapless.OnlineDetector(forward_gap=3, voting={"references": 8, "grow": False}).latency == 3
    with pytest.raises(mapless.ParameterError, match=r"OnlineDetector\(\).*voting.references.*99"):
        mapless.OnlineDetector(voting={"references": 99})
    with pytest.raises(mapless.ParameterError, match="voting.refrences.*voting.references"):
        mapless.OnlineDetector(voting={"refrences": 8})
    assert "odometry.gate_m" in mapless.parameters()


def grid(count=1000):
    """Points on a circle of 10 m around the sensor, at -1 degree."""
    angle = np.linspace(0, -2 * np.pi, count, endpoint=False)
    return np.stack([10 * np.cos(angle), 10 * np.sin(angle), np.full(count, -10 * np.tan(np.radians(1)))], axis=1)


@pytest.mark.parametrize(
    ("points", "arguments", "message"),
    [
        (np.zeros((5, 2)), {}, r"points: shape \(5, 2\): expected \(N, 3\)"),
        (np.zeros(5), {}, r"points: shape \(5,\): expected \(N, 3\)"),
        (np.zeros((5, 3), np.float16), {}, "x is float16: expected float32 or float64"),
        (np.zeros((5, 3), np.int32), {}, "x is int32: expected float32 or float64"),
        (np.zeros(5, [("x", "f4"), ("y", "f4")]), {}, "no field z"),
        (grid() * 1000, {}, "are they millimetres"),
        (grid(), {"stamp_ns": None}, "stamp_ns: missing"),
        (grid(), {"stamp_ns": 1.5}, "stamp_ns = 1.5: expected whole nanoseconds"),
        (grid(), {"ring": np.zeros(999, int)}, "ring: 999 numbers: expected one per point, 1000"),
        (grid(), {"ring": np.zeros(1000, complex)}, "ring: complex128"),
        (grid(), {"ring": np.full(1000, 16)}, "16: not one of the 16 lasers"),
        (grid(), {"ring": np.full(1000, 7), "time": np.zeros(1000)}, "all points have it"),
        (grid(), {"time": np.linspace(0, 1, 1000)}, "more than three turns"),
        (grid(), {"time": np.linspace(5000, 5000.1, 1000, dtype=np.float32)}, "cannot tell two columns apart"),
        (grid(), {"time_unit": "minutes"}, "time_unit = 'minutes': expected one of s, ms, us, ns"),
    ],
)
def test_errors_name_the_argument_and_what_was_expected(points, arguments, message):
    with pytest.raises(mapless.InputError, match=message):
        mapless.OnlineDetector("VLP-16").push(points, **{"stamp_ns": 0, **arguments})


def test_a_refused_scan_is_not_taken(scans):
    detector = mapless.OnlineDetector()
    detector.push(scans[0])
    with pytest.raises(mapless.InputError, match="after"):
        detector.push(scans[0])
    detector.push(scans[1])
    assert [f.scan for f in detector.flush()] == [0, 1]


@pytest.mark.parametrize(("unit", "factor"), [("ns", 1e9), ("us", 1e6), ("ms", 1e3), ("s", 1)])
def test_floating_times_of_the_unix_epoch_tell_their_unit(scans, unit, factor):
    from mapless._fields import unit_of

    epoch_s = 1_790_000_000.25 + np.nan_to_num(scans[0].time_s)
    assert unit_of(epoch_s * factor) == unit


def test_detectors_in_several_threads_run_side_by_side_and_agree(scans):
    few, results = scans[:7], [None, None]

    def run(i):
        results[i] = [f.label for f in labels_of(mapless.OnlineDetector(), few)]

    threads = [threading.Thread(target=run, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for a, b in zip(*results, strict=True):
        np.testing.assert_array_equal(a, b)


def runs_beside(call):
    """Whether another thread of Python runs in the middle of a call."""
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-4)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    call()
    length = time.perf_counter() - begin
    done.set()
    thread.join()
    return any(0.25 * length < at - begin < 0.75 * length for at in ticks)


def test_the_gil_is_released_while_a_scan_is_labelled(scans):
    detector = mapless.OnlineDetector()
    beside = [runs_beside(lambda: detector.push(scan)) for scan in scans]  # noqa: B023
    assert sum(beside) > len(beside) / 2
    assert not runs_beside(lambda: ctypes.PyDLL(None).usleep(50_000))  # holds it
