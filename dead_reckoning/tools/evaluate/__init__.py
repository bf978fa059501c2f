"""`dead-reckoning evaluate`: how far off an estimate is, by evo's definitions and some more."""
