"""Vision on NumPy images against the truth of the rendered session, and replay against its recorded digest."""
import pathlib
import re
import shutil
import subprocess

import numpy as np
import pytest

import multireach


@pytest.fixture(scope="module")
def pairs():
    """The first hundred pairs of logs/reach.lcm, decoded, with the ball's true position."""
    from conftest import ROOT
    log = multireach.Log(ROOT / "logs/reach.lcm")
    truth = {message.utime: message.position_m for message in (event.message for event in log.events(["TARGET_TRUTH"]))}
    found = []
    for event in log.events(["STEREO_IMAGES"]):
        left, right = multireach.images_of(event.data)
        found.append((event.message.utime, left, right, truth[event.message.utime]))
        if len(found) == 100:
            return found


def test_positions_are_those_of_the_rendered_ball(root, pairs):
    vision = multireach.Vision(root / "robots/hoap2/vision.yaml")
    distances = []
    for utime, left, right, truth in pairs:
        ball, = vision.update(left, right, utime, chroma_subsampled=True)
        assert ball.name == "ball"
        if ball.status == "tracked":
            error = ball.position - truth
            distances.append(error @ np.linalg.solve(ball.covariance, error))
    assert len(distances) > 90
    # Squared distances in units of the stated covariance: chi square with three degrees of freedom, of which 99.9 % are below 16.3.
    assert np.mean(np.array(distances) < 16.3) > 0.97


def test_numbers_are_those_of_the_node(root, pairs, tmp_path):
    multireach.replay(root / "logs/reach.lcm", root / "robots/hoap2", output=tmp_path / "out.lcm", until_s=3)
    node = multireach.Log(tmp_path / "out.lcm").columns("TARGET")
    vision = multireach.Vision(root / "robots/hoap2/vision.yaml")
    for row, (utime, left, right, _) in enumerate(pairs[:80]):
        ball, = vision.update(left, right, utime, chroma_subsampled=True)
        assert node["utime"][row] == utime
        np.testing.assert_array_equal(node["position_m"][row], ball.position)
        np.testing.assert_array_equal(node["left_px"][row], ball.left_px)


def test_images_are_not_copied_and_may_be_parts_of_others(root, pairs):
    utime, left, right, _ = pairs[10]
    wide = np.zeros((left.shape[0], left.shape[1] + 40, 3), np.uint8)
    wide[:, 20:-20] = left
    answers = [multireach.Vision(root / "robots/hoap2/vision.yaml").update(image, right, utime)[0] for image in (left, wide[:, 20:-20])]
    np.testing.assert_array_equal(answers[0].position, answers[1].position)
    for wrong in (left[:, :, ::-1], left.astype(float), left[:, :, 0], left[:, ::2]):
        with pytest.raises(ValueError, match=r"left: expected an array of shape \(height, width, 3\), uint8"):
            multireach.Vision(root / "robots/hoap2/vision.yaml").update(wrong, right, utime)


def test_one_image_for_both_cameras_is_no_position(root, pairs):
    vision = multireach.Vision(root / "robots/hoap2/vision.yaml")
    utime, left, _, _ = pairs[0]
    (ball,) = vision.update(left, left, utime)
    assert (ball.status, ball.reason) == ("lost", "the left and the right image are the same")


def test_triangulation_inverts_the_projection(root, rng):
    vision = multireach.Vision(root / "robots/hoap2/vision.yaml")
    for position in rng.uniform([0.05, -0.2, 0], [0.15, -0.05, 0.15], (20, 3)):
        left, right = vision.project(position)
        found, covariance = vision.triangulate(left, right)
        np.testing.assert_allclose(found, position, atol=1e-7)  # the lens is inverted to 1e-9 of the image plane
        assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_replay_gives_the_recorded_digest(root):
    digests = dict(reversed(line.split()) for line in (root / "logs/REPLAY_DIGESTS").read_text().splitlines())
    result = multireach.replay(root / "logs/reach.lcm", root / "robots/hoap2", threads=2)
    assert result["digest"] == digests["reach.lcm"]


def test_replay_takes_the_files_that_the_command_takes(root, tmp_path):
    """The calibration beside the session comes before the robot's; values may be replaced."""
    program = pathlib.Path(multireach.__file__).parents[2] / "bin/multireach-replay"
    session, own = tmp_path / "session.lcm", tmp_path / "session.vision.yaml"
    shutil.copy(root / "logs/reach.lcm", session)
    text = (root / "robots/hoap2/vision.yaml").read_text()
    own.write_text(re.sub(r"fx_px: [\d.]+", "fx_px: 250", text))
    assert own.read_text() != text
    digests = []
    for options in ({}, {"set": ["controller.gamma_rad2_m2=60"]}, {"vision": root / "robots/hoap2/vision.yaml"}):
        digests.append(multireach.replay(session, root / "robots/hoap2", until_s=1, **options)["digest"])
        if program.exists():
            words = [word for key, values in options.items() for value in (values if key == "set" else [values]) for word in (f"--{key}", value)]
            done = subprocess.run([program, "run", session, "--robot", root / "robots/hoap2", "--until", "1", "-o", tmp_path / "out.lcm", *words],
                                  capture_output=True, text=True)
            assert digests[-1] in done.stdout + done.stderr, done.stderr
    assert len(set(digests)) == 3
    with pytest.raises(multireach.InputError, match="gama"):
        multireach.replay(session, root / "robots/hoap2", set=["controller.gama=60"])


def test_report_of_a_replayed_run(root, tmp_path):
    multireach.replay(root / "logs/reach.lcm", root / "robots/hoap2", output=tmp_path / "out.lcm", until_s=4)
    report = multireach.report(tmp_path / "out.lcm", root / "robots/hoap2")
    counts = multireach.Log(tmp_path / "out.lcm").channels()
    assert (report["images"], report["targets"], report["commands"]) == (counts["STEREO_IMAGES"], counts["TARGET"], counts["JOINT_COMMAND"])
    state = multireach.Log(tmp_path / "out.lcm").columns("ROBOT_STATE")
    arm, reach = multireach.Chain.from_robot(root / "robots/hoap2"), report["reaches"][0]
    end = np.searchsorted(state["utime"], state["utime"][0] + reach["end_s"] * 1e6) - 1
    # Its error is that of the hand, with the noise of the images: the same within a millimetre.
    assert abs(1000 * np.linalg.norm(arm.position(state["joint_position"][end]) - reach["target_m"]) - reach["hand_error_mm"]) < 1


def test_errors_are_sentences(root, tmp_path):
    with pytest.raises(ValueError, match="robot_model: 'x' is not one of ideal, sim, recorded"):
        multireach.replay(root / "logs/reach.lcm", root / "robots/hoap2", robot_model="x")
    with pytest.raises(multireach.InputError, match="nowhere"):
        multireach.Vision(tmp_path / "nowhere.yaml")
    with pytest.raises(ValueError, match="images_of: expected the bytes"):
        multireach.images_of(b"12345678")
