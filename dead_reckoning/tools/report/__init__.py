"""One HTML page about one recording: what came out of it, how sure that is, what was dropped."""
