"""The equations: linear structure, contact elements, receptance."""
