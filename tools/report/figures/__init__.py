"""The numbers of a report: what follows from a calibration's file, and nothing about its looks."""
