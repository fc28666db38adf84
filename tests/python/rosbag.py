"""Opens a run's directory as a rosbag2, reads every message of it, and checks the order of the file.

    rosbag.py RUN PACKAGE

PACKAGE is what `timegap print layouts --msg` wrote. Prints the number of messages of each topic.
"""

import sys
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

run, package = map(Path, sys.argv[1:])
store = get_typestore(Stores.ROS2_HUMBLE)
for file in sorted(package.glob("msg/*.msg")):
    store.register(get_types_from_msg(file.read_text(), f"timegap_msgs/msg/{file.stem}"))

counts = {}
with Reader(run) as reader:
    declared = {connection.topic: connection.msgcount for connection in reader.connections}
    for connection, _, raw in reader.messages():
        # The types are those of the package and of ROS itself, not those in the file.
        store.deserialize_cdr(raw, connection.msgtype)
        counts[connection.topic] = counts.get(connection.topic, 0) + 1
assert {topic: count for topic, count in declared.items() if count} == counts, (declared, counts)

with open(run / "recording.mcap", "rb") as stream:
    reader = make_reader(stream)
    assert reader.get_header().profile == "ros2"
    last = 0
    for _, channel, message in reader.iter_messages(log_time_order=False):
        assert message.log_time >= last, (channel.topic, message.log_time, last)
        assert message.log_time == message.publish_time, channel.topic
        last = message.log_time
    assert last > 1_700_000_000_000_000_000, last

for topic, count in sorted(counts.items()):
    print(topic, count)
