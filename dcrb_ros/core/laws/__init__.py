"""The published laws, one per file: force, slope, inverse and energy side by side."""
