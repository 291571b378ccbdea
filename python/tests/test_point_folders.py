"""Plain folders of points: .bin with named columns, .npy, .ply, .las."""

import numpy as np
import pytest

import mapless
from comparison import compact, iou

XYZIRT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring", "time")])


def rows_of(scan, dtype=XYZIRT):
    rows = np.zeros(len(scan), dtype)
    for i, name in enumerate("xyz"):
        rows[name] = scan.points[:, i]
    rows["ring"] = scan.ring
    rows["time"] = np.nan_to_num(scan.time_s)
    return rows[compact(scan)]


def write_bin(path, rows):
    rows.tofile(path)


def write_npy(path, rows):
    np.save(path, np.column_stack([rows[name] for name in rows.dtype.names]))


def write_structured_npy(path, rows):
    np.save(path, rows)


def write_ply(path, rows):
    names = {"ring": "scalar_ring", "time": "timestamp"}
    properties = "".join(f"property float {names.get(name, name)}\n" for name in rows.dtype.names)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{properties}end_header\n"
    path.write_bytes(header.encode() + rows.tobytes())


def write_ascii_ply(path, rows):
    header = f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n"
    header += "".join(f"property double {name}\n" for name in rows.dtype.names) + "end_header\n"
    lines = [" ".join(f"{number:.9g}" for number in row) for row in rows.tolist()]
    path.write_text(header + "\n".join(lines) + "\n")


def write_las(path, rows):
    laspy = pytest.importorskip("laspy")
    las = laspy.create(point_format=0, file_version="1.2")
    las.header.scales = [1e-5] * 3
    for name in ("ring", "time"):
        las.add_extra_dim(laspy.ExtraBytesParams(name=name, type=np.float32))
        las[name] = rows[name]
    las.x, las.y, las.z = rows["x"], rows["y"], rows["z"]
    las.write(str(path))


def folder_of(scans, tmp_path, suffix, write, name=lambda k, scan: f"{k:06d}", times=True):
    folder = tmp_path / "drive"
    folder.mkdir()
    for k, scan in enumerate(scans):
        write(folder / f"{name(k, scan)}{suffix}", rows_of(scan))
    if times:
        (folder / "times.txt").write_text("".join(f"{scan.stamp_ns * 1e-9:.9f}\n" for scan in scans))
    return folder


@pytest.mark.parametrize(
    ("suffix", "write", "columns"),
    [
        (".bin", write_bin, "x,y,z,intensity,ring,time"),
        (".npy", write_npy, "x,y,z,intensity,ring,time"),
        (".npy", write_structured_npy, None),
        (".ply", write_ply, None),
        (".ply", write_ascii_ply, None),
        (".las", write_las, None),
    ],
)
def test_scans_of_a_folder_are_those_written(suffix, write, columns, scans, tmp_path):
    folder = folder_of(scans[:3], tmp_path, suffix, write)
    recording = mapless.open(folder, sensor="VLP-16", columns=columns)
    assert (recording.format, len(recording)) == (suffix[1:], 3)
    for found, scan in zip(recording, scans[:3], strict=True):
        kept = compact(scan)
        np.testing.assert_allclose(found.points, scan.points[kept], atol=2e-5)
        np.testing.assert_array_equal(found.ring, scan.ring[kept])
        offset_s = (found.stamp_ns - scan.stamp_ns) * 1e-9
        np.testing.assert_allclose(found.time_s + offset_s, scan.time_s[kept], atol=2e-8)


def test_a_folder_gives_the_labels_of_the_native_recording(scans, driver_result, tmp_path):
    folder = folder_of(scans, tmp_path, ".bin", write_bin)
    result = mapless.detect(folder, tmp_path / "out", sensor="VLP-16", columns="x,y,z,intensity,ring,time")
    found = np.concatenate([result.moving(k) for k in result.scans])
    expected = np.concatenate([driver_result.moving(k)[compact(scans[k])] for k in result.scans])
    assert expected.any()
    assert iou(found, expected) > 0.99


def test_times_of_scans_come_from_names_or_absolute_times(scans, tmp_path):
    def epoch_name(k, scan):
        return str(1_790_000_000_000_000_000 + scan.stamp_ns)

    folder = folder_of(scans[:2], tmp_path, ".npy", write_structured_npy, name=epoch_name, times=False)
    first, second = mapless.open(folder, sensor="VLP-16")
    assert second.stamp_ns - first.stamp_ns == pytest.approx(scans[1].stamp_ns - scans[0].stamp_ns, abs=100_000)
    assert first.stamp_ns >= 1_790_000_000_000_000_000


def test_a_folder_without_any_time_of_scans_is_refused(scans, tmp_path):
    folder = folder_of(scans[:2], tmp_path, ".npy", write_structured_npy, times=False)
    with pytest.raises(mapless.InputError, match="no time of each scan: put a times.txt"):
        mapless.open(folder, sensor="VLP-16")


