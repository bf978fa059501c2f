"""A board that is not there: its protocol on a pseudo-terminal, a simulated sensor behind it."""
