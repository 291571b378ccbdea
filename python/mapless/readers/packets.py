"""Packet captures (.pcap, .pcapng): the Velodyne and Ouster readers by what is in them."""

from __future__ import annotations

import collections
import pathlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from mapless._core import InputError
from mapless._recording import CloudSource
from mapless.readers.options import Options

SUFFIXES = (".pcap", ".pcapng")
VELODYNE_PACKET_BYTES = 1206
HESAI_START = b"\xee\xff"
OUSTER_PORT = 7502
# Packets that are read to find whose they are: a capture may begin with those of position or IMU.
SNIFFED_PACKETS = 200


class UdpPacket(NamedTuple):
    time_s: float
    source: bytes  # address
    port: int  # of the destination
    payload: bytes


def link_layers(dpkt: Any) -> dict[int, Callable[[bytes], Any]]:
    """How a frame becomes a packet of IP, by the link type of the capture (tcpdump.org/linktypes.html)."""
    loopback: Callable[[bytes], Any] = lambda frame: dpkt.loopback.Loopback(frame).data
    layers = {
        1: lambda frame: dpkt.ethernet.Ethernet(frame).data,
        113: lambda frame: dpkt.sll.SLL(frame).data,
        276: lambda frame: dpkt.sll2.SLL2(frame).data,
        **dict.fromkeys((0, 108), loopback),
        **dict.fromkeys((12, 14, 101, 228), dpkt.ip.IP),
    }
    return layers


def udp_packets(path: pathlib.Path) -> Iterator[UdpPacket]:
    """Every UDP packet; of a fragmented one the first fragment."""
    try:
        import dpkt
    except ImportError:
        raise InputError(
            f"{path}: Velodyne captures are read by the package velodyne-decoder: pip install 'mapless[velodyne]'; a "
            "capture of an Ouster needs its metadata: --meta FILE.json"
        ) from None
    with path.open("rb") as file:
        try:
            reader = dpkt.pcap.UniversalReader(file)
        except (ValueError, dpkt.dpkt.Error):
            raise InputError(f"{path}: no packet capture: neither pcap nor pcapng") from None
        ip_of = link_layers(dpkt).get(reader.datalink())
        if ip_of is None:
            raise InputError(
                f"{path}: link type = {reader.datalink()}: frames that are not read; record on Ethernet, or convert the "
                "capture to Ethernet or raw IP"
            )
        try:
            for stamp, frame in reader:
                try:
                    packet = ip_of(frame)
                except dpkt.dpkt.Error:
                    continue
                udp = getattr(packet, "data", None)
                if isinstance(udp, dpkt.udp.UDP):
                    yield UdpPacket(float(stamp), bytes(packet.src), int(udp.dport), bytes(udp.data))
        except dpkt.dpkt.NeedData:
            return  # the last packet of a capture that was cut off


def metadata_of(path: pathlib.Path, options: Options) -> pathlib.Path | None:
    """The Ouster metadata of a capture: the file given, as the sensor too, else the JSON file that shares most of the name."""
    if options.meta is not None:
        return pathlib.Path(options.meta)
    if options.sensor.lower().endswith(".json"):
        return pathlib.Path(options.sensor)
    beside = [file for file in path.parent.glob("*.json") if path.stem.startswith(file.stem)]
    return max(beside, key=lambda file: len(file.stem), default=None)


def refusal(path: pathlib.Path) -> InputError:
    """Why a capture cannot be read: what is in it."""
    kinds: collections.Counter[tuple[int, int]] = collections.Counter()
    for _, packet in zip(range(SNIFFED_PACKETS), udp_packets(path)):
        if packet.payload[:2] == HESAI_START:
            return InputError(
                f"{path}: packets of a Hesai sensor, which no library that mapless uses decodes; record the "
                "PointCloud2 of its driver in a bag"
            )
        kinds[packet.port, len(packet.payload)] += 1
    if any(port == OUSTER_PORT for port, _ in kinds):
        return InputError(f"{path}: packets of an Ouster sensor: give its metadata with --meta FILE.json")
    found = ", ".join(f"{count} of {size} bytes to port {port}" for (port, size), count in kinds.most_common(3))
    return InputError(f"{path}: no packets of a Velodyne (1206 bytes) or an Ouster; its UDP packets: {found or 'none'}")


class PacketReader:
    formats = ("velodyne", "ouster")

    def fits(self, path: pathlib.Path) -> bool:
        return path.is_file() and path.suffix.lower() in (*SUFFIXES, ".osf")

    def open(self, path: pathlib.Path, options: Options, format: str = "") -> CloudSource:
        from mapless.readers import ouster, velodyne

        if not path.is_file():
            raise InputError(f"{path}: no such file")
        metadata = None if path.suffix.lower() == ".osf" else metadata_of(path, options)
        if path.suffix.lower() == ".osf" or metadata is not None:
            return ouster.OusterCapture(path, metadata)
        sniffed = zip(range(SNIFFED_PACKETS), udp_packets(path))
        if any(len(packet.payload) == VELODYNE_PACKET_BYTES for _, packet in sniffed):
            return velodyne.VelodyneCapture(path, options.sensor)
        raise refusal(path)
