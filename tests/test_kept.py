"""The store of results that are made once."""

import gc
import threading
import weakref

import pytest

from shadowlab.scene.kept import Kept


def test_a_result_is_made_once() -> None:
    kept, made = Kept(100), []
    for _ in range(3):
        assert kept.get("a", 1, lambda: made.append(1) or "value", lambda _: 10) == "value"
    assert len(made) == 1
    assert kept.bytes == 10


def test_the_least_recently_used_go_first_and_the_bytes_stay_bounded() -> None:
    kept, made = Kept(25), []

    def get(name: int) -> int:
        return kept.get("a", name, lambda: made.append(name) or name, lambda _: 10)

    get(1), get(2), get(1), get(3)  # 2 has to go
    assert kept.bytes == 20
    get(1), get(3)
    assert made == [1, 2, 3]
    get(2)
    assert made == [1, 2, 3, 2]


def test_what_is_larger_than_the_store_is_returned_and_not_kept() -> None:
    kept, made = Kept(5), []
    for _ in range(2):
        assert kept.get("a", 1, lambda: made.append(1) or "large", lambda _: 6) == "large"
    assert (len(made), kept.bytes) == (2, 0)


def test_an_error_is_raised_and_nothing_is_kept() -> None:
    kept = Kept(100)
    with pytest.raises(ZeroDivisionError):
        kept.get("a", 1, lambda: 1 // 0, lambda _: 1)
    assert kept.get("a", 1, lambda: 7, lambda _: 1) == 7


def test_forget_takes_one_result_or_all_of_an_owner() -> None:
    kept = Kept(100)
    for owner in "ab":
        for name in (1, 2):
            kept.get(owner, name, lambda: 0, lambda _: 10)
    kept.forget("a", 1)
    assert kept.bytes == 30
    kept.forget("b")
    assert kept.bytes == 10


def test_threads_that_ask_at_once_make_it_once() -> None:
    kept, made, start = Kept(100), [], threading.Barrier(8)

    def ask() -> None:
        start.wait()
        kept.get("a", 1, lambda: made.append(1), lambda _: 1)

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    assert len(made) == 1


def test_a_finalizer_may_run_while_the_store_is_locked() -> None:
    kept = Kept(100)
    kept.get("owner", 1, lambda: 0, lambda _: 10)

    class Owner:
        pass

    owner = Owner()
    weakref.finalize(owner, kept.forget_soon, "owner")
    with kept._locked():
        del owner
        gc.collect()
        assert kept.bytes == 10, "it is taken away when the lock is free, not under whoever holds it"
    assert kept.bytes == 0
