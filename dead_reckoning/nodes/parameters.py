"""Declare the parameters of a node's parts from their one declaration; refuse what is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, get_origin

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import HistoryPolicy, ReliabilityPolicy

from dead_reckoning.configuration import PARTS, Configuration, is_ros_key
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Parameter, Settings, refuse_unknown

POLICIES = {'history': HistoryPolicy, 'reliability': ReliabilityPolicy}
"""Policies, beside the depth, that qos_overrides can set here, and their values."""

MAXIMUM_DEPTH = 1_000_000


def declare(node: Node, parts: Iterable[type[Settings]]) -> Configuration:
    """Declare all parameters of ``parts`` with the values the user gave, and return the settings.

    Keys of other parts are left to the nodes that own them.  Raises `SettingsError` for a key that
    no part declares and for a value that is not allowed.
    """
    overrides = _overrides(node)
    _check_quality_of_service(overrides)
    given = {key: value for key, value in overrides.items() if not is_ros_key(key)}
    refuse_unknown(given, PARTS)
    parts = tuple(parts)
    own = {p.key for part in parts for p in part.parameters()}
    configuration = Configuration({key: given[key] for key in given if key in own})
    for part in parts:
        values = configuration[part].values()
        for parameter in part.parameters():
            node.declare_parameter(
                parameter.key,
                _to_ros(values[parameter.key]),
                descriptor(parameter),
                ignore_override=True,  # the value is the user's already, and checked
            )
    _widen_integers(node, {p.key for part in parts for p in part.parameters() if p.type is float})
    return configuration


def _widen_integers(node: Node, doubles: Collection[str]) -> None:
    """Take an integer where a double is meant, also in what is set later.

    Once per node: rclpy puts what several such callbacks return one after the other.
    """

    def widen(changes: list[RosParameter]) -> list[RosParameter]:
        return [
            RosParameter(change.name, value=float(change.value))
            if change.name in doubles and type(change.value) is int
            else change
            for change in changes
        ]

    node.add_pre_set_parameters_callback(widen)


def follow_changes(node: Node, settings: Settings, apply: Callable[[Any], None]) -> None:
    """Hand changed settings to ``apply`` whenever the user sets mutable parameters of their part.

    A set of changes is taken whole or not at all.
    """
    current = settings
    keys = {p.key for p in settings.parameters()}

    def check(changes: list[RosParameter]) -> SetParametersResult:
        try:
            current.changed({change.name: change.value for change in changes})
        except SettingsError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def take(changes: list[RosParameter]) -> None:
        nonlocal current
        if any(change.name in keys for change in changes):
            current = current.changed({change.name: change.value for change in changes})
            apply(current)

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(take)


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Make the ROS descriptor of a declared parameter."""
    unit = f' [{parameter.unit}]' if parameter.unit else ''
    made = ParameterDescriptor(
        name=parameter.key,
        description=f'{parameter.description}{unit}',
        additional_constraints=parameter.allowed(),
        read_only=not parameter.mutable,
    )
    bounded = math.isfinite(parameter.minimum) and math.isfinite(parameter.maximum)
    if bounded and get_origin(parameter.type) is not list:
        if parameter.type is float:
            made.floating_point_range = [
                FloatingPointRange(
                    from_value=float(parameter.minimum), to_value=float(parameter.maximum)
                )
            ]
        elif parameter.type is int:
            made.integer_range = [
                IntegerRange(
                    from_value=int(parameter.minimum), to_value=int(parameter.maximum), step=1
                )
            ]
    return made


def _overrides(node: Node) -> dict[str, Any]:
    """Return what the user gave this node.

    rclpy drops overrides that no one declares without a word and has no public way to list them,
    hence the look at its private mapping, here and nowhere else.
    """
    return {name: _from_ros(p) for name, p in node._parameter_overrides.items()}


def _from_ros(parameter: RosParameter) -> Any:
    if parameter.type_ is RosParameter.Type.NOT_SET:
        return []  # an empty list has no type in ROS, and so no value
    value = parameter.value
    return list(value) if hasattr(value, 'tolist') else value


def _check_quality_of_service(overrides: Mapping[str, Any]) -> None:
    """Raise `SettingsError` for a policy in qos_overrides that rclpy would end in a traceback."""
    for key, value in overrides.items():
        if not key.startswith('qos_overrides.'):
            continue
        policy = key.rpartition('.')[2]
        if policy == 'depth':
            if type(value) is not int or not 0 <= value <= MAXIMUM_DEPTH:
                raise SettingsError(
                    f'{key}: {value!r} is not allowed; an integer from 0 to {MAXIMUM_DEPTH}'
                )
        elif policy in POLICIES:
            allowed = [name.lower() for name in POLICIES[policy].__members__ if name != 'UNKNOWN']
            if not isinstance(value, str) or value.lower() not in allowed:
                raise SettingsError(
                    f'{key}: {value!r} is not allowed; one of '
                    + ', '.join(repr(name) for name in allowed)
                )


def _to_ros(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
