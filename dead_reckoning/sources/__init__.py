"""Where samples come from: simulated sensors and recordings."""
