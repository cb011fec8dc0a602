"""Modified friction laws: each changes the arguments of the law inside it, or the force that comes out."""
