"""Checks recorded messages with PyPI's autosar-e2e, and protects them anew.

Reads lines `data_id hex` on standard input; writes for each whether the message is intact, whether it
still is with one bit flipped, and the bytes of the same message protected again."""

import sys

from e2e import p07

for line in sys.stdin:
    data_id, text = line.split()
    data_id = int(data_id)
    message = bytearray.fromhex(text)
    # The rest is unused.
    message = message[: int.from_bytes(message[8:12], "big")]
    intact = p07.e2e_p07_check(bytes(message), data_id)
    flipped = bytearray(message)
    flipped[len(flipped) // 2] ^= 0x10
    still = p07.e2e_p07_check(bytes(flipped), data_id)
    again = bytearray(message)
    again[0:12] = bytes(12)
    p07.e2e_p07_protect(again, data_id, increment_counter=False)
    print(int(intact), int(still), again.hex())
