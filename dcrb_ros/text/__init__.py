"""Text: files, YAML and JSON from outside, read within limits that each refusal names, and Markdown tables."""
