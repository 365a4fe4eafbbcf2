"""Functions take few parameters: eight at most, twelve in compiled code."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
MOST, MOST_OF_KERNELS = 8, 12
EXCEPTIONS = {"railvib/prediction.py: predict", "railvib/prediction.py: predict_passage"}
"""Public, with a parameter for each property of a study."""


def parameters(function):
    """Return the names of a function's parameters but the object or the class."""
    lists = function.args.posonlyargs, function.args.args, function.args.kwonlyargs
    return [argument.arg for part in lists for argument in part if argument.arg not in ("self", "cls")]


def test_no_function_has_more_parameters_than_its_kind_may():
    excess = set()
    for package in ("railvib", "sweep", "queries"):
        for path in sorted((ROOT / package).rglob("*.py")):
            most = MOST_OF_KERNELS if "_kernels" in path.parts else MOST
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and len(parameters(node)) > most:
                    excess.add(f"{path.relative_to(ROOT).as_posix()}: {node.name}")
    assert excess == EXCEPTIONS
