"""How a study chooses its designs, one method a file; each is registered by one line above its class."""
