#!/usr/bin/env python3
"""`mapless live` without a topic of clouds: it takes the only one there is, refuses to choose between two, and says which
other messages a topic carries.

usage: live_topics_client.py MAPLESS
"""

import signal
import subprocess
import sys

from live_client import DRIVER, Client, DiagnosticArray, Imu, PointCloud2


def live(command, *options):
    return subprocess.Popen([command, "live", *options], stderr=subprocess.PIPE, text=True)


def end(node):
    node.send_signal(signal.SIGINT)
    assert node.wait(timeout=30) == 0, "the exit code after SIGINT is not 0"


def first_line(node, begin):
    for line in node.stderr:
        if line.startswith(begin):
            return line
    sys.exit(f"no line begins with {begin!r}")


def diagnostics_of(node, client):
    """The first message that is not that nothing has come."""
    for _ in range(100):
        client.collect(100)
        for message in client.received["diagnostics"]:
            if "carries" in message.status[0].message:
                return message.status[0].message
    node.kill()
    sys.exit("the diagnostics do not say what the topic carries")


def main():
    command = sys.argv[1]
    client = Client({"diagnostics": DiagnosticArray}, driver=False)
    writers = [client.writer("points", Imu, DRIVER)]  # kept: a writer ends with its name
    node = live(command, "--points", "points")
    message = diagnostics_of(node, client)
    print(message)
    assert "carries sensor_msgs/msg/Imu, not sensor_msgs/msg/PointCloud2" in message
    end(node)

    writers.append(client.writer("roof/points", PointCloud2, DRIVER))
    node = live(command)
    line = first_line(node, "mapless: reads topic")
    print(line, end="")
    assert "roof/points" in line
    end(node)

    writers.append(client.writer("bumper/points", PointCloud2, DRIVER))
    node = live(command)
    assert node.wait(timeout=30) == 2, "two topics of clouds are no usage error"
    line = node.stderr.read()
    print(line, end="")
    assert "bumper/points, roof/points" in line and "--points" in line
    print("topics: passed")


if __name__ == "__main__":
    main()
