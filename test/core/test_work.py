"""Who asks for something that takes some samples gets exactly one answer."""

from dead_reckoning.core.errors import NotAtRestError, SupersededError
from dead_reckoning.core.work import Work


def test_success_carries_a_sentence():
    work = Work()
    future = work.begin()
    assert work.running
    assert not future.done()
    work.succeed('level')
    assert future.result(timeout=0) == 'level'
    assert not work.running


def test_failure_carries_the_reason():
    work = Work()
    future = work.begin()
    error = NotAtRestError('moved')
    work.fail(error)
    assert future.exception(timeout=0) is error
    assert not work.running


def test_asking_again_supersedes_the_first():
    work = Work()
    first, second = work.begin(), work.begin()
    assert isinstance(first.exception(timeout=0), SupersededError)
    assert not second.done()
    work.succeed('level')
    assert second.result(timeout=0) == 'level'


def test_end_without_a_task_is_nothing():
    work = Work()
    work.succeed('level')
    work.fail(NotAtRestError('moved'))
    assert not work.running
    assert not work.begin().done()
