"""Does the damping of a walk ease where steps do what they promise, and rise fast where they fail?

That walks with it arrive is shown by the solves themselves.
"""

import pytest

from calib.solving.joint.damping import Damping, descends


def test_a_step_eases_the_next_by_how_well_its_fall_was_foretold():
    # Foretold is half the decrement; at half of that it stays, and with no fall it doubles.
    assert Damping(1e-2).eased(1.0, 2.0).value == pytest.approx(1e-3)
    assert Damping(1e-2).eased(0.5, 2.0).value == pytest.approx(1e-2)
    assert Damping(1e-2).eased(0.0, 2.0).value == pytest.approx(2e-2)


def test_steps_that_fail_are_held_back_ever_faster_until_it_is_in_vain():
    damping, values = Damping(1e-4), []
    while not damping.exhausted:
        values.append(damping.value)
        damping = damping.raised()
    ratios = [after / before for before, after in zip(values, values[1:], strict=False)]
    assert ratios == pytest.approx([4.0 ** (place + 1) for place in range(len(ratios))])
    assert len(values) < 10


def test_after_a_good_step_it_rises_slowly_again():
    failed = Damping(1e-4).raised().raised()
    assert failed.eased(1.0, 2.0).raising == Damping(1.0).raising


def test_a_cost_that_rounding_raised_has_not_risen():
    assert descends(-1e-10, 1e3)
    assert not descends(-1e-8, 1e3)
    assert not descends(float("nan"), 1.0)
