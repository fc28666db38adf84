"""A law as a node on DDS, with PyPI's `cyclonedds` in place of ROS 2: a time headway of two seconds.

    timegap run following --law mine=ros2:         and beside it
    CYCLONEDDS_URI=file://$PWD/cyclonedds.xml python3 ros2_law.py

A node of ROS 2 does the same with `timegap_msgs` (`timegap print layouts --msg DIR`): it subscribes to
/timegap/situation, and publishes a LawAnswer with the question's number on /timegap/command.
"""

import os
from dataclasses import dataclass, field

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


def named(name: str) -> str:
    return f"timegap_msgs::msg::dds_::{name}_"


@dataclass
class LawInterval(IdlStruct, typename=named("LawInterval")):
    phase: uint64
    ends_in_s: float64


@dataclass
class LawSignal(IdlStruct, typename=named("LawSignal")):
    id: uint64
    distance_m: float64
    interval_count: uint64
    intervals: array[LawInterval, 8]


@dataclass
class LawInput(IdlStruct, typename=named("LawInput")):
    sequence: uint64
    reset: uint64
    time_s: float64
    period_s: float64
    position_m: float64
    speed_mps: float64
    acceleration_mps2: float64
    set_speed_mps: float64
    speed_limit_mps: float64
    has_target: uint64
    target_id: uint64
    gap_m: float64
    relative_speed_mps: float64
    target_acceleration_mps2: float64
    target_age_s: float64
    signal_count: uint64
    signals: array[LawSignal, 4]
    has_powertrain: uint64
    gear: uint64
    since_shift_s: float64
    engine_torque_nm: float64
    grade: float64
    cell_count: uint64
    first_cell_m: float64
    cell_m: float64
    cell_grades: array[float64, 64]


@dataclass
class LawAnswer(IdlStruct, typename=named("LawAnswer")):
    sequence: uint64
    request_mps2: float64
    mode: uint64 = 0
    figures: array[float64, 8] = field(default_factory=lambda: [0.0] * 8)
    has_torque: uint64 = 0
    engine_torque_nm: float64 = 0.0
    service_brake_n: float64 = 0.0
    gear: uint64 = 0
    plan_count: uint64 = 0
    plan_mps2: array[float64, 96] = field(default_factory=lambda: [0.0] * 96)


def law(q: LawInput) -> float:
    request = 0.4 * (min(q.set_speed_mps, q.speed_limit_mps) - q.speed_mps)
    if q.has_target:
        request = min(request, 0.2 * (q.gap_m - 5.0 - 2.0 * q.speed_mps) + 0.7 * q.relative_speed_mps)
    return max(-4.0, min(2.0, request))


def main() -> None:
    domain = DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", "0")))
    reliable = Policy.Reliability.Reliable(max_blocking_time=100_000_000)
    qos = Qos(reliable, Policy.Durability.Volatile, Policy.History.KeepLast(10))
    command = DataWriter(domain, Topic(domain, "rt/timegap/command", LawAnswer, qos=qos), qos=qos)
    topic = Topic(domain, "rt/timegap/situation", LawInput, qos=qos)
    for question in DataReader(domain, topic, qos=qos).take_iter():
        command.write(LawAnswer(question.sequence, law(question)))


if __name__ == "__main__":
    main()
