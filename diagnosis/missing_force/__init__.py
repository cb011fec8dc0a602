"""The force that the model lacks, read from the data as a function of amplitude."""
