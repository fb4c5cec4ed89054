"""Checks of notebook 07: places that look alike."""

from tutorial_lib.checks.nb07.around_cycles import check_around_cycles
from tutorial_lib.checks.nb07.match_sequence import check_match_sequence
from tutorial_lib.checks.nb07.predict import check_predict
from tutorial_lib.checks.nb07.small_models import distance
from tutorial_lib.checks.nb07.track import check_track
from tutorial_lib.checks.nb07.update import check_update

__all__ = [
    "check_around_cycles",
    "check_match_sequence",
    "check_predict",
    "check_track",
    "check_update",
    "distance",
]
