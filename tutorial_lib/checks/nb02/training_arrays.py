"""How numbers of two trainings are compared."""

import numpy as np


def close_arrays(first: object, second: object) -> bool:
    """Whether two arrays have the same shape and nearly the same numbers."""
    first, second = np.asarray(first, float), np.asarray(second, float)
    return first.shape == second.shape and np.allclose(first, second, rtol=1e-4, atol=1e-7)
