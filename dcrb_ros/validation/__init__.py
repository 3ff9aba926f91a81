"""The paper, reproduced: runs, numbers against its figures, figures laid out like its own, a report."""
