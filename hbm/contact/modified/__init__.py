"""Laws around a friction law: they change what it sees, or what comes out of it."""
