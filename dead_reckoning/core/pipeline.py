"""Settings of a whole chain in one process, and the chain they ask for."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class PipelineSettings(Settings, prefix='pipeline'):
    """Which source feeds the chain and which estimators it ends in."""

    source: str = parameter(
        'simulated',
        'topic (imu/data_raw, or imu/data where gravity.attitude is message) or one of the '
        "driver's",
        choices=('topic', 'simulated'),
    )
    estimators: tuple[str, ...] = parameter(
        ('integrator',), 'Estimators at the end of the chain', choices=('integrator',)
    )
