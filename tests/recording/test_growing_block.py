import numpy as np
import pytest

from crazychoir_fw.recording import growing_block
from crazychoir_fw.recording.growing_block import GrowingBlock


@pytest.mark.parametrize("count", [0, 1, 3, 4, 9])
def test_rows_come_back_in_their_order_whatever_the_pieces(count, monkeypatch):
    monkeypatch.setattr(growing_block, "_MAX_ROWS", 3)
    block = GrowingBlock((2, 2), np.int16)
    for k in range(count):
        block.add()[:] = [[k, 10 * k], [100 * k, -k]]
    rows = block.rows()
    assert len(block) == count and rows.shape == (count, 2, 2) and rows.dtype == np.int16
    assert rows[:, 0, 1].tolist() == [10 * k for k in range(count)]
    assert rows[:, 1, 1].tolist() == [-k for k in range(count)]


def test_rows_are_a_copy():
    block = GrowingBlock((1,))
    block.add()[:] = 1.0
    block.rows()[:] = 2.0
    assert block.rows() == 1.0


def test_a_row_may_be_larger_than_a_piece(monkeypatch):
    monkeypatch.setattr(growing_block, "_PIECE_BYTES", 8)
    block = GrowingBlock((5,))
    for k in range(2):
        block.add()[:] = k
    assert block.rows().tolist() == [[0.0] * 5, [1.0] * 5]


def test_the_memory_of_cleared_rows_is_filled_again(monkeypatch):
    monkeypatch.setattr(growing_block, "_MAX_ROWS", 2)
    block = GrowingBlock((1,))
    first = [block.add() for _ in range(5)]
    block.clear()
    assert len(block) == 0 and block.rows().shape == (0, 1)
    again = [block.add() for _ in range(5)]
    for k, row in enumerate(again):
        row[:] = k
    assert all(np.shares_memory(row, other) for row, other in zip(first, again, strict=True))
    assert block.rows()[:, 0].tolist() == [0, 1, 2, 3, 4]


def test_free_rows_become_rows_of_the_block(monkeypatch):
    monkeypatch.setattr(growing_block, "_MAX_ROWS", 4)
    block = GrowingBlock((1,))
    block.add()[:] = 0.0
    free = block.free()
    assert free.shape == (3, 1)
    free[:2, 0] = 1.0, 2.0
    block.grow(2)
    assert block.rows()[:, 0].tolist() == [0.0, 1.0, 2.0]
