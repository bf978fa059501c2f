"""Models of sensors, one module each: counts to specific force and back."""
