"""What a test would have seen of the model: branches at the sensors, with derivatives by parameters."""
