"""Shows the table of decisions, case by case.  How often it errs is simulated in another file."""

import math
from dataclasses import replace

import pytest

from measure import PieceVerdict
from station.recalibration import (
    Action,
    Difference,
    Evidence,
    NewCalibration,
    Outcome,
    PieceFindings,
    decide,
    largest_ratio,
)
from station.settings import GateSettings, PolicySettings

GATES = GateSettings()
ASKS = PolicySettings()
BY_ITSELF = PolicySettings(drifted="activate", first="activate", shifted="activate")
SOUND = NewCalibration(poses=10, rms_dots_px=0.05, rms_stripe_px=0.1, pictures_age_h=1.0)
# 0.0042 and 0.0028 mm make 0.005: with 3.48 of that a drift shows from 0.0174 mm on.
SAME = Difference(0.005, 0.009, (100.0, 50.0), 0.005, 0.0042, 0.0028)
EQUALLY_GOOD = replace(SAME, present_sigma_mm=0.0035, new_sigma_mm=0.0035)
AT_REST = Evidence(new=SOUND, sheet=EQUALLY_GOOD, present_age_days=10.0, unchecked_days=1.0)
BLURRED = replace(EQUALLY_GOOD, rms_mm=0.03, largest_mm=0.06)
MOVED = replace(EQUALLY_GOOD, rms_mm=0.15, largest_mm=0.30)
TRUE, WRONG, UNKNOWN = PieceVerdict.TRUE, PieceVerdict.DRIFTED, PieceVerdict.UNKNOWN


def with_difference(difference, **changes):
    return replace(AT_REST, sheet=difference, **changes)


def with_piece(by_new=None, by_present=None, *, required=False, **changes):
    piece = PieceFindings(by_new=by_new, by_present=by_present, required=required)
    return replace(AT_REST, piece=piece, **changes)


def refused(**changes):
    return replace(AT_REST, new=replace(SOUND, **changes))


AGING = GateSettings(oldest_calibration_days=9.0)
LONGEST = GateSettings(longest_unchecked_days=3.0)
NOTHING = Evidence(unchecked_days=4.0, present_age_days=10.0)

