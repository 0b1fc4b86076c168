"""What was measured: checked placements, known distances, and the errors of a model."""
