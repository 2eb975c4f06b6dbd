"""Messages against lcm-gen's own Python code, which encodes and decodes by itself; and malformed ones."""
import importlib
import subprocess
import sys

import numpy as np
import pytest

import multireach
from multireach import messages


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """The package that lcm-gen makes of lcmtypes/*.lcm, called `multireach` like ours: loaded under another name."""
    from conftest import ROOT
    folder = tmp_path_factory.mktemp("generated")
    subprocess.run(["lcm-gen", "-p", "--ppath", str(folder), *map(str, (ROOT / "lcmtypes").glob("*.lcm"))], check=True)
    (folder / "multireach").rename(folder / "lcm_gen_types")
    for file in (folder / "lcm_gen_types").glob("*.py"):
        file.write_text(file.read_text().replace("import multireach.", "import lcm_gen_types.").replace("multireach.", "lcm_gen_types."))
    sys.path.insert(0, str(folder))
    yield importlib.import_module("lcm_gen_types")
    sys.path.remove(str(folder))


def filled(message, rng, depth=0):
    """Every field gets a value; counts agree with the arrays."""
    for name, kind, dimensions in type(message)._definition:
        sizes = [int(size) if size.isdigit() else 3 - depth for size in dimensions]
        if any(name == size for _, _, others in type(message)._definition for size in others):
            setattr(message, name, 3 - depth)
        elif kind == "string":
            text = "Ä ball"
            setattr(message, name, [text] * sizes[0] if sizes else text)
        elif kind == "boolean":
            setattr(message, name, np.ones(sizes, bool) if sizes else True)
        elif kind == "byte":
            setattr(message, name, rng.integers(0, 256, sizes).astype(np.uint8) if sizes else 200)
        elif kind.startswith("int"):
            most = 2 ** (int(kind[3:-2]) - 1) - 1
            values = rng.integers(-most, most, sizes or None)
            setattr(message, name, values if sizes else int(values))
        elif kind in ("float", "double"):
            values = np.asarray(rng.normal(size=sizes), np.float32 if kind == "float" else np.float64)
            setattr(message, name, values if sizes else float(values))
        else:
            make = lambda: filled(getattr(messages, kind)(), rng, depth + 1)
            setattr(message, name, [make() for _ in range(sizes[0])] if sizes else make())
    return message


def to_generated(message, generated):
    """The same message as an object of lcm-gen's class."""
    other = getattr(generated, type(message).__name__)()
    for name, kind, dimensions in type(message)._definition:
        value = getattr(message, name)
        if isinstance(value, messages.Message):
            value = to_generated(value, generated)
        elif isinstance(value, list) and value and isinstance(value[0], messages.Message):
            value = [to_generated(each, generated) for each in value]
        elif isinstance(value, np.ndarray):
            value = bytes(value) if kind == "byte" else value.tolist()
        setattr(other, name, value)
    return other


@pytest.mark.parametrize("name", sorted(multireach._core.message_classes))
def test_bytes_are_those_of_lcm_gen(name, generated, rng):
    for empty in (True, False):
        message = getattr(messages, name)()
        if not empty:
            filled(message, rng)
        data = multireach.encode(message)
        assert data == to_generated(message, generated).encode()
        again = multireach.decode(data)
        assert type(again) is type(message) and multireach.encode(again) == data


@pytest.mark.parametrize("name", sorted(multireach._core.message_classes))
def test_constants_are_those_of_lcm_gen(name, generated):
    theirs = {key: value for key, value in vars(getattr(generated, name)).items() if key.isupper() and not key.startswith("_")}
    ours = {key: value for key, value in vars(getattr(messages, name)).items() if key.isupper()}
    assert ours == theirs


def test_damaged_bytes_are_no_message(rng):
    data = multireach.encode(filled(messages.images_t(), rng))
    assert multireach.decode(data) is not None
    for length in range(len(data)):
        assert multireach.decode(data[:length]) is None
    assert multireach.decode(data + b"x") is None
    for _ in range(20000):
        changed = bytearray(data)
        for at in rng.integers(0, len(data), 3):
            changed[at] = rng.integers(256)
        multireach.decode(changed)  # must not crash


def test_counts_follow_from_the_arrays():
    message = messages.joint_setpoint_t(joint_name=["a", "b"], joint_position=[1, 2.5], joint_velocity=np.zeros(2))
    assert multireach.decode(multireach.encode(message)).num_joints == 2
    message.joint_velocity = [0]
    with pytest.raises(ValueError, match=r"joint_setpoint_t.joint_velocity: has 1 elements; expected 2 \(num_joints"):
        multireach.encode(message)


def test_errors_are_sentences():
    with pytest.raises(TypeError, match="target_t has no field 'position'"):
        messages.target_t(position=[1, 2, 3])
    with pytest.raises(ValueError, match="target_t.position_m: has 2 elements; expected 3"):
        multireach.encode(messages.target_t(position_m=[1, 2]))
    with pytest.raises(ValueError, match="target_t.status: 200 is not a int8_t"):
        multireach.encode(messages.target_t(status=200))
    with pytest.raises(ValueError, match="target_t.name: '3' is not a string"):
        multireach.encode(messages.target_t(name=3))
    with pytest.raises(TypeError):
        multireach.encode(messages.image_t(data=[1.5]))
    for position in (np.zeros((3, 2)), [[0, 0]] * 3):
        with pytest.raises(ValueError, match="target_t.position_m: has more dimensions"):
            multireach.encode(messages.target_t(position_m=position))
    with pytest.raises(ValueError, match="'int' is no message of multireach"):
        multireach.encode(3)
