"""The type stubs name what the module has, and nothing else; everything public has a docstring."""
import ast
import inspect

import multireach
from conftest import ROOT


def names_of(body):
    """Public names in a stub's body: name -> the class's own body, or None."""
    names = {}
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names[node.name] = node.body if isinstance(node, ast.ClassDef) else None
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = None
    return {name: value for name, value in names.items() if not name.startswith("_")}


def test_stubs_are_complete():
    stub = names_of(ast.parse((ROOT / "python/multireach/__init__.pyi").read_text()).body)
    assert set(stub) | {"messages"} == set(multireach.__all__)
    for name, body in stub.items():
        if body is None:
            continue
        thing = getattr(multireach, name)
        if issubclass(thing, Exception):
            continue
        members = {key for key in vars(thing) if not key.startswith("_")} - {"name", "value"} | ({"name"} & set(names_of(body)))
        assert set(names_of(body)) - {"name", "value"} | ({"name"} & members) == members, name


def test_everything_has_a_docstring():
    for name in multireach.__all__:
        thing = getattr(multireach, name)
        assert name == "build" or inspect.getdoc(thing), name
    for name in multireach.messages.__all__:
        assert inspect.getdoc(getattr(multireach.messages, name)), name
