"""Prints every message of a recording as one line of its scalars, read by the library named first.

    flatten.py mcap|rosbags FILE
"""

import dataclasses
import sys
from pathlib import Path


def mcap(path):
    from mcap_ros2.reader import read_ros2_messages

    for message in read_ros2_messages(path):
        yield message.channel.topic, message.log_time_ns, message.ros_msg


def rosbags(path):
    from rosbags.highlevel import AnyReader

    with AnyReader([Path(path)]) as reader:
        for connection, log_time_ns, raw in reader.messages():
            yield connection.topic, log_time_ns, reader.deserialize(raw, connection.msgtype)


def scalars(value):
    if isinstance(value, bytes):
        yield "0x" + value.hex()
    elif getattr(value, "dtype", None) == "uint8":
        yield "0x" + value.tobytes().hex()
    elif hasattr(value, "tolist"):
        yield from scalars(value.tolist())
    elif isinstance(value, (int, float, str)):
        yield repr(value)
    elif isinstance(value, (list, tuple)):
        for element in value:
            yield from scalars(element)
    elif dataclasses.is_dataclass(value):
        # Constants, and the type's name, belong to the class.
        fields = (field for field in dataclasses.fields(value) if "ClassVar" not in str(field.type))
        for field in fields:
            yield from scalars(getattr(value, field.name))
    else:
        for name in value.__slots__:
            yield from scalars(getattr(value, name))


for topic, log_time_ns, message in {"mcap": mcap, "rosbags": rosbags}[sys.argv[1]](sys.argv[2]):
    print(topic, log_time_ns, *scalars(message))
