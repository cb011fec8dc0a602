"""Whether periodic responses are stable: exponents of perturbations, with the memory of sliders, along a branch."""
