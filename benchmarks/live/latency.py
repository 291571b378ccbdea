#!/usr/bin/env python3
"""Plays a recording to `mapless live` at the pace of the sensor, over DDS on the loopback interface, and prints the latency
that a subscriber sees (benchmarks/live/live_player.cpp), and the processor time and memory of the node.

usage: latency.py MAPLESS PLAYER RECORDING [--clouds N] [--rate HZ] [OPTION OF mapless live ...]

    mapless simulate town2 -o drive --sensor OS1-128 --duration-s 60
    python3 benchmarks/live/latency.py build/mapless build/release/benchmarks/live_player drive --clouds 6000 --sensor OS1-128
"""

import argparse
import os
import signal
import subprocess
import sys

LOOPBACK = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer Address="127.0.0.1"/></Peers><SPDPInterval>1s</SPDPInterval></Discovery>
<Internal><SocketReceiveBufferSize max="8MB"/></Internal></Domain></CycloneDDS>"""


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("mapless")
    parser.add_argument("player")
    parser.add_argument("recording")
    parser.add_argument("--clouds", type=int, default=600)
    parser.add_argument("--rate", type=float, default=10)
    chosen, options = parser.parse_known_args()
    environment = {"ROS_DOMAIN_ID": "97", "CYCLONEDDS_URI": LOOPBACK, **os.environ}
    node = subprocess.Popen([chosen.mapless, "live", *options], env=environment)
    try:
        newer = 0 if "--causal" in options else 1
        player = subprocess.run(
            [chosen.player, chosen.recording, str(chosen.clouds), str(chosen.rate), str(newer)], env=environment
        )
        node.send_signal(signal.SIGINT)
        _, status, usage = os.wait4(node.pid, 0)
        node.returncode = os.waitstatus_to_exitcode(status)
        user_ms, system_ms = (1e3 * seconds / chosen.clouds for seconds in (usage.ru_utime, usage.ru_stime))
        print(f"processor time of the node {user_ms:.1f} ms a cloud, of the system for it {system_ms:.1f} ms")
        print(f"largest memory of the node {usage.ru_maxrss / 1024:.0f} MB")
        sys.exit(node.returncode or player.returncode)
    finally:
        node.kill()


if __name__ == "__main__":
    main()
