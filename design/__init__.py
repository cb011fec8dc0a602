"""Design studies: variables of a rig file, responses, methods that choose designs, records that survive, one page."""
