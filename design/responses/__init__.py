"""What is asked of a design, one family of responses a file; each is registered by one line above its class."""
