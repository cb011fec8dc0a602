"""A rig, a measurement of it with an effect hidden in it, and what to try: what `updamp init` copies."""
