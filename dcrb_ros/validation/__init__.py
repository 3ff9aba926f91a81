"""Validation against Fan et al. 2025: runs, comparisons with the paper's numbers, figures laid out like the paper's, a report."""
