"""Injected faults have the asked-for rates and come again with the same seed."""

import numpy as np
import pytest

from station.simulated import Faults
from station.simulated.faults import FaultInjector

PACKETS = 20_000


def test_a_link_without_faults_sends_every_packet_once_in_order():
    assert list(FaultInjector(Faults()).transmission(250)) == list(range(250))


def test_packets_are_lost_at_the_asked_for_rate():
    sent = FaultInjector(Faults(packet_loss=0.05)).transmission(PACKETS)
    # Binomial: sigma is 0.0015 of the rate; five of them.
    assert 1.0 - len(sent) / PACKETS == pytest.approx(0.05, abs=0.008)


def test_packets_are_doubled_at_the_asked_for_rate():
    sent = FaultInjector(Faults(packet_duplication=0.05)).transmission(PACKETS)
    assert len(sent) / PACKETS - 1.0 == pytest.approx(0.05, abs=0.008)
    assert set(sent) == set(range(PACKETS))


def test_late_packets_are_overtaken_by_few():
    sent = FaultInjector(Faults(packet_reorder=0.1)).transmission(PACKETS)
    assert sorted(sent) == list(range(PACKETS))
    moved = np.arange(PACKETS) - np.array(sent)
    # A late packet lets at most 8 pass, and no packet passes more than the 8 before it.
    assert np.mean(moved != 0) > 0.1
    assert np.abs(moved).max() <= 8


def test_the_same_seed_gives_the_same_faults():
    faults = Faults(packet_loss=0.1, packet_duplication=0.1, packet_reorder=0.1, seed=5)
    one, other = FaultInjector(faults), FaultInjector(faults)
    assert [list(one.transmission(100)) for _ in range(5)] == [
        list(other.transmission(100)) for _ in range(5)
    ]


def test_requests_for_packets_do_not_change_the_faults_of_the_pictures():
    one, other = FaultInjector(Faults(packet_loss=0.1)), FaultInjector(Faults(packet_loss=0.1))
    for _ in range(7):
        one.loses_resent_packet()
    assert list(one.transmission(100)) == list(other.transmission(100))


def test_named_frames_are_lost_and_no_others():
    injector = FaultInjector(Faults(lost_frames=frozenset({2, 5})))
    assert [index for index in range(8) if injector.loses_frame(index)] == [2, 5]


def test_frames_are_lost_at_the_asked_for_rate():
    injector = FaultInjector(Faults(frame_loss=0.1))
    lost = np.mean([injector.loses_frame(index) for index in range(PACKETS)])
    assert lost == pytest.approx(0.1, abs=0.011)  # five sigma of a binomial


@pytest.mark.parametrize(
    "wrong",
    [
        {"packet_loss": 1.5},
        {"packet_loss": float("nan")},
        {"frame_loss": -0.1},
        {"delay_s": 5.0},
        {"seed": -1},
    ],
)
def test_impossible_faults_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Faults(**wrong)
