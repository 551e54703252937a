import ast
import pkgutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import aeb_sumo

MODULES = [name for _, name, _ in pkgutil.walk_packages(aeb_sumo.__path__, "aeb_sumo.") if "__main__" not in name]


def _kernels():
    for name in MODULES:
        for attribute in vars(import_module(name)).values():
            if isinstance(attribute, Dispatcher) and attribute.py_func.__module__ == name:
                yield pytest.param(attribute, id=f"{name}.{attribute.__name__}")


KERNELS = list(_kernels())


def reached(kernel):
    code = kernel.py_func.__code__
    return {name: kernel.py_func.__globals__[name] for name in code.co_names if name in kernel.py_func.__globals__}


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_calls_only_kernels_of_its_own_file(kernel):
    called = [value for value in reached(kernel).values() if isinstance(value, Dispatcher)]
    assert all(one.py_func.__module__ == kernel.py_func.__module__ for one in called)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_takes_no_numbers_from_other_files_but_those_of_nature(kernel):
    tree = ast.parse(Path(kernel.py_func.__code__.co_filename).read_text(encoding="utf-8"))
    imported = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.module.startswith("aeb_sumo") and node.module != "aeb_sumo.units"
        for alias in node.names
    }
    assert not imported & set(reached(kernel))


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_leaves_transcendental_functions_to_numpy(kernel):
    code = kernel.py_func.__code__
    assert not {"sin", "cos", "tan", "exp", "log", "hypot", "arctan2", "atan2", "power", "pow"} & set(code.co_names)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_is_kept_from_one_process_to_the_next(kernel):
    assert type(kernel._cache).__name__ == "FunctionCache"


def test_what_one_process_has_compiled_another_can_prepare(tmp_path):
    one = """import pickle, sys
from aeb_sumo import compiled
from aeb_sumo.criticality import ttc
ttc(gap=1.0, closing_speed=1.0)
pickle.dump(compiled.known(), open(sys.argv[1], 'wb'))
"""
    other = """import pickle, sys
from aeb_sumo import compiled
kernels = pickle.load(open(sys.argv[1], 'rb'))
assert kernels
assert not compiled.known()
compiled.prepare(kernels)
assert compiled.known() == kernels
"""
    for code in (one, other):
        subprocess.run([sys.executable, "-c", code, str(tmp_path / "kernels")], check=True)


def test_compiling_is_announced_once_and_a_kept_kernel_is_not(tmp_path, monkeypatch):
    (tmp_path / "some_kernels.py").write_text(
        "from aeb_sumo.compiled import announce, kernel\n"
        "announce(lambda: print('compiling'))\n"
        "@kernel\ndef half(x):\n    return x / 2\n"
        "@kernel\ndef twice(x):\n    return 2 * x\n"
        "print(half(3.0), twice(3.0))\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(Path(aeb_sumo.__file__).parents[1]))
    command = [sys.executable, "-c", "import some_kernels"]
    said = [subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True) for _ in range(2)]
    assert [each.stdout for each in said] == ["compiling\n1.5 6.0\n", "1.5 6.0\n"]
