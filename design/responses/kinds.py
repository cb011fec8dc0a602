"""All kinds of responses: importing the files registers them. A new file joins with one line here."""

from updamp.design.responses import contacts, energies, frequencies, jumps, masses, peaks
from updamp.design.responses.response import RESPONSES

__all__ = ["RESPONSES", "contacts", "energies", "frequencies", "jumps", "masses", "peaks"]
