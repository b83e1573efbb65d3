"""Public names of the Python package, read from its sources: signatures without types, attributes, enumerators."""
import ast
import os

FRAMEWORKS = ("mujoco", "pybullet", "sofa")  # modules that users import by themselves
OPERATORS = ("__init__", "__call__", "__getitem__", "__iter__", "__len__")


class Package:
    def __init__(self, folder):
        self._folder = folder
        self._modules = {}

    def interface(self):
        names = next(ast.literal_eval(node.value) for node in self._module("__init__").body
                     if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__")
        for name in names:
            yield from self._described("fire3dv", name, *self._found("__init__", name))
        for module in FRAMEWORKS:
            for node in self._module(module).body:
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_"):
                    yield from self._described(f"fire3dv.{module}", node.name, module, node)

    def _module(self, name):
        if name not in self._modules:
            path = os.path.join(self._folder, name)
            with open(path + ".py" if os.path.exists(path + ".py") else os.path.join(path, "__init__.py"), encoding="utf-8") as file:
                self._modules[name] = ast.parse(file.read())
        return self._modules[name]

    def _found(self, module, name):
        """Module and definition of a name, through imports of the package; no definition of a plain value."""
        for node in self._module(module).body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name == name:
                return module, node
            if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module:
                for alias in node.names:
                    if (alias.asname or alias.name) == name:
                        return self._found(node.module, alias.name)
        return module, None

    def _described(self, prefix, name, module, node):
        if node is None:
            yield f"{prefix}.{name}"
        elif isinstance(node, ast.FunctionDef):
            yield f"{prefix}.{name}{_signature(node)}"
        else:
            yield f"{prefix}.{name}"
            for member in sorted(self._members(module, node).values()):
                yield f"{prefix}.{name}{member}"

    def _members(self, module, node):
        """Text of each member by its name; members of bases in the package belong to the class."""
        members = {}
        for base in reversed(node.bases):
            if isinstance(base, ast.Name):
                where, definition = self._found(module, base.id)
                if isinstance(definition, ast.ClassDef):
                    members.update(self._members(where, definition))
        for item in node.body:
            if isinstance(item, ast.FunctionDef):
                is_property = any(ast.unparse(decorator).endswith("property") for decorator in item.decorator_list)
                if item.name == "__init__":
                    members.update({name: f".{name}" for name in _attributes(item)})
                if item.name in OPERATORS:
                    members[item.name] = _signature(item) if item.name == "__init__" else f".{item.name}{_signature(item)}"
                elif not item.name.startswith("_"):
                    members[item.name] = f".{item.name}" + ("" if is_property else _signature(item))
            elif isinstance(item, (ast.Assign, ast.AnnAssign)):
                targets = item.targets if isinstance(item, ast.Assign) else [item.target]
                for target in (each for each in targets if isinstance(each, ast.Name) and not each.id.startswith("_")):
                    is_number = isinstance(item.value, ast.Constant) and isinstance(item, ast.Assign)
                    members[target.id] = f".{target.id}" + (f" = {ast.unparse(item.value)}" if is_number else "")
        return members


def _signature(function):
    """Parameters with defaults, without types: these may become wider."""
    arguments = function.args
    for argument in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, arguments.vararg, arguments.kwarg]:
        if argument:
            argument.annotation = None
    text = ast.unparse(arguments)
    first, _, rest = text.partition(", ")
    return f"({rest if first in ('self', 'cls') else text})"


def _attributes(function):
    """Public attributes that __init__ sets."""
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and ast.unparse(node.value) == "self":
            if not node.attr.startswith("_"):
                yield node.attr


def public_interface(root):
    yield from Package(os.path.join(root, "adapters", "generic", "python", "fire3dv")).interface()


def name_of(line):
    return line.split("(")[0].split(" ")[0]
