"""Prognosis: the rating life of a bearing, the remaining life from a trend, and scores of such estimates."""
