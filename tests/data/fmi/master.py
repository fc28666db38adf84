"""Validates exported units and steps them as other people's master: `master.py LAW.fmu LOOP.fmu`."""

import sys

import numpy
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

law, loop = sys.argv[1:]
for unit in (law, loop):
    problems = validate_fmu(unit)
    assert not problems, problems

inputs = [("time", float), ("speed_mps", float), ("set_speed_mps", float), ("has_target", float), ("gap_m", float)]
signal = numpy.array([(0, 20, 30, 0, 0), (2, 20, 30, 0, 0), (2.001, 20, 30, 1, 8), (4, 20, 30, 1, 8)], dtype=inputs)
result = simulate_fmu(law, stop_time=4, step_size=0.1, output_interval=0.1, input=signal, output=["request_mps2"])
request = result["request_mps2"]
assert request[15] > 0.3, "it accelerates on a free road"
assert request[-1] < -1.0, "it brakes behind a near vehicle"

lead = numpy.array([(t, 50 + 20 * t, 20) for t in range(61)],
                   dtype=[("time", float), ("lead_position_m", float), ("lead_speed_mps", float)])


def follow(**values):
    result = simulate_fmu(loop, stop_time=60, step_size=0.1, output_interval=0.1, input=lead,
                          start_values={"initial_speed_mps": 25.0, **values},
                          output=["position_m", "speed_mps"])
    assert abs(result["speed_mps"][0] - 25.0) < 1e-9 and abs(result["speed_mps"][-1] - 20.0) < 0.5, result[-1]
    return result["position_m"]


ideal = follow()
assert numpy.array_equal(ideal, follow()), "the same bytes"
noisy = follow(delay_ms=200.0, jitter_ms=100.0, drop_share=0.2, restart_every_s=7.0)
assert not numpy.array_equal(ideal, noisy)
assert numpy.array_equal(noisy, follow(delay_ms=200.0, jitter_ms=100.0, drop_share=0.2, restart_every_s=7.0))
print("both units drive")
