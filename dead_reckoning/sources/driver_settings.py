"""Settings of the accelerometer driver: which source, which sensor, which circuit around it."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core import sensors
from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Derived, Settings, parameter
from dead_reckoning.sources import motions


@dataclass(frozen=True, kw_only=True)
class DriverSettings(Settings, prefix='driver'):
    """A sensor, its supply and its ADC, and how conversions become messages."""

    source: str = parameter(
        'simulated',
        'Where samples come from: a board (serial), a driver of the Linux kernel (iio), or an '
        'ADXL345 on a bus (i2c)',
        choices=('simulated', 'serial', 'iio', 'i2c'),
    )
    motion: str = parameter('slide', 'What the simulated sensor does', choices=motions.names())
    sensor: str = parameter('mma7260qt', 'Which sensor it is', choices=sensors.names())
    range_g: float = parameter(
        Derived(lambda driver: min(driver.part.ranges), 'the smallest of the sensor'),
        'Range of the sensor, ±: 1.5, 2, 4, 6 (mma7260qt, by its g-select pins), 3 (adxl330), 2, '
        '4, 8, 16 (adxl345), 8 (um7)',
        unit='g', minimum=1.0, maximum=16.0,
    )  # fmt: skip
    supply: float = parameter(
        Derived(lambda driver: driver.part.supply[0], 'that of the data sheet'),
        'Supply of the sensor; an analogue one is ratiometric to it',
        unit='V', minimum=1.8, maximum=3.6,
    )  # fmt: skip
    adc_reference: float = parameter(
        Derived(lambda driver: driver.part.supply[0], 'the supply of the data sheet'),
        'Reference of the ADC: the voltage one count above full scale; a digital sensor has none',
        unit='V', minimum=0.5, maximum=10.0,
    )  # fmt: skip
    adc_bits: int = parameter(
        12, 'Resolution of the ADC; a digital sensor has its own', choices=(8, 10, 12, 16)
    )
    zero_g: tuple[float, float, float] = parameter(
        Derived(
            lambda driver: (driver.part.zero_g * driver.part.scale(driver.supply),) * 3,
            'that of the data sheet at the supply: half of it, or 0 counts',
        ),
        'Output of x, y, z at zero g, before calibration',
        unit='V, or counts of a digital sensor', minimum=-65_536.0, maximum=65_536.0, length=3,
    )  # fmt: skip
    sensitivity: tuple[float, float, float] = parameter(
        Derived(
            lambda driver: (
                driver.part.ranges.get(driver.range_g, 1.0) * driver.part.scale(driver.supply),
            )
            * 3,
            'the typical one for the range and the supply',
        ),
        'Sensitivity of x, y, z',
        unit='V/g, or counts/g of a digital sensor', minimum=0.001, maximum=65_536.0, length=3,
    )  # fmt: skip
    noise: float = parameter(
        Derived(lambda driver: driver.part.noise, 'that of the data sheet'),
        'Noise of one conversion, one sigma',
        unit='V, or counts of a digital sensor', minimum=0.0, maximum=1000.0,
    )  # fmt: skip
    sample_rate: float = parameter(
        Derived(
            lambda driver: 6400.0 if driver.source == 'simulated' else 100.0,
            '6400 for the simulated source, else 100',
        ),
        'Conversions per second of each axis of the simulated sensor; of another, only for the '
        'noise of a gyroscope, that of one reading',
        unit='Hz', minimum=1.0, maximum=100_000.0,
    )  # fmt: skip
    samples_per_message: int = parameter(
        Derived(
            lambda driver: 64 if driver.source == 'simulated' else 1,
            '64, as in AN3397, for the simulated source, else 1',
        ),
        'Conversions averaged into one message',
        minimum=1, maximum=65_536,
    )  # fmt: skip
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
    orientation_deviation: tuple[float, float, float] = parameter(
        (0.05, 0.05, 0.1), 'Standard deviation of an orientation that the device itself measures, '
        'about x, y, z of the world: of its tilt, of its tilt, of its yaw',
        unit='rad', minimum=1e-6, maximum=10.0, length=3,
    )  # fmt: skip
    wait_for_subscribers: int = parameter(
        0, 'Subscribers of imu/data_raw and ground_truth/odom, counted together, to wait for '
        'before the simulated sensor starts',
        minimum=0, maximum=100,
    )  # fmt: skip

    @property
    def part(self) -> sensors.Part:
        """The data sheet of the sensor."""
        return sensors.part(self.sensor)

    def validate(self) -> None:
        """Raise `SettingsError` for a range or a supply that the sensor does not have."""
        ranges = self.part.ranges
        if self.range_g not in ranges:
            raise SettingsError(
                f'driver.range_g: {self.range_g:g} is not allowed; the {self.sensor} has '
                + ', '.join(f'{r:g}' for r in ranges)
                + ' [g]'
            )
        _, low, high = self.part.supply
        if not low <= self.supply <= high:
            raise SettingsError(
                f'driver.supply: {self.supply:g} is not allowed; the {self.sensor} takes {low:g} '
                f'to {high:g} V'
            )

    def model(self) -> Accelerometer:
        """Return the sensor and its ADC as set."""
        part = self.part
        limits = part.limits(self.range_g) if part.digital else (0.0, (1 << self.adc_bits) - 1.0)
        swing = (part.swing_margin, self.supply - part.swing_margin)
        return Accelerometer(
            range_g=self.range_g,
            zero_g=self.zero_g,
            sensitivity=self.sensitivity,
            zero_g_tolerance=part.zero_g_tolerance * part.scale(self.supply),
            swing=limits if part.digital else swing,
            noise=self.noise,
            unit_per_count=1.0 if part.digital else self.adc_reference / (1 << self.adc_bits),
            limits=limits,
        )
