"""Commands of `updamp` and what they share: arguments, clean errors, interruptions."""
