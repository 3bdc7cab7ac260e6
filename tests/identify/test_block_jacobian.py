import numpy as np
import pytest

from identify.fitting.block_jacobian import BlockJacobian, BlockPattern

MOVES = (None, None, (0,), (0,), (1,), (1,), (1,))
READINGS = (40, 60)


@pytest.fixture
def jacobian() -> BlockJacobian:
    random = np.random.default_rng(1)
    made = BlockJacobian.zeros(BlockPattern.of(MOVES, len(READINGS)), READINGS)
    for block in made.blocks:
        block[:] = random.standard_normal(block.shape)
    return made


def dense(jacobian: BlockJacobian) -> np.ndarray:
    whole = np.zeros((len(jacobian), len(MOVES)))
    for j in range(len(MOVES)):
        for i, row in jacobian.of_unknown(j):
            whole[jacobian.rows[i], j] = row
    return whole


def test_an_unknown_of_one_window_moves_no_other(jacobian):
    whole = dense(jacobian)
    assert whole.shape == (100, 7)
    assert not whole[40:, 2:4].any()
    assert not whole[:40, 4:].any()
    assert whole[:, :2].all()


def test_products_are_those_of_the_whole_matrix(jacobian):
    whole, random = dense(jacobian), np.random.default_rng(2)
    misfit, step = random.standard_normal(100), random.standard_normal(7)
    np.testing.assert_allclose(jacobian.normal(), whole.T @ whole, atol=1e-12)
    np.testing.assert_allclose(jacobian.gradient(misfit), whole.T @ misfit, atol=1e-12)
    np.testing.assert_allclose(jacobian.change(step), whole @ step, atol=1e-12)


@pytest.mark.parametrize("zero", [(), (0,), (3, 5)])
def test_what_is_free_of_the_unknowns_is_what_least_squares_leaves(jacobian, zero):
    """Unknowns that move nothing follow nothing."""
    for j in zero:
        for _, row in jacobian.of_unknown(j):
            row[:] = 0.0
    columns = np.random.default_rng(3).standard_normal((100, 4))
    design = dense(jacobian)
    left = columns - design @ np.linalg.lstsq(design, columns, rcond=None)[0]
    np.testing.assert_allclose(jacobian.free(columns), left, atol=1e-12)


def test_a_mended_jacobian_predicts_the_step_that_it_was_mended_with_in_every_window(jacobian):
    random = np.random.default_rng(5)
    step, size, surprise = random.standard_normal(7), random.uniform(0.5, 2.0, 7), random.standard_normal(100)
    mended = jacobian.mended(step, size, surprise)
    np.testing.assert_allclose(mended.change(step), jacobian.change(step) + surprise, atol=1e-12)
    assert not dense(mended)[40:, 2:4].any()
    assert not dense(mended)[:40, 4:].any()


def test_a_window_that_a_step_did_not_move_keeps_its_block(jacobian):
    step = np.array([0.0, 0.0, 1.0, -1.0, 1e-9, 0.0, 0.0])
    mended = jacobian.mended(step, np.ones(7), np.ones(100))
    np.testing.assert_array_equal(mended.blocks[1], jacobian.blocks[1])
    assert not np.array_equal(mended.blocks[0], jacobian.blocks[0])
