"""Inverse kinematics and the guarded law: solutions checked by the forward kinematics, limits, and one arm against many."""
import copy
import pathlib
import subprocess

import numpy as np
import pytest

import multireach
from conftest import draw

ACCURACY_M = 1e-4  # what docs/guarantees.md promises for reachable targets


def test_solutions_are_inside_the_limits_and_at_the_target(any_arm, rng):
    arm, _ = any_arm
    ik = multireach.MultiStartIk(arm)
    for theta, start in zip(draw(arm, rng, 10), draw(arm, rng, 10)):
        target = arm.position(theta)
        solution, error_m = ik.best(target, start)
        assert error_m <= 1e-6 and np.linalg.norm(arm.position(solution) - target) <= 1e-6
        assert arm.limit_excess(solution) == 0
        nearest = ik.nearest(target, start)
        # The configuration that the target was made from is a solution, too: the nearest is no further away.
        assert np.linalg.norm(nearest - start) <= np.linalg.norm(theta - start) + 1e-2


def test_poses_are_solved(root, rng):
    arm = multireach.Chain.from_robot(root / "robots/iiwa14")
    ik = multireach.MultiStartIk(arm)
    for theta, start in zip(draw(arm, rng, 5), draw(arm, rng, 5)):
        pose = arm.pose(theta)
        solution, error_m = ik.best(multireach.TaskTarget(pose[:3, 3], orientation=pose[:3, :3]), start)
        assert error_m <= 1e-6
        np.testing.assert_allclose(arm.pose(solution), pose, atol=2e-5)  # 1e-6 m at a length of 0.1 m: 1e-5 rad


def test_unreachable_positions_have_no_solution(hoap2):
    ik = multireach.MultiStartIk(hoap2)
    assert ik.closed_form
    assert ik.nearest([5, 0, 0], np.zeros(4)) is None
    found = ik.nearest([[0.1, -0.12, 0.1], [5, 0, 0], [np.nan, 0, 0]], [0.2, -0.3, -0.2, -0.9])
    np.testing.assert_array_equal(np.isnan(found).all(axis=1), [False, True, True])


def test_the_law_arrives_within_the_limits(any_arm, rng):
    arm, _ = any_arm
    law = multireach.GuardedLaw(arm)
    starts, goals = draw(arm, rng, 5), draw(arm, rng, 5)
    for start, goal in zip(starts, goals):
        law.start(start)
        assert law.set_target(arm.position(goal)) == multireach.TargetResult.REACHABLE
        trajectory = law.run(140 * 30)
        assert trajectory.shape == (140 * 30, arm.size)
        np.testing.assert_array_equal(trajectory[-1], law.theta)
        assert np.linalg.norm(arm.position(law.theta) - arm.position(goal)) < ACCURACY_M
        assert (trajectory >= arm.lower - 1e-12).all() and (trajectory <= arm.upper + 1e-12).all()
        speed = np.abs(np.diff(np.vstack([start, trajectory]), axis=0)) * 140
        assert (speed <= arm.velocity * (1 + 1e-9)).all()


def test_run_takes_the_same_steps_as_step(hoap2):
    laws = [multireach.GuardedLaw(hoap2, gamma=180) for _ in range(2)]
    for law in laws:
        law.start([0.2, -0.3, -0.2, -0.9])
        law.set_target([0.1, -0.12, 0.1])
    rows = []
    for _ in range(60):
        laws[0].step(7)
        rows.append(laws[0].theta)
    np.testing.assert_array_equal(laws[1].run(420, every=7), rows)


def test_copies_are_independent(hoap2):
    law = multireach.GuardedLaw(hoap2)
    law.start([0.2, -0.3, -0.2, -0.9])
    law.set_target([0.1, -0.12, 0.1])
    law.step(20)
    other, before = copy.deepcopy(law), law.theta
    other.step(50)
    np.testing.assert_array_equal(law.theta, before)
    law.step(50)
    np.testing.assert_array_equal(law.theta, other.theta)


def test_many_arms_move_like_one(any_arm, rng):
    arm, _ = any_arm
    starts, goals = draw(arm, rng, 11), draw(arm, rng, 11)
    targets = arm.position(goals)
    targets[3] = [50, 0, 0]  # out of reach
    batch = multireach.GuardedBatch(arm, 11, gamma=150)
    running = batch.start(starts, targets)
    assert list(np.flatnonzero(~running)) == [3] and batch.size == 11
    batch.step(300)
    theta, x = batch.theta, batch.x
    assert theta.shape == (11, arm.size) and np.isnan(theta[3]).all()
    ik = multireach.MultiStartIk(arm)
    for i in np.flatnonzero(running):
        law = multireach.GuardedLaw(arm, gamma=150)
        law.start(starts[i])
        law.set_target(targets[i], theta_target=ik.nearest(targets[i], starts[i]))
        law.step(300)
        np.testing.assert_array_equal(theta[i], law.theta)
        np.testing.assert_array_equal(x[i], law.x)


