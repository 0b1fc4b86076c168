"""The paper's experiments, Section IV-B, in MuJoCo: peg insertion and drawing."""
