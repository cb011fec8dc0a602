"""Response curves: branches followed through turning points and jumps."""
