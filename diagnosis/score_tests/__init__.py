"""How much each effect would explain, estimated from its signature before any fit."""
