"""`dead-reckoning demo`: simulate, run the nodes over DDS, compare with the truth, show it."""
