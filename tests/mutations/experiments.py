"""Experiments: how trials end, what is counted, and how sure one is of it."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
experiments/meng2020/table2.py | experiments/meng2020/test_table2.py -k have_its_thresholds
a part of the drives gets the thresholds of all
    settings.thresholds.get(drives, Thresholds()) -> settings.thresholds.get('', Thresholds())
the thresholds of the tour are not those of the continuous one
    TOUR if options.drives == CONTINUOUS else options.drives -> options.drives

experiments/protocols/drives.py | experiments/protocols/test_drives.py
a trial is driven where a drive passes the goal first
    at_goal.any(axis=0) & (first <= last) -> at_goal.any(axis=0) & (first < len(drive))

experiments/benchmarks/map_building.py | experiments/benchmarks/test_map_building.py
the recall of the index counts edges of anchors that were replaced
    (table[:, ~reused][:, :, ends] for table in above)
        -> (table[:, reused | True] for table in above)

experiments/protocols/navigation.py | experiments/protocols/test_fair_inputs.py -k true_poses
robots that navigate have exact odometry
    odometry = instance("building", building, Building).odometry.noise(NAVIGATING)
        -> odometry = None

experiments/protocols/navigation_tasks.py | experiments/protocols/test_fair_inputs.py -k true_poses
recorded odometry is exact
    odometry.noise(RECORDING) -> Odometry(drifts=False).noise(RECORDING)

experiments/protocols/odometry.py | experiments/protocols/test_fair_inputs.py -k seed
a robot navigates with the drift that it had while recording
    DriftingOdometry(*self.seed, use) -> DriftingOdometry(*self.seed)

experiments/protocols/navigation.py | experiments/meng2020/test_table2.py -k wormholes
an edge is a wormhole at half the length
    WORMHOLE = 5.0 -> WORMHOLE = 2.5

driving/rollouts.py | experiments/meng2020/test_table2.py -k stuck
touching is added up and never reset
    touched + STEP, 0.0) -> touched + STEP, touched)

experiments/protocols/navigation_tasks.py | experiments/meng2020/test_table2.py -k place
the place drawn first is one of those to keep away from
    far if step <= 1 else np.minimum(nearest, far) -> np.minimum(nearest, far)

experiments/protocols/navigation_tasks.py | experiments/meng2020/test_table2.py -k look
a car on a tight spot is placed along the path all the same
    tried[is_free(scene, body, tried).argmax()] -> tried[0]

experiments/common/statistics.py | experiments/common/test_statistics.py
each world counts the same, however many episodes it has
    sums[draws].sum(axis=1) / counts[draws].sum(axis=1) -> (sums / counts)[draws].mean(axis=1)
differences are bootstrapped over episodes, not worlds
    units if units.max() else np.arange(len(gap)) -> np.arange(len(gap))
the interval of a share is not Wilson's
    method="wilson" -> method="exact"

experiments/meng2020/fig7.py | experiments/meng2020/test_fig7.py -k curve
curves are compared where only one of them is
    max(first[0, 0], second[0, 0]) -> min(first[0, 0], second[0, 0])

experiments/protocols/reachability.py | experiments/meng2020/test_calibration_table.py -k far
a pair of which one sees the other is far
    (both < SEEN).all(axis=1) -> (both < SEEN).any(axis=1)

experiments/protocols/moves.py | experiments/robustness/test_disturbances.py -k moved
a robot is moved at every step near the place
    near[robots] & (self.step[robots] < 0) -> near[robots]

experiments/robustness/faults.py | experiments/meng2020/test_map_experiments.py -k block
a path may be blocked where there is no other
    < around <= DETOUR * straight -> < around

experiments/results_page/tables.py | experiments/results_page/test_local_control_tables.py -k bold
the oracle's success may be the best of a column
    return lambda row: None if row[name] in bounds else row[key] -> return lambda row: row[key]

experiments/results_page/tables.py | experiments/results_page/test_navigation_tables.py -k together
success in all worlds together is the mean over worlds
    "success": succeeded / trials} -> "success": sum(row["success"] for row in found) / len(found)}

experiments/results_page/markdown.py | project/test_style.py -k doctests
an interval without width is shown
    if row[low] == row[high]: -> if row[low] > row[high]:

experiments/results_page/templates.py | experiments/results_page/test_sources.py -k damaged
a damaged report is an error of the program
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        -> except OSError as error:

experiments/protocols/directions.py | experiments/protocols/test_directions.py
the lowest score chooses a direction
    np.where(np.isfinite(metres), scores, -np.inf)
        -> np.where(np.isfinite(metres), -scores, -np.inf)
directions are not compared with their mean
    return values - values.mean(axis=0) -> return values - values.mean()

experiments/protocols/directions.py | experiments/protocols/test_directions.py -k depth
signs are read where there are none
    Depth(scene.plan) if signs else None -> Depth(scene.plan)

experiments/nts/scores.py | experiments/nts/test_scores.py -k two_directions
decisions without a choice count
    level.any(axis=1) & (np.isfinite(metres).sum(axis=1) > 1) -> level.any(axis=1)

experiments/nts/table2.py | experiments/nts/test_exploration_tables.py
overall has no difficulty
    (found["difficulty"] == number) | (difficulty == "overall") -> (found["difficulty"] == number)

experiments/nts/fig8.py | experiments/nts/test_comparisons.py -k fig8_subtracts
a gap is to the agent, not from it
    difference(columns["nts"][name][:count].ravel(), values, repeated)
        -> difference(values, columns["nts"][name][:count].ravel(), repeated)

experiments/leaderboard.py | experiments/test_leaderboard.py -k ranks_own
references of another run stand beside a class
    one.seam in ("", seam) and one.run == (*run,) -> one.seam in ("", seam)
the worst stands first
    key=lambda one: -one.score -> key=lambda one: one.score
"""),
    (
        "the least strict of the best thresholds is taken",
        "experiments/meng2020/table2_thresholds.py",
        '(row[by], row["threshold"])',
        '(row[by], -row["threshold"])',
        "experiments/meng2020/test_map_experiments.py -k best_threshold",
    ),
    (
        "what is seen after a collision counts",
        "experiments/protocols/local_control.py",
        "+ (not rollouts.collided[robot])",
        "+ 1",
        "experiments/meng2020/test_table1.py -k 'matched or noise_differs'",
    ),
    (
        "one great overlap is a match",
        "experiments/protocols/local_control.py",
        "(both > OVERLAPPING).all(axis=1).any()",
        "(both > OVERLAPPING).any(axis=1).any()",
        "experiments/meng2020/test_table1.py -k 'matched or noise_differs'",
    ),
    (
        "noise is the same in every world",
        "experiments/protocols/local_control.py",
        "return seed, place if isinstance(place, int) else 0",
        "return seed, 0",
        "experiments/meng2020/test_table1.py -k 'matched or noise_differs'",
    ),
    (
        "the greatest error of calibration is bold",
        "experiments/results_page/reachability.py",
        'least=key == "ece"',
        'least=key == "auc"',
        "experiments/results_page/test_reachability_and_following_tables.py -k calibration",
    ),
    (
        "the node before is forgotten where it is far",
        "experiments/protocols/called_robot.py",
        "chosen += [self._from] if self._from >= 0 else []",
        "chosen += []",
        "experiments/protocols/test_exploring_by_calls.py -k always_beside",
    ),
    (
        "nodes of a watched robot are drawn about its start",
        "experiments/protocols/watching.py",
        "compose(compose(believed, inverse(memory.offset)), graph.poses_from(memory.node))",
        "compose(believed, graph.poses_from(memory.node))",
        "experiments/protocols/test_exploring_by_calls.py -k where_it_believes",
    ),
    (
        "a fault of one's own class ends the experiment",
        "experiments/common/own.py",
        "        return Fault(error)",
        "        raise",
        "experiments/common/test_own.py -k explorer",
    ),
    (
        "goals are the places themselves",
        "experiments/nts/scores.py",
        "    goal = goal + settings.places\n",
        "",
        "experiments/nts/test_scores.py -k two_directions",
    ),
]
