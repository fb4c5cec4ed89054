"""What to say of known mistakes in the navigator's loop, for the check of notebook 06."""

from __future__ import annotations

FAULTS = {
    "exclude the vertices beside it, too: those that it leads to and that lead back": "alone",
    "beside it are those that it leads to and that lead back to it, not all that it leads to": (
        "out"
    ),
    "beside it are those that it leads to and that lead back to it, not all that lead to it": "in",
    "beside it are those with edges in both directions; one direction is not enough": "either",
    "exclude the vertex that could not be reached, path[robot.active], not the one before it": (
        "behind"
    ),
    "exclude every vertex that could not be reached so far, not only the last one": "forgets",
    "plan on the graph without what is excluded: without(graph, excluded)": "excludes nothing",
    "a robot that was lost takes a refused path rather than none": "always refuses",
    "before it was lost, the robot ends with a refused path; yours drives it": "dares",
    "where there is no path, turn and look again; yours gives up at once": "gives up at once",
    "after limits.search steps of turning the robot gives up": "searches for ever",
    "while it turns, the robot looks every limits.interval steps, not at each": "always looks",
    "while there is a path, follow it; yours plans again and again": "replans all the time",
    "a robot that was lost needs a new plan; yours follows the old one": "same path",
    "each search begins anew: the steps of turning are counted from 0": "searched before",
    "it may be lost limits.replans times and plan again; yours allows one less": "too few",
    "it may be lost limits.replans times and plan again; yours allows one more": "too many",
    "after limits.steps steps the ending is late": "never late",
    "it turns limits.search times in a search, not once less, before it gives up": "search less",
    "it turns limits.search times in a search, not once more, before it gives up": "search more",
    "each turn and each follow is a step; there are limits.steps of them, not one less": (
        "steps less"
    ),
    "each turn and each follow is a step; there are limits.steps of them, not one more": (
        "steps more"
    ),
    "while it turns, the robot looks again every limits.interval steps": "looks once",
    "it looks at the steps 0, limits.interval, 2 limits.interval ... of a search": "looks late",
    "the steps of turning in this search count for the next look, not those of the whole "
    "navigation": "all steps",
    "where a look is due, it comes before giving up: there may be a path now": "no last look",
    "a path with a reason against it ends the navigation: refused; yours turns on": "turns on",
    "whether the robot was lost counts for a refusal, not whether anything is excluded": (
        "by excluded"
    ),
    "as soon as there is a path, follow it in the same step": "follows later",
    "GOAL is no vertex of the map: it is never excluded": "goal",
    "exclude the vertex that could not be reached, path[robot.active], not the one after it": (
        "ahead"
    ),
    "ask robot.active after follow has returned lost; before, it was another one": (
        "active too early"
    ),
    "return all vertices that were excluded, also on arrival": "forgets in the end",
    "the first step of a search looks; yours turns before": "turns before it looks",
    "look again in each search: what was seen at first is of another place": "looks at first only",
    "not on the map is a reason, too: any reason refuses a robot that was never lost": (
        "refuses the improbable only"
    ),
    "without a path there is nothing to refuse: turn, and look again": "refuses without a path",
    "a robot that was lost takes an improbable path; yours turns on": "never improbable",
    "limits.search counts steps of turning, not looks": "counts looks",
    "exclude path[robot.active], not the first vertex of the path": "first",
    "being lost before the goal counts as well: limits.replans is for the whole drive": (
        "goal is free"
    ),
    "being lost at a vertex counts each time, not only before the goal": "only the goal counts",
    "lost before the goal is no end: nothing is excluded, and the robot searches again": (
        "gives up at the goal"
    ),
    "the vertex that could not be reached is excluded itself, not only those beside it": (
        "not itself"
    ),
    "beside a vertex are those one edge away, there and back, not those beside them as well": (
        "two away"
    ),
}
"""For each mistake, what to say and the name of the fault."""
