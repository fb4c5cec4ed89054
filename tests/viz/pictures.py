"""Pictures for the tests of drawing."""

import cv2
import numpy as np


def plain(height, width, shade=100):
    return np.full((height, width, 3), shade, np.uint8)


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
