"""Shows `station recalibrate` where no station runs: it does the work itself, and its exit code
says what came of it."""

import json

import pytest
from recalibration_ground import Shop
from sensor_points import turned

from station.cli.main import build_app, run
from station.scenes import paper_sensor
from station.store import active
from station.worker import held


@pytest.fixture
def shop(ground, tmp_path, rng):
    return Shop(ground, tmp_path / "trace", rng)


@pytest.fixture
def call(shop, tmp_path, capsys):
    config = tmp_path / "station.toml"
    config.write_text(
        f'data_dir = "{shop.ground.layout.root}"\n'
        '[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
        "[[sensors]]\nid = 'right'\naddress = '127.0.0.3'\n"
    )

    def call(*arguments):
        capsys.readouterr()
        code = run(build_app("recalibrate"), ["recalibrate", "--config", str(config), *arguments])
        said = capsys.readouterr()
        return code, said.out, said.err

    return call


def test_sensor_at_rest_is_kept_with_exit_0_and_the_reason(shop, call):
    shop.activate_first()
    shop.session()
    code, out, _ = call()
    assert code == 0
    assert out.startswith("left: consistent, kept\n  the sheets differ by ")


def test_drift_is_exit_1_and_names_the_question(shop, call):
    shop.activate_first()
    shop.session(sensor=turned(paper_sensor(), 1e-3))
    code, out, err = call("--sensor", "left", "--json")
    (result,) = json.loads(out)["recalibrations"]
    assert (code, result["state"], result["alarm"]) == (1, "asking", True)
    assert f"somebody must look: left (recalibration {result['id']})" in err
    with shop.store.look() as session:
        assert active(session, "left").calibration_id == "first"


def test_without_a_calibration_in_force_it_is_exit_2(call):
    code, out, err = call()
    assert (code, out) == (2, "")
    assert "no sensor has a calibration in force" in err


def test_unknown_sensor_is_exit_2_and_names_those_there_are(call):
    code, _, err = call("--sensor", "middle")
    assert code == 2
    assert "the station has left, right" in err


@pytest.mark.usefixtures("once")
def test_beside_a_worker_it_does_nothing(shop, call):
    with held(shop.ground.layout.worker_lock, "a worker"):
        code, _, err = call()
    assert code == 2
    assert "a worker runs already" in err


def test_beside_a_station_it_wants_a_key(shop, call, monkeypatch):
    for name in ("STATION_KEY", "STATION_ADMIN_KEY"):
        monkeypatch.delenv(name, raising=False)
    with held(shop.ground.layout.station_lock, "a station"):
        code, _, err = call()
    assert code == 2
    assert "put a key of it with scope calibrate into STATION_KEY" in err
