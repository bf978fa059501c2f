"""One declaration checks every value."""

from __future__ import annotations

import array
import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Derived, Settings, parameter, refuse_unknown


@dataclass(frozen=True, kw_only=True)
class WheelSettings(Settings, prefix='wheel'):
    """Each kind of parameter once."""

    powered: bool = parameter(True, 'Whether it is driven')
    spokes: int = parameter(8, 'How many spokes', minimum=3, maximum=100)
    radius: float = parameter(0.5, 'From hub to ground', unit='m', minimum=0.1, maximum=2.0)
    camber: float = parameter(0.0, 'Lean of the wheel', unit='rad')
    load: float = parameter(10.0, 'What it carries', unit='kg', minimum=0.0)
    sag: float = parameter(-0.01, 'How far it gives', unit='m', maximum=0.0)
    side: str = parameter('left', 'Where it sits', choices=('left', 'right'))
    label: str = parameter('front', 'What is written on it')
    bits: int = parameter(8, 'Resolution of its encoder', choices=(8, 12))
    axes: tuple[str, ...] = parameter(('x',), 'Axes it turns', choices=('x', 'y', 'z'))
    weights: tuple[float, ...] = parameter((1.0,), 'Weights', minimum=0.0)
    hub: tuple[float, float, float] = parameter((0.0, 0.0, 0.0), 'Where', unit='m', length=3)
    circumference: float = parameter(
        Derived(lambda wheel: 2.0 * math.pi * wheel.radius, 'from the radius'),
        'Way of one turn',
        unit='m',
    )

    def validate(self) -> None:
        if self.side == 'right' and self.camber > 0.0:
            raise SettingsError('wheel.camber: a right wheel leans the other way')


DECLARED = {declared.name: declared for declared in WheelSettings.parameters()}

REFUSED = [
    ('powered', 1, 'true or false'),
    ('powered', 'true', 'true or false'),
    ('powered', None, 'true or false'),
    ('spokes', 2, 'an integer from 3 to 100'),
    ('spokes', 101, 'an integer from 3 to 100'),
    ('spokes', 8.0, 'an integer'),
    ('spokes', True, 'an integer'),
    ('spokes', '8', 'an integer'),
    ('spokes', [8], 'an integer'),
    ('spokes', 10**400, 'an integer'),
    ('radius', 0.0999, 'a finite number from 0.1 to 2 [m]'),
    ('radius', 2.0001, 'a finite number from 0.1 to 2 [m]'),
    ('radius', math.nan, 'a finite number'),
    ('radius', True, 'a finite number'),
    ('radius', '0.5', 'a finite number'),
    ('radius', None, 'a finite number'),
    ('radius', [0.5], 'a finite number'),
    ('camber', math.nan, 'a finite number [rad]'),
    ('camber', math.inf, 'a finite number [rad]'),
    ('camber', -math.inf, 'a finite number [rad]'),
    ('camber', 10**400, 'a finite number [rad]'),
    ('load', -1e-9, 'a finite number of at least 0 [kg]'),
    ('load', math.inf, 'a finite number of at least 0'),
    ('sag', 1e-9, 'a finite number of at most 0 [m]'),
    ('side', 'top', "one of 'left', 'right'"),
    ('side', 1, "one of 'left', 'right'"),
    ('label', 3, 'a string'),
    ('bits', 10, 'one of 8, 12'),
    ('axes', [], "a list of one or more elements, none twice, each one of 'x', 'y', 'z'"),
    ('axes', ['x', 'x'], 'none twice'),
    ('axes', ['x', 'w'], "each one of 'x', 'y', 'z'"),
    ('axes', 'x', 'a list of one or more elements'),
    ('weights', [], 'a list of one or more elements, each a finite number of at least 0'),
    ('weights', [1.0, -1.0], 'of at least 0'),
    ('weights', [1.0, math.nan], 'a finite number'),
    ('weights', [1.0, True], 'a finite number'),
    ('weights', 1.0, 'a list'),
    ('hub', [0.0, 0.0], 'a list of 3 elements'),
    ('hub', [0.0, 0.0, 0.0, 0.0], 'a list of 3 elements, each a finite number [m]'),
    ('circumference', math.inf, 'a finite number [m]'),
]


@pytest.mark.parametrize(('name', 'value', 'allowed'), REFUSED)
def test_wrong_value_is_refused_with_key_value_and_what_is_allowed(name, value, allowed):
    with pytest.raises(SettingsError) as caught:
        WheelSettings.from_values({f'wheel.{name}': value})
    said = str(caught.value)
    assert said.startswith(f'wheel.{name}: ')
    assert repr(value) in said
    assert allowed in said


@pytest.mark.parametrize(('name', 'value', 'allowed'), REFUSED)
def test_wrong_value_is_refused_wherever_settings_are_built(name, value, allowed):
    with pytest.raises(SettingsError, match=f'wheel.{name}'):
        WheelSettings(**{name: value})
    with pytest.raises(SettingsError, match=f'wheel.{name}'):
        dataclasses.replace(WheelSettings(), **{name: value})


