"""Text from outside: files, YAML and JSON are read within limits, and each refusal names the source, the figure and the limit."""
