"""Results that show themselves: a table in a notebook, a line in a terminal, a picture on call."""
