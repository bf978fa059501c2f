"""Accelerometers that a driver of the Linux kernel reads: industrial I/O."""
