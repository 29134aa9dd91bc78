"""L*a*b* and CIEDE2000."""
import lacquer
import numpy as np
import pytest


def test_lab_of_known_colors():
    assert np.allclose(lacquer.lab([1, 1, 1]), [100, 0, 0], atol=1e-3)
    assert np.allclose(lacquer.lab([[0, 0, 0], [1, 0, 0]]), [[0, 0, 0], [53.24, 80.09, 67.20]], atol=0.05)
    with pytest.raises(ValueError, match=r"\(\.\.\., 3\)"):
        lacquer.lab([1, 2])


def test_delta_e2000_broadcasts():
    a = np.array([[50, 2.6772, -79.7751], [50, 3.1571, -77.2803]])
    d = lacquer.delta_e2000(a, [50, 0, -82.7485])
    assert d.shape == (2,) and np.allclose(d, [2.0425, 2.8615], atol=5e-5)
    assert lacquer.delta_e2000([50, 0, 0], [50, 0, 0]) == 0
    with pytest.raises(ValueError):
        lacquer.delta_e2000([1, 2], [3, 4])
