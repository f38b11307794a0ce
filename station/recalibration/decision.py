"""What follows from a new calibration: it comes into force, the old one stays, or a person decides.

Pure: figures in, a decision with its reasons out.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import NormalDist

from measure import PieceVerdict
from station.recalibration.evidence import Difference, Evidence, NewCalibration
from station.settings import GateSettings, PolicySettings

_STANDS = "the drift that was found before is still there as far as is known"


class Action(StrEnum):
    """What is done with the new calibration."""

    ACTIVATE = "activate"
    KEEP = "keep"
    ASK = "ask"


class Outcome(StrEnum):
    """What the new calibration and the one in force say together."""

    NOTHING_NEW = "nothing_new"
    VOUCHED = "vouched"
    FIRST = "first"
    CONSISTENT = "consistent"
    IMPROVED = "improved"
    AGED = "aged"
    SHIFTED = "shifted"
    DRIFTED = "drifted"
    DOUBTFUL = "doubtful"

    @property
    def tells(self) -> bool:
        """Whether it tells how the sensor is, whatever it says."""
        return self not in {Outcome.NOTHING_NEW, Outcome.DOUBTFUL}

    @property
    def vouches(self) -> bool:
        """Whether the calibration in force was found good enough."""
        return self in {
            Outcome.VOUCHED,
            Outcome.CONSISTENT,
            Outcome.IMPROVED,
            Outcome.AGED,
            Outcome.SHIFTED,
        }


@dataclass(frozen=True, slots=True)
class Decision:
    """What is to be done, and why.

    Attributes
    ----------
    alarm
        Whether somebody must look: the calibration in force may measure wrongly.
    reasons
        One line each.
    """

    outcome: Outcome
    action: Action
    reasons: tuple[str, ...]
    alarm: bool = False
    figures: dict[str, float] = field(default_factory=dict)


def largest_ratio(false_alarm: float) -> float:
    r"""Return how many times its expectation the RMS difference of a sensor at rest may reach.

    Parameters
    ----------
    false_alarm
        Chance of more, at most; below 0.2.

    Notes
    -----
    The mean square over the field is a weighted sum :math:`Q = \sum \lambda_k \chi^2_1` of squared
    normal variables, :math:`\sum \lambda_k = 1` in units of its expectation. Far out its tail is
    heaviest where one weight is all, hence

    .. math:: P(Q > z^2) \le P(\chi^2_1 > z^2) = \alpha, \quad z = \Phi^{-1}(1 - \alpha / 2)

    Examples
    --------
    >>> round(largest_ratio(0.001), 2)
    3.29
    """
    return NormalDist().inv_cdf(1.0 - 0.5 * false_alarm)


def decide(evidence: Evidence, gates: GateSettings, policy: PolicySettings) -> Decision:
    """Decide what follows from what was found.

    Parameters
    ----------
    evidence
        The new calibration, how it differs from the one in force, the reference piece, the past.
    gates, policy
        Of the settings.

    Returns
    -------
    Decision
        Never an error: what cannot be relied on is an outcome, and keeps the calibration in force.
    """
    judged = _Judge(evidence, gates, policy).judge()
    return _guarded(judged, evidence)


def _guarded(judged: Decision, evidence: Evidence) -> Decision:
    """Let nothing come into force by itself that the piece would have had to vouch for."""
    piece = evidence.piece
    if judged.action is not Action.ACTIVATE or not piece.required:
        return judged
    if piece.by_new is PieceVerdict.TRUE:
        return judged
    why = f"the reference piece is required and {_said(piece.by_new)}"
    return Decision(
        judged.outcome, Action.ASK, (*judged.reasons, why), judged.alarm, judged.figures
    )


def _said(verdict: PieceVerdict | None) -> str:
    return "was not seen" if verdict is None else f"its check says {verdict}"


@dataclass(frozen=True, slots=True)
class _Judge:
    evidence: Evidence
    gates: GateSettings
    policy: PolicySettings

    def judge(self) -> Decision:
        new, sheet = self.evidence.new, self.evidence.sheet
        if new is None:
            return self._without_new()
        failures = tuple(self._failures(new))
        if failures:
            return self._doubtful(failures)
        if self.evidence.piece.by_new is PieceVerdict.DRIFTED:
            return self._doubtful(("the new calibration makes the reference piece come out wrong",))
        if sheet is None:
            return self._as(Outcome.FIRST, self.policy.first, "no calibration was in force")
        if not math.isfinite(sheet.rms_mm):
            return self._doubtful(("it sees no part of the sheet in common with the one in force",))
        return self._compared(sheet)

    def _without_new(self) -> Decision:
        evidence = self.evidence
        if evidence.piece.by_present is PieceVerdict.DRIFTED:
            why = "with the calibration in force the reference piece comes out wrong"
            return self._kept(Outcome.DRIFTED, evidence.unsolved or "no new pictures", why)
        if evidence.unsolved is not None:
            return self._kept(Outcome.DOUBTFUL, evidence.unsolved, alarm=evidence.drifting)
        if evidence.piece.by_present is PieceVerdict.TRUE and not evidence.drifting:
            why = "no new pictures, but the reference piece comes out right"
            return self._kept(Outcome.VOUCHED, why, alarm=False)
        days, longest = evidence.unchecked_days, self.gates.longest_unchecked_days
        if longest is not None and days is not None and days > longest:
            late = f"the sensor was last found good {days:.1f} days ago; {longest:g} are allowed"
            return self._kept(Outcome.NOTHING_NEW, "there are no new pictures", late)
        return self._kept(Outcome.NOTHING_NEW, "there are no new pictures", alarm=evidence.drifting)

    def _kept(self, outcome: Outcome, *reasons: str, alarm: bool = True) -> Decision:
        return self._as(outcome, Action.KEEP, *reasons, *self._still(), alarm=alarm)

    def _still(self) -> tuple[str, ...]:
        return (_STANDS,) if self.evidence.drifting else ()

    def _failures(self, new: NewCalibration) -> Iterator[str]:
        gates = self.gates
        if new.failed_gates:
            yield f"it fails its own gates {', '.join(new.failed_gates)}"
        if not new.poses >= gates.fewest_poses:
            yield f"{new.poses} poses; at least {gates.fewest_poses} are needed"
        for what, value, limit in (
            ("dots RMS", new.rms_dots_px, gates.largest_dots_px),
            ("stripe RMS", new.rms_stripe_px, gates.largest_stripe_px),
        ):
            if not value <= limit:
                yield f"{what} {value:.3f} px; at most {limit:g} is allowed"
        if not new.pictures_age_h <= gates.oldest_pictures_h:
            yield f"pictures {new.pictures_age_h:.0f} h old; at most {gates.oldest_pictures_h:g}"

    def _compared(self, sheet: Difference) -> Decision:
        # Each of the two comparisons has half of the chance of a false alarm.
        ratio = largest_ratio(0.5 * self.gates.false_alarm)
        told = (("sheets", sheet), ("sensors as a whole", self.evidence.whole))
        differing = [
            (name, each)
            for name, each in told
            if each is not None and not each.rms_mm <= ratio * each.expected_mm
        ]
        if differing:
            return self._differing(differing)
        shows_from_mm = ratio * sheet.expected_mm
        if shows_from_mm > self.gates.drift_mm:
            return self._doubtful((
                f"a drift would show from {shows_from_mm:.3f} mm on, but {self.gates.drift_mm:g} "
                "mm matters; take more poses",
            ))
        if self.evidence.piece.by_present is PieceVerdict.DRIFTED:
            why = "both calibrations agree, but with the one in force the piece comes out wrong"
            return self._as(Outcome.DOUBTFUL, Action.ASK, why, alarm=True)
        return self._agreeing(sheet)

    def _agreeing(self, difference: Difference) -> Decision:
        days, oldest = self.evidence.present_age_days, self.gates.oldest_calibration_days
        within = (
            f"the sheets differ by {difference.rms_mm:.4f} mm RMS where "
            f"{difference.expected_mm:.4f} is expected of their uncertainties"
        )
        if difference.new_sigma_mm <= self.gates.better * difference.present_sigma_mm:
            better = (
                f"the new one knows the sheet to {difference.new_sigma_mm:.4f} mm, the one in "
                f"force to {difference.present_sigma_mm:.4f} mm"
            )
            return self._as(Outcome.IMPROVED, self.policy.improved, within, better)
        if oldest is not None and days is not None and days > oldest:
            aged = f"the one in force is {days:.1f} days old; at most {oldest:g} are allowed"
            return self._as(Outcome.AGED, self.policy.aged, within, aged)
        return self._as(Outcome.CONSISTENT, self.policy.consistent, within)

    def _differing(self, differing: Sequence[tuple[str, Difference]]) -> Decision:
        limit_mm = self.gates.drift_mm * (self.gates.release if self.evidence.drifting else 1.0)
        beyond = [one for one in differing if not one[1].largest_mm <= limit_mm]
        # The sheets come first: they tell the more clearly.
        what, difference = (beyond or differing)[0]
        u, v = difference.largest_at_px
        apart = (
            f"the {what} differ by {difference.rms_mm:.4f} mm RMS where "
            f"{difference.expected_mm:.4f} is expected; at most by {difference.largest_mm:.4f} mm, "
            f"at pixel ({u:.0f}, {v:.0f}), where {limit_mm:g} matters"
        )
        if not beyond:
            return self._as(Outcome.SHIFTED, self.policy.shifted, apart)
        return self._drifted(apart)

    def _drifted(self, apart: str) -> Decision:
        piece, policy = self.evidence.piece, self.policy
        if piece.by_present is PieceVerdict.TRUE:
            why = "but with the calibration in force the reference piece comes out right"
            return self._as(Outcome.DRIFTED, Action.ASK, apart, why, alarm=True)
        if piece.confirms_drift:
            why = "the reference piece comes out right with the new one alone"
            return self._as(Outcome.DRIFTED, policy.drifted, apart, why, alarm=True)
        found = 1 + self.evidence.confirmed
        if policy.drifted == "activate" and found < policy.confirmations:
            why = f"found {found} times of the {policy.confirmations} that confirm it"
            return self._as(Outcome.DRIFTED, Action.KEEP, apart, why, alarm=True)
        return self._as(Outcome.DRIFTED, policy.drifted, apart, alarm=True)

    def _doubtful(self, reasons: tuple[str, ...]) -> Decision:
        # A drift that was found stays one until a good calibration says otherwise.
        wrong = self.evidence.drifting or self.evidence.piece.by_present is PieceVerdict.DRIFTED
        told = (*reasons, *self._still())
        return self._as(Outcome.DOUBTFUL, self.policy.doubtful, *told, alarm=wrong)

    def _as(self, outcome: Outcome, action: str, *reasons: str, alarm: bool = False) -> Decision:
        return Decision(outcome, Action(action), reasons, alarm, self.evidence.figures)
