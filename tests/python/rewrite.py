"""Writes a recording again with the MCAP project's own library, in several ways.

    rewrite.py FILE DIRECTORY
"""

import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer

source, directory = map(Path, sys.argv[1:])
with open(source, "rb") as stream:
    metadata = list(make_reader(stream).iter_metadata())
with open(source, "rb") as stream:
    messages = list(make_reader(stream).iter_messages(log_time_order=False))


def write(name, order=lambda messages: messages, metadata_last=False, **options):
    with open(directory / f"{name}.mcap", "wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2", library="rewrite.py")
        said = [(record.name, record.metadata) for record in metadata]
        if not metadata_last:
            [writer.add_metadata(*record) for record in said]
        schemas, channels = {}, {}
        for schema, channel, _ in messages:
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id]
                )
        for _, channel, message in order(messages):
            writer.add_message(
                channels[channel.id],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        if metadata_last:
            [writer.add_metadata(*record) for record in said]
        writer.finish()


bare = {
    "index_types": IndexType.NONE,
    "repeat_channels": False,
    "repeat_schemas": False,
    "use_statistics": False,
}
write("zstd", compression=CompressionType.ZSTD, metadata_last=True)
write("lz4", compression=CompressionType.LZ4)
write("plain", compression=CompressionType.NONE, chunk_size=4096)
write("unchunked", use_chunking=False)
write("bare", **bare)
write("reversed", order=lambda messages: messages[::-1], chunk_size=4096, **bare)
