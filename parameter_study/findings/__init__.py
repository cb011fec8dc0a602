"""What papers saw, each as a check of a study's curves that can fail. A new one is a function and a line in a set."""