def test_five_floats_a_point_in_a_folder_of_kitti_are_refused_with_the_remedy(scans, tmp_path):
    five = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring")])
    sequence = tmp_path / "00"
    (sequence / "velodyne").mkdir(parents=True)
    for k, scan in enumerate(scans[:2]):
        rows = rows_of(scan)[list(five.names)].astype(five)
        rows[: len(rows) // 4 * 4].tofile(sequence / "velodyne" / f"{k:06d}.bin")  # a multiple of 16 bytes too
    (sequence / "times.txt").write_text("0.0\n0.1\n")
    with pytest.raises(mapless.InputError, match="five floats a point.*--columns x,y,z,intensity,ring"):
        mapless.open(sequence)
    recording = mapless.open(sequence, columns="x,y,z,intensity,ring", sensor="VLP-16")
    np.testing.assert_array_equal(recording[0].ring[:100], scans[0].ring[compact(scans[0])][:100])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "name their columns, as --columns x,y,z,intensity,ring,time"),
        ({"columns": "x,y,z,ring,ring"}, "ring is there 2 times"),
        ({"columns": "x,y,intensity"}, "z is there 0 times"),
        ({"columns": "x,y,z,ring:u3"}, "'ring:u3': expected a name, or name:type"),
        ({"columns": "x,y,z,i,j,k,l"}, "not whole points of 28 bytes"),
    ],
)
def test_wrong_columns_are_named(options, message, scans, tmp_path):
    folder = folder_of(scans[:1], tmp_path, ".bin", lambda path, rows: rows[:50].tofile(path))
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(folder, **options)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"plywood", "no header"),
        (b"ply\nformat ascii 1.0\nelement face 1\nelement vertex 1\nend_header\n", "expected the element vertex first"),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\nend_header\nabcdefgh", "2 of 9"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int a\nend_header\n", "expected a number"),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nend_header\n", "no points"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\nend_header\n0 0", "x: is there twice"),
        (b"ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nend_header\n0\n", "cut off"),
        (b"ply\nformat ascii 1.0\nelement vertex " + b"9" * 5000 + b"\nproperty float x\nend_header\n0\n", "damaged"),
    ],
)
def test_damaged_ply_files_are_named(data, message, tmp_path):
    (tmp_path / "0.ply").write_bytes(data)
    with pytest.raises(mapless.InputError, match=message):
        mapless.open(tmp_path)


@pytest.mark.parametrize("text", ["1e999999999", "-1e11", "nan", "infinity", "now", "\ud800"])
def test_a_time_that_is_none_is_named(text, scans, tmp_path):
    folder = folder_of(scans[:1], tmp_path, ".npy", write_npy)
    (folder / "times.txt").write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(mapless.InputError, match="times.txt:1: .*: not a time in seconds"):
        mapless.open(folder, columns="x,y,z,intensity,ring,time")


# What is wrong with the second scan of a folder, and what the error says of it.
SPOILT = {
    "complex": (lambda rows: np.zeros((9, 3), complex), "field x = complex128: not a number per point"),
    "vectors": (
        lambda rows: np.zeros(9, [("x", "f4", (3,)), ("y", "f4"), ("z", "f4")]),
        "field x = float32, \\(3,\\) of them a point: not a number per point",
    ),
    "text": (lambda rows: np.zeros(9, [("x", "S8"), ("y", "f4"), ("z", "f4")]), "field x = .*S8: not a number per point"),
    "time NaN": (lambda rows: with_time(rows, np.nan), "point 7 time = nan: not a time; correct it, or leave the field out"),
}


def with_time(rows, time):
    rows["time"][7] = time
    return rows


@pytest.mark.parametrize("kind", SPOILT)
def test_a_scan_that_is_no_numbers_is_refused_by_file_and_field(kind, scans, tmp_path):
    spoil, message = SPOILT[kind]
    folder = folder_of(scans[:2], tmp_path, ".npy", write_structured_npy)
    np.save(folder / "000001.npy", spoil(rows_of(scans[1])))
    recording = mapless.open(folder, sensor="VLP-16")
    with pytest.raises(mapless.InputError, match=f"drive/000001.npy: {message}"):
        recording[1]


def test_an_array_that_claims_more_than_the_memory_is_refused_by_file(scans, tmp_path):
    folder = folder_of(scans[:1], tmp_path, ".npy", write_structured_npy)
    file = folder / "000000.npy"
    count = f"({len(rows_of(scans[0]))},)".encode()
    file.write_bytes(file.read_bytes().replace(count, b"(99999999999999,)", 1))
    with pytest.raises(mapless.InputError, match="000000.npy: no array of NumPy"):
        mapless.open(folder, sensor="VLP-16")


def test_times_beyond_all_clocks_are_refused_by_scan(scans, tmp_path):
    def far_away(path, rows):
        wide = rows.astype([(name, "<f8") for name in rows.dtype.names])
        wide["time"] = 1e27 * (1 + wide["time"])
        np.save(path, wide)

    folder = folder_of(scans[:1], tmp_path, ".npy", far_away)
    with pytest.raises(mapless.InputError, match="000000.npy: start = [0-9]+ ns: beyond 146 years from 1970"):
        mapless.open(folder, sensor="VLP-16")


def test_a_name_that_is_not_utf8_is_refused(tmp_path):
    with pytest.raises(mapless.InputError, match=r"a.udcff: is not UTF-8; rename the file or folder"):
        mapless.open(tmp_path / "a\udcff")


def test_the_command_refuses_a_name_that_is_not_utf8(capsys):
    from mapless._command import run

    assert run(["info", "a\udcff"]) == 2
    assert capsys.readouterr().err == "mapless: error: argument a\\udcff: is not UTF-8; rename the file or folder\n"
