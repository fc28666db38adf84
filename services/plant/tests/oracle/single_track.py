"""Writes single_track.csv: the single track of commonroad-vehicle-models on two steering inputs.

    pip install commonroad-vehicle-models==3.0.2 scipy==1.17.1
    python single_track.py > single_track.csv

The plant's model is compared with these figures (services/plant/src/lateral/tests.rs). Steering angles have an
amplitude whose steady circle has the lateral acceleration of the column. Speeds are constant.
"""

import math

from scipy.integrate import solve_ivp
from vehiclemodels.parameters_vehicle1 import parameters_vehicle1
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.parameters_vehicle3 import parameters_vehicle3
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st

GRAVITY = 9.81


def step(t):
    """A turn of the wheel in half a second."""
    return 0.5 - 0.5 * math.cos(math.pi * min(t, 0.5) / 0.5)


def sine(t):
    """Half a hertz."""
    return math.sin(math.pi * t)


def main():
    """Prints all cases."""
    print("vehicle,mass_kg,inertia_kgm2,front_m,rear_m,slip_rad_per_mps2,"
          "shape,speed_mps,amplitude_rad,time_s,yaw_rate_radps,slip_rad")
    vehicles = [parameters_vehicle1(), parameters_vehicle2(), parameters_vehicle3()]
    for number, p in enumerate(vehicles, 1):
        compliance = 1.0 / (-p.tire.p_ky1 * GRAVITY)
        for speed in [6.0, 17.0, 32.0]:
            for acceleration in [1.0, 3.0]:
                amplitude = acceleration * (p.a + p.b) / speed**2
                for name, shape in [("step", step), ("sine", sine)]:
                    def rate(t, x, p=p, shape=shape, amplitude=amplitude):
                        x = list(x)
                        # The angle itself is the input, without the limits of a steering rate.
                        x[2] = amplitude * shape(t)
                        return vehicle_dynamics_st(x, [0.0, 0.0], p)

                    times = [0.2 * k for k in range(1, 21)]
                    start = [0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0]
                    found = solve_ivp(rate, (0.0, 4.0), start, t_eval=times, rtol=1e-9, atol=1e-12)
                    for t, yaw_rate, slip in zip(found.t, found.y[5], found.y[6]):
                        print(f"{number},{p.m:.10g},{p.I_z:.10g},{p.a:.10g},{p.b:.10g},{compliance:.12g},"
                              f"{name},{speed:g},{amplitude:.12g},{t:.1f},{yaw_rate:.9g},{slip:.9g}")


main()
