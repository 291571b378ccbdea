"""Labels a recording of any format and prints its moving objects: python label_recording.py drive.mcap"""

import sys

import mapless

recording = mapless.open(sys.argv[1])
print(f"{recording.format}, {recording.sensor}, {len(recording)} scans")
detector = mapless.OnlineDetector()


def show(found: mapless.LabelledScan) -> None:
    speeds = ", ".join(f"{o.id}: {(o.velocity @ o.velocity) ** 0.5:.1f} m/s" for o in found.objects)
    print(f"scan {found.scan}: {found.moving.sum()} of {len(found.moving)} points move; {speeds or 'no objects'}")


for scan in recording:
    for found in detector.push(scan):
        show(found)
for found in detector.flush():
    show(found)
