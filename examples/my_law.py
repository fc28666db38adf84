"""A law of your own: a time headway of two seconds. See docs/tutorial.md; `timegap print layouts --law` has all fields."""

import struct
import sys

INPUT_BYTES, ANSWER_BYTES = 1312, 896

while len(record := sys.stdin.buffer.read(INPUT_BYTES)) == INPUT_BYTES:
    (sequence, reset, time, period, position, speed, acceleration, set_speed, limit,
     has_target, target, gap, closing) = struct.unpack_from("<QQ7dQQdd", record)
    request = 0.4 * (min(set_speed, limit) - speed)
    if has_target:
        request = min(request, 0.2 * (gap - 5.0 - 2.0 * speed) + 0.7 * closing)
    request = max(-4.0, min(2.0, request))
    sys.stdout.buffer.write(struct.pack("<Qd", sequence, request).ljust(ANSWER_BYTES, b"\0"))
    sys.stdout.buffer.flush()
