"""The receiver: one type instead of a name, a number and NaN."""

import math

import pytest

from railvib.parameters.receiver import CENTRE, RAIL, Receiver


@pytest.mark.parametrize("receiver", [RAIL, CENTRE, Receiver(12.5)])
def test_a_key_stands_for_its_receiver(receiver):
    assert Receiver.of(receiver.key) == receiver == Receiver.of(receiver)


@pytest.mark.parametrize(
    ("receiver", "name", "label", "title"),
    [
        (RAIL, "rail", "rail", "rail"),
        (CENTRE, "ground", "0", "ground 0 m"),
        (Receiver(12.5), "ground", "12.5", "ground 12.5 m"),
    ],
)
def test_texts(receiver, name, label, title):
    assert (receiver.name, receiver.label, receiver.title) == (name, label, title)


def test_offsets_and_distances():
    assert math.isnan(RAIL.offset_m)
    assert Receiver(8.0).offset_m == 8.0
    assert [receiver.distance(1.6) for receiver in (RAIL, CENTRE, Receiver(1.0), Receiver(8.0))] == [
        0.0,
        0.0,
        0.0,
        6.4,
    ]


def test_the_track_reaches_the_rail_and_the_centre_line(track):
    receivers = RAIL, CENTRE, Receiver(1.0)
    assert [receiver.follows(track) for receiver in receivers] == [True, True, False]
    mean = track.model_copy(update={"coupling": "mean"})
    assert [receiver.follows(mean) for receiver in receivers] == [True, False, False]


def test_the_rail_comes_first():
    receivers = [Receiver(8.0), RAIL, CENTRE]
    assert sorted(receivers, key=lambda receiver: receiver.rank) == [RAIL, CENTRE, Receiver(8.0)]
