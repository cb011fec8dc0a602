"""Model selection: single effects first, then pairs."""
