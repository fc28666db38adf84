"""Pictures of drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._run import Results

_ROWS = [
    ("speed_mps", "speed, m/s"),
    ("gap_m", "gap, m"),
    ("acceleration_mps2", "acceleration, m/s²"),
]


def plot(runs: Sequence[tuple[str, Results]], axes: Any = None, title: str = "") -> Any:
    """Draws drives over each other and returns the figure."""
    import matplotlib.pyplot as plt

    if axes is None:
        figure, axes = plt.subplots(len(_ROWS), 1, sharex=True, figsize=(8, 6), layout="constrained")
        figure.suptitle(title)
    else:
        figure = axes[0].figure
    for label, run in runs:
        table = run.trajectory
        time_s = table["time_s"].to_numpy()
        for axis, (name, heading) in zip(axes, _ROWS):
            axis.plot(time_s, table[name].to_numpy(), label=label, linewidth=1.2)
            axis.set_ylabel(heading)
            axis.grid(True, alpha=0.3)
    if runs:
        lead = runs[0][1].trajectory
        speeds = lead["lead_speed_mps"].to_numpy()
        axes[0].plot(lead["time_s"].to_numpy(), speeds, "k--", linewidth=0.8, label="vehicle ahead")
    axes[0].legend(loc="best", fontsize="small")
    axes[-1].set_xlabel("time, s")
    return figure