def test_the_papers_law_minimises_its_objective(hoap2, rng):
    """A step of the paper's law against a least-squares solution of (6) by NumPy, with the attractors (19)-(22)."""
    gains = dict(alpha=0.08, beta=0.03)
    for start, goal in zip(draw(hoap2, rng, 10), draw(hoap2, rng, 10)):
        law = multireach.PaperLaw(hoap2, gamma=350, **gains)
        law.start(start)
        target = hoap2.position(goal)
        assert law.set_target(target, theta_target=goal)
        hand_velocity = np.zeros(3)
        for _ in range(3):
            theta, velocity, jacobian, weights = law.theta, law.velocity, hoap2.jacobian(law.theta), law.weights
            joints = velocity + gains["alpha"] * (-velocity + gains["beta"] * (law.theta_target - theta))
            hand = hand_velocity + gains["alpha"] * (-hand_velocity + gains["beta"] * (target - law.x))
            rows = np.vstack([np.diag(1 / np.sqrt(weights)), jacobian])
            expected = np.linalg.lstsq(rows, np.concatenate([joints / np.sqrt(weights), hand]), rcond=None)[0]
            hand_velocity = jacobian @ expected
            law.step()
            np.testing.assert_allclose(law.velocity, expected, atol=1e-12)
            np.testing.assert_allclose(law.theta, theta + expected, atol=1e-12)


def test_the_papers_law_is_that_of_the_trace(root, hoap2):
    program = pathlib.Path(multireach.__file__).parents[2] / "bin/multireach-trace"
    program.exists() or pytest.skip("multireach-trace is not built")
    start, target = [0.2, -0.3, -0.2, -0.9], [0.1, -0.12, 0.1]
    done = subprocess.run([program, "--urdf", root / "robots/hoap2/hoap2.urdf", "--base", "torso", "--tip", "right_hand", "--law", "paper",
                           f"--start={','.join(map(str, start))}", f"--target={','.join(map(str, target))}", "--gamma", "350", "--steps", "200"],
                          capture_output=True, text=True, check=True)
    rows = np.array([line.split(",") for line in done.stdout.splitlines()[1:]], float)
    law = multireach.PaperLaw(hoap2)
    law.start(start)
    assert law.set_target(target)
    trajectory = law.run(200)
    np.testing.assert_allclose(rows[1:, 1:5], trajectory, atol=1e-9)  # the trace computes in lanes: other rounding
    np.testing.assert_allclose(rows[-1, 8:], law.theta_target, atol=1e-9)
    assert not law.set_target([5, 0, 0])
    with pytest.raises(ValueError, match="expected gamma, alpha and beta finite"):
        multireach.PaperLaw(hoap2, gamma=-1)


def test_planned_ways_are_shorter(hoap2):
    def length(**parameters):
        law = multireach.GuardedLaw(hoap2, **parameters)
        law.start([0.2, -0.3, -0.2, -0.9])
        law.set_target([0.10, -0.05, 0.02])
        way = [law.x]
        for _ in range(600):
            law.step(1)
            way.append(law.x)
        np.testing.assert_allclose(law.x, [0.10, -0.05, 0.02], atol=1e-4)
        return np.linalg.norm(np.diff(way, axis=0), axis=1).sum()

    assert length(path_work=70) < length()
    with pytest.raises(ValueError, match="plans no paths"):
        multireach.GuardedBatch(hoap2, 8, path_work=70)


def test_obstacles_are_avoided(hoap2):
    law = multireach.GuardedLaw(hoap2, link_radius_m=0.02)
    law.start([0.2, -0.3, -0.2, -0.9])
    assert law.set_obstacles([multireach.Obstacle("sphere", [0.1, -0.12, 0.1], [0.05])]) == 0
    law.set_target([0.1, -0.12, 0.1])
    clearances = [law.step(7) or law.clearance() for _ in range(100)]
    assert min(clearances) > -1e-6
    assert law.obstruction == multireach.Obstruction.TARGET
    assert np.linalg.norm(law.x - [0.1, -0.12, 0.1]) > 0.05


def test_motion_is_the_same_at_any_rate(hoap2):
    hands = []
    for rate in (100, 1000):
        law = multireach.GuardedLaw(hoap2, natural_frequency=6, damping_ratio=1, steps_per_second=rate)
        law.start([0.2, -0.3, -0.2, -0.9])
        law.set_target([0.1, -0.12, 0.1])
        law.step(rate // 2)
        hands.append(law.x)
    assert np.linalg.norm(hands[0] - hands[1]) < 2e-3


def test_errors_are_sentences(hoap2):
    law = multireach.GuardedLaw(hoap2)
    with pytest.raises(RuntimeError, match=r"call start\(\) first"):
        law.set_target([0.1, -0.12, 0.1])
    law.start(np.zeros(4))
    with pytest.raises(ValueError, match="target: expected an array of 3 numbers"):
        law.set_target([0.1, -0.12])
    with pytest.raises(ValueError):
        law.set_target([np.nan, 0, 0])
    with pytest.raises(ValueError, match="the law has no parameter 'gama'; expected one of gamma, alpha"):
        multireach.GuardedLaw(hoap2, gama=3)
    with pytest.raises(ValueError):
        multireach.GuardedLaw(hoap2, alpha=0.01, beta=0.5)
    with pytest.raises(ValueError, match="alpha and beta: expected without natural_frequency"):
        multireach.GuardedLaw(hoap2, alpha=0.08, natural_frequency=6)
    with pytest.raises(ValueError, match="damping ratio must be in"):
        multireach.GuardedLaw(hoap2, damping_ratio=0.9)
    with pytest.raises(ValueError, match="size: a box has 3 numbers"):
        multireach.Obstacle("box", [0, 0, 0], [1])
    with pytest.raises(ValueError, match="start: expected 4 rows"):
        multireach.GuardedBatch(hoap2, 4).start(np.zeros((3, 4)), [0.1, -0.12, 0.1])
