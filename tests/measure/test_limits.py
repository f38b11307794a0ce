"""Limits raise alarms as the regimes have them, and say which regime it was."""

import pickle

import pytest

from measure import PRESETS, Alarm, Limit, Limits, Quantity, reference_profile

SD = Quantity.FLANGE_THICKNESS_10


@pytest.mark.parametrize("name", ["S1002", "LMA"])
@pytest.mark.parametrize("regime", PRESETS)
def test_a_new_wheel_raises_nothing_in_any_regime(name, regime):
    nominal = reference_profile(name).nominal
    for quantity, value in nominal.items():
        # 0.03 mm is what is asked of a reading.
        assert PRESETS[regime].judge(quantity, value, 0.03) is Alarm.NONE


@pytest.mark.parametrize(
    ("regime", "quantity", "worn", "condemned"),
    [
        ("tsi", Quantity.FLANGE_HEIGHT, 35.8, 36.1),
        ("tsi", Quantity.FLANGE_THICKNESS_10, 22.2, 21.9),
        ("tsi", Quantity.FLANGE_GRADIENT_QR, 6.7, 6.4),
        ("china_freight", Quantity.FLANGE_THICKNESS_12, 23.2, 22.9),
        ("china_freight", Quantity.TREAD_WEAR, 7.8, 8.1),
        ("practice", Quantity.TREAD_WEAR, 7.8, 8.1),
        ("practice", Quantity.HOLLOW_DEPTH, 1.8, 2.1),
    ],
)
def test_a_regime_warns_near_the_worn_end_and_alarms_beyond_it(regime, quantity, worn, condemned):
    limits = PRESETS[regime]
    assert limits.regime == regime
    assert limits.judge(quantity, worn, 0.03) is Alarm.WARNING
    assert limits.judge(quantity, condemned, 0.03) is Alarm.ALARM


def test_regimes_leave_alone_what_they_do_not_speak_of():
    assert PRESETS["tsi"].judge(Quantity.TREAD_WEAR, 99.0, 0.1) is Alarm.NONE
    assert PRESETS["china_freight"].judge(SD, 1.0, 0.1) is Alarm.NONE


def test_limits_are_the_same_in_another_process():
    again = pickle.loads(pickle.dumps(PRESETS["tsi"]))
    assert (again, hash(again)) == (PRESETS["tsi"], hash(PRESETS["tsi"]))
    assert again != Limits("tsi", {SD: Limit(1.0, 2.0)})
