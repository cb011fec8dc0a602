"""The measurement that would tell apart the explanations that are left."""
