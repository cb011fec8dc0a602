"""Which physical effect the model lacks, and how sure that is."""
