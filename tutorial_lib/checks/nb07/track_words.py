"""What to say of known mistakes in the filter's loop, for the check of notebook 07."""

from __future__ import annotations

FAULTS = {
    "standing still, the same evidence counts again and again in yours: update the prior of the "
    "last motion, not the belief": "twice",
    "at rest a look begins again with the prior of the last motion, not with the belief: the same "
    "evidence counts once": "at rest",
    "each look begins with the prior; yours forgets all that was believed before": "no memory",
    "predict from the belief after the last look, not from the prior before it": "from the prior",
    "look at the first step, too: nothing is known yet": "no first look",
    "looking costs time: look after a stride or after rules.interval steps, not at each": (
        "always looks"
    ),
    "a robot that has not moved looks all the same after rules.interval steps": "never waits",
    "wait rules.interval steps from one look to the next, not one more: count in every step, also "
    "in that of the look": "late",
    "wait rules.interval steps from one look to the next, not one less": "early",
    "after a look the steps of waiting are counted from 0": "always due",
    "after any look the steps of waiting are counted from 0, also after one because of a motion": (
        "due at rest"
    ),
    "predict once the robot has moved a stride since the last prediction, not at each step": (
        "each step"
    ),
    "measure the motion from the pose of the last prediction, not from the step before": (
        "step by step"
    ),
    "measure the motion from the pose of the last prediction; yours measures it from the start": (
        "from the start"
    ),
    "measure from the pose of the last prediction to this one; yours adds up the steps between, so "
    "that going to and fro counts as going far": "adds up",
    "turning counts as well: distance(last, pose), not the coordinates alone": "no turns",
    "a motion of just a stride is enough: >=": "greater",
    "predict with the motion that was measured, not with the stride": "stride",
    "a picture may always deceive: no likelihood below rules.least": "no least",
    "off the map any view has the likelihood rules.unknown; append it": "no unknown",
    "off the map is the last state: append rules.unknown behind the vertices, not before them": (
        "unknown first"
    ),
    "first no likelihood below rules.least, then the power; yours has it the other way round": (
        "power before least"
    ),
    "all likelihoods to the power of rules.sharpness, that of being off the map as well": (
        "unknown as it is"
    ),
    "the likelihoods to the power of rules.sharpness": "no power",
    "return the beliefs, after the look, not the priors": "prior",
    "off the map is the last state; the robot may be there: vertex -1": "never lost",
    "the greatest belief may be that of being off the map: look for it among all states": (
        "never off"
    ),
    "off the map is a state like the others: the robot stays there, too, while that has "
    "rules.hysteresis times the best belief": "off at once",
    "rules.least is for the vertices: off the map the likelihood is rules.unknown, even below it": (
        "least for all"
    ),
    "a belief of just rules.hysteresis times the greatest keeps the vertex: >=": (
        "more than the share"
    ),
    "rules.hysteresis is not always 0.5": "share is a half",
    "headings jump at half a turn: distance(last, pose) takes the short way round": "no wrap",
    "small motions count as well, where rules.stride is small": "no small ones",
    "nothing is known at first: the vertex begins at -1, and 0 is the first vertex": "at 0",
    "off the map the vertex is -1, not the number of the last state": "last number",
    "the robot stays at its vertex while that has rules.hysteresis times the best belief": (
        "no hysteresis"
    ),
    "the robot leaves its vertex once another one is clearly more probable": "for ever",
    "compare the old vertex's belief with the best one's times rules.hysteresis, not with "
    "rules.hysteresis itself": "half",
}
"""For each mistake, what to say and the name of the fault."""
