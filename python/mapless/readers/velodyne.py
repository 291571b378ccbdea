"""Packets of Velodyne sensors, decoded by velodyne-decoder: captures, and VelodyneScan messages of bags."""

from __future__ import annotations

import ipaddress
import pathlib
import struct
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from mapless._core import InputError
from mapless._fields import FROM_STAMP, Array, Fields
from mapless._recording import CloudSource
from mapless.readers.packets import VELODYNE_PACKET_BYTES, udp_packets
from mapless.readers.sequential import SequentialScans

# Columns of the decoder's clouds.
TIME, RING = 4, 6
# Models of the decoder that mapless has a named model of; the others are recovered from their points.
SENSORS = {"VLP16": "VLP-16", "PuckLite": "VLP-16", "HDL32E": "HDL-32E"}
# Beyond the range of any model: the decoder would leave out farther points.
MAX_RANGE_M = 400.0
# An HDL-64E puts another byte of its status and calibration into each packet where other models name themselves.
STATUS_PACKETS = 5


# Packets that are looked at for whether the sensor turns, and the share of them that may be before the one before them.
TURNING_PACKETS, MOST_BACKWARDS = 400, 0.1
FULL_TURN = 36000  # [0.01 degrees]


def require_turning(path: str, packets: Iterable[bytes]) -> None:
    """Azimuths of packets increase by little, but for a few that the network exchanges."""
    azimuths = [struct.unpack_from("<H", packet, 2)[0] for packet in packets]
    steps = [(after - before) % FULL_TURN for before, after in zip(azimuths, azimuths[1:])]
    backwards = sum(step > FULL_TURN / 2 for step in steps)
    if steps and (not any(steps) or backwards > MOST_BACKWARDS * len(steps)):
        said = "do not change" if not any(steps) else f"decrease {backwards} times"
        raise InputError(
            f"{path}: azimuth: those of the first {len(azimuths)} packets {said}: a sensor that does not turn, packets out "
            "of order, or damaged ones; record the capture again"
        )


def import_decoder(path: str) -> Any:
    try:
        import velodyne_decoder
    except ImportError:
        raise InputError(
            f"{path}: Velodyne packets are read by the package velodyne-decoder: pip install 'mapless[velodyne]'"
        ) from None
    return velodyne_decoder


def decoder_config(path: str, packets: Iterator[bytes], sensor: str) -> Any:
    """`sensor`: a calibration file of Velodyne (YAML) or a name. Without one, that in the packets of an HDL-64E."""
    vd = import_decoder(path)
    config: dict[str, Any] = {"max_range": MAX_RANGE_M}
    if pathlib.Path(sensor).is_file():
        try:
            config["calibration"] = vd.Calibration.read(sensor)
        except (RuntimeError, ValueError) as error:
            raise InputError(f"{sensor}: no calibration of a Velodyne: {error}") from None
    first = [packet for _, packet in zip(range(STATUS_PACKETS), packets)]
    if len({packet[-2:] for packet in first}) > 1:
        config |= hdl_64e_config(path, vd, [*first, *packets], "calibration" in config)
    return vd.Config(**config)


def hdl_64e_config(path: str, vd: Any, packets: list[bytes], calibrated: bool) -> dict[str, Any]:
    import yaml

    try:
        status = vd.hdl64e.read_status_info(iter(packets))
    except ValueError:
        if calibrated:
            return {"model": vd.Model.HDL64E_S3}
        raise InputError(
            f"{path}: packets of an HDL-64E without its whole calibration, which takes 4160 of them; give its "
            "calibration file with --sensor FILE.yaml"
        ) from None
    model = vd.Model.HDL64E_S2 if status["Model"] == "S2" else vd.Model.HDL64E_S3
    if calibrated:
        return {"model": model}
    text = yaml.dump(vd.hdl64e.status_info_to_calib_dict(status))
    return {"model": model, "calibration": vd.Calibration.from_string(text)}


def turns_beams(vd: Any, config: Any) -> bool:
    """Whether the decoder turns the points of each laser by when it fires within a firing, up to a column, which the
    calibration of an HDL-64E does not say: the beams are not those of the file."""
    return config.model in (vd.Model.HDL64E_S1, vd.Model.HDL64E_S2, vd.Model.HDL64E_S3)


def fields_of_decoded(stamp_s: float, cloud: Array) -> Fields:
    """A cloud of the decoder, whose times count from the stamp of its last packet."""
    x, y, z = (cloud[:, axis] for axis in range(3))
    ring = cloud[:, RING].astype(np.uint16)
    return Fields(x, y, z, round(stamp_s * 1e9), ring, cloud[:, TIME], "s", FROM_STAMP)


