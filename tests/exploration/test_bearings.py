"""Bins of bearings and columns of panoramas agree with each other and with the camera."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.exploration.bearings import bearing_of, bin_of, column_bearings, column_of
from tutorial_lib.geometry import wrap
from tutorial_lib.world.sensors import PanoramicCamera


@given(st.floats(-20.0, 20.0), st.sampled_from([4, 12, 24]))
def test_a_bin_is_the_nearest_and_never_the_one_after_the_last(bearing, directions):
    found = int(bin_of(bearing, directions))
    assert 0 <= found < directions
    gap = np.abs(wrap(bearing_of(np.arange(directions), directions) - bearing))
    assert gap[found] <= gap.min() + 1e-9


def test_columns_look_where_the_camera_s_rays_go():
    fan = PanoramicCamera().fan
    assert np.allclose(column_bearings(192), fan.angles[::-1])
    assert (column_of(column_bearings(192), 192) == np.arange(192)).all()


def test_patches_are_centred_on_the_bins():
    camera = PanoramicCamera()
    image = np.zeros((1, 16, 192, 3), np.uint8)
    image[0, :, :, 0] = np.arange(192)
    middle = camera.split(image)[0, :, 0, 23:25, 0].astype(int)
    assert (
        middle
        == np.stack(
            [column_of(bearing_of(np.arange(12)) + side, 192) for side in (1e-6, -1e-6)], axis=1
        )
    ).all()
