"""From points to a camera and a light plane: starting values, methods, bound."""
