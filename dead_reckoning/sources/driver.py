"""Build what the driver's settings ask for, the same for the node, the tools and the tests."""

from __future__ import annotations

from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.front_end import FrontEnd
from dead_reckoning.core.parameters import Parts
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.hand import HandSettings, Held
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.receiver import Receiver
from dead_reckoning.sources.serial.settings import SerialSettings
from dead_reckoning.sources.simulated import SimulatedAccelerometer, SimulatedSettings
from dead_reckoning.sources.simulated_gyroscope import GyroSettings, SimulatedGyroscope


def front_end(parts: Parts) -> FrontEnd:
    """Return what makes samples of the sensor's conversions."""
    driver, gyro = parts[DriverSettings], parts[GyroSettings]
    x, y, z = (deviation**2 for deviation in driver.orientation_deviation)
    simulated = driver.source == 'simulated'
    return FrontEnd(
        driver.model(),
        frame_id=parts[FrameSettings].sensor,
        samples_per_message=driver.samples_per_message,
        calibration_samples=driver.calibration_samples,
        rest_deviation=driver.rest_deviation,
        calibrate_on_start=driver.calibrate_on_start,
        gyroscope=(gyro.model if simulated else gyro.gyroscope)(driver.sample_rate),
        orientation_covariance=(x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z),
    )


def simulated_sensor(parts: Parts, start_ns: int) -> SimulatedAccelerometer:
    """Return the simulated sensor, its gyroscope too, on the motion that begins at a stamp."""
    driver, simulated, gyro = (
        parts[DriverSettings],
        parts[SimulatedSettings],
        parts[GyroSettings],
    )
    kind = motions.motion_class(driver.motion)
    motion: motions.Motion = kind(parts[kind.Settings])
    hand = parts[HandSettings]
    if hand.enabled:
        motion = Held(motion, hand, simulated.seed)
    model = gyro.model(driver.sample_rate)
    gyroscope = (
        SimulatedGyroscope(gyro, model, driver.sample_rate, simulated.seed) if model else None
    )
    return SimulatedAccelerometer(
        simulated,
        driver.part,
        driver.model(),
        motion,
        driver.sample_rate,
        start_ns,
        gyroscope,
    )


def serial_receiver(parts: Parts) -> Receiver:
    """Return what makes conversions of the bytes of a board.

    Raises `SettingsError` for volts of a sensor that has none, and for counts of another ADC than
    the protocol has.
    """
    driver, port = parts[DriverSettings], parts[SerialSettings]
    decoder_class = protocols.decoder_class(port.protocol)
    decoder: protocols.Decoder = decoder_class(parts[decoder_class.Settings])
    if decoder.range_g not in (None, driver.range_g):
        raise SettingsError(
            f'driver.serial.{port.protocol}.range_g: the board would have ±{decoder.range_g:g} g, '
            f'and driver.range_g is {driver.range_g:g}; set both alike'
        )
    if decoder.unit == 'volts' and driver.part.digital:
        raise SettingsError(
            f'driver.serial.{port.protocol}.unit: volts are not what driver.sensor '
            f'{driver.sensor} gives, which is digital; set one of the two'
        )
    analogue_counts = decoder.unit == 'counts' and not driver.part.digital
    if analogue_counts and decoder.BITS not in (None, driver.adc_bits):
        raise SettingsError(
            f'driver.adc_bits: {driver.adc_bits} is not allowed, as driver.serial.protocol '
            f"'{port.protocol}' has {decoder.BITS}; set one of the two"
        )
    return Receiver(decoder, driver.model(), port)
