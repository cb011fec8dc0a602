"""Ways on where the corrector fails: beyond kinks, ahead in phase, across jumps."""
