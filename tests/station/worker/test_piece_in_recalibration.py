"""Shows the reference piece in a recalibration, from rendered pictures: who checks it, what is
kept, and what a later check is held against.  Whether a check is right is shown elsewhere."""

import json

import cv2
import numpy as np
import pytest
from recalibration_ground import Shop
from sqlalchemy import select

import station.worker.piece_checking as piece_checking
from station.documents import PieceDocument
from station.scenes import PieceScene, paper_sensor, piece_pose
from station.settings import RecalibrationSettings
from station.store import CalibrationSession, KeptPieceCheck, Recording, SessionState

CERTIFICATE = {
    "format": "treadline-piece",
    "version": 1,
    "name": "ridges",
    "profile": [[0, 0], [25, 0], [35, 10], [65, 10], [75, 0], [100, 0]],
    "u95_mm": 0.004,
    "held_u95_mm": 0.01,
}


@pytest.fixture
def shop(ground, tmp_path, rng):
    certificate = tmp_path / "piece.json"
    certificate.write_text(json.dumps(CERTIFICATE))
    piece = {"certificate": certificate, "holder_kept": True}
    settings = RecalibrationSettings(sensors={"left": {"piece": piece}})
    shop = Shop(ground, tmp_path / "trace", rng, settings=settings)
    shop.activate_first()
    return shop


@pytest.fixture
def checked_since(monkeypatch):
    """What each check was held against."""
    since = []
    real = piece_checking.check_piece

    def check(*arguments, **options):
        since.append(None if options["since"] is None else options["since"].created)
        return real(*arguments, **options)

    monkeypatch.setattr(piece_checking, "check_piece", check)
    return since


def show_piece(shop, name):
    """Take a picture of the piece; return the recording."""
    folder = shop.ground.layout.root / name
    folder.mkdir()
    known, truth = PieceDocument.model_validate(CERTIFICATE).piece(), paper_sensor()
    pose = piece_pose(truth, known, middle_px=(1000.0, 560.0), turn_rad=0.1)
    picture = PieceScene(truth, pose, known, seed=1).render(np.random.default_rng(1))
    cv2.imwrite(str(folder / "0.png"), picture)
    with shop.store.change() as session:
        session.add(
            CalibrationSession(
                id=name, state=SessionState.RECORDED, sensor="left", target="dots:7x8:12",
                pictures=1, opened_at=shop.now,
            )
        )  # fmt: skip
        session.flush()
        session.add(
            Recording(
                id=f"session.{name}.left", sensor="left", session_id=name, path=name,
                opened_at=shop.now, closed_at=shop.now, recorded=1,
            )
        )  # fmt: skip
    return f"session.{name}.left"


def kept(shop):
    with shop.store.look() as session:
        return session.scalars(select(KeptPieceCheck).order_by(KeptPieceCheck.id)).all()


def test_both_calibrations_check_it_and_later_checks_are_held_against_the_first(
    shop, checked_since
):
    shop.session()
    recording = show_piece(shop, "piece-1")
    row = shop.recalibrate("r1")
    assert row.taken["piece"] == [recording]
    assert recording not in row.taken["recordings"]
    assert [each.calibration_id for each in kept(shop)] == ["r1", "first"]
    assert set(row.findings["piece"]) == {"by_new", "by_present"}
    assert checked_since == [None, None]
    # The sensor is at rest: whatever the piece can say, it is not that one of them is wrong.
    assert "drifted" not in row.findings["piece"].values()
    assert any(
        each.startswith("the piece by the new calibration: ") for each in row.reasons["reasons"]
    )

    show_piece(shop, "piece-2")
    row = shop.recalibrate("r2")
    assert row.taken["recordings"] == []
    first_by_present = json.loads(kept(shop)[1].document)["created"]
    assert [each.calibration_id for each in kept(shop)] == ["r1", "first", "first"]
    assert checked_since[2].isoformat().replace("+00:00", "Z") == first_by_present


def test_certificate_that_cannot_be_read_is_a_remark_and_decides_nothing(shop):
    shop.settings.sensors["left"].piece.certificate.write_text("no json")
    shop.session()
    show_piece(shop, "piece-1")
    row = shop.recalibrate()
    assert (row.outcome, kept(shop)) == ("consistent", [])
    assert any("the reference piece was not checked" in each for each in row.reasons["reasons"])
