"""Declare a parameter once: default, description, unit and range in one place.

A part of the package (a driver, an estimator, a motion of the simulator) keeps its settings in a
frozen dataclass derived from `Settings`, one `parameter` per field::

    @dataclass(frozen=True, kw_only=True)
    class SlideSettings(Settings, prefix='driver.slide'):
        distance: float = parameter(0.5, 'How far from A to B', unit='m')

From that one declaration follow the check of every value, the ROS descriptor
(`dead_reckoning.nodes.parameters`), the committed files in config/ and the reference page in docs/
(`dead_reckoning.tools.generate`).  Settings are valid from the moment they exist.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeVar, get_args, get_origin, get_type_hints

from dead_reckoning.core.errors import SettingsError

Value = bool | int | float | str | tuple[str, ...] | tuple[float, ...]
SettingsType = TypeVar('SettingsType', bound='Settings')


@dataclass(frozen=True)
class Derived:
    """A default that follows from the other settings of its part.

    ``compute`` gets the settings and returns the value; ``words`` say it in the reference.
    """

    compute: Callable[[Any], Value]
    words: str


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """What one declaration says; `Settings.parameters` lists them.

    ``key`` is the full ROS name, prefix included; ``type`` one of bool, int, float, str, or
    ``list[str]``, ``list[float]``; ``minimum`` and ``maximum`` are inclusive and hold for each
    element of a list; ``length`` 0 allows any number of elements but none.
    """

    name: str
    key: str
    type: Any
    default: Value | Derived
    description: str
    unit: str = ''
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: tuple[Any, ...] = ()
    length: int = 0
    mutable: bool = False

    def check(self, value: Any) -> Value:
        """Return the value in the declared type; an integer is accepted where a double is meant.

        Raises `SettingsError`, which names key, value and what is allowed.
        """
        if get_origin(self.type) is not list:
            scalar: Value = self._check_scalar(value)
            return scalar
        if not isinstance(value, (list, tuple)) and not hasattr(value, 'tolist'):
            raise self._refused(value)
        elements = list(value)
        if not elements or (self.length and len(elements) != self.length):
            raise self._refused(value)
        checked = tuple(self._check_scalar(element, value) for element in elements)
        if self.choices and len(set(checked)) != len(checked):
            raise self._refused(value)
        return checked

    def _check_scalar(self, value: Any, whole: Any = None) -> Any:
        whole = value if whole is None else whole
        scalar_type = (get_args(self.type) or (self.type,))[0]
        a_bool = isinstance(value, bool)
        if scalar_type is float and isinstance(value, (int, float)) and not a_bool:
            try:
                value = float(value)
            except OverflowError:  # an integer that no double holds
                raise self._refused(whole) from None
        if type(value) is not scalar_type:
            raise self._refused(whole)
        if scalar_type in (int, float) and not self.minimum <= value <= self.maximum:
            raise self._refused(whole)
        if scalar_type is float and not math.isfinite(value):
            raise self._refused(whole)
        if self.choices and value not in self.choices:
            raise self._refused(whole)
        return value

    def _refused(self, value: Any) -> SettingsError:
        hint = ''
        if self.type in (str, list[str]) and (isinstance(value, bool) or _holds_bool(value)):
            hint = "; in YAML an unquoted y, n, yes, no, on or off is a boolean: quote it, as 'y'"
        if isinstance(value, tuple):
            value = list(value)
        return SettingsError(f'{self.key}: {value!r} is not allowed; {self.allowed()}{hint}')

    def allowed(self) -> str:
        """Say in words which values are allowed."""
        is_list = get_origin(self.type) is list
        scalar_type = (get_args(self.type) or (self.type,))[0]
        words = {
            bool: 'true or false',
            int: 'an integer',
            float: 'a finite number',
            str: 'a string',
        }
        said = (
            'one of ' + ', '.join(repr(c) for c in self.choices)
            if self.choices
            else words[scalar_type]
        )
        if self.minimum > -math.inf and self.maximum < math.inf:
            said += f' from {_said(self.minimum)} to {_said(self.maximum)}'
        elif self.minimum > -math.inf:
            said += f' of at least {_said(self.minimum)}'
        elif self.maximum < math.inf:
            said += f' of at most {_said(self.maximum)}'
        if self.unit:
            said += f' [{self.unit}]'
        if is_list:
            count = f'{self.length} elements' if self.length else 'one or more elements'
            if self.choices:
                count += ', none twice'
            said = f'a list of {count}, each {said}'
        return said


def _said(bound: float) -> str:
    return f'{bound:.0f}' if bound == int(bound) else f'{bound:g}'


def _holds_bool(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and any(isinstance(element, bool) for element in value)


def parameter(
    default: Any,
    description: str,
    *,
    unit: str = '',
    minimum: float = -math.inf,
    maximum: float = math.inf,
    choices: Iterable[Any] = (),
    length: int = 0,
    mutable: bool = False,
) -> Any:
    """Declare one field of a `Settings` class; `Parameter` says what each argument means."""
    declaration = {
        'default': default,
        'description': description,
        'unit': unit,
        'minimum': minimum,
        'maximum': maximum,
        'choices': tuple(choices),
        'length': length,
        'mutable': mutable,
    }
    return dataclasses.field(default=default, metadata=declaration)


class Settings:
    """Base of every part's settings: frozen dataclasses that are valid once they exist.

    Subclasses give their prefix as a class argument.  Wrong values raise `SettingsError` when the
    object is built, so an estimator never sees them; `validate` is the place for what concerns
    several values at once.
    """

    prefix: ClassVar[str]

    def __init_subclass__(cls, *, prefix: str, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.prefix = prefix

    def __post_init__(self) -> None:
        derived = []
        for declared in self.parameters():
            value = getattr(self, declared.name)
            if isinstance(value, Derived):
                derived.append((declared, value))
            else:
                object.__setattr__(self, declared.name, declared.check(value))
        for declared, value in derived:
            object.__setattr__(self, declared.name, declared.check(value.compute(self)))
        self.validate()

    def validate(self) -> None:
        """Raise `SettingsError` where values contradict each other; the base allows all."""

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """List the declarations of this part, in their order in the class."""
        if '_parameters' not in cls.__dict__:
            hints = get_type_hints(cls)
            cls._parameters = tuple(
                Parameter(
                    name=field.name,
                    key=f'{cls.prefix}.{field.name}',
                    type=_list_type(hints[field.name]),
                    **field.metadata,
                )
                for field in dataclasses.fields(cls)  # type: ignore[arg-type]
            )
        return cls._parameters

    _parameters: ClassVar[tuple[Parameter, ...]]

    @classmethod
    def from_values(cls: type[SettingsType], values: Mapping[str, Any]) -> SettingsType:
        """Build the settings from a mapping of full keys to values; other parts' keys are ignored.

        Raises `SettingsError` for a value that is not allowed.
        """
        given = {p.name: values[p.key] for p in cls.parameters() if p.key in values}
        return cls(**given)

    def changed(self: SettingsType, values: Mapping[str, Any]) -> SettingsType:
        """Return settings with some full keys changed, all or none; raises `SettingsError`.

        Keys of other parts are ignored; derived defaults keep the value they have.
        """
        given = {p.name: values[p.key] for p in self.parameters() if p.key in values}
        return dataclasses.replace(self, **given)  # type: ignore[type-var]

    def values(self) -> dict[str, Value]:
        """Return all values under their full keys."""
        return {p.key: getattr(self, p.name) for p in self.parameters()}


class Parts(Protocol):
    """Settings by their class, as `dead_reckoning.configuration.Configuration` holds them."""

    def __getitem__(self, part: type[SettingsType]) -> SettingsType:
        """Return the settings of a part."""


def _list_type(hint: Any) -> Any:
    """Read ``tuple[float, ...]`` or ``tuple[float, float, float]`` as ``list[float]``."""
    return list[get_args(hint)[0]] if get_origin(hint) is tuple else hint  # type: ignore[misc]


def refuse_unknown(keys: Iterable[str], parts: Iterable[type[Settings]]) -> None:
    """Raise `SettingsError` for the first key that no part declares, naming the nearest one."""
    known = {p.key: None for part in parts for p in part.parameters()}
    for key in keys:
        if key in known:
            continue
        near = difflib.get_close_matches(key, known, n=1)
        if near:
            remedy = f'did you mean {near[0]!r}?'
        else:
            remedy = 'known prefixes: ' + ', '.join(sorted({k.split('.')[0] for k in known}))
        raise SettingsError(f'{key}: no such parameter; {remedy}')
