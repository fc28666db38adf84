"""Runs with a law in Python."""

from __future__ import annotations

import threading

import numpy as np
import pyarrow as pa
import pytest
import timegap
from laws import Counting, two_seconds


def test_a_function_drives_and_its_results_have_units_in_their_names() -> None:
    run = timegap.run("following", law=two_seconds, set={"set_speed_mps": 25})
    assert run.ok and run.outcome == "completed" and run.error is None, run.error
    assert run.law == "two_seconds" and run.scenario == "following"
    assert run.summary["control"]["min_gap_m"] > 5.0
    assert run.summary["timing"]["law_program"]["answers"] == 601
    table = run.trajectory
    assert isinstance(table, pa.Table)
    assert {"time_s", "speed_mps", "gap_m", "request_mps2"} <= set(table.column_names)
    assert table["request_mps2"].null_count > 0, "steps without a command have no value"
    assert table["speed_mps"].null_count == 0
    events = run.events.to_pylist()
    assert events[-1]["kind"] == "end" and events[-1]["what"] == "completed"


def test_the_emergency_brake_is_seen() -> None:
    run = timegap.run("tight-cut-in")
    count = run.summary["aebs"]["interventions"]
    brakes = [event for event in run.events.to_pylist() if event["kind"] == "brake"]
    assert count > 0 and len(brakes) == count and brakes[0]["what"] == "emergency braking"
    assert f"interventions={count}" in repr(run) and "interventions" in run._repr_html_()
    quiet = timegap.run("following", duration_s=2)
    assert "interventions" not in repr(quiet) and [e["kind"] for e in quiet.events.to_pylist()] == ["end"]


def test_a_run_repeats_to_the_byte() -> None:
    runs = [timegap.run("following", law=two_seconds, digests=True, duration_s=5) for _ in range(2)]
    digests = [{topic: counts["digests"] for topic, counts in run.summary["messages"].items()} for run in runs]
    assert digests[0] == digests[1] and any(digests[0].values())


def test_pandas_polars_and_a_notebook_show_a_run() -> None:
    run = timegap.run("following", law=two_seconds, duration_s=3)
    assert pytest.importorskip("pandas") is not None
    assert list(run.to_pandas().columns) == run.trajectory.column_names
    polars = pytest.importorskip("polars")
    assert isinstance(run.to_polars(), polars.DataFrame) and len(run.to_polars()) == run.trajectory.num_rows
    shown = run._repr_html_()
    assert "two_seconds" in shown and "min_gap_m" in shown and "completed" in repr(run)


def test_a_plot_has_a_curve_for_speed_gap_and_acceleration() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = timegap.run("following", law=two_seconds, duration_s=3).plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["speed, m/s", "gap, m", "acceleration, m/s²"]
    assert all(axis.lines for axis in figure.axes)


def test_an_object_is_reset_before_its_first_question() -> None:
    law = Counting()
    timegap.run("following", law=law, duration_s=2)
    timegap.run("following", law=law, duration_s=2)
    assert (law.asked, law.resets) == (21, 2)


def test_an_answer_may_have_a_plan_a_mode_and_figures() -> None:
    def law(q: timegap.Question) -> timegap.Answer:
        request = two_seconds(q)
        return timegap.Answer(request, plan_mps2=[request / 2, 0.0], mode=3, figures=[q.gap_m, 1.5])

    run = timegap.run("following", law=law, duration_s=2)
    table = run.trajectory
    modes = [mode for mode in table["mode"].to_pylist() if mode is not None]
    assert set(modes) == {3.0} and run.modes[3] == "mode-3"
    figures = [value for value in table["figure_1"].to_pylist() if value is not None]
    assert set(figures) == {1.5}


def test_arrays_of_a_question_are_views_that_stay_valid() -> None:
    kept = []

    def law(q: timegap.Question) -> float:
        signals = q.signals
        if len(signals):
            assert not signals.flags.owndata and not signals.flags.writeable
            count = int(signals["interval_count"][0])
            kept.append((signals, float(signals["distance_m"][0]), signals["intervals"][0]["phase"][:count].copy()))
        return two_seconds(q)

    timegap.run("cacc-a", law=law)
    assert len(kept) > 50
    for signals, distance_m, phases in kept:
        assert float(signals["distance_m"][0]) == distance_m, "a later question did not write over it"
        assert set(np.unique(phases)) <= {0, 1, 2, 3}
    distances = [distance_m for _, distance_m, _ in kept]
    assert max(distances) > min(distances) + 10.0


def test_a_truck_sees_the_road_ahead() -> None:
    seen = []

    def law(q: timegap.Question) -> float:
        seen.append((q.has_powertrain, q.gear, len(q.cell_grades), q.cell_m))
        return 0.4 * (q.set_speed_mps - q.speed_mps)

    timegap.run("truck-hills", law=law, duration_s=5)
    has_powertrain, gear, cells, cell_m = seen[-1]
    assert has_powertrain and gear >= 1 and cells > 10 and cell_m > 0.0


def test_an_exception_ends_the_run_with_its_traceback() -> None:
    def law(q: timegap.Question) -> float:
        if q.time_s > 1.0:
            raise ValueError("by design")
        return 0.0

    run = timegap.run("following", law=law)
    assert run.outcome == "aborted" and not run.ok
    assert run.error is not None
    for words in ("the law `law` failed", "Traceback", "test_run.py", 'raise ValueError("by design")'):
        assert words in run.error, run.error
    assert isinstance(run.exception, ValueError)
    assert run.trajectory.num_rows > 90, "what was driven before is there"
    assert "Traceback" in run._repr_html_()


def test_deep_recursion_is_an_exception_too() -> None:
    def law(q: timegap.Question) -> float:
        return law(q)

    run = timegap.run("following", law=law)
    assert isinstance(run.exception, RecursionError)


def test_an_interrupt_in_a_law_reaches_the_caller() -> None:
    def law(q: timegap.Question) -> float:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        timegap.run("following", law=law)
    assert timegap.run("following", duration_s=1).ok, "the next run is not harmed"


def test_runs_go_on_in_threads_at_once() -> None:
    results: dict[int, float] = {}

    def work(number: int) -> None:
        run = timegap.run("following", law=two_seconds if number % 2 else "acc-mpc", duration_s=5)
        results[number] = run.summary["control"]["min_gap_m"]

    threads = [threading.Thread(target=work, args=(number,)) for number in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 6
    assert len({results[number] for number in (1, 3, 5)}) == 1 and len({results[number] for number in (0, 2, 4)}) == 1


def test_there_are_scenarios_and_laws() -> None:
    assert "following" in [scenario.name for scenario in timegap.scenarios()]
    laws = {law.name: law for law in timegap.laws()}
    assert "acc-mpc" in laws and "external" not in laws and laws["acc-mpc"].description
