"""One point: Newton's method, tangents, linear solvers, and what is read off a solution."""
