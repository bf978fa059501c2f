"""Stages by name, and an error that stays where it happened."""

import pytest

from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.errors import NotFiniteError


def test_outputs_flow_to_those_who_ask_for_them():
    chain = Chain(
        [
            {'raw': lambda x: [('doubled', 2 * x), ('squared', x * x)]},
            {'doubled': lambda x: [('sum', x + 1)], 'squared': lambda x: [('sum', x - 1)]},
        ]
    )
    assert chain.push('raw', 5) == [('doubled', 10), ('squared', 25), ('sum', 11), ('sum', 24)]


def test_chain_can_be_entered_anywhere():
    chain = Chain([{'raw': lambda x: [('doubled', 2 * x)]}, {'doubled': lambda x: [('end', x)]}])
    assert chain.push('doubled', 3) == [('end', 3)]


def test_what_nobody_asks_for_goes_nowhere():
    assert Chain([]).push('raw', 1) == []


def test_takers_of_one_name_come_in_the_order_of_the_stages():
    order = []
    stages = [{'raw': lambda x, who=who: order.append(who) or []} for who in 'abc']
    Chain(stages).push('raw', 1)
    assert order == ['a', 'b', 'c']


def test_error_keeps_no_other_stage_from_its_sample():
    error = NotFiniteError('NaN')

    def broken(sample):
        raise error

    chain = Chain(
        [
            {'raw': broken},
            {'raw': lambda x: [('doubled', 2 * x)]},
            {'doubled': broken},
            {'doubled': lambda x: [('end', x)]},
        ]
    )
    assert chain.push('raw', 1) == [(FAULT, error), ('doubled', 2), (FAULT, error), ('end', 2)]
    assert chain.push('raw', 2)[-1] == ('end', 4), 'the next sample goes the same way'


def test_mistakes_of_the_program_are_not_hidden():
    def mistaken(sample):
        raise KeyError('oops')

    with pytest.raises(KeyError):
        Chain([{'raw': mistaken}]).push('raw', 1)
