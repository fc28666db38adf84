"""The air between two hosts: forwards Ethernet frames between two interfaces, late, in another order, or
not at all. A seeded stand-in for `tc netem`, which many kernels lack, that also counts what it dropped.

    air.py forward IF_A IF_B SEED     reads `air DELAY_MS JITTER_MS LOSS`, `cut`, `count` on standard input
    air.py plain IF                   lets the interface compute checksums itself, as a cable would need
"""

import array
import fcntl
import heapq
import json
import random
import select
import socket
import struct
import sys
import time

FRAME = b"TGR1\x00\x00\x00\x01"


def plain(interface):
    control = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for command in (0x17, 0x1F, 0x24):  # no transmit checksums, TSO, GSO
        value = array.array("B", struct.pack("II", command, 0))
        request = struct.pack("16sP", interface.encode(), value.buffer_info()[0])
        fcntl.ioctl(control, 0x8946, request)


def forward(interfaces, seed):
    ends = []
    for interface in interfaces:
        end = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
        end.bind((interface, 0))
        end.setblocking(False)
        ends.append(end)
    draw = random.Random(seed)
    delay_s, jitter_s, loss, is_cut = 0.0, 0.0, 0.0, False
    waiting, number = [], 0
    dropped = [0, 0]
    commands = b""
    while True:
        now = time.monotonic()
        while waiting and waiting[0][0] <= now:
            _, _, end, packet = heapq.heappop(waiting)
            try:
                ends[end].send(packet)
            except OSError:
                dropped[1 - end] += FRAME in packet
        wait = max(0.0, waiting[0][0] - now) if waiting else None
        ready, _, _ = select.select([sys.stdin.fileno(), *ends], [], [], wait)
        for end in (0, 1):
            if ends[end] not in ready:
                continue
            while True:
                try:
                    packet, address = ends[end].recvfrom(65536)
                except BlockingIOError:
                    break
                if address[2] == socket.PACKET_OUTGOING:
                    continue
                if is_cut or draw.random() < loss:
                    dropped[end] += FRAME in packet
                    continue
                number += 1
                late = max(0.0, delay_s + draw.uniform(-jitter_s, jitter_s))
                heapq.heappush(waiting, (time.monotonic() + late, number, 1 - end, packet))
        if sys.stdin.fileno() in ready:
            read = sys.stdin.buffer.raw.read(4096)
            if not read:
                return
            commands += read
            *lines, commands = commands.split(b"\n")
            for line in lines:
                words = line.decode().split()
                if words[0] == "air":
                    delay_s, jitter_s, loss = (float(word) for word in words[1:])
                    delay_s, jitter_s, is_cut = delay_s / 1e3, jitter_s / 1e3, False
                elif words[0] == "cut":
                    is_cut = True
                print(json.dumps({"dropped": dropped, "waiting": len(waiting)}), flush=True)


if sys.argv[1] == "plain":
    plain(sys.argv[2])
else:
    forward(sys.argv[2:4], int(sys.argv[4]))
