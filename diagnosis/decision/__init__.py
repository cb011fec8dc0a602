"""From fitted candidate models to the verdict."""
