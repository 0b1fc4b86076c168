"""The pages of the report: numbers in, HTML out."""
