"""Changes at exact ticks, whatever the length of the pieces."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.scheduled_changes import ScheduledChanges


@given(ticks=st.lists(st.integers(0, 60), max_size=6).map(sorted), cuts=st.lists(st.integers(0, 30), max_size=8))
def test_every_change_is_applied_before_the_piece_at_its_tick(ticks: list[int], cuts: list[int]) -> None:
    applied: list[tuple[int, int]] = []
    changes: ScheduledChanges[int] = ScheduledChanges(lambda change, tick: applied.append((change, tick)))
    for number, tick in enumerate(ticks):
        changes.add(tick, number)
    present: list[int] = []
    for count in cuts:
        begin = changes.reached
        assert changes.due(count) == any(begin <= tick < begin + count for tick in ticks)
        pieces = []
        for piece in changes.pieces(count):
            pieces.append(piece)
            present += [len(applied)] * (piece.stop - piece.start)
        assert [at for piece in pieces for at in range(piece.start, piece.stop)] == list(range(count))
        assert changes.reached == begin + count
    assert present == [sum(tick <= at for tick in ticks) for at in range(sum(cuts))]
    assert applied == [(number, tick) for number, tick in enumerate(ticks) if tick < sum(cuts)]


def test_skipped_ticks_count() -> None:
    applied: list[int] = []
    changes: ScheduledChanges[str] = ScheduledChanges(lambda _, tick: applied.append(tick))
    changes.skip(10)
    changes.add(12, "change")
    assert [(piece.start, piece.stop) for piece in changes.pieces(5)] == [(0, 2), (2, 5)]
    assert (applied, changes.reached) == ([12], 15)
