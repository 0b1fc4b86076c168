"""Faults of emulated controllers: how often, when, and what they make of messages."""

import math
from itertools import pairwise

from mukca.drivers.arms import Fault
from mukca.tools.emulators import KINDS, FaultInjector


def sent(*faults, count=1000, moment=1.0):
    injector = FaultInjector([Fault.parse(fault, KINDS, math.inf) for fault in faults], seed=3)
    packets = [(0, number.to_bytes(4, "big")) for number in range(count)]
    return [data for packet in packets for _, data in injector.packets(packet, moment)]


def numbers(messages):
    return [int.from_bytes(message, "big") for message in messages]


def test_without_faults_all_is_sent():
    assert numbers(sent()) == list(range(1000))


def test_faults_strike_in_their_time_alone():
    assert numbers(sent("drop@1.5")) == list(range(1000))
    assert numbers(sent("drop@0+0.5")) == list(range(1000))
    assert sent("drop@0.5+1") == sent("silent") == []


def test_drop_and_duplicate():
    assert 850 < len(sent("drop:0.1")) < 950
    doubled = numbers(sent("duplicate:0.1"))
    assert sorted(set(doubled)) == list(range(1000))
    assert 1050 < len(doubled) < 1150


def test_reorder_loses_nothing():
    shuffled = numbers(sent("reorder:0.1"))
    assert sorted(shuffled) == list(range(len(shuffled)))
    assert len(shuffled) >= 999
    assert 50 < sum(a > b for a, b in pairwise(shuffled)) < 150


def test_truncate_and_garble():
    assert all(len(message) < 4 for message in sent("truncate"))
    garbled = sent("garble")
    assert all(len(message) == 4 for message in garbled)
    assert sum(a == b for a, b in zip(garbled, sent(), strict=True)) < 3


def test_what_a_stall_held_back_comes_in_order_once_it_is_over():
    injector = FaultInjector([Fault.parse("stall@1+1", KINDS, math.inf)])
    assert [injector.packets((0, b"%d" % second), second) for second in range(4)] == [
        [(0, b"0")],
        [],
        [(0, b"1"), (0, b"2")],
        [(0, b"3")],
    ]
