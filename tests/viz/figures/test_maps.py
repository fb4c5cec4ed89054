import numpy as np

from tests.agents.line import LineReachability, line_map
from tutorial_lib.interfaces import Plan
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.viz import colours, drive_picture, map_view


def count(picture, colour):
    return int((picture == np.array(colour, np.uint8)).all(axis=-1).sum())


def test_a_drive_is_drawn_over_the_map(recorded):
    topomap = line_map(range(4), LineReachability())
    frames = np.array([5, 40, 80, 120])
    topomap.vertices.timestamps[:] = recorded.experience(0).timestamps[frames]
    assert isinstance(topomap, TopoMap)
    poses = recorded.poses[frames]
    plain = map_view(recorded.scene, topomap, poses)
    track, goal = recorded.poses[5:110], recorded.poses[120]
    picture = drive_picture(recorded, topomap, Plan((0, 1, 2)), track, goal)
    assert picture.shape == plain.base.shape
    assert count(plain.base, colours.PATH) == count(plain.base, colours.GOAL) == 0
    assert count(picture, colours.PATH) > 50
    assert count(picture, colours.GOAL) > 50
    assert count(picture, colours.ROBOT) > 200
    x, y = plain.pixels(track[-1, :2]).round().astype(int)
    assert tuple(picture[y, x]) == colours.ROBOT  # it is shown where it is now
    still = drive_picture(recorded, topomap, Plan(), track[:1], goal)
    assert count(still, colours.ROBOT) < count(picture, colours.ROBOT)