TABLE = {
    "agrees": (AT_REST, GATES, ASKS, Outcome.CONSISTENT, Action.KEEP, False),
    "agrees and is better": (
        with_difference(SAME), GATES, ASKS, Outcome.IMPROVED, Action.ACTIVATE, False,
    ),
    "agrees with an old one": (AT_REST, AGING, ASKS, Outcome.AGED, Action.ACTIVATE, False),
    "differs by little": (
        with_difference(BLURRED), GATES, ASKS, Outcome.SHIFTED, Action.KEEP, False,
    ),
    "differs by much": (with_difference(MOVED), GATES, ASKS, Outcome.DRIFTED, Action.ASK, True),
    "differs by much, not yet confirmed": (
        with_difference(MOVED), GATES, BY_ITSELF, Outcome.DRIFTED, Action.KEEP, True,
    ),
    "differs by much, confirmed": (
        with_difference(MOVED, confirmed=1),
        GATES, BY_ITSELF, Outcome.DRIFTED, Action.ACTIVATE, True,
    ),
    "the piece confirms the drift": (
        with_piece(TRUE, WRONG, sheet=MOVED),
        GATES, BY_ITSELF, Outcome.DRIFTED, Action.ACTIVATE, True,
    ),
    "the piece contradicts the drift": (
        with_piece(TRUE, TRUE, sheet=MOVED, confirmed=5),
        GATES, BY_ITSELF, Outcome.DRIFTED, Action.ASK, True,
    ),
    "the piece cannot say": (
        with_piece(UNKNOWN, UNKNOWN, sheet=MOVED),
        GATES, BY_ITSELF, Outcome.DRIFTED, Action.KEEP, True,
    ),
    "the new one makes the piece wrong": (
        with_piece(WRONG, TRUE, sheet=MOVED, confirmed=5),
        GATES, BY_ITSELF, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "both agree and make the piece wrong": (
        with_piece(UNKNOWN, WRONG), GATES, BY_ITSELF, Outcome.DOUBTFUL, Action.ASK, True,
    ),
    "better, but without the piece that is required": (
        with_piece(required=True, sheet=SAME), GATES, ASKS, Outcome.IMPROVED, Action.ASK, False,
    ),
    "better, with the piece that is required": (
        with_piece(TRUE, TRUE, required=True, sheet=SAME),
        GATES, ASKS, Outcome.IMPROVED, Action.ACTIVATE, False,
    ),
    "nothing was in force": (
        replace(AT_REST, sheet=None), GATES, ASKS, Outcome.FIRST, Action.ASK, False,
    ),
    "nothing was in force, and it may begin by itself": (
        replace(AT_REST, sheet=None), GATES, BY_ITSELF, Outcome.FIRST, Action.ACTIVATE, False,
    ),
    "nothing new": (NOTHING, GATES, ASKS, Outcome.NOTHING_NEW, Action.KEEP, False),
    "nothing new for too long": (NOTHING, LONGEST, ASKS, Outcome.NOTHING_NEW, Action.KEEP, True),
    "nothing new but the piece is right": (
        replace(NOTHING, piece=PieceFindings(by_present=TRUE)),
        LONGEST, ASKS, Outcome.VOUCHED, Action.KEEP, False,
    ),
    "nothing new and the piece is wrong": (
        replace(NOTHING, piece=PieceFindings(by_present=WRONG)),
        GATES, BY_ITSELF, Outcome.DRIFTED, Action.KEEP, True,
    ),
    "not solved": (
        replace(NOTHING, unsolved="2 views"), LONGEST, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "too few poses": (refused(poses=5), GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False),
    "dots scatter": (refused(rms_dots_px=1.1), GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False),
    "stripe scatters": (
        refused(rms_stripe_px=math.nan), GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "its own gates": (
        refused(failed_gates=("sheet_sigma_mm",)),
        GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "old pictures": (
        refused(pictures_age_h=37.0), GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "sees nothing in common": (
        with_difference(replace(SAME, rms_mm=math.nan)),
        GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "too uncertain to see a drift": (
        with_difference(replace(SAME, rms_mm=0.04, largest_mm=0.2, expected_mm=0.031)),
        GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, False,
    ),
    "the cameras differ": (
        replace(AT_REST, whole=MOVED), GATES, ASKS, Outcome.DRIFTED, Action.ASK, True,
    ),
    "doubtful in a drift": (
        replace(refused(poses=5), drifting=True), GATES, ASKS, Outcome.DOUBTFUL, Action.KEEP, True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", TABLE)
def test_evidence_leads_to_its_decision(case):
    evidence, gates, policy, outcome, action, alarm = TABLE[case]
    decision = decide(evidence, gates, policy)
    assert (decision.outcome, decision.action, decision.alarm) == (outcome, action, alarm)
    assert decision.reasons
    assert all(reason == " ".join(reason.split()) for reason in decision.reasons)


def test_every_outcome_is_in_the_table():
    assert {row[3] for row in TABLE.values()} == set(Outcome)


def test_every_policy_is_followed():
    cases = {
        "consistent": AT_REST,
        "improved": with_difference(SAME),
        "shifted": with_difference(BLURRED),
        "drifted": with_difference(MOVED, confirmed=9),
        "first": replace(AT_REST, sheet=None),
        "doubtful": refused(poses=5),
    }
    for name, evidence in cases.items():
        for action in ("keep", "ask") if name == "doubtful" else ("activate", "keep", "ask"):
            decision = decide(evidence, GATES, PolicySettings(**{name: action}))
            assert (decision.outcome, decision.action) == (name, action)


def test_drift_once_found_ends_only_clearly_below_the_limit():
    # 0.08 mm: below the limit of 0.1, above the 0.07 at which a drift ends.
    near = with_difference(replace(MOVED, largest_mm=0.08))
    assert decide(near, GATES, ASKS).outcome is Outcome.SHIFTED
    assert decide(replace(near, drifting=True), GATES, ASKS).outcome is Outcome.DRIFTED
    clear = with_difference(replace(MOVED, largest_mm=0.069), drifting=True)
    assert decide(clear, GATES, ASKS).outcome is Outcome.SHIFTED


def test_better_calibration_cannot_be_bettered_for_ever():
    # Each must know the sheet to 0.7 of the last: from the gate's 0.05 mm down to 0.002 mm is a
    # factor of 25, which 10 steps make, in all the years of a sensor.
    sigma_mm, activated = 0.05, 0
    while sigma_mm > 0.002:
        new_mm = 0.99 * GATES.better * sigma_mm
        difference = replace(SAME, expected_mm=0.01, present_sigma_mm=sigma_mm, new_sigma_mm=new_mm)
        assert decide(with_difference(difference), GATES, ASKS).action is Action.ACTIVATE
        back = replace(difference, present_sigma_mm=new_mm, new_sigma_mm=sigma_mm)
        assert decide(with_difference(back), GATES, ASKS).outcome is Outcome.CONSISTENT
        sigma_mm, activated = new_mm, activated + 1
    assert activated <= 10


def test_figures_of_a_decision_are_numbers_that_json_takes():
    figures = decide(with_difference(replace(SAME, rms_mm=math.nan)), GATES, ASKS).figures
    assert "sheet_rms_mm" not in figures
    assert all(isinstance(value, float) and math.isfinite(value) for value in figures.values())
    assert figures["sheet_expected_mm"] == 0.005


def test_reasons_of_a_drift_say_how_far_where_and_what_matters():
    (apart,) = decide(with_difference(MOVED), GATES, ASKS).reasons
    assert "0.1500 mm RMS" in apart
    assert "at most by 0.3000 mm, at pixel (100, 50), where 0.1 matters" in apart


def test_sheets_speak_where_both_have_drifted():
    both = replace(AT_REST, sheet=MOVED, whole=replace(MOVED, largest_mm=0.5))
    assert decide(both, GATES, ASKS).reasons[0].startswith("the sheets differ")
    # A small but sure difference of the sheets does not hide a large one of the cameras.
    camera = replace(AT_REST, sheet=BLURRED, whole=MOVED)
    assert decide(camera, GATES, ASKS).outcome is Outcome.DRIFTED
    assert decide(camera, GATES, ASKS).reasons[0].startswith("the sensors as a whole differ")


def test_drift_that_stands_is_said_where_nothing_new_is_known():
    for evidence in (NOTHING, refused(poses=5)):
        decision = decide(replace(evidence, drifting=True), GATES, ASKS)
        assert decision.alarm
        assert "the drift that was found before is still there" in decision.reasons[-1]


def test_ratio_is_that_of_a_single_normal_variable():
    # Two-sided 5 % and 0.1 % of a normal variable.
    assert largest_ratio(0.05) == pytest.approx(1.960, abs=5e-4)
    assert largest_ratio(0.001) == pytest.approx(3.2905, abs=5e-4)