@pytest.mark.parametrize(
    ('name', 'value', 'kept'),
    [
        ('radius', 0.1, 0.1),
        ('radius', 2.0, 2.0),
        ('spokes', 3, 3),
        ('load', 0.0, 0.0),
        ('sag', 0.0, 0.0),
        ('axes', ['z', 'x'], ('z', 'x')),
        ('weights', [1.0, 1.0], (1.0, 1.0)),
        ('hub', array.array('d', [1.0, 2.0, 3.0]), (1.0, 2.0, 3.0)),
        ('hub', np.array([1.0, 2.0, 3.0]), (1.0, 2.0, 3.0)),
        ('label', '', ''),
    ],
)
def test_allowed_value_is_kept(name, value, kept):
    assert getattr(WheelSettings(**{name: value}), name) == kept


def test_integer_is_taken_where_a_double_is_meant():
    settings = WheelSettings.from_values({'wheel.radius': 1, 'wheel.hub': [1, 2.5, 3]})
    assert settings.radius == 1.0
    assert type(settings.radius) is float
    assert settings.hub == (1.0, 2.5, 3.0)
    assert {type(element) for element in settings.hub} == {float}


@pytest.mark.parametrize(('name', 'value'), [('side', True), ('label', False), ('axes', [True])])
def test_boolean_for_a_string_hints_at_yaml(name, value):
    with pytest.raises(SettingsError, match=r"unquoted y, n, .* quote it, as 'y'"):
        WheelSettings(**{name: value})


@pytest.mark.parametrize(('name', 'value'), [('side', 1), ('axes', ['w']), ('radius', True)])
def test_other_mistakes_get_no_hint_at_yaml(name, value):
    with pytest.raises(SettingsError) as caught:
        WheelSettings(**{name: value})
    assert 'YAML' not in str(caught.value)


def test_derived_default_follows_the_other_settings():
    assert WheelSettings(radius=1.0).circumference == pytest.approx(2.0 * math.pi)
    assert WheelSettings(radius=1.0, circumference=6.0).circumference == 6.0


def test_derived_value_is_checked_too():
    @dataclass(frozen=True, kw_only=True)
    class Broken(Settings, prefix='broken'):
        wide: float = parameter(Derived(lambda _: 9.0, 'nine'), 'Too wide', maximum=1.0)

    with pytest.raises(SettingsError, match=r'broken\.wide: 9\.0 is not allowed'):
        Broken()


def test_values_that_contradict_each_other_are_refused():
    with pytest.raises(SettingsError, match=r'wheel\.camber'):
        WheelSettings(side='right', camber=0.1)


def test_values_give_back_the_settings():
    settings = WheelSettings(radius=1.0, axes=('y', 'z'))
    values = settings.values()
    assert values['wheel.radius'] == 1.0
    assert values['wheel.axes'] == ('y', 'z')
    assert list(values) == [declared.key for declared in WheelSettings.parameters()]
    assert WheelSettings.from_values(values).values() == values


def test_keys_of_other_parts_are_ignored():
    settings = WheelSettings.from_values({'wheel.radius': 1.5, 'engine.radius': 'none'})
    assert settings.radius == 1.5
    assert settings.changed({'engine.radius': 'none'}).values() == settings.values()


def test_change_is_all_or_nothing():
    before = WheelSettings()
    with pytest.raises(SettingsError, match=r'wheel\.spokes'):
        before.changed({'wheel.radius': 1.5, 'wheel.spokes': 1})
    assert before.values() == WheelSettings().values()
    after = before.changed({'wheel.radius': 1.5, 'wheel.spokes': 5})
    assert (after.radius, after.spokes) == (1.5, 5)
    assert before.radius == 0.5


def test_change_is_judged_as_a_whole():
    with pytest.raises(SettingsError, match=r'wheel\.camber'):
        WheelSettings(camber=0.1).changed({'wheel.side': 'right'})
    changed = WheelSettings(camber=0.1).changed({'wheel.side': 'right', 'wheel.camber': -0.1})
    assert changed.side == 'right'


def test_change_keeps_derived_values():
    before = WheelSettings(radius=1.0)
    assert before.changed({'wheel.radius': 2.0}).circumference == before.circumference


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        WheelSettings().radius = 1.0


def test_declarations_carry_what_was_said():
    radius = DECLARED['radius']
    assert (radius.key, radius.type, radius.default) == ('wheel.radius', float, 0.5)
    assert (radius.minimum, radius.maximum, radius.unit) == (0.1, 2.0, 'm')
    assert DECLARED['axes'].type == list[str]
    assert DECLARED['hub'].type == list[float]
    assert DECLARED['hub'].length == 3
    assert not radius.mutable


@pytest.mark.parametrize(
    ('key', 'suggested'),
    [('wheel.radios', 'wheel.radius'), ('wheel.spoke', 'wheel.spokes'), ('weel.hub', 'wheel.hub')],
)
def test_unknown_key_names_the_nearest_one(key, suggested):
    with pytest.raises(SettingsError) as caught:
        refuse_unknown(['wheel.hub', key], [WheelSettings])
    assert str(caught.value) == f"{key}: no such parameter; did you mean '{suggested}'?"


def test_unknown_prefix_names_the_known_ones():
    @dataclass(frozen=True, kw_only=True)
    class EngineSettings(Settings, prefix='engine'):
        power: float = parameter(1.0, 'Power', unit='W')

    with pytest.raises(SettingsError) as caught:
        refuse_unknown(['quux.zzz'], [WheelSettings, EngineSettings])
    assert str(caught.value) == 'quux.zzz: no such parameter; known prefixes: engine, wheel'


def test_known_keys_pass():
    refuse_unknown(WheelSettings().values(), [WheelSettings])
