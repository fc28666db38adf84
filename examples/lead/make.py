"""Writes the recorded leads of this folder: drive.csv, two-cars.csv and drive.mcap (standard library only).

A car drives for 60 s through two stops. A receiver measures its speed at 10 Hz with a noise of 0.25 m/s.
"""

import random
import struct
from pathlib import Path

HERE = Path(__file__).parent
START_S = 1_767_225_600  # 2026-01-01 00:00 UTC
PIECES = [(3, 0.0), (7, 2.0), (8, 0.0), (5, -2.8), (6, 0.0), (10, 1.6), (6, 0.0), (8, -2.0), (7, 0.0)]


def truth():
    """Speeds, m/s, at 10 Hz."""
    speed, speeds = 0.0, []
    for duration_s, acceleration_mps2 in PIECES:
        for _ in range(10 * duration_s):
            speeds.append(speed)
            speed = max(0.0, speed + 0.1 * acceleration_mps2)
    return speeds


def record(kind, body):
    return bytes([kind]) + struct.pack("<Q", len(body)) + body


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def mcap(stamps, speeds):
    """An MCAP file of geometry_msgs/TwistStamped at /gps/velocity."""
    definition = "\n".join([
        "std_msgs/Header header", "geometry_msgs/Twist twist",
        "=" * 80, "MSG: std_msgs/Header", "builtin_interfaces/Time stamp", "string frame_id",
        "=" * 80, "MSG: builtin_interfaces/Time", "int32 sec", "uint32 nanosec",
        "=" * 80, "MSG: geometry_msgs/Twist", "geometry_msgs/Vector3 linear", "geometry_msgs/Vector3 angular",
        "=" * 80, "MSG: geometry_msgs/Vector3", "float64 x", "float64 y", "float64 z", "",
    ])
    magic = b"\x89MCAP0\r\n"
    parts = [magic, record(1, text("ros2") + text("timegap examples"))]
    parts.append(record(3, struct.pack("<H", 1) + text("geometry_msgs/msg/TwistStamped") + text("ros2msg") + text(definition)))
    parts.append(record(4, struct.pack("<HH", 1, 1) + text("/gps/velocity") + text("cdr") + struct.pack("<I", 0)))
    for sequence, (stamp_ms, speed) in enumerate(zip(stamps, speeds)):
        seconds, ms = divmod(stamp_ms, 1000)
        payload = struct.pack("<4BiIII", 0, 1, 0, 0, seconds, ms * 1_000_000, 4, int.from_bytes(b"gps\0", "little"))
        payload += struct.pack("<6d", speed, 0, 0, 0, 0, 0)
        log_ns = stamp_ms * 1_000_000 + 3_000_000
        parts.append(record(5, struct.pack("<HIQQ", 1, sequence, log_ns, log_ns) + payload))
    parts += [record(15, struct.pack("<I", 0)), record(2, struct.pack("<QQI", 0, 0, 0)), magic]
    return b"".join(parts)


def main():
    noise = random.Random(7)
    speeds = truth()
    stamps = [1000 * START_S + 100 * k for k in range(len(speeds))]
    measured = [max(0.0, speed + noise.gauss(0, 0.25)) for speed in speeds]
    rows = [f"{stamp},{3.6 * speed:.2f}\n" for stamp, speed in zip(stamps, measured)]
    (HERE / "drive.csv").write_text("stamp_ms,speed_kmh\n" + "".join(rows))
    rows = []
    for k in range(0, len(speeds), 2):
        rows.append(f"first,{0.1 * k:.1f},{speeds[k]:.2f}\n")
        rows.append(f"second,{0.1 * k:.1f},{speeds[max(0, k - 12)]:.2f}\n")
    (HERE / "two-cars.csv").write_text("car,time_s,speed_mps\n" + "".join(rows))
    (HERE / "drive.mcap").write_bytes(mcap(stamps[::2], measured[::2]))


if __name__ == "__main__":
    main()
