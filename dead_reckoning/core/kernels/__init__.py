"""Functions on columns of samples, compiled by numba where it is; the one module that knows it.

A kernel is an ordinary function on arrays and numbers.  It and all functions of this package that
it calls are compiled with its first call, so the equations that streaming estimators use are
compiled as they are.  Compiled code is kept from run to run, beside the source or, where that can
not be written, where ``NUMBA_CACHE_DIR`` says or in the user's own cache.

Without numba, or with ``NUMBA_DISABLE_JIT=1``, `accelerated` is false, and whole recordings and
messages go through the streaming estimators.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from inspect import unwrap
from types import FunctionType
from typing import Any, TypeVar

Kernel = TypeVar('Kernel', bound=Callable[..., Any])

PACKAGE = __name__.partition('.')[0]

INNER = {'error_model': 'numpy', 'forceinline': True}
"""How functions that kernels call are compiled; else each array of each call has its references
counted, which takes a third of the time."""

RARE = {'error_model': 'numpy'}
"""How those are compiled that are `rare`: by themselves, which takes the less time the more they
call."""

SLOW = (
    'numba is not there, or NUMBA_DISABLE_JIT is set, so this takes many times as long: '
    'pip install numba (or apt install python3-numba)'
)
"""What a tool says once where `accelerated` is false."""


@cache
def _numba() -> Any:
    """Return numba, whose import takes half a second, or None where it can't be used."""
    try:
        import numba
    except ImportError:  # a numba that is not made for this numpy raises it too
        return None
    return None if numba.config.DISABLE_JIT else numba


def accelerated() -> bool:
    """Say whether kernels are compiled; imports numba."""
    return _numba() is not None


def rare(function: Kernel) -> Kernel:
    """Mark a function that kernels seldom call."""
    function.rare = True  # type: ignore[attr-defined]
    return function


def compiled(function: Kernel) -> Kernel:
    """Return a kernel that is compiled, or loaded, when it is first called.

    ``__wrapped__`` is the function itself.
    """
    made: Callable[..., Any] | None = None

    @wraps(function)
    def call(*arguments: Any) -> Any:
        nonlocal made
        if made is None:
            made = _kept(function) if accelerated() else function
        return made(*arguments)

    return call  # type: ignore[return-value]


def load(kernel: Kernel, *arguments: Any) -> bool:
    """Load a kernel for such arguments, if an earlier run has kept it; say whether it has."""
    if not accelerated():
        return False
    dispatcher: Any = _kept(unwrap(kernel))
    signature = tuple(map(_numba().typeof, arguments))
    if signature in dispatcher.overloads:
        return True
    code = dispatcher._cache.load_overload(signature, dispatcher.targetctx)
    if code is not None:
        dispatcher.add_overload(code)
    return code is not None


@cache
def _kept(function: Any) -> Callable[..., Any]:
    """Compile a function and keep what comes of it for the next run, where that is possible."""
    from numba.core.caching import FunctionCache

    clone, meaning = _closed(function)

    class Cache(FunctionCache):  # type: ignore[misc]
        """Keep code as long as all it was made of is the same: numba looks at one file only."""

        def _index_key(self, *arguments: Any) -> Any:
            return (*super()._index_key(*arguments), meaning)

        def save_overload(self, *arguments: Any) -> None:
            with suppress(OSError):  # no space: it is compiled, and that is what matters
                super().save_overload(*arguments)

    dispatcher: Any = _numba().njit(clone, error_model='numpy')
    with suppress(RuntimeError):  # no place for a cache
        dispatcher._cache = Cache(clone)
    return dispatcher  # type: ignore[no-any-return]


@cache
def _closed(function: Any) -> tuple[Any, str]:
    """Return a function whose calls into this package are compiled, and all it is made of.

    The latter are the codes and the constants of it and of what it calls.
    """
    code, names = function.__code__, dict(function.__globals__)
    meaning = [code.co_code.hex(), repr(code.co_consts)]
    for name in code.co_names:
        value = names.get(name)
        if isinstance(value, FunctionType) and value.__module__.startswith(PACKAGE):
            names[name], inner = _callee(unwrap(value))  # another kernel is a function like others
            meaning.append(inner)
        elif isinstance(value, type) and issubclass(value, tuple):
            meaning.append(f'{name} = {getattr(value, "_fields", ())}')
        elif isinstance(value, int | float | tuple):
            meaning.append(f'{name} = {value!r}')
    return FunctionType(code, names, function.__name__), '\n'.join(meaning)


@cache
def _callee(function: Any) -> tuple[Any, str]:
    clone, meaning = _closed(function)
    options = RARE if getattr(function, 'rare', False) else INNER
    return _numba().njit(clone, **options), f'{options}\n{meaning}'