def first_instant_ns(fields: Fields) -> int:
    assert fields.time is not None
    return fields.stamp_ns + round(float(fields.time.min()) * 1e9)


class PacketMessages:
    """Decodes the packets of VelodyneScan messages: a message is a scan."""

    def __init__(self, packets: Iterable[Any], path: str, sensor: str) -> None:
        """`packets`: of the first message."""
        self._vd = import_decoder(path)
        self._config = decoder_config(path, (bytes(packet.data) for packet in packets), sensor)
        self.sensor = ""
        self.recovers_sensor = turns_beams(self._vd, self._config)

    def fields(self, packets: Iterable[Any], name: str) -> tuple[Fields, list[str]]:
        vector = self._vd.PacketVector()
        for packet in packets:
            stamp_s = packet.stamp.sec + 1e-9 * packet.stamp.nanosec
            vector.append(self._vd.VelodynePacket(stamp_s, bytes(packet.data)))
        decoder = self._vd.ScanDecoder(self._config)
        stamp, cloud = decoder.decode(vector)
        if len(cloud) == 0:
            raise InputError(f"{name}: no return in its packets")
        self.sensor = sensor_name(decoder.model_id)
        return fields_of_decoded(stamp.device, cloud), notes_of(decoder.model_id)


def notes_of(model: Any) -> list[str]:
    return [
        f"points: decoded by velodyne-decoder from packets of a {getattr(model, 'name', 'Velodyne')}, as measured",
        "times: of points from the packets, with the firing times of the sensor's manual",
        "rings: of points from the packets, by increasing elevation",
    ]


def sensor_name(model: Any) -> str:
    return SENSORS.get(getattr(model, "name", ""), "")


class VelodyneCapture(CloudSource):
    format = "velodyne"

    def __init__(self, path: pathlib.Path, sensor: str) -> None:
        self.path = str(path)
        self._file = path
        self._config = decoder_config(self.path, (packet for _, packet in self._packets()), sensor)
        require_turning(self.path, (packet for _, (_, packet) in zip(range(TURNING_PACKETS), self._packets())))
        self._scans = SequentialScans(self._decoded)
        self.starts_ns = [first_instant_ns(fields) for fields in self._decoded()]
        if not self.starts_ns:
            raise InputError(f"{path}: no return in its packets of a Velodyne sensor, or all of them damaged")
        model = self._model()
        self.sensor = sensor_name(model)
        self.recovers_sensor = turns_beams(import_decoder(self.path), self._config)
        self.notes = ["scans: turns; the first and the last may be a part of one", *notes_of(model)]

    def read(self, k: int) -> Fields:
        return self._scans[k]

    def _model(self) -> Any:
        vd = import_decoder(self.path)
        decoder, packet = vd.ScanDecoder(self._config), vd.PacketVector()
        packet.append(vd.VelodynePacket(*next(self._packets())))
        decoder.decode(packet)
        return decoder.model_id

    def _packets(self) -> Iterator[tuple[float, bytes]]:
        """Of one sensor. Scans of two in one would be no scans."""
        sensor = None
        for packet in udp_packets(self._file):
            if len(packet.payload) != VELODYNE_PACKET_BYTES:
                continue
            sensor = sensor or (packet.source, packet.port)
            if (packet.source, packet.port) != sensor:
                both = " and ".join(
                    f"{ipaddress.ip_address(source)} to port {port}"
                    for source, port in (sensor, (packet.source, packet.port))
                )
                raise InputError(
                    f"{self.path}: packets of two Velodyne sensors, from {both}; give a capture of one, which "
                    "tcpdump -r writes with 'src host' and 'dst port'"
                )
            yield packet.time_s, packet.payload

    def _decoded(self) -> Iterator[Fields]:
        vd = import_decoder(self.path)
        decoder = vd.StreamDecoder(self._config)
        try:
            results = (decoder.decode(stamp_s, packet) for stamp_s, packet in self._packets())
            for result in results:
                if result is not None and len(result[1]):
                    yield fields_of_decoded(result[0].device, result[1])
            last = decoder.finish()
        except RuntimeError as error:  # of a model that is unknown, or another than that of the first packet
            raise InputError(
                f"{self.path}: packet: {error}; its packets are damaged, or of a sensor that velodyne-decoder does not read"
            ) from None
        if last is not None and len(last[1]):
            yield fields_of_decoded(last[0].device, last[1])
