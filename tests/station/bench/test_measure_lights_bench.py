"""The bench of wheels by light, made small; calibrating in each light is shown with the lights."""

import numpy as np

from station.bench import measure_lights
from station.bench.measure_lights import FAULTS, bench_measure_lights, worn_wheels
from station.progress import silent
from station.scenes import Light, paper_sensor


def test_every_light_and_fault_has_its_row(monkeypatch):
    monkeypatch.setattr(
        measure_lights, "calibrated_in", lambda light, *, poses, seed: paper_sensor()
    )
    table = bench_measure_lights(silent, wheels=1, poses=1)
    assert [row["light or fault"] for row in table.rows] == [*map(str, Light), *FAULTS]
    good = table.rows[0]
    # One new wheel in good light, by the true sensor.
    assert good["holds"]
    assert good["inside u95"] == 1.0


def test_wheels_of_a_light_are_of_both_references_and_worn_over_the_whole_range():
    wheels = worn_wheels(Light.STRAY, count=6, seed=2)
    assert {scene.wheel.reference for scene in wheels} == {"S1002", "LMA"}
    np.testing.assert_allclose(
        [scene.wheel.tread_wear_mm for scene in wheels], np.linspace(0.0, 8.0, 6)
    )
    again = worn_wheels(Light.STRAY, count=6, seed=2)
    assert [scene.seed for scene in wheels] == [scene.seed for scene in again]
