"""Brings a student's file to life statement by statement, as far as it goes; standard library only.

Where a check sets the robot's numbers, the file is run again with them, so that what it computes
from them follows.
"""

import __future__

import ast
import importlib.machinery
import importlib.util
import sys
import types
from collections.abc import Callable, Iterable

from answers import failure, plain
from reading import deep, statements

FILE = "<student>"
_SCOPES = (
    ast.FunctionDef,
    ast.AsyncFunctionDef,
    ast.ClassDef,
    ast.Lambda,
    ast.ListComp,
    ast.SetComp,
    ast.DictComp,
    ast.GeneratorExp,
)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom)
_CALCULATORS = {"math", "np", "numpy"}
MOST_OUTLINED = 300  # functions whose calls are told


def load(
    source: str,
    notebook: bool,
    skip: set[int],
    announce: Callable[[int, int], None],
    constants: dict | None = None,
    rewrite: Callable[[ast.AST], ast.AST] = lambda tree: tree,
) -> tuple[types.ModuleType, dict | None, dict[str, float]]:
    """Return (module, first trouble or None, numbers) after running the statements that are not in
    `skip`.

    announce(index, line) is called before each, so that one that kills the process is known.
    numbers: those that the file's own statements give a name; constants: other values for some of
        them, from the statement on that does.
    rewrite: changes a statement's syntax tree before it is compiled.
    """
    module = types.ModuleType("student")
    sys.modules["student"] = module
    return module, *_run(module, FILE, source, notebook, skip, announce, constants or {}, rewrite)


class Siblings:
    """Finds the modules that lie beside the student's file, and runs them as that file is run.

    trouble: of the first one that had any; numbers: as `load` gives them, of all.
    """

    def __init__(
        self, sources: dict[str, str], rewrite: Callable[[ast.AST], ast.AST] = lambda tree: tree
    ):
        self.sources = sources
        self.constants: dict = {}
        self.trouble: dict | None = None
        self.numbers: dict = {}
        self.rewrite = rewrite

    def find_spec(self, name: str, path: object = None, target: object = None) -> object:
        if name not in self.sources:
            return None
        # importlib asks a loader for no more than the methods below.
        return importlib.machinery.ModuleSpec(name, self)  # type: ignore[arg-type]

    def create_module(self, spec: object) -> None:
        return None

    def exec_module(self, module: types.ModuleType) -> None:
        file, source = f"<{module.__name__}.py>", self.sources[module.__name__]
        trouble, numbers = _run(
            module,
            file,
            source,
            False,
            set(),
            lambda index, line: None,
            self.constants,
            self.rewrite,
        )
        self.numbers |= numbers
        if trouble and not self.trouble:
            line = f", line {trouble['l']}" if trouble.get("l") else ""
            self.trouble = {
                "k": trouble["k"],
                "t": f"{module.__name__}.py{line}: {trouble.get('t', '')}",
            }

    def forget(self, constants: dict) -> None:
        """Let all be run anew with these constants."""
        self.constants = constants
        for name in self.sources:
            sys.modules.pop(name, None)


class OwnImports(ast.NodeTransformer):
    """Rewrites imports of the modules beside a file that name its folder, or "." for it: a file
    that is graded lies in no package.
    """

    def __init__(self, modules: Iterable[str]):
        self.modules = set(modules)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.stmt:
        folder, dot, name = (node.module or "").rpartition(".")
        if node.level and not node.module:
            return ast.copy_location(ast.Import(node.names), node)
        if node.level or (dot and name in self.modules and not _is_known(folder)):
            return ast.copy_location(ast.ImportFrom(name, node.names, 0), node)
        return node


def _is_known(package):
    """Return whether a package can be imported, with those that it lies in."""
    try:
        return importlib.util.find_spec(package) is not None
    except (ImportError, ValueError):  # the latter of a module that stands for another
        return False


def _run(module, file, source, notebook, skip, announce, constants, rewrite):
    """Return (first trouble or None, numbers) after running a source in a module."""
    with deep():
        body, error = statements(source, file)
    trouble = failure(error, file) if error else None
    if notebook:
        used = _used(body)
        body = [node for node in body if _is_definition(node) or node in used]
    flags, numbers = 0, {}
    for index, node in enumerate(body):
        if isinstance(node, ast.ImportFrom) and node.module == "__future__":
            for alias in node.names:
                flags |= getattr(getattr(__future__, alias.name, None), "compiler_flag", 0)
        if index in skip:
            continue
        announce(index, node.lineno)
        try:
            with deep():
                tree = rewrite(ast.Module([node], []))
                code = compile(tree, file, "exec", flags, dont_inherit=True)
            exec(code, module.__dict__)
        except BaseException as error:
            trouble = trouble or {"l": node.lineno} | {
                k: v for k, v in failure(error, file).items() if v is not None
            }
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("lab_amoro"):
                _names_of_the_lab(module)
        for name in _stored(node) & vars(module).keys():
            numbers[name] = _number(vars(module)[name])
            if name in constants and numbers[name] is not None:
                vars(module)[name] = constants[name]
    return trouble, {name: number for name, number in numbers.items() if number is not None}


