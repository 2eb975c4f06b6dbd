"""Kinematics against a URDF reader and product of matrices of their own, and finite differences."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import multireach
from conftest import draw


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def numbers(element, name, default):
    return np.array([float(word) for word in (element.get(name) if element is not None and element.get(name) else default).split()])


def pose_from_urdf(urdf, base, tip, theta):
    """X_WT by the URDF's definition: origin, then motion, of every joint from tip to base. For chains that go down the tree."""
    joints = {joint.find("child").get("link"): joint for joint in ElementTree.parse(urdf).getroot().findall("joint")}
    pose, link, moving = np.eye(4), tip, []
    while link != base:
        moving.append(joints[link])
        link = joints[link].find("parent").get("link")
    angles = iter(theta)
    for joint in reversed(moving):
        origin = np.eye(4)
        roll, pitch, yaw = numbers(joint.find("origin"), "rpy", "0 0 0")
        origin[:3, :3] = rotation((0, 0, 1), yaw) @ rotation((0, 1, 0), pitch) @ rotation((1, 0, 0), roll)
        origin[:3, 3] = numbers(joint.find("origin"), "xyz", "0 0 0")
        motion = np.eye(4)
        if joint.get("type") != "fixed":
            axis = numbers(joint.find("axis"), "xyz", "1 0 0")
            axis /= np.linalg.norm(axis)
            angle = next(angles)
            if joint.get("type") == "prismatic":
                motion[:3, 3] = axis * angle
            else:
                motion[:3, :3] = rotation(axis, angle)
        pose = pose @ origin @ motion
    return pose


def test_pose_is_that_of_the_urdf(any_arm, rng):
    arm, folder = any_arm
    urdf = next(folder.glob("*.urdf"))
    for theta in draw(arm, rng, 20):
        expected = pose_from_urdf(urdf, arm.base, arm.tip, theta)
        # Rounding of some dozen products of numbers below 2.
        np.testing.assert_allclose(arm.pose(theta), expected, atol=1e-14)
        np.testing.assert_allclose(arm.position(theta), expected[:3, 3], atol=1e-14)


def test_jacobian_is_the_derivative(any_arm, rng):
    arm, _ = any_arm
    h = 1e-6
    for theta in draw(arm, rng, 10):
        moved = theta + h * np.vstack([np.eye(arm.size), -np.eye(arm.size)])
        ends = arm.position(moved)
        slope = (ends[:arm.size] - ends[arm.size:]).T / (2 * h)
        # Central differences: h^2 / 6 times the third derivative (below the arm's reach), and rounding / h.
        tolerance = arm.reach * h**2 + 1e-15 * arm.reach / h * 4
        np.testing.assert_allclose(arm.jacobian(theta), slope, atol=tolerance)
        np.testing.assert_array_equal(arm.pose_jacobian(theta)[:3], arm.jacobian(theta))


def test_rows_are_computed_like_single_configurations(any_arm, rng):
    arm, _ = any_arm
    thetas = draw(arm, rng, 100)  # more than the number from which the interpreter is let go
    for compute in (arm.position, arm.pose, arm.jacobian, arm.pose_jacobian):
        np.testing.assert_array_equal(compute(thetas), [compute(theta) for theta in thetas])
    np.testing.assert_array_equal(arm.position(np.asfortranarray(thetas)), arm.position(thetas))


def test_limits_and_names(hoap2):
    assert hoap2.joint_names == ["right_SFE", "right_SAA", "right_SHR", "right_EB"]
    assert (hoap2.size, hoap2.base, hoap2.tip) == (4, "torso", "right_hand")
    assert (hoap2.lower < hoap2.upper).all() and (hoap2.velocity > 0).all()
    over = hoap2.upper + [0.25, 0, 0, 0]
    assert hoap2.limit_excess(over) == pytest.approx(0.25, abs=1e-15)
    np.testing.assert_array_equal(hoap2.clamped(over), hoap2.upper)


def test_errors_are_sentences(hoap2, root, tmp_path):
    with pytest.raises(ValueError, match=r"theta: expected an array of shape \(4,\) or \(rows, 4\)"):
        hoap2.position([1, 2, 3])
    with pytest.raises(multireach.InputError, match="nowhere.urdf: cannot be opened"):
        multireach.Chain.from_urdf(tmp_path / "nowhere.urdf", "a", "b")
    with pytest.raises(multireach.InputError, match="hoap2.urdf.*no_link"):
        multireach.Chain.from_urdf(root / "robots/hoap2/hoap2.urdf", "torso", "no_link")
    with pytest.raises(ValueError):
        multireach.Chain.from_urdf_text("no URDF", "a", "b")
