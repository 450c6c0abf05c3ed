"""Multi-heuristic queues: whose turn it is, and what is in them."""

import pytest
from mamo_planners.reaching.queues import Queues


def drained(queues):
    popped = []
    while (found := queues.pop()) is not None:
        popped.append(found)
    return popped


def test_empty():
    assert Queues(3, 1.0, 2.0).pop() is None


def test_keys_are_cost_and_inflated_heuristic():
    queues = Queues(1, 10.0, 2.0)
    queues.push(0, 5.0, [1.0])  # 15
    queues.push(1, 14.0, [0.0])  # 14
    queues.push(2, 0.0, [1.6])  # 16
    assert [state for state, _ in drained(queues)] == [1, 0, 2]


def test_equal_keys_first_come_first_served():
    queues = Queues(1, 1.0, 2.0)
    for state in (3, 1, 2):
        queues.push(state, 1.0, [1.0])
    assert [state for state, _ in drained(queues)] == [3, 1, 2]


def test_what_is_popped_leaves_all_lists():
    queues = Queues(2, 1.0, 2.0)
    queues.push(0, 0.0, [1.0, 1.0])
    assert queues.pop() == (0, 0)
    assert queues.pop() is None


def test_the_list_with_the_least_work_is_next():
    queues = Queues(3, 1.0, 100.0)
    for state in range(4):
        queues.push(state, 0.0, [1.0 + state, 4.0 - state, 1.0 + state])
    assert queues.pop() == (0, 0)
    queues.spend(0, 2.0)
    assert queues.pop() == (3, 1)
    queues.spend(1, 3.0)
    assert queues.pop() == (1, 2)
    queues.spend(2, 2.5)
    assert queues.pop() == (2, 0)


@pytest.mark.parametrize(("w2", "expected"), [(1.9, (0, 0)), (2.0, (1, 1))])
def test_a_list_much_worse_than_the_anchor_lets_it_go_first(w2, expected):
    queues = Queues(2, 1.0, w2)
    queues.push(0, 0.0, [1.0, 3.0])
    queues.push(1, 0.0, [2.0, 2.0])
    queues.spend(0, 1.0)
    assert queues.pop() == expected


def test_pushed_again_it_moves_and_the_old_entry_is_stale():
    queues = Queues(1, 1.0, 2.0)
    queues.push(0, 0.0, [1.0])
    queues.push(1, 0.0, [2.0])
    queues.push(0, 0.0, [3.0])
    assert [state for state, _ in drained(queues)] == [1, 0]


def test_pushed_again_after_it_was_popped():
    queues = Queues(2, 1.0, 2.0)
    queues.push(0, 0.0, [1.0, 1.0])
    queues.push(1, 0.0, [5.0, 5.0])
    assert queues.pop() == (0, 0)
    queues.push_into(1, 0, 0.0, 9.0)
    queues.spend(0, 1.0)
    # The second list holds 1 (5.0) before 0 (9.0), the first only 1.
    assert drained(queues) == [(1, 1), (0, 1)]


def test_a_state_in_one_list_waits_for_that_list():
    queues = Queues(2, 1.0, 2.0)
    queues.push_into(1, 7, 0.0, 1.0)
    assert queues.pop() == (7, 1)
