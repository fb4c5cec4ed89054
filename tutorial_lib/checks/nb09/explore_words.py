"""What to say of known mistakes in the exploration loop, for the check of notebook 09."""

FAULTS = {
    "look for the goal in every round: a robot that looks only at the start passes it": (
        "looks once"
    ),
    "the goal may also be seen on the way, at a node: call sees_goal() in every round": (
        "looks at ghosts"
    ),
    "the goal may also be seen on the way, from a node that is known: call sees_goal() in every "
    "round": "looks at first and at ghosts",
    "the goal may also be seen from a node that is known: call sees_goal() in every round, not "
    "only where a node is new": "looks at new",
    "call sees_goal(), and to_goal() where it is seen": "never looks",
    "only where to_goal() returned True has the robot reached the goal": "believes",
    "the robot has still just arrived at a ghost where it then took something for the goal: that "
    "place becomes a node": "forgets arrival",
    "where something was mistaken for the goal the robot has not arrived at a ghost": (
        "invents arrival"
    ),
    "to_goal() returns False where something was mistaken for the goal; then go on exploring": (
        "gives up"
    ),
    "to_goal() returned False: go on below, in this round, with the node and its ghosts": (
        "tries again"
    ),
    "the last step counts as well: go on while robot.steps is above 0": "last step unused",
    "the score alone chooses the ghost, as in the paper: no weight for global_policy": "weighs",
    "the score alone chooses the ghost, as in the paper: call global_policy without a weight": (
        "weighs a little"
    ),
    "the loop ends when robot.steps is 0": "no end",
    "a ghost that was reached becomes a node also where F_L still has the robot in the old one": (
        "only where lost"
    ),
    "a ghost that was reached becomes a node, whatever node F_L takes it for": "only in the last",
    "where to_ghost() returned False the robot has not just arrived, also if it had before": (
        "stays arrived"
    ),
    "remove the ghost to which the robot was sent, not the others of its node": "all of the node",
    "the ghosts of earlier nodes stay: give add_ghosts the ghosts so far": "forgets",
    "the scores of earlier nodes stay: add the new ones to them": "forgets scores",
    "ask for scores() only where a node is new: at a known node the robot looks another way than "
    "it did then, and directions are counted from there": "scores anew",
    "give add_ghosts the nodes beside the new one, robot.beside(); where they stand there is no "
    "ghost": "stale",
    "the new node gets an edge to every node beside it, not only to the last one": "last edge",
    "an edge has the metres between its nodes, np.hypot of x and y": "no metres",
    "the best ghost of the whole graph is next, however far away: not that of the node where the "
    "robot is, and no weight of the metres in global_policy": ("best of this node"),
    "remove the ghost after the drive, reached or not, or the robot will want to go there again": (
        "keeps it"
    ),
    "remove the ghost also where to_ghost returned False: it cannot be reached": (
        "keeps what is blocked"
    ),
}
"""For each mistake, what to say and the name of the fault."""
