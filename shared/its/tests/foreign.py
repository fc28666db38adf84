# Messages that are not for an on-board unit of timegap, made by pycrate: a line `NAME HEX` for each.
#
# pycrate's modules share their names: each is imported in a process of its own, named by the argument.
import sys

if sys.argv[1] == "sae":
    from pycrate_asn1dir import ITS

    # SAE J2735, as sent in North America: SPAT has the id 19 (0x13), MAP the id 18 (0x12).
    frame = ITS.GLOBAL.MOD["DSRC"]["MessageFrame"]
    state = {"eventState": "protected-Movement-Allowed", "timing": {"minEndTime": 100, "maxEndTime": 200}}
    movement = {"signalGroup": 9, "state-time-speed": [state]}
    crossing = {"id": {"id": 501}, "revision": 3, "status": (0, 16), "timeStamp": 30000, "states": [movement]}
    frame.set_val({"messageId": 19, "value": ("SPAT", {"timeStamp": 218159, "intersections": [crossing]})})
    print("sae_spat", frame.to_uper().hex())
    lane = {
        "laneID": 1,
        "ingressApproach": 2,
        "laneAttributes": {"directionalUse": (2, 2), "sharedWith": (0, 10), "laneType": ("vehicle", (0, 8))},
        "nodeList": ("nodes", [{"delta": ("node-XY1", {"x": -5, "y": 6})}, {"delta": ("node-XY1", {"x": -9, "y": 0})}]),
    }
    geometry = {"id": {"id": 501}, "revision": 3, "refPoint": {"lat": 423000000, "long": -837000000}, "laneSet": [lane]}
    frame.set_val({"messageId": 18, "value": ("MapData", {"msgIssueRevision": 1, "intersections": [geometry]})})
    print("sae_map", frame.to_uper().hex())
elif sys.argv[1] == "is":
    from pycrate_asn1dir import ITS_IS

    # A vehicle asks for green: message id 9, on BTP port 2007.
    srem = ITS_IS.GLOBAL.MOD["SREM-PDU-Descriptions"]["SREM"]
    request = {"timeStamp": 99, "second": 1000, "requestor": {"id": ("stationID", 77)}}
    srem.set_val({"header": {"protocolVersion": 2, "messageID": 9, "stationID": 77}, "srm": request})
    print("srem", srem.to_uper().hex())

    # A SPATEM of a later version, whose events and movements have additions that are not known yet.
    spatem = ITS_IS.GLOBAL.MOD["SPATEM-PDU-Descriptions"]["SPATEM"]
    events = [
        {"eventState": state, "timing": {"minEndTime": end}, "_ext_2": b"later"}
        for state, end in [("stop-And-Remain", 100), ("protected-Movement-Allowed", 200)]
    ]
    movements = [{"signalGroup": group, "state-time-speed": events, "_ext_5": b"much later"} for group in (9, 10)]
    crossing = {"id": {"id": 501}, "revision": 3, "status": (0, 16), "timeStamp": 30000, "states": movements}
    header = {"protocolVersion": 2, "messageID": 4, "stationID": 77}
    spatem.set_val({"header": header, "spat": {"intersections": [crossing]}})
    print("spatem_later", spatem.to_uper().hex())
else:
    from pycrate_asn1dir import ITS_CAM_2

    cam = ITS_CAM_2.GLOBAL.MOD["CAM-PDU-Descriptions"]["CAM"]
    ellipse = {"semiMajorConfidence": 4095, "semiMinorConfidence": 4095, "semiMajorOrientation": 3601}
    unknown = {"altitudeValue": 800001, "altitudeConfidence": "unavailable"}
    fast = {
        "heading": {"headingValue": 900, "headingConfidence": 127},
        "speed": {"speedValue": 1000, "speedConfidence": 127},
        "driveDirection": "forward",
        "vehicleLength": {"vehicleLengthValue": 45, "vehicleLengthConfidenceIndication": "unavailable"},
        "vehicleWidth": 19,
        "longitudinalAcceleration": {"longitudinalAccelerationValue": 0, "longitudinalAccelerationConfidence": 102},
        "curvature": {"curvatureValue": 1023, "curvatureConfidence": "unavailable"},
        "curvatureCalculationMode": "unavailable",
        "yawRate": {"yawRateValue": 0, "yawRateConfidence": "unavailable"},
    }
    # The same station id, 4711, at two places.
    for name, longitude in [("cam_west", 91000000), ("cam_east", 91010000)]:
        position = {
            "latitude": 487000000, "longitude": longitude,
            "positionConfidenceEllipse": ellipse, "altitude": unknown,
        }
        basic = {"stationType": 5, "referencePosition": position}
        parameters = {
            "basicContainer": basic,
            "highFrequencyContainer": ("basicVehicleContainerHighFrequency", fast),
        }
        cam.set_val({
            "header": {"protocolVersion": 2, "messageID": 2, "stationID": 4711},
            "cam": {"generationDeltaTime": 0, "camParameters": parameters},
        })
        print(name, cam.to_uper().hex())
