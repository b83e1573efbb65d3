"""Test of signatures: types of literals hold the names that functions take, arguments are explicit, enumerations are named
by errors. No renderer."""
import ast
import builtins
import inspect
import typing

import fire3dv
from fire3dv import _types, image, images, markers, mujoco
from fire3dv._numbers import enumerated


def names_of(literal):
    return list(typing.get_args(literal))


assert set(names_of(fire3dv.Output)) == set(image.BITS_OF_ANY_NAME)
assert names_of(fire3dv.When) == list(images.WHEN)
assert names_of(fire3dv.Lens) == list(image.LENSES)
assert names_of(_types.Shown) == list(mujoco._SHOWN)

# Every marker function has the arguments that set_marker has for all kinds, with the same defaults, by name.
COMMON = ("parent", "parent_from_marker", "lifetime_s", "overlaid")
of_all = inspect.signature(markers.Markers.set_marker).parameters
shapes = [kind.name.lower() for kind in fire3dv.MarkerKind]
shapes = [{"texts": "text", "images": "image"}.get(name, name) for name in shapes]
for name in shapes:
    own = inspect.signature(getattr(fire3dv.Stream, name)).parameters
    assert list(own)[-len(COMMON):] == list(COMMON), (name, list(own))
    for argument in COMMON:
        assert own[argument].kind is inspect.Parameter.KEYWORD_ONLY, (name, argument)
        assert (own[argument].default, own[argument].annotation) == (of_all[argument].default, of_all[argument].annotation)

# Public functions hide no arguments, and say types of arrays. Names of joints are arguments.
for owner in (fire3dv.Stream, fire3dv.Renderer, fire3dv.Image, fire3dv.ImageRequest, fire3dv.Robot, mujoco.Publisher):
    for name, function in inspect.getmembers(owner, inspect.isfunction):
        if name.startswith("_") and name != "__init__":
            continue
        signature = inspect.signature(function)
        for argument in signature.parameters.values():
            assert argument.kind is not inspect.Parameter.VAR_POSITIONAL, (owner, name)
            assert argument.kind is not inspect.Parameter.VAR_KEYWORD or argument.name == "joints", (owner, name, argument)
            assert argument.name == "self" or argument.annotation is not inspect.Parameter.empty, (owner, name, argument)
        assert signature.return_annotation is not inspect.Signature.empty, (owner, name)
for name in fire3dv.ALIASES:
    text = getattr(fire3dv.Image, name).fget.__annotations__["return"]
    assert text.startswith("npt.NDArray[np."), (name, text)
    assert "(height, width" in getattr(fire3dv.Image, name).__doc__, name

# Annotations have known names alone.
for module in (image, images, markers, mujoco, fire3dv.stream, fire3dv.renderer, fire3dv.robot, fire3dv.poses):
    known = {*vars(module), *fire3dv.__all__, *dir(typing), *dir(builtins), "np", "npt", "Path"}
    for function in ast.walk(ast.parse(inspect.getsource(module))):
        if isinstance(function, ast.FunctionDef):
            for annotation in [a.annotation for a in function.args.args + function.args.kwonlyargs] + [function.returns]:
                for word in ast.walk(annotation) if annotation is not None else []:
                    assert not isinstance(word, ast.Name) or word.id in known, (module.__name__, function.name, word.id)

for value, kind, expected in (("directional", fire3dv.LightKind, "kind is 'directional'; use fire3dv.LightKind.DIRECTIONAL, "
                               "or .POINT, .SPOT"), (7, fire3dv.Property, "kind is 7; use fire3dv.Property.VISIBLE, or "),
                              (None, fire3dv.MarkerKind, "kind is None; use fire3dv.MarkerKind.POINTS, or ")):
    try:
        enumerated(value, kind, "kind")
    except fire3dv.ArgumentError as error:
        assert str(error).startswith(expected), error
    else:
        raise AssertionError(f"{value!r} was taken")
assert enumerated(2, fire3dv.LightKind, "kind") == enumerated(fire3dv.SPOT, fire3dv.LightKind, "kind") == 2

with fire3dv.Stream("udp://127.0.0.1:9") as stream:
    for call in (lambda: stream.set_light("sun", "directional"), lambda: stream.clear("sun", "light"),
                 lambda: stream.set_marker("m", "points", [[0, 0, 0]])):
        try:
            call()
        except fire3dv.ArgumentError as error:
            assert "use fire3dv." in str(error), error
        else:
            raise AssertionError("a str was taken")
assert fire3dv.__version__ == fire3dv.version(), (fire3dv.__version__, fire3dv.version())
print("passed")
