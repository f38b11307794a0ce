"""Shows that lists of measurements come without profiles, and where the profiles are to be had."""

import pytest

from station.store import Calibration, CalibrationState, Measurement, Recording
from station.store.measured import add_measurements

PROFILE = {"d_mm": [0.0, 70.0], "h_mm": [0.0, 0.1], "sigma_mm": [0.02, 0.02]}


@pytest.fixture
def measured(served):
    """A wheel with a profile and one without."""
    now = served.station.now()
    with served.store.change() as session:
        session.add(
            Calibration(
                id="c1", state=CalibrationState.READY, sensor="left", target="dots:7x8:12",
                method="joint", recording_ids={"recordings": [], "laser_off": []},
                created_at=now, job_id="j",
            )
        )  # fmt: skip
        session.flush()
        session.add(Recording(id="r1", sensor="left", path="x", opened_at=now, recovered=False))
        session.flush()
        rows = [
            Measurement(
                recording_id="r1", frame=frame, calibration_id="c1", sensor="left",
                reference="S1002", software="none", measured_at=now,
                wheel={"frame": frame, "profile": profile},
            )
            for frame, profile in ((1, PROFILE), (2, None))
        ]  # fmt: skip
        add_measurements(session, rows)
        return [row.id for row in rows]


def wheels(call, **query):
    answer = call.get("/v1/measurements", params=query).raise_for_status().json()
    return [each["wheel"] for each in answer["measurements"]]


def test_a_list_has_profiles_only_where_they_are_asked_for(measured, call):
    assert wheels(call) == [{"frame": 1}, {"frame": 2}]
    assert wheels(call, profiles=True) == [{"frame": 1, "profile": PROFILE}, {"frame": 2}]


def test_one_measurement_comes_with_its_profile(measured, call):
    found = call.get(f"/v1/measurements/{measured[0]}").raise_for_status().json()
    assert found["wheel"] == {"frame": 1, "profile": PROFILE}
    assert (found["recording"], found["calibration"], found["software"]) == ("r1", "c1", "none")


@pytest.mark.parametrize(("name", "status"), [("999999", 404), ("0", 422), ("x", 422)])
def test_what_is_no_measurement_is_refused(call, name, status):
    assert call.get(f"/v1/measurements/{name}").status_code == status
