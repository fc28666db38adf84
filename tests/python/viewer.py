"""A viewer of Foxglove's protocol by PyPI's `websockets`, whose messages `mcap-ros2-support` reads.

    viewer.py PORT [FAULT]

It subscribes to all channels, asks for all parameters, injects FAULT (JSON), and prints a JSON object at the end of the
connection: messages by topic, the newest odometry, parameters, what the service answered, and why it ended.
"""

import asyncio
import json
import struct
import sys

import websockets
from mcap_ros2._dynamic import generate_dynamic


async def view(port: str, fault: str | None) -> dict:
    seen = {"messages": {}, "times": 0, "answer": None}
    readers, topics = {}, {}
    protocols = ["foxglove.sdk.v1", "foxglove.websocket.v1"]
    url = f"ws://127.0.0.1:{port}"
    async with websockets.connect(url, subprotocols=protocols, max_size=None) as socket:
        seen["subprotocol"] = socket.subprotocol
        try:
            while True:
                message = await socket.recv()
                if isinstance(message, str):
                    text = json.loads(message)
                    if text["op"] == "advertise":
                        for channel in text["channels"]:
                            name = channel["schemaName"]
                            readers[channel["id"]] = generate_dynamic(name, channel["schema"])[name]
                            topics[channel["id"]] = channel["topic"]
                        asked = [{"id": 100 + id, "channelId": id} for id in topics]
                        await socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
                        question = {"op": "getParameters", "parameterNames": [], "id": "all"}
                        await socket.send(json.dumps(question))
                    elif text["op"] == "parameterValues":
                        seen["parameters"] = {p["name"]: p["value"] for p in text["parameters"]}
                    elif text["op"] == "advertiseServices" and fault:
                        id = text["services"][0]["id"]
                        head = b"\x02" + struct.pack("<III", id, 1, 4) + b"json"
                        await socket.send(head + fault.encode())
                    elif text["op"] == "serviceCallFailure":
                        seen["answer"] = text["message"]
                elif message[0] == 1:
                    id = struct.unpack_from("<I", message, 1)[0] - 100
                    read = readers[id](message[13:])
                    seen["messages"][topics[id]] = seen["messages"].get(topics[id], 0) + 1
                    if topics[id] == "vehicle/odometry":
                        seen["speed_mps"] = read.speed_mps
                elif message[0] == 2:
                    seen["times"] += 1
                elif message[0] == 3:
                    seen["answer"] = json.loads(message[17:])
        except websockets.ConnectionClosed as closed:
            seen["end"] = closed.rcvd.reason if closed.rcvd else "cut off"
    return seen


print(json.dumps(asyncio.run(view(sys.argv[1], *sys.argv[2:3], *[None] * (3 - len(sys.argv))))))
