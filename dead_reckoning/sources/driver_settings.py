"""Settings of the accelerometer driver: which source, which sensor, which circuit around it."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.accelerometer import AnalogAccelerometer
from dead_reckoning.core.parameters import Derived, Settings, parameter
from dead_reckoning.core.sensors import mma7260qt
from dead_reckoning.sources import motions


@dataclass(frozen=True, kw_only=True)
class DriverSettings(Settings, prefix='driver'):
    """An MMA7260QT, its supply and its ADC, and how conversions become messages."""

    source: str = parameter('simulated', 'Where samples come from', choices=('simulated',))
    motion: str = parameter('slide', 'What the simulated sensor does', choices=motions.names())
    range_g: float = parameter(
        1.5, 'Range chosen by the g-select pins, ±', unit='g', choices=tuple(mma7260qt.SENSITIVITY)
    )
    supply: float = parameter(
        mma7260qt.NOMINAL_SUPPLY,
        'Supply of the sensor, to which its outputs are ratiometric',
        unit='V',
        minimum=mma7260qt.SUPPLY[0],
        maximum=mma7260qt.SUPPLY[1],
    )
    adc_reference: float = parameter(
        3.3, 'Reference of the ADC: the voltage one count above full scale', unit='V',
        minimum=0.5, maximum=10.0,
    )  # fmt: skip
    adc_bits: int = parameter(12, 'Resolution of the ADC', choices=(8, 10, 12, 16))
    zero_g: tuple[float, float, float] = parameter(
        Derived(lambda driver: (driver.supply / 2.0,) * 3, 'half the supply'),
        'Output of x, y, z at zero g, before calibration',
        unit='V', minimum=0.0, maximum=10.0, length=3,
    )  # fmt: skip
    sensitivity: tuple[float, float, float] = parameter(
        Derived(
            lambda driver: (mma7260qt.sensitivity(driver.range_g, driver.supply),) * 3,
            'the typical one for the range and the supply',
        ),
        'Sensitivity of x, y, z',
        unit='V/g', minimum=0.001, maximum=10.0, length=3,
    )  # fmt: skip
    noise: float = parameter(
        mma7260qt.NOISE, 'Noise of one conversion, one sigma', unit='V', minimum=0.0, maximum=1.0
    )
    sample_rate: float = parameter(
        6400.0, 'Conversions per second of each axis', unit='Hz', minimum=1.0, maximum=100_000.0
    )
    samples_per_message: int = parameter(
        64, 'Conversions averaged into one message (AN3397: 64)', minimum=1, maximum=65_536
    )
    calibration_samples: int = parameter(
        1024, 'Conversions averaged to find the zero-g offsets (AN3397: 1024)',
        minimum=16, maximum=1_000_000,
    )  # fmt: skip
    calibrate_on_start: bool = parameter(
        Derived(
            lambda driver: driver.source == 'simulated',
            'true for the simulated source, else false',
        ),
        'Find the zero-g offsets before the first message; the device must rest level, since a '
        'tilted mounting would be taken for offsets',
    )
    rest_deviation: float = parameter(
        0.5, 'Largest standard deviation of the conversions of an axis that still counts as rest',
        unit='m/s²', minimum=1e-6, maximum=10.0,
    )  # fmt: skip
    wait_for_subscribers: int = parameter(
        0, 'Subscribers of imu/data_raw to wait for before the simulated sensor starts',
        minimum=0, maximum=100,
    )  # fmt: skip

    def model(self) -> AnalogAccelerometer:
        """Return the sensor and its ADC as set."""
        return AnalogAccelerometer(
            range_g=self.range_g,
            zero_g=self.zero_g,
            sensitivity=self.sensitivity,
            zero_g_tolerance=mma7260qt.zero_g_tolerance(self.supply),
            swing=(mma7260qt.SWING_MARGIN, self.supply - mma7260qt.SWING_MARGIN),
            noise=self.noise,
            reference=self.adc_reference,
            bits=self.adc_bits,
        )
