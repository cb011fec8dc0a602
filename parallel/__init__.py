"""Worker processes, and the time and memory that work takes."""
