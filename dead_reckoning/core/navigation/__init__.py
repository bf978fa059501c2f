"""What the inertial navigator is made of, beside its kernels; docs/navigation.md derives it."""