def outline(sources: list[tuple[str, str]]) -> dict[str, list[list[str]]]:
    """Return function -> [its arguments, those of the functions that it mentions], of
    (source, file).

    A function is one of the top level; what a class or another value mentions counts as well.
    """
    defined: dict = {}
    for source, file in sources:
        with deep():
            body, _ = statements(source, file)
        for node in body:
            for name in {node.name} if hasattr(node, "name") else _stored(node):
                defined.setdefault(name, []).append(node)
    return {
        name: [_arguments(nodes[-1]), sorted(_mentioned(nodes) & defined.keys())]
        for name, nodes in [*defined.items()][:MOST_OUTLINED]
    }


def _arguments(node):
    """Return the names of a function's arguments, none for anything else."""
    function = getattr(node, "value", node)
    if not isinstance(function, ast.FunctionDef | ast.Lambda):
        return []
    return [argument.arg for argument in (*function.args.posonlyargs, *function.args.args)]


def _mentioned(nodes):
    parts = (part for node in nodes for part in ast.walk(node))
    return {part.id for part in parts if isinstance(part, ast.Name)}


def own_values(module: types.ModuleType) -> list:
    """Return the functions and classes that a module itself defines."""
    own = []
    for value in vars(module).values():
        try:
            if getattr(value, "__module__", None) == module.__name__:
                own.append(value)
        except BaseException:  # noqa: S112  a class of its own may raise whatever is asked of it
            continue
    return own


def methods(
    module: types.ModuleType, constants: dict | None = None, anew: bool = False
) -> dict[str, float]:
    """Give the module the methods of a class of its own that needs no arguments, where it has no
    function of such a name; return the numbers of its object.

    It runs what makes the object, which may take for ever: not where the file has functions that
    are asked. constants: other values for some of the numbers; anew: in place of those that it has.
    """
    numbers: dict = {}
    for name in [k for k, v in vars(module).items() if anew and isinstance(v, types.MethodType)]:
        del vars(module)[name]
    for own in own_values(module):
        if not isinstance(own, type):
            continue
        try:
            made = own()
            values = {name: getattr(made, name) for name in dir(made) if name[0] != "_"}
            given = {name: value for name, value in values.items() if _number(value) is not None}
            asked = {name: value for name, value in values.items() if callable(value)}
            changed = constants or {}
            for name in given.keys() & changed.keys():
                setattr(made, name, changed[name])
        except BaseException:  # noqa: S112  a class of another kind: its methods are not asked
            continue
        if asked:
            numbers |= {name: _number(value) for name, value in given.items()}
            for name, value in asked.items():
                vars(module).setdefault(name, value)
    return numbers


def _names_of_the_lab(module):
    """Return what its star imports bring besides the robot: np."""
    try:
        vars(module).setdefault("np", importlib.import_module("numpy"))
    except ImportError:
        pass  # a file that uses it says so


def _stored(node):
    """Return the names that a statement gives a value in the module itself."""
    names, waiting = set(), [node]
    while waiting:  # a sum of thousand terms is as deep as that
        part = waiting.pop()
        if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
            names.add(part.id)
        if not isinstance(part, _SCOPES):
            waiting += ast.iter_child_nodes(part)
    return names


def _number(value):
    """Return a plain number, None for anything else: a module or a function may have a constant's
    name.
    """
    try:
        value = plain(value)
        if isinstance(value, dict) and value.get("shape") == []:
            value = value["data"][0]
        return float(value) if type(value) in (int, float) and abs(value) < float("inf") else None
    except Exception:
        return None


def _used(body):
    """Return a notebook's assignments of names that its functions read, or that such an assignment
    reads.
    """
    assignments = [
        node for node in body if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign)
    ]
    wanted = set().union(*(_read(node) for node in body if isinstance(node, _SCOPES)))
    used = []
    while new := [node for node in assignments if node not in used and _stored(node) & wanted]:
        used += new
        wanted = wanted.union(*map(_read, new))
    return used


def _read(node):
    """Return names that a statement reads, and that are not its own: arguments, or
    assigned in it.
    """
    parts = list(ast.walk(node))
    names = {
        part.id for part in parts if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Load)
    }
    own = {part.arg for part in parts if isinstance(part, ast.arg)}
    if isinstance(node, _SCOPES):
        own |= {
            part.id
            for part in parts
            if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store)
        }
    return names - own


def _is_definition(node):
    """Return whether a notebook's statement defines a function, a class or a constant, or
    imports.
    """
    if isinstance(node, _DEFINITIONS):
        return True
    if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
        return False
    if isinstance(node.value, ast.Lambda):
        return True
    return all(
        not isinstance(part, ast.Call)
        or (
            isinstance(part.func, ast.Attribute)
            and isinstance(part.func.value, ast.Name)
            and part.func.value.id in _CALCULATORS
        )
        for part in ast.walk(node.value)
    )
